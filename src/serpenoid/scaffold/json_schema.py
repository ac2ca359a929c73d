"""JSON Schemas of the files that a user writes, for editors and other programs: they accept what the package accepts.

Editors read the first line of a file: `#:schema PATH` (Even Better TOML, taplo).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from serpenoid.files.schema import Record
from serpenoid.files.writing import write_json

KINDS = ("problem", "model", "robot", "protocol", "campaign")
DIALECT = "https://json-schema.org/draft/2020-12/schema"
FOLDER = ".serpenoid"  # beside the files that name it


def schema_of(kind: str) -> dict[str, Any]:
    """The JSON Schema of one kind of file."""
    schema = _record(kind).model_json_schema()
    for part in _parts(schema):
        _let_family_be_left_out(part)
    if "ActiveEffect" in schema.get("$defs", {}):
        schema["$defs"]["ActiveEffect"] = _effect()
    return {"$schema": DIALECT, **schema, "title": f"serpenoid {kind} file"}


def write_schema(folder: Path, kind: str) -> str:
    """Write the schema beside the files in `folder`; returns the comment with which such a file begins."""
    name = f"{FOLDER}/{kind}.schema.json"
    write_json(folder / name, schema_of(kind))
    return f"#:schema {name}"


def _record(kind: str) -> type[Record]:
    if kind == "problem":
        from serpenoid.problem import Problem

        return Problem
    if kind == "model":
        from serpenoid.model_file import ModelFile

        return ModelFile
    if kind == "robot":
        from serpenoid.robot.description import Robot

        return Robot
    if kind == "protocol":
        from serpenoid.arena.protocol import Protocol

        return Protocol
    from serpenoid.measure.campaign import CampaignFile

    return CampaignFile


def _parts(node: Any) -> Iterator[dict[str, Any]]:
    """Every object inside a schema, itself first."""
    if isinstance(node, dict):
        yield node
    for below in node.values() if isinstance(node, dict) else node if isinstance(node, list) else ():
        yield from _parts(below)


def _let_family_be_left_out(part: dict[str, Any]) -> None:
    """A gait's family has a default, and bounds have the gait's: several forms may then fit, and one is enough."""
    if part.get("discriminator", {}).get("propertyName") == "family":
        del part["discriminator"]
        part["anyOf"] = part.pop("oneOf")


def _effect() -> dict[str, Any]:
    """An `[[effects]]` entry: parameters stand beside name and place, each effect with its own."""
    from serpenoid.effects.catalogue import catalogue

    forms = []
    for effect in catalogue().values():
        keys: dict[str, Any] = {"name": {"const": effect.name}}
        if effect.place is not None:
            keys["place"] = {"type": "integer", "minimum": 0, "description": f"the {effect.place} it acts on"}
        for p in effect.parameters:
            ends = {"minimum": p.lower, "maximum": p.upper}
            finite = {end: value for end, value in ends.items() if math.isfinite(value)}
            keys[p.name] = {"type": "number", "description": f"{p.meaning} [{p.units}]", **finite}
        needed = ["name", *(p.name for p in effect.parameters), *(["place"] if effect.place is not None else [])]
        form = {"type": "object", "description": effect.looks_like, "properties": keys, "required": needed}
        forms.append(form | {"additionalProperties": False})
    return {"description": "an effect at work; `serpenoid effects` lists them", "oneOf": forms}
