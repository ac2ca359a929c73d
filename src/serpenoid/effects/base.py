"""What an effect is: a name, a site, a kind of place, parameters, a symbolic contribution, and words for people.

Every parameter has a *coordinate*: what the symbolic contribution takes, and what a fit varies. It is the value itself,
or a power of it where the neutral value is infinite (a grip that never saturates), so that derivatives exist there.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Literal

import casadi as ca

from serpenoid.body import Body
from serpenoid.effects.element import Drag, Element
from serpenoid.effects.view import View

Site = Literal["actuation", "medium", "observation"]
Values = Mapping[str, float]
Symbols = SimpleNamespace
USES = ("simulate", "nlp", "fit", "diagnose")


@dataclass(frozen=True)
class Parameter:
    """One number of an effect, in `unit`; `neutral` None: it only matters beside the others (where a patch lies).

    power: the coordinate is value ** power; 1 (the value itself), or negative where the neutral value is infinite.
    typical: a moderate value, for examples and tests, and the coordinate's scale in fits.
    """

    name: str
    unit: str
    lower: float
    upper: float
    neutral: float | None
    typical: float
    meaning: str
    power: int = 1

    def coordinate(self, value: float) -> float:
        """The number that the symbolic contribution takes."""
        return value if self.power == 1 else value**self.power

    def value(self, coordinate: float) -> float:
        """The public value of a coordinate; a coordinate of zero stands for infinity where the power is negative."""
        if self.power == 1:
            return coordinate
        return math.inf if coordinate <= 0 else coordinate ** (1 / self.power)

    @property
    def resting(self) -> float:
        """Coordinate where the effect is absent."""
        return self.coordinate(self.typical if self.neutral is None else self.neutral)


@dataclass(frozen=True)
class Effect:
    """Description of one physical effect; each file of the catalogue makes one instance, called EFFECT.

    reasons: for each use (simulate, nlp, fit, diagnose) that does not apply, why not. rank: in what order contributions
    are applied where it matters. single: at most one in a model (else: one per place).
    """

    name: str
    place: Literal["vertex", "joint"] | None
    parameters: tuple[Parameter, ...]
    looks_like: str
    what_to_do: str
    reasons: Mapping[str, str] = field(default_factory=dict)
    rank: int = 10

    @property
    def site(self) -> Site:
        """Where it sits between command and data."""
        raise NotImplementedError

    def applies_to(self, use: str) -> bool:
        """Whether it can be used to `simulate`, in the `nlp`, in a `fit`, in `diagnose`."""
        return use not in self.reasons

    def is_neutral(self, values: Values) -> bool:
        """Whether these values leave the baseline as it is."""
        neutral = [p for p in self.parameters if p.neutral is not None]
        return bool(neutral) and all(values[p.name] == p.neutral for p in neutral)

    def fault(self, body: Body, place: int | None, values: Values) -> str | None:
        """A rule beyond bounds that these values break on this body, as a sentence."""
        return None

    def symbols(self, coordinates: ca.SX) -> Symbols:
        """Coordinates (P + 1) under the parameters' names; the last one, `present`, is 1 where the effect sits."""
        names = [*(p.name for p in self.parameters), "present"]
        return SimpleNamespace(**dict(zip(names, ca.vertsplit(coordinates), strict=True)))


@dataclass(frozen=True)
class MediumEffect(Effect):
    """Shape to motion. Override `on_element` (geometry, weights, pushes, momentum) or `on_drag` (the force law).

    knows: what the contribution depends on beyond the shapes: `speed` (seconds per step), `clock` (seconds since the
    start), `place` (pose on the floor), `history` (momentum of the steps before).
    """

    knows: frozenset[str] = frozenset()

    @property
    def site(self) -> Site:
        """Medium."""
        return "medium"

    def on_element(self, element: Element, p: Symbols) -> Element:
        """Change what meets the floor at one vertex."""
        return element

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Change the law of the drag at one vertex, at one end of the step."""
        return drag

    def is_present(self, vertex: int, vertices: int) -> bool:
        """Whether an effect without a place acts on this vertex."""
        return True

    @property
    def needs_seconds(self) -> bool:
        """Whether the duration of a step must be known."""
        return bool(self.knows & {"speed", "clock", "history"})


@dataclass(frozen=True)
class ActuationEffect(Effect):
    """Command to shape. `respond` takes one joint from one time to the next.

    memory: whether the answer depends on the angle before. shown: whether the servo's reading shows the true angle.
    """

    memory: bool = False
    shown: bool = True
    needs_seconds: bool = False

    @property
    def site(self) -> Site:
        """Actuation."""
        return "actuation"

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Joint angle after `duration` [s] of a set-point that runs linearly from `before` to `after` [rad]."""
        raise NotImplementedError


@dataclass(frozen=True)
class ObservationEffect(Effect):
    """Motion to data: what cameras and clocks make of it. Everything in SI, by numbers."""

    @property
    def site(self) -> Site:
        """Observation."""
        return "observation"

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Change what is seen."""
        raise NotImplementedError
