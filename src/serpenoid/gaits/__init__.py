"""Gaits: closed curves in shape space, joint tables. One family per file, found by listing this folder."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from functools import cache

from serpenoid.gaits.ellipse import EllipseBounds, EllipseGait
from serpenoid.gaits.family import Gait, GaitBounds, GaitFamily
from serpenoid.gaits.table import TableGait

__all__ = ["EllipseBounds", "EllipseGait", "Gait", "GaitBounds", "GaitFamily", "TableGait", "families"]


@cache
def families() -> dict[str, type[Gait]]:
    """All families by name: every class of this folder that is a Gait which files name by a `family` word."""
    found = {}
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda m: m.name):
        for value in vars(importlib.import_module(f"{__name__}.{module.name}")).values():
            if inspect.isclass(value) and issubclass(value, Gait) and value is not Gait and value.named:
                found[str(value.model_fields["family"].default)] = value
    return found
