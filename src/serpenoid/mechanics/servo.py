"""One joint during one step of its set-point: all actuation effects, one after the other.

Legend: Q effects with memory, P coordinates.
"""

from __future__ import annotations

from functools import cache

import casadi as ca

from serpenoid.effects.catalogue import actuation_effects
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.functions import CSE

SERIES = (32, 256)  # steps of one call


def memories() -> int:
    """Q: each of these effects remembers the angle that it let through last."""
    return sum(effect.memory for effect in actuation_effects())


@cache
def joint_series() -> dict[int, ca.Function]:
    """By their number of steps: (memory (Q), before (1, n), after (1, n), durations (1, n), theta (P)) -> memory after
    each step (Q, n), true angles (1, n), readings (1, n)."""
    return dict(zip(SERIES, compiled([_series(count) for count in SERIES]), strict=True))


def _series(count: int) -> ca.Function:
    step = _joint_step()
    inputs = [ca.MX.sym(step.name_in(0), memories()), *(ca.MX.sym(step.name_in(i), 1, count) for i in (1, 2, 3))]
    theta = ca.MX.sym("theta", step.size1_in(4))
    outputs = step.mapaccum(count)(*inputs, ca.repmat(theta, 1, count))
    return ca.Function(f"joint_series_{count}", [*inputs, theta], list(outputs))


@cache
def joint_sensitivity() -> ca.Function:
    """One step with derivatives carried along: state (Q (1 + P)) = memory and its derivatives by theta, columnwise.

    (state, before, after [rad], duration [s], theta (P)) -> state, true angle, reading, derivatives of both by theta
    (P, 2).
    """
    plain, q = _joint_step(), memories()
    _, *inputs = plain.sx_in()
    theta = inputs[-1]
    state = ca.SX.sym("state", q * (1 + theta.numel()))
    memory, carried = state[:q], ca.reshape(state[q:], q, theta.numel())
    remembered, angle, reading = plain(memory, *inputs)

    def by_theta(value: ca.SX) -> ca.SX:
        return ca.jacobian(value, memory) @ carried + ca.jacobian(value, theta)

    following = ca.densify(ca.vertcat(remembered, ca.vec(by_theta(remembered))))
    slopes = ca.densify(ca.horzcat(by_theta(angle).T, by_theta(reading).T))
    outputs = [following, angle, reading, slopes]
    return compiled([ca.Function("joint_sensitivity", [state, *inputs], outputs, CSE)])[0]


def parameter_rows() -> dict[tuple[str, str], int]:
    """(effect, parameter) -> row of theta."""
    names = [(kind.name, name) for kind in actuation_effects() for name in (*(p.name for p in kind.parameters), "")]
    return {pair: row for row, pair in enumerate(names) if pair[1]}


def _joint_step() -> ca.Function:
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
    return ca.Function("joint_step", inputs, outputs, CSE)
