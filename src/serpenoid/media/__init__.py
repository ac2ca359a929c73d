"""Media: one dissipation law per file, each a potential of an element's squared slip, found by listing this folder.

A file that makes a `LAW` is a law that problem files can name; everything else asks the law for what it must know.
"""

from __future__ import annotations

import importlib
import pkgutil

from serpenoid.errors import InputError
from serpenoid.media.base import Law, Rival
from serpenoid.media.viscous import LAW as VISCOUS

__all__ = ["DEFAULT", "LAWS", "VISCOUS", "Law", "Rival", "rivals"]

DEFAULT = VISCOUS.name  # of a file that names none


def _listed() -> dict[str, Law]:
    """All laws by name, the default first."""
    found = {}
    for module in sorted(module.name for module in pkgutil.iter_modules(__path__)):
        law = getattr(importlib.import_module(f"{__name__}.{module}"), "LAW", None)
        if law is not None:
            if law.name != module:
                raise InputError(f"{__name__}.{module}: `name` of its LAW must be that of the file, got `{law.name}`.")
            found[law.name] = law
    return {law.name: law for law in sorted(found.values(), key=lambda law: law.name != DEFAULT)}


LAWS: dict[str, Law] = _listed()


def rivals(law: Law) -> list[Law]:
    """Laws that a diagnosis asks for beside this one."""
    return [other for other in LAWS.values() if other.rival is not None and other.rival.of is law]
