"""The catalogue: every module in `actuation/`, `medium/` and `observation/` that makes an EFFECT, found by listing."""

from __future__ import annotations

import importlib
import pkgutil
from functools import cache

from serpenoid.body import Body
from serpenoid.effects.base import ActuationEffect, Effect, Marks, MediumEffect
from serpenoid.errors import InputError
from serpenoid.wording import meant_or_all

SITES = ("actuation", "medium", "observation")


@cache
def catalogue() -> dict[str, Effect]:
    """All effects by name, in the order of their sites and alphabetical within."""
    found: dict[str, Effect] = {}
    for site in SITES:
        package = importlib.import_module(f"serpenoid.effects.{site}")
        for module in sorted(pkgutil.iter_modules(package.__path__), key=lambda m: m.name):
            file = f"{package.__name__}.{module.name}"
            effect = getattr(importlib.import_module(file), "EFFECT", None)
            if not isinstance(effect, Effect):
                raise InputError(f"{file}: must make one effect, `EFFECT = ...`, got {type(effect).__name__}.")
            if effect.name != module.name:
                raise InputError(f"{file}: `name` of its EFFECT must be that of the file, got `{effect.name}`.")
            if effect.site != site:
                raise InputError(f"{file}: must stand in effects/{effect.site}, the folder of its site.")
            found[effect.name] = effect
    return found


def find(name: str) -> Effect:
    """The effect called `name`; InputError with the closest names where there is none."""
    known = catalogue()
    if name in known:
        return known[name]
    raise InputError(f"no effect is called `{name}`; {meant_or_all(name, known, 'known')}")


def places(effect: Effect, body: Body) -> list[int | None]:
    """Where an effect can sit on a body."""
    return effect.places(body)


@cache
def medium_effects() -> tuple[MediumEffect, ...]:
    """Effects from shape to motion, in the order in which they are applied."""
    found = [e for e in catalogue().values() if isinstance(e, MediumEffect)]
    return tuple(sorted(found, key=lambda e: e.rank))


@cache
def of_laws() -> tuple[MediumEffect, ...]:
    """Effects whose values are numbers of a law, calibrated with eps."""
    return tuple(e for e in medium_effects() if e.of_the_law)


@cache
def motion_effects() -> tuple[Effect, ...]:
    """Effects that a diagnosis looks for in the motion that cameras see, in the catalogue's order."""
    return tuple(e for e in catalogue().values() if e.moves and e.applies_to("diagnose") and e not in of_laws())


@cache
def view_effects() -> tuple[Effect, ...]:
    """Effects of observation with no marks: a diagnosis looks for what they show of the body, by their law alone."""
    found = (e for e in catalogue().values() if e.site == "observation" and e.marks is None)
    return tuple(e for e in found if e.applies_to("diagnose"))


@cache
def marking(marks: Marks) -> tuple[Effect, ...]:
    """Effects whose numbers are of this kind."""
    return tuple(e for e in catalogue().values() if e.marks == marks)


@cache
def actuation_effects() -> tuple[ActuationEffect, ...]:
    """Effects from command to shape, in the order in which they are applied."""
    found = [e for e in catalogue().values() if isinstance(e, ActuationEffect)]
    return tuple(sorted(found, key=lambda e: e.rank))
