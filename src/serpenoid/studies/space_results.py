"""The folder of a gait in space: solution.json, joint_table.csv (yaw, then pitch), trajectory.csv, pictures."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.files.writing import provenance, write_csv, write_json
from serpenoid.optimise.in_space import SpatialSolution
from serpenoid.optimise.lifted import NAMES


def write_in_space(folder: str | Path, found: list[SpatialSolution], figures: bool = True) -> dict[str, Any]:
    """Write the best of these solutions and return its record."""
    best, folder = found[0], Path(folder)
    record = spatial_record(best) | {"starts": [{"status": s.status.name.lower(), "cost": s.cost} for s in found]}
    m, n = best.joints.shape[1] // 2, best.vertices.shape[1]
    names = [f"joint_{j + 1}_{way}" for way in ("yaw", "pitch") for j in range(m)]
    write_csv(folder / "joint_table.csv", names, best.joints.tolist())
    header = ["step", *(f"{axis}_{k}" for k in range(n) for axis in "xyz"), *(f"contact_{k}" for k in range(n))]
    rows = np.hstack([best.vertices.reshape(len(best.vertices), -1), best.contact])
    write_csv(folder / "trajectory.csv", header, ([i, *row] for i, row in enumerate(rows.tolist())))
    if figures and best.motion.sound:
        from serpenoid.plot.space import spatial_figures

        spatial_figures(folder, best)
    write_json(folder / "solution.json", record)
    return record


def spatial_record(s: SpatialSolution) -> dict[str, Any]:
    """What solution.json holds."""
    motion = s.motion
    return {
        "kind": "optimum in space",
        "status": s.status.name.lower(),
        "message": s.status.value,
        "displacement_body_lengths": motion.displacement,
        "sideways_deg": s.sideways_deg,
        "heading_change_rad": motion.heading_change,
        "tilt_rad": motion.tilt,
        "standing": s.standing,
        "dissipation": motion.dissipation,
        "cost": s.cost,
        "c": s.c,
        "gait": dict(zip(NAMES, s.q.tolist(), strict=True)),
        "kkt": asdict(s.residuals),
        "resimulation_error": s.resimulation_error,
        "polishing_gain": s.polishing_gain,
        "mesh": s.mesh.record,
        "provenance": provenance(problem=s.problem.name, problem_hash=s.problem.hash),
    }
