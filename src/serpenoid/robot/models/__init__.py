"""Servo models, one per file of this folder that makes a `MODEL`, found by listing; each names its sources."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from serpenoid.robot.models.servo_model import WATCHDOG_TRIPPED, Block, Effort, Register, ServoModel

__all__ = ["DEFAULT", "WATCHDOG_TRIPPED", "Block", "Effort", "Register", "ServoModel", "by_number", "models"]

DEFAULT = "XL430-W250-T"  # of a robot file that names none


@cache
def models() -> dict[str, ServoModel]:
    """All models by name."""
    names = sorted(module.name for module in pkgutil.iter_modules(__path__))
    found = [getattr(importlib.import_module(f"{__name__}.{name}"), "MODEL", None) for name in names]
    return {model.name: model for model in found if model is not None}


def by_number(number: int) -> ServoModel | None:
    """The model that answers a ping with this number; None: none that is known here."""
    return next((model for model in models().values() if model.number == number), None)
