"""`serpenoid.measure` and its like are packages and verbs: called, they are the function of their name."""

from __future__ import annotations

import importlib
import sys
from types import ModuleType
from typing import Any


class Room(ModuleType):
    """A package that can be called: as `serpenoid.studies.verbs` defines it."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """See the function of this name in `serpenoid.studies.verbs`."""
        studies = importlib.import_module("serpenoid.studies.verbs")
        return getattr(studies, self.__name__.rpartition(".")[2])(*arguments, **options)


def make_callable(name: str) -> None:
    """Of a package that is being imported."""
    sys.modules[name].__class__ = Room
