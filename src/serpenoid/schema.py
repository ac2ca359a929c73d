"""TOML files as validated, frozen values: a misspelt key or a bad number is refused with its place in the file."""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Iterator
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
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}).") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file ({error.reason} at byte {error.start}).") from None
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}.") from None


def validate(schema: type[R], data: dict[str, Any], source: str) -> R:
    """Build `schema` from parsed `data`; every fault is named `source: [section] key: rule, got value`."""
    try:
        return schema.model_validate(data)
    except ValidationError as error:
        found = error.errors()
        # a list whose entries are faulty counts as empty: that is no second fault
        above = {fault["loc"][:depth] for fault in found for depth in range(1, len(fault["loc"]))}
        found = [fault for fault in found if fault["type"] != "too_short" or fault["loc"] not in above]
        faults = "\n".join(f"{source}: {_describe(schema, fault)}" for fault in found)
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
    *sections, key = [str(part) for part in _without_tags(schema, fault["loc"])] or [""]
    place = f"[{'.'.join(sections)}] {key}" if sections else key
    if fault["type"] == "extra_forbidden":
        return f"{place}: unknown key.{_suggest(schema, fault['loc'])}"
    if fault["type"] == "missing":
        return f"{place}: is required and not there."
    shown = "" if isinstance(fault["input"], dict) else f", got {fault['input']!r}"
    if fault["type"] == "model_type":
        return f"{place}: must be a section, [{place}] and its keys below it{shown}."
    message = fault["msg"].removeprefix("Value error, ").removesuffix(".")
    if not place:
        return f"{message}."
    rule, _, remedy = message.partition("; ")
    return f"{place}: {rule}{shown}.{f' {remedy[0].upper()}{remedy[1:]}' if remedy else ''}"


def _suggest(schema: type[BaseModel], location: tuple[Any, ...]) -> str:
    """The closest known keys beside an unknown one, found by walking the schema down to its section."""
    for _, below in _walk(schema, location[:-1]):
        schema = below
    known = list(schema.model_fields)
    close = difflib.get_close_matches(str(location[-1]), known, n=1)
    return f" Did you mean `{close[0]}`?" if close else f" Known keys: {', '.join(known)}."


def _without_tags(schema: type[BaseModel], location: tuple[Any, ...]) -> list[Any]:
    """A location as it stands in the file: without the tag that pydantic adds to a section with several forms."""
    return [part for part, _ in _walk(schema, location) if part is not None]


def _walk(schema: type[BaseModel], location: tuple[Any, ...]) -> Iterator[tuple[Any, type[BaseModel]]]:
    """(part or None for a tag, schema below it) along a location."""
    forms: list[type[BaseModel]] = []
    for part in location:
        if isinstance(part, int):  # an entry of a list
            yield part, schema
            continue
        tagged = [form for form in forms if part in _tags(form)]
        if tagged:
            schema, forms = tagged[0], []
            yield None, schema
            continue
        field = schema.model_fields.get(str(part))
        forms = _models(field.annotation) if field is not None else []
        schema = forms[0] if forms else schema
        yield part, schema


def _tags(form: type[BaseModel]) -> tuple[Any, ...]:
    """The word that says which of several forms a section has: its `family`, or its `kind`."""
    tag = form.model_fields.get("family") or form.model_fields.get("kind")
    return get_args(tag.annotation) if tag is not None else ()


def _models(annotation: Any) -> list[type[BaseModel]]:
    """All records in an annotation, in order: of a union, of the entries of a list."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [form for part in get_args(annotation) for form in _models(part)]
