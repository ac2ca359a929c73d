"""How time grows with steps and vertices: a simulated step, and an iteration of the gait NLP."""

from __future__ import annotations

import time

import numpy as np
from bench import clock, empty_cache, exponent, in_units, report, side_by_side, table

from serpenoid.mechanics.tables import joint_tables
from serpenoid.optimise.serpenoid_blocks import SerpenoidBlocks
from serpenoid.optimise.solver import GaitSolver
from serpenoid.problem import Problem
from serpenoid.simulation import simulate_batch
from serpenoid.simulation.steps import _compiled
from specimens import problem

STEPS, VERTICES, ROUNDS = (50, 200, 800, 1600), (12, 48, 192), 7
START = np.array([0.8, 0.3, -0.3, 0.2, 5.0, 0.9])


def sized(vertices: int, steps: int) -> Problem:
    """The reference optimum on another chain and mesh; joint limits shrink with the angle each joint has to take."""
    limit = 60.0 * 10 / (vertices - 2)
    return problem(
        "reference-optimum", f"body.vertices={vertices}", f"task.steps={steps}", f"body.joint_limit_deg={limit!r}"
    )


def cycle_seconds(asked: Problem, repeats: int) -> float:
    """One cycle of forward simulation in a batch of `repeats`, compiled, fastest round."""
    tables = joint_tables(asked.model, np.tile(START, (repeats, 1)), asked.task.steps)
    timing = side_by_side({"batch": (lambda: simulate_batch(asked.model, tables), 1)}, ROUNDS)["batch"]
    return timing.fastest / repeats


def iteration_seconds(asked: Problem) -> tuple[float, int, float]:
    """Seconds per IPOPT iteration (fastest of three solves), iterations, share of function evaluation."""
    solver = GaitSolver(asked)
    solver.solve(START, 0.5)  # prepares
    best = (np.inf, 0, 0.0)
    for _ in range(3):
        begin = clock()
        answer = solver.solve(START, 0.5)
        timing = answer.outcome.timing
        each = (clock() - begin) / max(answer.iterations, 1)
        best = min(best, (each, answer.iterations, timing["function_evaluation"] / timing["total"]))
    return best


def compile_seconds(asked: Problem) -> float:
    """First use of this body's functions, from an empty cache; wall time, since the compiler is another process."""
    begin = time.perf_counter()
    _compiled(asked.model.structure)
    SerpenoidBlocks(asked.model.structure)
    return time.perf_counter() - begin


def measured(sizes: tuple[int, ...], make) -> list[list[float]]:  # type: ignore[no-untyped-def]
    rows = []
    for size in sizes:
        asked = make(size)
        built = compile_seconds(asked)
        cycle = cycle_seconds(asked, max(2, 200 * 50 // asked.task.steps // (asked.body.vertices // 12)))
        rows.append([size, built, cycle, *iteration_seconds(asked)])
    return rows


def shown(rows: list[list[float]], steps: list[int]) -> list[list[str]]:
    return [
        [str(size), in_units(cycle / t), in_units(cycle), in_units(each), f"{count}", f"{share:.0%}", in_units(built)]
        for (size, built, cycle, each, count, share), t in zip(rows, steps, strict=True)
    ]


def main() -> None:
    with empty_cache():
        write()


def write() -> None:
    by_steps = measured(STEPS, lambda t: sized(12, t))
    by_vertices = measured(VERTICES, lambda n: sized(n, 50))
    powers = [exponent([r[0] for r in rows], [r[k] for r in rows]) for rows in (by_steps, by_vertices) for k in (2, 3)]
    names = ["cycle over T", "iteration over T", "cycle over N", "iteration over N"]
    limits = [1.1, 1.1, 1.5, 1.5]
    rows = [
        [n, f"{limit}", f"{p:.2f}", "yes" if p <= limit else "no"]
        for n, limit, p in zip(names, limits, powers, strict=True)
    ]
    header = ["", "step", "cycle", "NLP iteration", "iterations", "functions", "compile (wall; 0 where done)"]
    report(
        "growth",
        "Growth with steps T and vertices N, compiled",
        table(["exponent of time", "at most", "found", "met"], rows),
        "T, with 12 vertices:",
        table(["T", *header[1:]], shown(by_steps, list(STEPS))),
        "N, with 50 steps:",
        table(["N", *header[1:]], shown(by_vertices, [50] * len(VERTICES))),
    )


if __name__ == "__main__":
    main()
