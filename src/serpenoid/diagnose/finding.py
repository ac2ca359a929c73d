"""One named effect with what is known of its size; what a rung of the ladder found."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from serpenoid.effects.active import ActiveEffect


@dataclass(frozen=True)
class Named:
    """An effect, 95 % intervals by parameter, its strength in floors, and parameters that ended at a bound."""

    effect: ActiveEffect
    intervals: dict[str, tuple[float | None, float | None]]
    strength: float
    at_bound: tuple[str, ...] = ()

    def record(self) -> dict[str, Any]:
        """As it stands in diagnosis.json."""
        parameters = {}
        for p in self.effect.effect.parameters:
            low, high = self.intervals.get(p.name, (None, None))
            entry: dict[str, Any] = {"value": self.effect.parameters[p.name], "interval": [low, high], "unit": p.unit}
            if p.name in self.at_bound:
                entry["at_bound"] = True
            parameters[p.name] = entry
        effect = self.effect
        return {
            "name": effect.name, "site": effect.effect.site, "place": effect.place, "parameters": parameters,
            "strength_floors": self.strength,
        }  # fmt: skip


@dataclass(frozen=True)
class Rung:
    """What one rung says: effects named, rivals that cannot be excluded, effects too faint to name, what is left.

    left: remaining misfit in floors (1 = chance alone); words: its pattern, empty where there is none. skipped: why
    the recordings say nothing on this rung, empty where they do; untestable: effects that were no candidates, and why.
    """

    name: str
    named: tuple[Named, ...] = ()
    rivals: tuple[ActiveEffect, ...] = ()
    faint: tuple[ActiveEffect, ...] = ()
    left: float = 1.0
    words: tuple[str, ...] = field(default=())
    skipped: str = ""
    untestable: dict[str, str] = field(default_factory=dict)

    @property
    def settled(self) -> bool:
        """Whether chance is all that is left."""
        return not self.words


def interval(values: Sequence[float]) -> tuple[float | None, float | None]:
    """Ends in order, infinite ones as None."""
    ends = [None if abs(v) == float("inf") else float(v) for v in sorted(values)]
    return ends[0], ends[1]
