"""A sweep's folder: sweep.csv, one folder per solved point, sweep.json and the pictures of the family."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from serpenoid.files.writing import provenance, write_csv, write_json
from serpenoid.joint_limits import limit_lines
from serpenoid.optimise.refine import REFINED
from serpenoid.optimise.solution import Solution
from serpenoid.performance import electrical_cost_of_transport, idle_for_minimum, pareto_front
from serpenoid.problem import Problem
from serpenoid.results import write_solution
from serpenoid.simulation.mesh import RESOLVED
from serpenoid.studies.beside import Beside
from serpenoid.studies.sweep import NOT_REACHED, Sweep, SweepPoint


def write_sweep(folder: str | Path, result: Sweep, figures: bool, beside: Beside | None = None) -> dict[str, Any]:
    """Write everything and return the summary; beside: a gait that the family is compared with."""
    folder = Path(folder)
    for solution in result.solved:
        write_solution(folder / f"c-{solution.c!r}", solution, figures=False)
    write_sweep_table(folder / "sweep.csv", result)
    solved = result.solved
    failures = [{"c": point.c, "message": point.message} for point in result.points if point.failed]
    window = idle_for_minimum(result.c, result.displacement, result.dissipation, 1.0, 2.0) if solved else None
    summary = {
        "kind": "sweep",
        "problem": result.problem.name,
        "folder": str(folder),
        **({} if result.problem.body_note is None else {"body_note": result.problem.body_note}),
        "complete": result.complete,
        "points": len(result.points),
        "solved": len(solved),
        "kept_from_an_earlier_run": result.kept,
        "failed": len(failures),
        "failures": failures,
        "not_reached": sum(not point.reached for point in result.points),
        "displacement": [float(result.displacement.min()), float(result.displacement.max())] if solved else None,
        "limits": limit_lines(result.problem, solved[0].table) if solved else [],
        "idle_for_minimum_between_1_and_2": window,
        "mesh": _mesh(solved) if solved else None,
        **({} if beside is None else {"beside": beside.against(result)}),
        "status": "solved" if len(solved) == len(result.points) and result.complete else "incomplete",
        "provenance": provenance(problem=result.problem.name, problem_hash=result.problem.hash),
    }
    write_json(folder / "sweep.json", summary)
    if figures and len(solved) > 1:
        from serpenoid.plot.family import Family
        from serpenoid.plot.figures import sweep_figures

        family = Family(result.c, result.displacement, result.dissipation, result.gaits, result.names)
        sweep_figures(
            folder, family, None if beside is None else (beside.name, beside.displacement, beside.dissipation)
        )
    return summary


def _mesh(solved: list[Solution]) -> dict[str, Any]:
    """Steps, and how far the worst displacement is off; coarse: how many points are not as good as `--refine` asks."""
    steps = [s.mesh.steps for s in solved]
    moving = [s.mesh.error / abs(s.mesh.displacement) for s in solved if abs(s.mesh.displacement) > RESOLVED]
    coarse = sum(not s.mesh.within(REFINED) for s in solved)
    return {"steps": [min(steps), max(steps)], "largest_error": max(moving, default=0.0), "coarse": coarse}


BEFORE = ["c", "status", "displacement_body_lengths", "dissipation", "cost", "heading_change_rad", "cost_of_transport"]
AFTER = ["steps", "iterations", "seconds", "chain", "message"]


def write_sweep_table(path: str | Path, result: Sweep) -> None:
    """One line per point; a failed point has its reason and empty numbers."""
    front = iter(pareto_front(result.displacement, result.dissipation).tolist())
    family = result.problem.family_of()
    names = () if family.free else family.names  # a free gait is its table, in the point's folder
    write_csv(
        path,
        [*BEFORE, "pareto", *names, *AFTER],
        [_row(names, result.problem, p, next(front) if p.solution else "") for p in result.points],
    )


def _row(names: tuple[str, ...], problem: Problem, point: SweepPoint, on_front: bool | str) -> list:
    s = point.solution
    if s is None:
        blanks = len(BEFORE) + 1 + len(names) + len(AFTER) - 3
        return [point.c, "failed" if point.failed else NOT_REACHED, *[""] * blanks, point.message]
    d, e = s.trajectory.displacement, s.trajectory.dissipation
    transport = electrical_cost_of_transport(problem, d, e)
    numbers = [d, e, s.cost, s.trajectory.heading_change, "" if transport is None else transport, on_front]
    gait = s.q.tolist()[: len(names)]
    return [point.c, "solved", *numbers, *gait, s.mesh.steps, s.iterations, s.seconds, point.chain, point.message]
