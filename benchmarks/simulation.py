"""Forward simulation of one cycle, 12 vertices x 50 steps, against a plain SciPy root-finding loop."""

from __future__ import annotations

import numpy as np
from bench import Timing, evaluation, in_units, report, side_by_side, table

from serpenoid.body import Floats
from serpenoid.mechanics.tables import joint_table
from serpenoid.model import Model
from serpenoid.simulation import simulate_batch, simulate_joint_angles
from serpenoid.simulation import steps as kernel
from specimens import oracle_run, problem

BATCH, ROUNDS = 200, 15


def inside(model: Model, one: Floats) -> dict[str, Timing]:
    """Parts of a single call."""
    rows = np.concatenate([one, one[:1]])
    _, elements = kernel.shape_rows(model, rows)
    before, after = elements[:, :-12], elements[:, 12:]
    work = {
        "shapes of 51 rows": (lambda: kernel.shape_rows(model, rows), 50),
        "roots of 50 steps": (lambda: kernel.solve_steps(model, before, after), 50),
        "whole call": (lambda: simulate_joint_angles(model, one), 50),
    }
    return side_by_side(work, ROUNDS)


def main() -> None:
    asked = problem("reference")
    model, rng = asked.model, np.random.default_rng(0)
    q = asked.gait.parameters
    gaits = np.array([q * np.append(rng.uniform(0.6, 1.0, 5), 1.0) for _ in range(BATCH)])
    tables = np.array([joint_table(model, gait, 50) for gait in gaits])
    one = tables[0]
    timings, parts = {}, {}
    for compiled in (True, False):
        word = "compiled" if compiled else "virtual machine"
        with evaluation(compiled):
            work = {
                f"batch of {BATCH}, {word}": (lambda: simulate_batch(model, tables), 1),
                f"single, {word}": (lambda: simulate_joint_angles(model, one), 10),
                f"SciPy loop beside it, {word}": (lambda: oracle_run(model, one), 1),
            }
            timings |= side_by_side(work, ROUNDS)
            if compiled:
                parts = inside(model, one)
    scipy = min(t.fastest for name, t in timings.items() if name.startswith("SciPy"))
    lines = []
    for name, timing in timings.items():
        per_cycle = timing.fastest / (BATCH if name.startswith("batch") else 1)
        median = timing.median / (BATCH if name.startswith("batch") else 1)
        lines.append([name, in_units(per_cycle), in_units(median), f"{scipy / per_cycle:.0f}x"])
    best = timings[f"batch of {BATCH}, compiled"].fastest / BATCH
    targets = table(
        ["target", "asked", "found", "met"],
        [
            ["a cycle in a batch, compiled", "35 us", in_units(best), "yes" if best <= 35e-6 else "no"],
            ["against the SciPy loop", "300x", f"{scipy / best:.0f}x", "yes" if scipy / best >= 300 else "no"],
        ],
    )
    whole = parts["whole call"].fastest
    shares = [[name, in_units(t.fastest), f"{t.fastest / whole:.0%}"] for name, t in parts.items()]
    report(
        "simulation",
        "Forward simulation, one cycle of 12 vertices x 50 steps",
        targets,
        table(["one cycle by", "fastest", "median", "against SciPy's fastest"], lines),
        "Where the time of a single compiled call goes (the rest is composing poses, checks and arrays in NumPy):",
        table(["part", "fastest", "share"], shares),
    )


if __name__ == "__main__":
    main()
