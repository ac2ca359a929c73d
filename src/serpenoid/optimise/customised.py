"""The user's own objective and constraints: their function is called once, and what it did is checked."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import casadi as ca

from serpenoid.errors import InputError
from serpenoid.objectives import Criteria
from serpenoid.objectives.checked import HOW, gaps

Customise = Callable[[Criteria], None]
MUST = "must be a function of one argument, sp.Criteria, that calls its methods and returns nothing"
CALLS = "Call minimise(...), also_minimise(...), subject_to(..., lower, upper) or keep_clear(...) in it."


def add_own(customise: Callable[[Criteria], Any], criteria: Criteria) -> None:
    """Call the user's function; its own exceptions pass, CasADi's are told in words."""
    if not callable(customise):
        raise InputError(f"`customise` {MUST}, got {type(customise).__name__}.")
    name = getattr(customise, "__name__", type(customise).__name__)
    if not _takes_one(customise):
        raise InputError(f"`customise` {name}: {MUST}; it does not take one argument.")
    before = len(criteria.clear_of)
    try:
        returned = customise(criteria)
        for added in criteria.clear_of[before:]:
            gaps(added.of)
    except (RuntimeError, NotImplementedError) as error:
        raise InputError(f"`customise` {name}: {_said(error)} {HOW}") from error
    if isinstance(returned, ca.SX | ca.MX | ca.DM | float):  # somebody expects that it is minimised
        raise InputError(f"`customise` {name}: returned {type(returned).__name__}, which is not looked at. {CALLS}")


def _takes_one(customise: Customise) -> bool:
    try:
        inspect.signature(customise).bind(None)
    except TypeError:
        return False
    except ValueError:  # written in C, it does not say
        return True
    return True


def _said(error: Exception) -> str:
    """The line of a message of CasADi that people can use: the last of an assertion, the first of a list of types."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()] or [type(error).__name__]
    line = lines[0] if isinstance(error, NotImplementedError) else lines[-1]
    return line.rpartition(".cpp:")[2].partition(": ")[2].rstrip(".") + "." if ".cpp:" in line else f"{line}."
