"""The paper's set of gaits on disk: random gaits beside the ones improved from them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from serpenoid.files.writing import provenance, write_csv, write_json
from serpenoid.problem import Problem
from serpenoid.results import write_simulation, write_solution
from serpenoid.simulation.problem import Simulation

if TYPE_CHECKING:
    from serpenoid.optimise.solve import Improved

HEADER = ["gait", "kind", "displacement_body_lengths", "dissipation", "status"]


def write_gait_set(
    folder: str | Path, problem: Problem, pairs: list[Improved], options: dict[str, Any]
) -> dict[str, Any]:
    """Write `random-NN` and `improved-NN` folders, gaits.csv and set.json; return the record."""
    folder = Path(folder)
    rows, gaits, family = [], [], problem.family_of()
    for number, pair in enumerate(pairs, start=1):
        name = f"{number:02d}"
        start = problem.model_copy(update={"gait": family.gait(pair.q)})
        write_simulation(folder / f"random-{name}", Simulation(start, pair.table, pair.trajectory), figures=False)
        write_solution(folder / f"improved-{name}", pair.solution, figures=False)
        better = pair.solution
        status = better.status.name.lower()
        rows.append(_row(name, "random", pair.trajectory, pair.trajectory.status.name.lower(), pair.q))
        rows.append(_row(name, "improved", better.trajectory, status, better.q))
        displacements = {"random": pair.trajectory.displacement, "improved": better.trajectory.displacement}
        gaits.append({"gait": name, **displacements, "status": status})
    write_csv(folder / "gaits.csv", [*HEADER, *family.names], rows)
    record = {"gaits": gaits, **options, "provenance": provenance(problem=problem.name, problem_hash=problem.hash)}
    write_json(folder / "set.json", record)
    return record


def _row(name: str, kind: str, motion: Any, status: str, q: Any) -> list[Any]:
    return [name, kind, motion.displacement, motion.dissipation, status, *(float(x) for x in q)]
