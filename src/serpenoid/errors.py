"""The package's own exceptions: few, and each says what to do."""

from __future__ import annotations

from typing import Any, TypeVar

T = TypeVar("T")


class InputError(ValueError):
    """Something the user wrote is wrong: the message names the place, the rule, the value and the remedy."""


class StopRequested(Exception):
    """The user pressed Ctrl-C: what was reached so far is kept, and the command exits with 130."""


def of_kind(name: str, given: Any, kind: type[T], remedy: str) -> T:
    """What a caller gave, if it is of that kind; InputError with the remedy where it is not."""
    if not isinstance(given, kind):
        raise InputError(f"`{name}` must be a {kind.__name__}, got {type(given).__name__}. {remedy}")
    return given
