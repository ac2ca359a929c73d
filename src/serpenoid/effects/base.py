"""What an effect is: a name, a site, a kind of place, parameters, a symbolic contribution, and words for people.

Every parameter has a *coordinate*: what the symbolic contribution takes, and what a fit varies. It is the value itself,
or a power of it where the neutral value is infinite (a grip that never saturates), so that derivatives exist there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Set
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any, ClassVar, Literal, get_args

import casadi as ca
import numpy as np

from serpenoid.body import Body, Floats, Part
from serpenoid.effects.element import Drag, Element
from serpenoid.effects.scan import Scan
from serpenoid.effects.view import View
from serpenoid.errors import InputError
from serpenoid.media import LAWS, Law

Site = Literal["actuation", "medium", "observation"]
Marks = Literal["zeros", "gaps", "markers", "ahead", "scale", "axes", "rate", "frame", "jumps"]
Values = Mapping[str, float]
Symbols = SimpleNamespace
Place = Literal["vertex", "joint"]
Knows = Literal["speed", "clock", "place", "history"]
USES = ("simulate", "nlp", "fit", "diagnose")


@dataclass(frozen=True)
class Parameter:
    """One number of an effect, in `unit`; `neutral` None: it only matters beside the others (where a patch lies).

    over_drag: whether it is a force over the drag level, that of a slip of 1 m/s. Such a force is told by the speed at
    which linear drag is as large; as a share of dry friction, which is the same at any speed: in a medium of any degree
    by a power of that speed (see `unit_in`).
    power: the coordinate is value ** power; 1 (the value itself), 2 where only the square matters, or negative where
    the neutral value is infinite.
    typical: a moderate value, for examples and tests, and the coordinate's scale in fits.
    resolution: how well instruments can tell it at all, whatever the noise; intervals are no narrower.
    across: by how much fits change the coordinate where set-points jump, so that some readings are moved across a jump;
    0: as little as elsewhere.
    """

    name: str
    unit: str
    lower: float
    upper: float
    neutral: float | None
    typical: float
    meaning: str
    power: int = 1
    resolution: float = 0.0
    over_drag: bool = False
    across: float = 0.0

    def __post_init__(self) -> None:
        if not self.lower < self.upper:
            raise InputError(f"`{self.name}`: `lower` must be below `upper`, got {self.lower:g} and {self.upper:g}.")
        for word, value in (("neutral", self.neutral), ("typical", self.typical)):
            if value is not None and not self.lower <= value <= self.upper:
                inside = f"[{self.lower:g}, {self.upper:g}]"
                raise InputError(f"`{self.name}`: `{word}` must be in {inside}, its own bounds, got {value:g}.")
        if self.typical == self.neutral:
            raise InputError(
                f"`{self.name}`: `typical` must be another value than `neutral`, got {self.typical:g} twice."
            )

    def unit_in(self, law: Law) -> str:
        """The unit in a medium of this law: a force over the drag level is a speed to the power of (degree - 1)."""
        return _times_speed(self.unit, law.degree - 2) if self.over_drag else self.unit

    def coordinate(self, value: float) -> float:
        """The number that the symbolic contribution takes."""
        return value if self.power == 1 else value**self.power

    def value(self, coordinate: float) -> float:
        """The public value of a coordinate; a coordinate of zero stands for infinity where the power is negative."""
        if self.power == 1:
            return coordinate
        if self.power > 1:
            return max(coordinate, 0.0) ** (1 / self.power)
        return math.inf if coordinate <= 0 else coordinate ** (1 / self.power)

    @property
    def units(self) -> str:
        """The unit, and those in media of other laws where they are others; of laws of one degree the first is told."""
        first = {self.unit_in(law): law.title for law in reversed(LAWS.values())}
        others = [f"with {title} {unit}" for unit, title in reversed(first.items()) if unit != self.unit]
        return "; ".join([self.unit, *others])

    def small(self, jumps: bool = False) -> float:
        """By how much fits change the coordinate to see what that does; jumps: whether set-points do."""
        return (self.across if jumps else 0.0) or 1e-4 * max(abs(self.coordinate(self.typical)), 1e-3)

    @property
    def resting(self) -> float:
        """Coordinate where the effect is absent."""
        return self.coordinate(self.typical if self.neutral is None else self.neutral)


def _times_speed(unit: str, power: int) -> str:
    """The unit (`m/s`, `s2/m`, `1`; a digit is a power) of a quantity in `unit` times a speed to this power."""
    powers = {"m": power, "s": -power}
    for i, part in enumerate(unit.split("/")):
        if part != "1":
            powers[part[0]] += int(part[1:] or 1) * (1 if i == 0 else -1)
    over, under = ([f"{u}{abs(n) if abs(n) > 1 else ''}" for u, n in powers.items() if n * s > 0] for s in (1, -1))
    return "/".join(["".join(over) or "1", *under])


@dataclass(frozen=True)
class Advice:
    """What a reader is told about an effect that was found."""

    looks_like: str
    what_to_do: str


@dataclass(frozen=True, eq=False)
class Effect:
    """Description of one physical effect; each file of the catalogue makes one instance, called EFFECT.

    needs: what must be there for it to act (see `Body.parts`). of_animals: its words where a body is one; None: the
    same. reasons: for each use (simulate, nlp, fit, diagnose) that does not apply, why not. rank: in what order
    contributions are applied where it matters. marks: which numbers between the servos' chain and the data are its own:
    the joints' `zeros`, their `gaps`, where `markers` sit on the links behind them or on those `ahead`, the `scale`,
    how the camera's `axes` differ, the clock's `rate`, how the `frame` moves that positions are seen in, its `jumps`
    across gaps; None: none, it changes how the body moves. scan: how a diagnosis looks for it where it lies somewhere
    on the floor; None: by derivatives about its neutral values.
    """

    name: str
    place: Place | None
    parameters: tuple[Parameter, ...]
    looks_like: str
    what_to_do: str
    needs: frozenset[Part] = frozenset()
    of_animals: Advice | None = None
    reasons: Mapping[str, str] = field(default_factory=dict)
    rank: int = 10
    marks: Marks | None = None
    scan: Scan | None = None
    laws: ClassVar[tuple[str, ...]] = ()  # methods, of which it must have one of its own

    def __post_init__(self) -> None:
        """InputError where its file says what nothing looks for, or has no law: the effect would do nothing."""
        if not isinstance(self.parameters, tuple) or not self.parameters:
            got = type(self.parameters).__name__
            raise InputError(f"effect `{self.name}`: `parameters` must be a tuple of Parameter, got {got}.")
        for key, words, known in self.vocabulary:
            for word in words - set(known):
                may = ", ".join(map(str, known))
                raise InputError(f"effect `{self.name}`: `{key}` must be of {may}, got `{word}`.")
        own = type(self)
        if self.laws and all(getattr(own, law).__module__ == __name__ for law in self.laws):
            methods = "` or `".join(self.laws)
            raise InputError(f"effect `{self.name}`: {own.__name__} must have a method `{methods}`, got none.")

    @property
    def vocabulary(self) -> list[tuple[str, Set[Any], tuple[Any, ...]]]:
        """Keys whose words others look for: what is said there, what may be."""
        return [
            ("place", {self.place}, (None, *get_args(Place))),
            ("marks", {self.marks}, (None, *get_args(Marks))),
            ("needs", self.needs, get_args(Part)),
            ("reasons", self.reasons.keys(), USES),
        ]

    @property
    def site(self) -> Site:
        """Where it sits between command and data."""
        raise NotImplementedError

    @property
    def moves(self) -> bool:
        """Whether the motion that cameras see shows it: as a change of how the body moves, or their frame."""
        return self.marks == "frame"

    @property
    def remembers(self) -> bool:
        """Whether what happened before matters."""
        return False

    @property
    def of_the_room(self) -> bool:
        """Whether it depends on where on the floor the body is, or on its heading there."""
        return self.marks == "frame"

    def acts_in(self, law: str) -> bool:
        """Whether it can be there in a medium of this law."""
        return True

    def places(self, body: Body) -> list[int | None]:
        """Where it can sit on a body: at its vertices, at its joints, or nowhere in particular."""
        if self.place is None:
            return [None]
        return list(range(body.vertices)) if self.place == "vertex" else list(range(1, body.joint_count + 1))

    def words(self, animal: bool) -> Advice:
        """What it looks like and what to do, of a robot or of an animal."""
        return self.of_animals if animal and self.of_animals else Advice(self.looks_like, self.what_to_do)

    def applies_to(self, use: str) -> bool:
        """Whether it can be used to `simulate`, in the `nlp`, in a `fit`, in `diagnose`."""
        return use not in self.reasons

    def is_neutral(self, values: Values) -> bool:
        """Whether these values leave the baseline as it is."""
        neutral = [p for p in self.parameters if p.neutral is not None]
        return bool(neutral) and all(values[p.name] == p.neutral for p in neutral)

    def coordinate_bounds(self, body: Body, place: int | None) -> list[tuple[float, float]]:
        """Lower and upper bound of every parameter's coordinate, for fits on this body."""
        ends = [(p.coordinate(p.lower), p.coordinate(p.upper)) for p in self.parameters]
        return [(min(pair), max(pair)) for pair in ends]

    def fault(self, body: Body, place: int | None, values: Values) -> str | None:
        """A rule beyond bounds that these values break on this body, as a sentence."""
        return None

    def symbols(self, coordinates: ca.SX) -> Symbols:
        """Coordinates (P + 1) under the parameters' names; the last one, `present`, is 1 where the effect sits."""
        names = [*(p.name for p in self.parameters), "present"]
        return SimpleNamespace(**dict(zip(names, ca.vertsplit(coordinates), strict=True)))


@dataclass(frozen=True, eq=False)
class MediumEffect(Effect):
    """Shape to motion. Override `on_element` (geometry, weights, pushes, momentum) or `on_drag` (the force law).

    knows: what the contribution depends on beyond the shapes: `speed` (seconds per step), `clock` (seconds since the
    start), `place` (pose on the floor), `history` (momentum of the steps before). scales_ratio: whether it multiplies
    the anisotropy ratio itself, and so would carry it beyond what a medium's bounds allow. of_degree: of the laws that
    it makes another of (`Law.degree`), None: of any. Dry friction is none on top of Coulomb's (degree 1). of_the_law:
    whether its values are numbers of that law, as eps is: a diagnosis calibrates them with eps, and names no cause.
    costly: whether it takes a step much longer, so that bodies without it have compiled steps of their own.
    """

    knows: frozenset[Knows] = frozenset()
    scales_ratio: bool = False
    of_degree: int | None = None
    of_the_law: bool = False
    costly: bool = False
    laws: ClassVar[tuple[str, ...]] = ("on_element", "on_drag")

    @property
    def vocabulary(self) -> list[tuple[str, Set[Any], tuple[Any, ...]]]:
        """And what it knows: of another word nothing would be told to it."""
        return [*super().vocabulary, ("knows", self.knows, get_args(Knows))]

    @property
    def site(self) -> Site:
        """Medium."""
        return "medium"

    @property
    def moves(self) -> bool:
        """The body."""
        return True

    @property
    def remembers(self) -> bool:
        """Momentum of the steps before."""
        return "history" in self.knows

    @property
    def of_the_room(self) -> bool:
        """By its law."""
        return "place" in self.knows

    def acts_in(self, law: str) -> bool:
        """See `of_degree`."""
        return self.of_degree in (None, LAWS[law].degree)

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
class Wave:
    """The periodic angle of one joint, `at(row)` [rad], rows 0 .. steps; duration of a step [s].

    An elliptical gait commands a sine about a mean: mean + cosine cos(2 pi row / steps) + sine sin(...).
    """

    at: Callable[[ca.SX], ca.SX]
    steps: int
    duration: float

    @property
    def harmonic(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Mean, cosine and sine of a wave that is still a sine."""
        quarters = [self.at(ca.SX(self.steps * i / 4)) for i in range(4)]
        mean = (quarters[0] + quarters[2]) / 2
        return mean, quarters[0] - mean, quarters[1] - mean

    def later(self, rows: ca.SX) -> Wave:
        """A wave so many rows later, on straight lines from row to row."""
        whole = ca.floor(rows)
        part = rows - whole

        def at(row: ca.SX) -> ca.SX:
            return (1 - part) * self.at(row - whole) + part * self.at(row - whole - 1)

        return replace(self, at=at)

    def filtered(self, top: tuple[ca.SX, ca.SX], bottom: tuple[ca.SX, ca.SX]) -> Wave:
        """A sine that comes out smaller or larger, and later: by a factor top / bottom, each (real, imaginary)."""
        size = bottom[0] ** 2 + bottom[1] ** 2
        real = (top[0] * bottom[0] + top[1] * bottom[1]) / size
        imaginary = (top[1] * bottom[0] - top[0] * bottom[1]) / size
        mean, cosine, sine = self.harmonic

        def at(row: ca.SX) -> ca.SX:
            angle = 2 * ca.pi * row / self.steps
            direct = cosine * ca.cos(angle) + sine * ca.sin(angle)
            quarter_later = sine * ca.cos(angle) - cosine * ca.sin(angle)
            return mean + real * direct + imaginary * quarter_later

        return replace(self, at=at)


@dataclass(frozen=True, eq=False)
class ActuationEffect(Effect):
    """Command to shape. `respond` takes one joint from one time to the next; `in_gait` is what it settles on.

    memory: how many numbers of what went before the answer depends on: the joint's angle, then others that are equal to
    it at rest. shown: whether the servo's reading shows the true angle.
    limits: whether an optimised gait stays slow enough to be played as it is commanded (`speed_limit`). dead_time:
    whether its one parameter is a time [s] by which all joints are told later: laws that do not know the time are the
    same before and after that.
    """

    memory: int = 0
    shown: bool = True
    limits: bool = False
    dead_time: bool = False
    needs_seconds: bool = False
    laws: ClassVar[tuple[str, ...]] = ("respond",)

    @property
    def site(self) -> Site:
        """Actuation."""
        return "actuation"

    def starts(self, readings: Floats, quickest: Floats) -> list[Floats]:
        """Coordinates (m,), by joint, where fits of its parameter to readings (R, m) [rad], NaN unread, may begin; of
        several parameters (P, m). quickest: speed (m,) of the set-points [rad/s]."""
        return [np.full(readings.shape[1], self.parameters[0].resting)]

    def held_at(self, values: Values) -> float | None:
        """The angle [rad] at which its joint stands, whatever is commanded; None: it is driven."""
        return None

    def late(self, p: Symbols) -> Any:
        """By how much later [s] all is done that servos do: of symbols, or of numbers."""
        return getattr(p, self.parameters[0].name) if self.dead_time else 0.0

    def respond(self, angle: ca.SX, before: ca.SX, after: ca.SX, duration: ca.SX, p: Symbols) -> ca.SX:
        """Joint angle after `duration` [s] of a set-point that runs linearly from `before` to `after` [rad]; `angle`:
        before it. Where more is remembered, both are columns of all that is."""
        raise NotImplementedError

    def in_gait(self, wave: Wave, p: Symbols) -> Wave:
        """The wave that comes out when `wave` goes in again and again: for the NLP. As it stands: without memory."""
        if self.memory:
            raise NotImplementedError

        def at(row: ca.SX) -> ca.SX:
            angle = wave.at(row)
            return self.respond(angle, angle, angle, ca.SX(wave.duration), p)

        return replace(wave, at=at)

    def speed_limit(self, values: Values) -> float:
        """Joint speed [rad/s] that an optimised gait must not exceed."""
        return math.inf


@dataclass(frozen=True, eq=False)
class ObservationEffect(Effect):
    """Motion to data: what cameras and clocks make of it. Everything in SI, by numbers."""

    laws: ClassVar[tuple[str, ...]] = ("on_view",)

    @property
    def site(self) -> Site:
        """Observation."""
        return "observation"

    def on_view(self, view: View, place: int | None, values: Values) -> View:
        """Change what is seen."""
        raise NotImplementedError
