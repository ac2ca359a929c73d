"""One joint during one step of its set-point: all actuation effects, one after the other.

Legend: Q effects with memory, P coordinates.
"""

from __future__ import annotations

from functools import cache

import casadi as ca

from serpenoid.effects.catalogue import actuation_effects
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.functions import CSE


def memories() -> int:
    """Q: each of these effects remembers the angle that it let through last."""
    return sum(effect.memory for effect in actuation_effects())


@cache
def joint_step() -> ca.Function:
    """(memory (Q), before, after [rad], duration [s], theta (P)) -> memory (Q), true angle, what the servo reads."""
    kinds = actuation_effects()
    counts = [len(kind.parameters) + 1 for kind in kinds]
    memory, theta = ca.SX.sym("memory", memories()), ca.SX.sym("theta", sum(counts))
    begin, end, duration = ca.SX.sym("before"), ca.SX.sym("after"), ca.SX.sym("duration")
    parts = ca.vertsplit(theta, [0, *(sum(counts[: i + 1]) for i in range(len(counts)))])
    remembered = iter(ca.vertsplit(memory))
    before, after, states, reading = begin, end, [], end
    for kind, part in zip(kinds, parts, strict=True):
        p = kind.symbols(part)
        angle = next(remembered) if kind.memory else kind.respond(before, before, before, duration, p)
        before, after = angle, kind.respond(angle, before, after, duration, p)
        states += [after] if kind.memory else []
        reading = after if kind.shown else reading
    inputs, outputs = [memory, begin, end, duration, theta], [ca.vertcat(*states), after, reading]
    return compiled([ca.Function("joint_step", inputs, outputs, CSE)])[0]
