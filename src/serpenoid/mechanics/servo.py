"""One joint during one step of its set-point: all actuation effects, one after the other.

Legend: Q numbers that effects remember, P coordinates; n steps of C joints side by side.
"""

from __future__ import annotations

import ctypes
from functools import cache
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect
from serpenoid.effects.catalogue import actuation_effects
from serpenoid.mechanics.columns import call
from serpenoid.mechanics.compile import compiled, loaded
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.mechanics.functions import CSE
from serpenoid.mechanics.lanes import LANES, PRELUDE, flags, kernel


def memories() -> int:
    """Q: effects with memory remember the angle that they let through last, and what else they need."""
    return sum(effect.memory for effect in actuation_effects())


def play(memory: Floats, setpoints: Floats, durations: Floats, theta: Floats) -> tuple[Floats, Floats, Floats]:
    """Rows (n + 1, C) of set-points played side by side for n steps of `durations` (n,), from the memory (Q, C) of C
    joints with coordinates theta (P, C): true angles and readings (n, C), and the memory after the last step."""
    steps, columns = len(durations), setpoints.shape[1]
    run = _in_lanes()
    if run is None:
        return _one_by_one(memory, setpoints, durations, theta)
    found = [np.empty((steps, columns)), np.empty((steps, columns)), np.empty_like(memory, float)]
    call(run, columns, [memory, setpoints, durations, theta], found, steps)
    angles, readings, last = found
    return angles, readings, last


@cache
def _in_lanes() -> Any:
    """C of `play`: block after block of joints; for each of them, step after step; in each, effect after effect."""
    kinds, q, numbers = actuation_effects(), memories(), len(parameter_rows()) + len(actuation_effects())
    passed = np.cumsum([0, *(1 + max(kind.memory, 1) for kind in kinds)]) * LANES
    sizes = [2, numbers, q, q, int(passed[-1]) // LANES]
    places = [f"work + {sum(sizes[:i]) * LANES}" for i in range(len(sizes))]
    names = ["told", "own", "known", "kept", "passed"]
    arrays = "\n".join(f"  double *{name} = {place};" for name, place in zip(names, places, strict=True))
    own = np.cumsum([0, *(len(kind.parameters) + 1 for kind in kinds)]) * LANES
    remembered = np.cumsum([0, *(kind.memory for kind in kinds)]) * LANES
    there = "\n".join(f"      there[{k}] |= own[{end - LANES} + i] != 0.0;" for k, end in enumerate(own[1:]))
    through = "\n".join(
        _through(kind, f"there[{k}]", f"own + {own[k]}", remembered[k], f"passed + {passed[k]}")
        for k, kind in enumerate(kinds)
    )
    body = f"""
static void load(long n, const long k, long columns, const double *a, double *x) {{
  for (long r = 0; r < k; ++r, a += columns, x += {LANES}) {{
    memcpy(x, a, n * sizeof(double));
    for (long i = n; i < (n + 7) / 8 * 8; ++i) x[i] = a[n - 1];
  }}
}}
static void store(long n, const long k, long columns, const double *x, double *a) {{
  for (long r = 0; r < k; ++r) memcpy(a + r * columns, x + r * {LANES}, n * sizeof(double));
}}
void play(long columns, const double *memory, const double *setpoints, const double *durations, const double *theta,
          double *angles, double *readings, double *last, long steps) {{
  static _Thread_local double work[{sum(sizes) * LANES}];
{arrays}
  for (long first = 0; first < columns; first += {LANES}) {{
    const long n = columns - first < {LANES} ? columns - first : {LANES}, eights = (n + 7) / 8;
    int there[{len(kinds)}] = {{0}};
    load(n, {q}, columns, memory + first, known);
    load(n, {numbers}, columns, theta + first, own);
    for (long i = 0; i < n; ++i) {{
{there}
    }}
    for (long t = 0; t < steps; ++t) {{
      load(n, 2, columns, setpoints + t * columns + first, told);
      const double *before = told, *after = told + {LANES}, *reading = after;
{through}
      store(n, 1, columns, after, angles + t * columns + first);
      store(n, 1, columns, reading, readings + t * columns + first);
      double *const spare = known;
      known = kept, kept = spare;
    }}
    store(n, {q}, columns, known, last + first);
  }}
}}
"""
    source = PRELUDE + "".join(kernel(_response(kind), [3]) for kind in kinds) + body
    return loaded("play", source, lambda library: ctypes.CDLL(library).play, flags())


def _through(kind: ActuationEffect, there: str, own: str, memory: int, passed: str) -> str:
    """C of one step through an effect. One that none of the joints has leaves what comes to it as it is, to the last
    bit, but remembers it."""
    response, known, kept = _response(kind).name(), f"known + {memory}", f"kept + {memory}"
    given = f"{known if kind.memory else 'before'}, before, after, durations + t, {own}"
    lines = [f"if ({there}) {response}(eights, {given}, {passed}, {passed} + {LANES});"]
    if kind.memory:
        for row in range(kind.memory):
            at = f"{there} ? {passed} + {(1 + row) * LANES} : after"
            lines += [f"memcpy({kept} + {row * LANES}, {at}, {LANES} * sizeof(double));"]
        lines += [f"before = {known}, after = {kept};"]
    else:
        lines += [f"if ({there}) before = {passed}, after = {passed} + {LANES};"]
    lines += ["reading = after;"] if kind.shown else []
    return "\n".join(f"      {line}" for line in lines)


@cache
def _response(kind: ActuationEffect) -> ca.Function:
    """(what it remembers, if it does, set-points before and after [rad], duration [s], coordinates) -> what comes out
    before and after; of what it remembers then, the first."""
    before, after, duration = (ca.SX.sym(name) for name in ("before", "after", "duration"))
    last = ca.SX.sym("last", max(kind.memory, 1))
    coordinates = ca.SX.sym("coordinates", len(kind.parameters) + 1)
    p = kind.symbols(coordinates)
    known = last if kind.memory else kind.respond(before, before, before, duration, p)
    inputs = [last, before, after, duration, coordinates]
    return ca.Function(kind.name, inputs, [known[0], kind.respond(known, before, after, duration, p)], CSE)


def _one_by_one(memory: Floats, setpoints: Floats, durations: Floats, theta: Floats) -> tuple[Floats, Floats, Floats]:
    """The same where no compiler is: CasADi's map, step by step."""
    columns = setpoints.shape[1]
    over, found = _joint_step().map(columns), []
    for before, after, duration in zip(setpoints[:-1], setpoints[1:], durations, strict=True):
        states, angles, readings = evaluate(over, memory.T, before, after, np.full(columns, duration), theta.T)
        found.append((angles[0], readings[0]))
        memory = states
    angles, readings = (np.array(x) for x in zip(*found, strict=True))
    return angles, readings, memory


@cache
def joint_sensitivity() -> ca.Function:
    """One step with derivatives carried along: state (Q (1 + P)) = memory and its derivatives by theta, columnwise.

    (state, before, after [rad], duration [s], theta (P)) -> state, true angle, reading, derivatives of both by theta
    (P, 2).
    """
    plain, q = _joint_step(), memories()
    _, *inputs = plain.sx_in()
    before, after, duration, theta = inputs
    state = ca.SX.sym("state", q * (1 + theta.numel()))
    memory, carried = state[:q], ca.reshape(state[q:], q, theta.numel())
    remembered, angle, reading = plain(memory, *inputs)

    def by_theta(value: ca.SX) -> ca.SX:
        return ca.jacobian(value, memory) @ carried + ca.jacobian(value, theta)

    late = ca.jacobian(dead_time(theta), theta)

    def moved(value: ca.SX) -> ca.SX:
        """What is later was done before: by how much it turned until then."""
        rate = ca.jacobian(value, duration) + ca.jacobian(value, after) * (after - before) / duration
        return by_theta(value) - rate * late

    following = ca.densify(ca.vertcat(remembered, ca.vec(by_theta(remembered))))
    slopes = ca.densify(ca.horzcat(moved(angle).T, moved(reading).T))
    outputs = [following, angle, reading, slopes]
    return compiled([ca.Function("joint_sensitivity", [state, *inputs], outputs, CSE)])[0]


def dead_time(theta: Any) -> Any:
    """By how much later [s] all is done that a joint with coordinates theta (P,) does: of symbols, or of numbers."""
    rows = parameter_rows()
    every = ((kind, {p.name: theta[rows[kind.name, p.name]] for p in kind.parameters}) for kind in actuation_effects())
    return sum(kind.late(SimpleNamespace(**numbers)) for kind, numbers in every)


def parameter_rows() -> dict[tuple[str, str], int]:
    """(effect, parameter) -> row of theta."""
    names = [(kind.name, name) for kind in actuation_effects() for name in (*(p.name for p in kind.parameters), "")]
    return {pair: row for row, pair in enumerate(names) if pair[1]}


@cache
def _joint_step() -> ca.Function:
    """(memory (Q), before, after [rad], duration [s], theta (P)) -> memory (Q), true angle, what the servo reads."""
    kinds = actuation_effects()
    counts = [len(kind.parameters) + 1 for kind in kinds]
    memory, theta = ca.SX.sym("memory", memories()), ca.SX.sym("theta", sum(counts))
    begin, end, duration = ca.SX.sym("before"), ca.SX.sym("after"), ca.SX.sym("duration")
    parts = ca.vertsplit(theta, [0, *(sum(counts[: i + 1]) for i in range(len(counts)))])
    remembered = iter(ca.vertsplit(memory, [0, *np.cumsum([kind.memory for kind in kinds if kind.memory]).tolist()]))
    states: list[ca.SX] = []
    before, after, reading = begin, end, end
    for kind, part in zip(kinds, parts, strict=True):
        last = next(remembered) if kind.memory else before
        before, passed = _response(kind)(last, before, after, duration, part)
        states += [passed] if kind.memory else []
        after = passed[0]
        reading = after if kind.shown else reading
    inputs, outputs = [memory, begin, end, duration, theta], [ca.vertcat(*states), after, reading]
    return ca.Function("joint_step", inputs, outputs, CSE)
