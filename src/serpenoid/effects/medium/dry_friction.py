"""A share of dry (Coulomb) friction: F -> F (1 + crossover_speed / |v|); below the crossover speed it prevails."""

from __future__ import annotations

from serpenoid.effects.base import Advice, MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Drag


class DryFriction(MediumEffect):
    """Forces that do not vanish with the speed; the norm is softened below 1 mm/s."""

    def on_drag(self, drag: Drag, p: Symbols) -> Drag:
        """Add the part that does not know speed."""
        return drag.by_speed(1, p.crossover_speed / drag.speed)


EFFECT = DryFriction(
    name="dry_friction",
    place=None,
    parameters=(Parameter("crossover_speed", "m/s", 0.0, 5.0, 0.0, 0.05, "speed at which both parts are equal"),),
    looks_like="slow cycles carry the body elsewhere than quick ones; slow vertices hold, fast ones let go",
    what_to_do="expect it with rubber on a hard floor; compare two cycle durations to be sure",
    needs=frozenset({"ground"}),
    of_animals=Advice(
        looks_like="slow beats carry the body elsewhere than quick ones; slow parts hold, fast ones let go",
        what_to_do="expect it on dry ground; compare slow and quick beats to be sure",
    ),
    rank=31,
    knows=frozenset({"speed"}),
    of_degree=2,
    costly=True,
)
