"""Results folders: solution.json, joint_table.csv, trajectory.csv and figures, each file whole or absent."""

from __future__ import annotations

from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.cases import told_table
from serpenoid.errors import InputError, of_kind
from serpenoid.files.inputs import read_json
from serpenoid.files.writing import provenance, short_hash, write_csv, write_json
from serpenoid.gaits import Gait
from serpenoid.performance import electrical_cost_of_transport, lighthill_efficiency
from serpenoid.problem import Problem
from serpenoid.self_contact import crossing_rows
from serpenoid.table_file import write_table
from serpenoid.trajectory import LiftedTrajectory, Trajectory

if TYPE_CHECKING:
    from serpenoid.optimise.solution import SelfClear, Solution
    from serpenoid.simulation.mesh import MeshStudy
    from serpenoid.simulation.problem import Simulation

POSE = ("x", "y", "heading", "z", "pitch", "roll")


def default_folder(problem: Problem, verb: str, *options: Any) -> Path:
    """`results/<problem>/<verb>-<hash>`; the hash changes with the problem and the options."""
    return Path("results") / problem.name / f"{verb}-{short_hash(problem.hash, *options)}"


def write_simulation(
    folder: str | Path, simulation: Simulation, figures: bool = True, mesh: MeshStudy | None = None
) -> dict[str, Any]:
    """Write a simulation's folder and return its record; mesh: where it is known how its steps change the motion."""
    from serpenoid.simulation.problem import Simulation

    of_kind("simulation", simulation, Simulation, "It is what sp.simulate gives.")
    problem, trajectory = simulation.problem, simulation.trajectory
    gait = problem.family_of().like  # as it is lifted, where it is
    record = _record(problem, trajectory, gait, "simulation", trajectory.status.name, trajectory.status.value)
    record |= _goals(problem, simulation.table, trajectory)
    record |= {} if mesh is None else {"mesh": mesh.record}
    record["provenance"] = provenance(problem=problem.name, problem_hash=problem.hash)
    table = told_table(problem, simulation.table)
    _write(Path(folder), record, table, trajectory)
    if figures:
        from serpenoid.plot.figures import simulation_figures, spatial_figures

        if isinstance(trajectory, LiftedTrajectory):
            spatial_figures(folder, problem, trajectory, table)
        else:
            simulation_figures(Path(folder), problem, trajectory, table, problem.gait)
    return record


def write_solution(
    folder: str | Path, solution: Solution, figures: bool = True, summary: dict[str, Any] | None = None
) -> dict[str, Any]:
    """Write an optimum's folder and return its record; `summary` (of a multi-start, say) is added to it."""
    from serpenoid.optimise.solution import Solution

    of_kind("solution", solution, Solution, "Of many starts it is found.best.")
    record = solution_record(solution) | (summary or {})
    told = replace(solution, table=told_table(solution.problem, solution.table))
    _write(Path(folder), record, told.table, told.trajectory)
    if figures:
        from serpenoid.plot.figures import solution_figures

        solution_figures(Path(folder), told)
    return record


def solution_record(solution: Solution) -> dict[str, Any]:
    """What solution.json holds of an optimum."""
    problem = solution.problem
    status = solution.status
    record = _record(problem, solution.trajectory, solution.gait, "optimum", status.name, solution.message)
    residuals = solution.residuals
    record |= {
        "cost": _number(solution.cost),
        "c": solution.c,
        "kkt": {
            "stationarity": _number(residuals.stationarity),
            "feasibility": _number(residuals.feasibility),
            "complementarity": _number(residuals.complementarity),
        },
        "resimulation_error": _number(solution.resimulation_error),
        "polishing_gain": _number(solution.polishing_gain),
        "at_bounds": list(solution.at_bounds),
        **_goals(problem, solution.table, solution.trajectory, solution.self_clearance),
        **({} if solution.note is None else {"note": solution.note}),
        "clearance": None if solution.clearance is None else asdict(solution.clearance),
        **({} if solution.fine_clearance is None else {"fine_clearance": asdict(solution.fine_clearance)}),
        **({} if solution.self_clearance is None else {"self_clearance": asdict(solution.self_clearance)}),
        "mesh": solution.mesh.record,
        **_cases(solution),
        "ipopt_status": solution.ipopt_status,
        "iterations": solution.iterations,
        "wall_time_s": solution.seconds,
        "timing_s": solution.timing,
        "provenance": provenance(problem=problem.name, problem_hash=problem.hash),
    }
    return record


def _goals(problem: Problem, table: Floats, motion: Trajectory, own: SelfClear | None = None) -> dict[str, Any]:
    """What the first cycle makes of all that is asked, in words; own: its distance from itself, where it is known."""
    from serpenoid.optimise.outcomes import clear_of_itself, goal_words

    if not motion.status.ok:
        return {"goals": []}
    return {"goals": goal_words(problem, table, motion, own or clear_of_itself(problem, table))}


def _cases(solution: Solution) -> dict[str, Any]:
    """What a robust gait does in each of its cases."""
    robust = solution.problem.task.robust
    if robust is None:
        return {}
    cases = [
        {"case": case.name, "objective": _number(case.value),
         **({"weight": case.weight} if robust.over == "mean" else {}),
         "displacement_body_lengths": _number(case.trajectory.displacement),
         "heading_change_rad": _number(case.trajectory.heading_change),
         "dissipation": _number(case.trajectory.dissipation)}
        for case in solution.cases
    ]  # fmt: skip
    return {"robust": {"over": robust.over, "headline": solution.headline_note, "cases": cases}}


def read_record(folder: str | Path, name: str = "solution.json") -> dict[str, Any]:
    """Read a results folder's record."""
    path = Path(folder) / name
    record = read_json(path)
    if not isinstance(record, dict):
        raise InputError(f"{path}: is not a record of this package.")
    return record


def weight_warning(problem: Problem) -> list[str]:
    """A line for the user where the body is not uniform though it may be meant to be."""
    return [f"warning           {remark}" for remark in problem.model.remarks]


def _record(
    problem: Problem, trajectory: Trajectory, gait: Gait, kind: str, status: str, message: str
) -> dict[str, Any]:
    body, task = problem.body, problem.task
    cycles = len(trajectory.step_energy) // trajectory.steps_per_cycle
    per_cycle = trajectory.displacement / cycles, trajectory.dissipation / cycles
    return {
        "kind": kind,
        "status": status.lower(),
        "message": message,
        "displacement_body_lengths": _number(trajectory.displacement),
        "forward_displacement_body_lengths": _number(trajectory.forward_displacement),
        "heading_change_rad": _number(trajectory.heading_change),
        "dissipation": _number(trajectory.dissipation),
        "energy_raw": _number(trajectory.energy_raw),
        "cost_of_transport": _number(electrical_cost_of_transport(problem, *per_cycle)),
        "lighthill_efficiency": _number(lighthill_efficiency(problem, *per_cycle)),
        "cycles": cycles,
        "gait": gait.document(),
        "body": {
            "vertices": body.vertices,
            "edge_lengths": body.edges_m.tolist(),
            "weights": problem.model.body.vertex_weights.tolist(),
            "joints": list(body.joint_vertices),
            "length_m": body.total_length_m,
            "mass_kg": body.mass_kg,
            "joint_limit_deg": body.joint_limit_deg,
            "joint_speed_limit_rpm": body.joint_speed_limit_rpm,
        },
        "limits_held": {
            "joint_limits": task.constraints.joint_limits is not False,
            "joint_speed_limits": task.constraints.joint_speed_limits is not False,
        },
        "transient": task.transient,
        "steps": trajectory.steps_per_cycle,
        "rows_that_cross": crossing_rows(trajectory),
        "cycle_duration_s": task.cycle_duration_s,
        "anisotropy_ratio": problem.medium.anisotropy_ratio,
        "dissipation_at": problem.medium.dissipation,
        "law": problem.medium.law,
        **({} if problem.body_note is None else {"body_note": problem.body_note}),
        "effects": [effect.model_dump(mode="json") for effect in problem.model.effects],
        "largest_step_residual": _number(trajectory.residual),
        **_on_the_floor(trajectory),
    }


def _on_the_floor(trajectory: Trajectory) -> dict[str, Any]:
    """What there is to say of a body that is lifted."""
    if not isinstance(trajectory, LiftedTrajectory) or not trajectory.status.ok:
        return {}
    return {"sideways_deg": trajectory.sideways_deg, "tilt_rad": trajectory.tilt, "standing": trajectory.standing}


def _write(folder: Path, record: dict[str, Any], table: Floats, trajectory: Trajectory) -> None:
    """Tables first, solution.json last: a folder that has it is complete."""
    write_table(folder / "joint_table.csv", table, isinstance(trajectory, LiftedTrajectory))
    n, d = trajectory.vertices.shape[1:]
    pose = POSE[: trajectory.poses.shape[1]]
    header = ["step", *pose, *(f"{axis}_{k}" for k in range(n) for axis in "xyz"[:d])]
    rows = np.hstack([trajectory.poses, trajectory.vertices.reshape(len(trajectory.poses), -1)])
    if isinstance(trajectory, LiftedTrajectory):
        header, rows = header + [f"contact_{k}" for k in range(n)], np.hstack([rows, trajectory.contact])
    write_csv(folder / "trajectory.csv", header, ([i, *row] for i, row in enumerate(rows.tolist())))
    write_json(folder / "solution.json", record)


def _number(value: float | None) -> float | None:
    return float(value) if value is not None and np.isfinite(value) else None
