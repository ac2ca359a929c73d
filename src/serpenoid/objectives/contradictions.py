"""Demands that no gait can meet together, told by arithmetic, before anything is solved.

Each demand confines numbers of the motion (`Demand.asks`): displacement, place and heading at a step or after some
cycles, joint angles at a row. Intervals of the same number that do not meet contradict each other. A convex room that
the body must stay in holds its centroid, which begins at the origin; in an obstacle to go round it is at most a body
length deep. Two edges are never farther apart than the edges between them reach. What is not found here may be
impossible all the same: the solver says so.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.objectives.obstacles import Obstacle
from serpenoid.objectives.reach import Reach
from serpenoid.objectives.self_clearance import SelfClearance
from serpenoid.objectives.term import Ask, Demand, Rows
from serpenoid.wording import counted

SLACK = 1e-9  # rounding of what the file says


def contradiction(
    demands: Sequence[Demand], rows: Rows, edges: Floats, others: Sequence[tuple[str, Ask]]
) -> str | None:
    """What two of the demands, or one and what else is asked (`others`: name, Ask), ask that excludes each other.

    edges: lengths (N - 1) of the body's edges [body lengths].
    """
    named = [(f"[[task.demands]] {i} ({d.kind})", d) for i, d in enumerate(demands, start=1)]
    asks = [*others, *((name, ask) for name, demand in named for ask in demand.asks(rows))]
    for i, (name, ask) in enumerate(asks):
        for before, other in asks[:i]:
            if ask.quantity == other.quantity and max(ask.lower, other.lower) > min(ask.upper, other.upper) + SLACK:
                return f"{before} and {name} contradict each other: {ask.quantity} {_words(other)} and {_words(ask)}"
    for name, demand in named:
        if isinstance(demand, SelfClearance) and demand.between > len(edges) - 2:
            return (
                f"{name} between: no two of the body's {len(edges)} edges have {demand.between} between them. Ask for "
                "fewer, or leave the demand out"
            )
        if isinstance(demand, SelfClearance) and demand.distance > (most := demand.most(edges)) + SLACK:
            return (
                f"{name} distance must be at most {most:.3g}, as far as the {counted(demand.between, 'edge')} between "
                f"two others reach, got {demand.distance:g}. Ask for less, or for edges with more `between`"
            )
        if isinstance(demand, Obstacle):
            for place, where, radius in [("where the body begins", (0.0, 0.0), 0.0), *_targets(named)]:
                deep = demand.clearance - float(demand.gap(np.array([where]))[0]) - radius - demand.room
                if deep > SLACK:
                    return f"{name} forbids {place}, by {deep:.3g} body lengths, however the body bends"
    return None


def _targets(named: Sequence[tuple[str, Demand]]) -> list[tuple[str, tuple[float, float], float]]:
    """Places in the frame of the first row that the centroid must reach."""
    return [(f"the place of {name}", d.target, d.radius) for name, d in named if isinstance(d, Reach) and d.cycles == 1]


def _words(ask: Ask) -> str:
    if ask.lower == ask.upper:
        return f"is {ask.lower:g}"
    return f"from {ask.lower:g} to {ask.upper:g}" if np.isfinite(ask.lower) else f"at most {ask.upper:g}"
