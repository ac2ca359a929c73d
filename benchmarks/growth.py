"""How time grows with steps and vertices: a simulated step, and an iteration of the gait NLP."""

from __future__ import annotations

import time

import numpy as np
from bench import clock, empty_cache, exponent, in_units, report, side_by_side, table

from serpenoid.mechanics import columns
from serpenoid.mechanics.tables import joint_tables
from serpenoid.optimise.solver import GaitSolver
from serpenoid.optimise.starts import random_gaits
from serpenoid.optimise.step.serpenoid_blocks import SerpenoidBlocks
from serpenoid.problem import Problem
from serpenoid.simulation import simulate_batch
from specimens import problem

STEPS, VERTICES, ROUNDS = (50, 200, 800, 1600), (12, 48, 192), 7
FREE_STEPS, FREE_VERTICES = (40, 80, 160, 320), (6, 11, 21, 41)
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


def free_iteration(vertices: int, steps: int) -> tuple[float, int]:
    """Seconds per iteration of a free table's NLP (T m parameters), and how many parameters it has."""
    asked = problem("reach", f"body.vertices={vertices}", f"task.steps={steps}", f"task.c={10 / steps}")
    solver = GaitSolver(asked)
    carried, c = solver.first(), asked.task.c
    _, ipopt = solver.prepared(carried)
    given = solver.parameters(c, carried.rows), solver.bounds(carried)
    best = np.inf
    for q in [*random_gaits(solver, 1, seed=0)] * 3:
        begin = clock()
        outcome = ipopt.solve(solver.start(q), *given)
        best = min(best, (clock() - begin) / outcome.iterations)
    return best, solver.family.size


def compile_seconds(asked: Problem) -> float:
    """First use of this body's functions, from an empty cache; wall time, since the compiler is another process."""
    begin = time.perf_counter()
    columns.steps(asked.model.structure), columns.shapes(asked.model.structure)
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
    free_steps = [(t, *free_iteration(11, t)) for t in FREE_STEPS]
    free_vertices = [(n, *free_iteration(n, 50)) for n in FREE_VERTICES]
    powers += [exponent([r[0] for r in rows], [r[1] for r in rows]) for rows in (free_steps, free_vertices)]
    names = ["cycle over T", "iteration over T", "cycle over N", "iteration over N",
             "free table: iteration over T, and over its 9 T parameters", "free table: iteration over N"]  # fmt: skip
    limits = [1.1, 1.1, 1.5, 1.5, 1.1, 1.5]
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
        "Free tables (the reach problem: T m parameters); T with 11 vertices, N with 50 steps:",
        table(
            ["T or N", "parameters", "NLP iteration"],
            [
                [f"{w} = {size}", str(n), in_units(each)]
                for w, found in (("T", free_steps), ("N", free_vertices))
                for size, each, n in found
            ],
        ),  # fmt: skip
    )


if __name__ == "__main__":
    main()
