"""An effect at work in a model: its name, its place and its parameters' values.

[[effects]]
name = "worn_wheel"
place = 4
seizure = 0.5
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Self

from pydantic import Field, model_validator

from serpenoid.body import Body, Floats
from serpenoid.effects.base import Effect, ObservationEffect, Parameter
from serpenoid.effects.catalogue import find, places
from serpenoid.effects.view import View
from serpenoid.errors import InputError
from serpenoid.files.schema import Record
from serpenoid.wording import meant_or_all


class ActiveEffect(Record):
    """One `[[effects]]` entry; parameters are written beside name and place, in the catalogue's units."""

    name: str = Field(description="as `serpenoid effects` lists it")
    place: int | None = Field(default=None, description="vertex (0 = tail) or joint (1 = next to the tail), or none")
    parameters: dict[str, float] = Field(description="values by name; in files they stand beside name and place")

    @classmethod
    def of(cls, name: str, place: int | None = None, **parameters: float) -> ActiveEffect:
        """An active effect; raise InputError for an unknown name, a bad place or a value out of bounds."""
        effect = find(name)
        _refuse(_fault(effect, place, parameters))
        return cls(name=name, place=place, parameters=dict(parameters))

    @classmethod
    def neutral(cls, name: str, place: int | None = None, **parameters: float) -> ActiveEffect:
        """The effect at its neutral values (those without one: typical), for derivatives at the baseline."""
        effect = find(name)
        values = {p.name: p.typical if p.neutral is None else p.neutral for p in effect.parameters} | parameters
        return cls.model_construct(name=name, place=place, parameters=values)

    @classmethod
    def typical(cls, name: str, place: int | None = None) -> ActiveEffect:
        """The effect at a moderate strength."""
        return cls.of(name, place, **{p.name: p.typical for p in find(name).parameters})

    @model_validator(mode="before")
    @classmethod
    def _gather(cls, data: Any) -> Any:
        if not isinstance(data, dict) or "parameters" in data:
            return data
        known = {key: data[key] for key in ("name", "place") if key in data}
        return known | {"parameters": {key: value for key, value in data.items() if key not in known}}

    @model_validator(mode="after")
    def _valid(self) -> Self:
        try:
            fault = _fault(self.effect, self.place, self.parameters)
        except InputError as error:
            raise ValueError(str(error)) from None
        if fault:
            raise ValueError(fault)
        return self

    def __hash__(self) -> int:
        return hash((self.name, self.place, tuple(sorted(self.parameters.items()))))

    @property
    def key(self) -> tuple[str, int | None]:
        """Name and place: what can be there once."""
        return self.name, self.place

    @property
    def effect(self) -> Effect:
        """Its description."""
        return find(self.name)

    @property
    def is_neutral(self) -> bool:
        """Whether it leaves the baseline as it is."""
        return self.effect.is_neutral(self.parameters)

    @property
    def coordinates(self) -> list[float]:
        """What the symbolic contribution takes: coordinates of the parameters, then 1 (present)."""
        return [*(p.coordinate(self.parameters[p.name]) for p in self.effect.parameters), 1.0]

    def with_coordinates(self, coordinates: Sequence[float] | Floats) -> ActiveEffect:
        """The same effect with other coordinates (P) or (P + 1), clipped to the bounds."""
        pairs = zip(self.effect.parameters, coordinates, strict=False)
        values = {p.name: min(max(p.value(float(c)), p.lower), p.upper) for p, c in pairs}
        return ActiveEffect.model_construct(name=self.name, place=self.place, parameters=values)

    def moved(self, index: int, step: float) -> ActiveEffect:
        """The same with one coordinate changed by a step, clipped to the bounds."""
        x = self.coordinates
        x[index] += step
        return self.with_coordinates(x)

    def on_body(self, body: Body, coordinates: Sequence[float]) -> ActiveEffect:
        """The same with other coordinates (P), clipped to the bounds that this body sets."""
        bounds = self.effect.coordinate_bounds(body, self.place)
        inside = [min(max(float(c), low), high) for c, (low, high) in zip(coordinates, bounds, strict=True)]
        return self.with_coordinates(inside)

    @property
    def called(self) -> str:
        """Name and place."""
        return self.name if self.place is None else f"{self.name} at {self.effect.place} {self.place}"


def of_key(effects: Sequence[ActiveEffect], key: tuple[str, int | None]) -> ActiveEffect | None:
    """The one of some effects that has this name and place."""
    return next((e for e in effects if e.key == key), None)


def joined(known: Sequence[ActiveEffect], new: Sequence[ActiveEffect]) -> tuple[ActiveEffect, ...]:
    """Known effects and new ones; a new one takes the place of a known one of its name and place."""
    given = {e.key for e in new}
    return (*(e for e in known if e.key not in given), *new)


def seen(view: View, effects: Sequence[ActiveEffect]) -> View:
    """What is seen where effects of observation are at work, one after the other; others change nothing here."""
    for active in sorted(effects, key=lambda e: (e.effect.rank, e.name)):
        if isinstance(active.effect, ObservationEffect):
            view = active.effect.on_view(view, active.place, active.parameters)
    return view


def check(effects: Sequence[ActiveEffect], body: Body) -> None:
    """Raise InputError where a set of effects does not fit a body."""
    seen = set()
    for active in effects:
        if active.key in seen:
            raise InputError(f"[[effects]] `{active.name}` is there twice at the same place; give it once.")
        seen.add(active.key)
        _refuse(_misplaced(active, body) or active.effect.fault(body, active.place, active.parameters))


def _misplaced(active: ActiveEffect, body: Body) -> str | None:
    possible = places(active.effect, body)
    if active.place in possible:
        return None
    ends = f"{possible[0]} to {possible[-1]}"
    return f"`{active.name}`: `place` must be a {active.effect.place} from {ends} of this body, got {active.place}"


def _refuse(fault: str | None) -> None:
    if fault:
        raise InputError(f"[[effects]] {fault}.")


def _fault(effect: Effect, place: int | None, values: dict[str, float]) -> str | None:
    known = {p.name: p for p in effect.parameters}
    for name in values:
        if name not in known:
            return f"`{effect.name}` has no parameter `{name}`; {meant_or_all(name, known, 'it has')}"
    missing = [name for name in known if name not in values]
    if missing:
        return f"`{effect.name}` needs `{missing[0]}` [{known[missing[0]].units}] ({known[missing[0]].meaning})"
    if (place is None) != (effect.place is None):
        remedy = f"give `place`, the number of a {effect.place}" if effect.place else "it has no `place`; leave it out"
        return f"`{effect.name}`: {remedy}"
    faults = [_out_of_bounds(effect, known[name], value) for name, value in values.items()]
    return next((fault for fault in faults if fault), None)


def _out_of_bounds(effect: Effect, p: Parameter, value: float) -> str | None:
    if p.lower <= value <= p.upper:
        return None
    unit = "" if p.unit == "1" else f" {p.unit}"
    return f"`{effect.name}`: `{p.name}` must be in [{p.lower:g}, {p.upper:g}]{unit}, got {value:g}"
