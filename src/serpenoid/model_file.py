"""Model files: a medium, the effects at work, and perhaps a body; what `diagnose` writes and `--model` reads.

[medium]
anisotropy_ratio = 0.21
dissipation = "vertex"

[[effects]]
name = "worn_wheel"
place = 4
seizure = 0.5
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

from pydantic import Field

from serpenoid.body import Body
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.files import schema
from serpenoid.files.inputs import read_text
from serpenoid.files.schema import Record
from serpenoid.files.writing import toml_string, write_text
from serpenoid.medium import Medium

END = "# end"
ENDS = f"# Written whole, this file has a line `{END}` behind its last value."


class ModelFile(Record):
    """What a model file holds."""

    file_kind: ClassVar[str | None] = "model"

    medium: Medium
    effects: tuple[ActiveEffect, ...] = Field(default=(), description="see `serpenoid effects`")
    body: Body | None = Field(default=None, description="where it differs from the problem's")


def read_model_file(path: str | Path) -> dict[str, Any]:
    """The sections of a model file, checked: `medium`, `effects` (even if there are none), `body` if there is one."""
    data = schema.read_toml(path, "model")
    schema.validate(ModelFile, data, str(path))
    lines = [line.strip() for line in read_text(path).splitlines()]
    if ENDS in lines and END not in lines:
        raise InputError(
            f"{path}: has no line `{END}`, which it was written with: values are missing that stood before it. Was a "
            "copy cut off? Copy it again."
        )
    return {"effects": [], **data}


def write_model_file(
    path: str | Path,
    medium: Medium,
    effects: Sequence[ActiveEffect],
    body: Body | None = None,
    comment: str = "",
    notes: Sequence[str] = (),
) -> None:
    """Write a model file, whole or not at all; `comment` goes to its top, each of `notes` above its effect.

    It says that it has an end, so that what is left of it where a copy was cut off is not taken for another model.
    """
    lines = [*(f"# {line}".rstrip() for line in comment.splitlines()), ENDS]
    open_law = {"law", "softening"} if medium.law == Medium.model_fields["law"].default else set()  # not stated: asked
    lines += ["[medium]", *_assignments(medium.model_dump(exclude=open_law))]
    if body is not None:
        lines += ["", "[body]", *_assignments(body.model_dump())]
    for effect, note in zip(effects, notes or [""] * len(effects), strict=True):
        values = {"name": effect.name, **({} if effect.place is None else {"place": effect.place}), **effect.parameters}
        lines += ["", *([f"# {note}"] if note else []), "[[effects]]", *_assignments(values)]
    write_text(path, "\n".join([*lines, "", END]) + "\n")


def _assignments(values: dict[str, Any]) -> list[str]:
    return [f"{key} = {_toml(value)}" for key, value in values.items() if value is not None]


def _toml(value: Any) -> str:
    if isinstance(value, str):
        return toml_string(value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_toml(item) for item in value) + "]"
    return repr(value)
