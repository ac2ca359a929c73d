"""Objectives and demands: one kind per file, each one symbolic expression of the motion."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from collections.abc import Mapping
from functools import cache
from typing import Any, get_args

from serpenoid.errors import InputError
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.displacement import Displacement
from serpenoid.objectives.term import Demand, Term

__all__ = ["Criteria", "Demand", "Displacement", "Term", "demands", "terms"]


@cache
def terms() -> tuple[type[Term], ...]:
    """Terms of an objective, every class of this folder that has a `kind` of its own."""
    return _found(Term)


@cache
def demands() -> tuple[type[Demand], ...]:
    """Requirements, likewise."""
    return _found(Demand)


def _found(base: Any) -> tuple[Any, ...]:
    kinds: dict[str, Any] = {}
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda m: m.name):
        there = vars(importlib.import_module(f"{__name__}.{module.name}")).values()
        for value in (value for value in there if inspect.isclass(value) and issubclass(value, base)):
            kind = _kind(value)
            if kind is not None:
                _refuse(value, kind, kinds)
                kinds[kind] = value
    return tuple(kinds.values())


def _kind(goal: Any) -> Any:
    """The word of a class; None for what several kinds share."""
    kind = goal.model_fields["kind"].default
    return None if inspect.isabstract(goal) and not isinstance(kind, str) else kind


def _refuse(goal: Any, kind: Any, others: Mapping[str, Any]) -> None:
    """InputError where a class of this folder cannot be a kind of its own."""
    where = f"{goal.__module__}: `{goal.__name__}`"
    if not isinstance(kind, str) or get_args(goal.model_fields["kind"].annotation) != (kind,):
        raise InputError(
            f'{where}: `kind` must be a literal and its own default, `kind: Literal["mine"] = "mine"`, got '
            f"{goal.model_fields['kind'].annotation}, {repr(kind) if isinstance(kind, str) else 'without a default'}."
        )
    if inspect.isabstract(goal):
        lacks = "`, `".join(sorted(goal.__abstractmethods__))
        raise InputError(f"{where}: must have a method `{lacks}`, got none. Is it spelt otherwise?")
    if others.get(kind, goal) is not goal:
        other = f"{others[kind].__module__} has it"
        raise InputError(f"{where}: `kind` must be a word of its own, got `{kind}`; {other}. Choose another.")
