"""Media: one dissipation law per file, each a potential of an element's squared slip, found by listing this folder.

A file that makes a `LAW` is a law that problem files can name; everything else asks the law for what it must know.
"""

from __future__ import annotations

import importlib
import pkgutil

from serpenoid.media.base import Law, Rival
from serpenoid.media.viscous import LAW as VISCOUS

__all__ = ["DEFAULT", "LAWS", "VISCOUS", "Law", "Rival", "rivals"]

DEFAULT = VISCOUS.name  # of a file that names none


def _listed() -> dict[str, Law]:
    """All laws by name, the default first."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    found = [getattr(importlib.import_module(f"{__name__}.{name}"), "LAW", None) for name in names]
    return {law.name: law for law in sorted((x for x in found if x is not None), key=lambda law: law.name != DEFAULT)}


LAWS: dict[str, Law] = _listed()


def rivals(law: Law) -> list[Law]:
    """Laws that a diagnosis asks for beside this one."""
    return [other for other in LAWS.values() if other.rival is not None and other.rival.of is law]
