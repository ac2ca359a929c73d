"""TOML files as validated, frozen values: a misspelt key or a bad number is refused with its place in the file."""

from __future__ import annotations

import difflib
import tomllib
from pathlib import Path
from typing import Any, TypeVar, get_args

from pydantic import BaseModel, ConfigDict, ValidationError

from serpenoid.errors import InputError


class Record(BaseModel):
    """Base of everything that is read from a file: frozen, no unknown keys, no NaN or infinity."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


R = TypeVar("R", bound=Record)


def read_toml(path: str | Path) -> dict[str, Any]:
    """Parse a TOML file; raise InputError with the line and column of a syntax error."""
    path = Path(path)
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{path}: no such file.") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; name the TOML file in it.") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file ({error.reason} at byte {error.start}).") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}.") from None


def validate(schema: type[R], data: dict[str, Any], source: str) -> R:
    """Build `schema` from parsed `data`; every fault is named `source: [section] key: rule, got value`."""
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        faults = "\n".join(f"{source}: {_describe(schema, fault)}" for fault in error.errors())
        raise InputError(faults) from None


def load(schema: type[R], path: str | Path) -> R:
    """Read and validate one TOML file as `schema`."""
    return validate(schema, read_toml(path), str(path))


def override(data: dict[str, Any], assignments: list[str]) -> dict[str, Any]:
    """Apply `section.key=value` assignments (values in TOML syntax; bare words are strings) to a copy of `data`."""
    result = _copy(data)
    for assignment in assignments:
        key, equals, text = assignment.partition("=")
        if not equals or not key.strip():
            raise InputError(f"--set {assignment}: write it as section.key=value.")
        *sections, last = key.strip().split(".")
        table = result
        for section in sections:
            table = table.setdefault(section, {})
            if not isinstance(table, dict):
                raise InputError(f"--set {assignment}: `{section}` is not a section.")
        table[last] = _parse_value(text.strip())
    return result


def _parse_value(text: str) -> Any:
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _copy(data: Any) -> Any:
    return {key: _copy(value) for key, value in data.items()} if isinstance(data, dict) else data


def _describe(schema: type[BaseModel], fault: Any) -> str:
    *sections, key = [str(part) for part in fault["loc"]] or [""]
    place = f"[{'.'.join(sections)}] {key}" if sections else key
    if fault["type"] == "extra_forbidden":
        return f"{place}: unknown key.{_suggest(schema, fault['loc'])}"
    message = fault["msg"].removeprefix("Value error, ").removesuffix(".")
    if not place:
        return f"{message}."
    if fault["type"] == "missing":
        return f"{place}: is required and not there."
    shown = "" if isinstance(fault["input"], dict) else f", got {fault['input']!r}"
    return f"{place}: {message}{shown}."


def _suggest(schema: type[BaseModel], location: tuple[Any, ...]) -> str:
    """The closest known keys beside an unknown one, found by walking the schema down to its section."""
    for part in location[:-1]:
        field = schema.model_fields.get(str(part))
        if field is None:
            continue
        models = [m for m in (field.annotation, *get_args(field.annotation)) if _is_model(m)]
        schema = models[0] if models else schema
    known = list(schema.model_fields)
    close = difflib.get_close_matches(str(location[-1]), known, n=1)
    return f" Did you mean `{close[0]}`?" if close else f" Known keys: {', '.join(known)}."


def _is_model(candidate: Any) -> bool:
    return isinstance(candidate, type) and issubclass(candidate, BaseModel)
