"""One named effect with what is known of its size; its rivals; what a stage of the ladder found."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import Any

from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.effects.active import ActiveEffect
from serpenoid.wording import listed

VISIBLE = 1.0  # times the noise level: what is smaller than noise is below detection, and if it is left not spoken of


@dataclass(frozen=True)
class Named:
    """An effect, 95 % intervals by parameter, its strength over the noise level, and parameters that ended at a bound.

    stand_in: what the model misses repeats, so that a cause which the catalogue does not hold may be behind it.
    before: values by parameter of what was there before a change; empty: it was not, and neutral values change nothing.
    gone: it was there, has no value that changes nothing, and is there no more.
    """

    effect: ActiveEffect
    intervals: dict[str, tuple[float | None, float | None]]
    strength: float
    at_bound: tuple[str, ...] = ()
    stand_in: bool = False
    before: Mapping[str, float] = field(default_factory=dict)
    gone: bool = False

    @property
    def may_change_nothing(self) -> bool:
        """Whether intervals of all of its parameters hold what changes nothing, however much it takes away."""
        rests = [
            (self.before.get(p.name, p.neutral), *self.intervals[p.name])
            for p in self.effect.effect.parameters
            if p.neutral is not None
        ]
        return bool(rests) and all(
            (-inf if low is None else low) <= rest <= (inf if high is None else high) for rest, low, high in rests
        )

    def record(self) -> dict[str, Any]:
        """As it stands in diagnosis.json."""
        parameters = {}
        for p in self.effect.effect.parameters:
            low, high = self.intervals.get(p.name, (None, None))
            value = self.effect.parameters[p.name]
            entry: dict[str, Any] = {"value": None if abs(value) == inf else value, "interval": [low, high]}
            if p.name in self.at_bound:
                entry["at_bound"] = True
            if p.name in self.before:
                entry["before"] = self.before[p.name]
            parameters[p.name] = entry
        effect = self.effect
        return {
            "name": effect.name, "site": effect.effect.site, "place": effect.place, "parameters": parameters,
            "strength_over_noise": self.strength, "stand_in": self.stand_in, **({"gone": True} if self.gone else {}),
        }  # fmt: skip


@dataclass(frozen=True)
class Rival:
    """An effect that could stand in the place of a chosen one.

    separation: S_ab over the noise level, the RMS between what the two predict on the stage's own scale.
    """

    effect: ActiveEffect
    instead_of: ActiveEffect
    separation: float

    def record(self) -> dict[str, Any]:
        """As it stands in diagnosis.json."""
        e, other = self.effect, self.instead_of
        return {
            "name": e.name, "site": e.effect.site, "place": e.place, "parameters": dict(e.parameters),
            "instead_of": {"name": other.name, "place": other.place}, "separation_over_noise": self.separation,
        }  # fmt: skip


def excludable(chi2: float, least: float, count: float, band: float, slack: float = 0.0) -> bool:
    """Whether the data exclude a fit: chi squared above the least of `count` residuals by more than chance explains.

    band: what the least would gain by chance if the other one were true (prices.most_gained). Where even the best fit
    leaves more than chance, differences count for as much less.
    """
    return chi2 - least > band * max(1.0, least / count) + slack


@dataclass(frozen=True)
class Divided:
    """What acts in some trials alone. words: what is said of it; changed, others: names of trials, empty where it is
    not known which are which; perhaps: it may act in all of them, and show in some, unless those tell it by themselves.
    grows: where it may grow from trial to trial, by how much it may differ within the changed ones, over what it is.
    any_gait: no gait makes it, so that sides with no gait in common are two, too.
    hint: it is less than most of what repeats differ by, and nothing follows but these words. cause: what differs, to
    first order, if that is known.
    """

    words: str
    changed: tuple[str, ...] = ()
    others: tuple[str, ...] = ()
    perhaps: bool = False
    grows: float = 0.0
    hint: bool = False
    cause: str = ""
    any_gait: bool = False


def alone(changed: Sequence[str], others: Sequence[str]) -> str:
    """Which trials something acts in, by what is shorter."""
    few, names = (changed, "") if len(changed) <= len(others) else (others, "all but ")
    return f"{names}{listed([f'`{name}`' for name in few])}"


@dataclass(frozen=True)
class Stage:
    """What one stage says: effects named, rivals that cannot be excluded, effects too weak to name, what is left.

    discrepancy_m: what repeats share and no effect accounts for, RMS of a window [m]; 0 where chance is all.
    left: remaining misfit over the noise level (1 = chance alone); words: its pattern, empty where there is none.
    skipped: why the recordings say nothing on this stage, empty where they do; untestable: effects that were no
    candidates, and why. laws, drag_at: how other laws, by name, how drag elsewhere on the body does, where it does
    better; law_taken: why another law than the file's default is taken.
    unlike, ratio: the effect by which parts of a kind differ from one another, if they do, and ends of eps beside it.
    squares: of the markers' stage, of each channel and of all together, what nothing accounts for in units of noise.
    news: of that stage, too, of each channel, which share of what is left was not left before, if visibly; else 0.
    mend: what to mend in the campaign before the rest is believed. divided: how trials are by what acts in some alone.
    hiding: of the motion, what hides in its noise, if that can be told.
    each: of that stage, the observation model of each trial, where markers are elsewhere in each.
    """

    name: str
    named: tuple[Named, ...] = ()
    rivals: tuple[Rival, ...] = ()
    undetected: tuple[Named, ...] = ()
    left: float = 1.0
    words: tuple[str, ...] = field(default=())
    skipped: str = ""
    untestable: dict[str, str] = field(default_factory=dict)
    discrepancy_m: float = 0.0
    laws: dict[str, str] = field(default_factory=dict)
    law_taken: str = ""
    drag_at: str = ""
    unlike: str = ""
    ratio: tuple[float, float] | None = None
    squares: tuple[float, ...] = ()
    news: tuple[float, ...] = ()
    mend: str = ""
    divided: Divided | None = None
    each: tuple[Observation, ...] = ()
    hiding: str = ""

    def naming(self, every: Sequence[Named]) -> Stage:
        """With these names; stand-ins that may change nothing are none, and too weak, and have no rivals."""
        named = tuple(n for n in every if not (n.stand_in and n.may_change_nothing))
        weak = (*self.undetected, *(n for n in every if n not in named))
        keys = {n.effect.key for n in named}
        return replace(
            self, named=named, undetected=weak, rivals=tuple(r for r in self.rivals if r.instead_of.key in keys)
        )

    @property
    def acting(self) -> list[ActiveEffect]:
        """What is named and there."""
        return [n.effect for n in self.named if not n.gone]

    @property
    def gone(self) -> list[ActiveEffect]:
        """What is named and there no more."""
        return [n.effect for n in self.named if n.gone]

    @property
    def settled(self) -> bool:
        """Whether chance is all that is left."""
        return not self.words


def interval(values: Sequence[float]) -> tuple[float | None, float | None]:
    """Ends in order, infinite ones as None."""
    ends = [None if abs(v) == float("inf") else float(v) for v in sorted(values)]
    return ends[0], ends[1]
