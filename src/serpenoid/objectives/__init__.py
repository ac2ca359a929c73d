"""Objectives and demands: one kind per file, each one symbolic expression of the motion."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from functools import cache
from typing import Any

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
        value: Any
        for value in vars(importlib.import_module(f"{__name__}.{module.name}")).values():
            if inspect.isclass(value) and issubclass(value, base) and not inspect.isabstract(value):
                kind: Any = value
                kinds[str(kind.model_fields["kind"].default)] = kind
    return tuple(kinds.values())
