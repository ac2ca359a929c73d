"""What callers of the public functions hand over: a problem or its file, a gait, whole numbers; refused in words."""

from __future__ import annotations

import operator
from pathlib import Path
from typing import Any

from serpenoid.errors import InputError
from serpenoid.gaits import Gait
from serpenoid.problem import Problem, load


def problem_of(given: Problem | str | Path) -> Problem:
    """The problem itself, or the one that a file holds, as on the command line."""
    if isinstance(given, str | Path):
        return load(given)
    if not isinstance(given, Problem):
        raise InputError(f"`problem` must be what sp.load(path) gives, or the path itself, got {_kind(given)}.")
    return given


def gait_of(given: Gait) -> Gait:
    """The gait itself."""
    if not isinstance(given, Gait):
        raise InputError(
            f"`gait` must be a gait, as problem.gait or solution.gait, got {_kind(given)}. Of a joint table: "
            "serpenoid.gaits.TableGait.from_angles(table)."
        )
    return given


def folder_of(given: str | Path | None) -> Path | None:
    """Where results are kept: a folder, or one that can be made; None where they are not."""
    if given is None:
        return None
    if not isinstance(given, str | Path):
        raise InputError(f"`folder` must be a path, got {_kind(given)}.")
    folder = Path(given)
    there = next((path for path in (folder, *folder.parents) if path.exists()), folder)
    if there.exists() and not there.is_dir():
        raise InputError(f"`folder` {folder}: {there} is a file, not a folder.")
    return folder


def whole(name: str, given: Any, least: int, remedy: str = "") -> int:
    """A whole number of at least `least`."""
    try:
        number = operator.index(given)
    except TypeError:
        number = least - 1
    if number < least:
        shown = repr(given) if isinstance(given, int | float | str) else _kind(given)
        raise InputError(f"`{name}` must be a whole number, {least} or more, got {shown}.{f' {remedy}' * bool(remedy)}")
    return number


def _kind(given: Any) -> str:
    return type(given).__name__
