"""Bodies, gaits and joint tables that many tests use; everything random comes from an explicit seed."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from oracle.chain import serpenoid_joint_table
from oracle.integrator import Run, simulate
from serpenoid.body import Body, Floats
from serpenoid.gaits import EllipseGait, Gait
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.optimise.asked import Customise, asked
from serpenoid.optimise.clear.between import GapField
from serpenoid.optimise.clear.watch import Watch, Watched, every_vertex
from serpenoid.optimise.program.transcription import GaitNLP
from serpenoid.optimise.step import motion_law
from serpenoid.problem import Problem, Task, load
from serpenoid.trajectory import Trajectory

PROBLEMS = Path(__file__).parents[1] / "problems"
REFERENCE_EPS = 0.1865
EVALUATING = tuple(f"serpenoid.{package}." for package in ("mechanics", "simulation", "optimise", "compare"))


def forget_functions() -> None:
    """Drop what was prepared for compiled or uncompiled evaluation, so that the environment is asked again: whatever
    the packages that make or evaluate Functions remember. What one of them kept would be slow in all later tests."""
    for name, module in list(sys.modules.items()):
        if name.startswith(EVALUATING):
            for member in list(vars(module).values()):
                if callable(forget := getattr(member, "cache_clear", None)) and member.__module__ == name:
                    forget()


def problem(name: str, *changes: str) -> Problem:
    """A problem file of the repository, with `section.key=value` changes."""
    return load(PROBLEMS / f"{name}.toml", set=list(changes))


def nlp_of(
    model: Model,
    steps: int,
    path_rows: int = 0,
    gait: Gait | None = None,
    customise: Customise | None = None,
    task: Task | None = None,
) -> GaitNLP:
    """The gait NLP of a model; for ellipses, and the displacement, unless `gait` and `task` say otherwise."""
    family = (gait or EllipseGait()).of(model.body.joint_count, steps)
    law = motion_law.motion_law(model, family)
    criteria, watch = asked(task or Task(), family, customise, model).criteria, Watch()
    if criteria.clear_of:
        between = Watched(0.25, 2, 0.5, 1, 0), Watched(0.75, steps - 1, 0.25, 0, 2)
        watch = Watch(
            (*every_vertex(steps, model.body.vertices, GapField(tuple(criteria.clear_of)).convex.size).points, *between)
        )
    return GaitNLP(law, criteria, path_rows, watch=watch)


def phases_of_rows(phases: Floats, steps: int) -> Floats:
    """Data of path rows: each row's phase and the next one's."""
    return np.column_stack([phases, np.asarray(phases) + 1 / steps]).ravel()


def reference() -> Model:
    """12 vertices, equal edges and weights, vertex dissipation."""
    return Model(Body(vertices=12), Medium(anisotropy_ratio=REFERENCE_EPS))


def three_links() -> Model:
    """Purcell's swimmer: three rigid links of four edges, edge dissipation."""
    return Model(Body(vertices=13, joints=(4, 8)), Medium(anisotropy_ratio=0.5, dissipation="edge"))


def uneven(dissipation: str = "vertex", anisotropy_ratio: float = 0.3) -> Model:
    """Unequal edges and weights, two rigid vertices among the joints."""
    edges = (0.05, 0.12, 0.08, 0.2, 0.06, 0.15, 0.11, 0.09)
    weights = (2.0, 0.5, 1.0, 1.5, 0.7, 1.1, 0.4, 0.9, 3.0)
    body = Body(vertices=9, edge_lengths=edges, weights=weights, joints=(1, 2, 4, 5, 7))
    return Model(body, Medium(anisotropy_ratio=anisotropy_ratio, dissipation=dissipation))


BODIES = {
    "reference": reference(),
    "Purcell": three_links(),
    "uneven, vertices": uneven("vertex"),
    "uneven, edges": uneven("edge"),
}


def serpenoid_table(model: Model, count: int = 20, **gait: float) -> Floats:
    """Joint table of an elliptical gait, written by the oracle: shape (T, m)."""
    values = {"sigma": 0.6, "a": 6.0, "xi": 0.9, "x_c": 1.0, "y_c": -1.5, "theta": 0.4} | gait
    return serpenoid_joint_table(model.body.edges, count, joints=model.body.joint_vertices, **values)


def random_table(model: Model, rng: np.random.Generator, count: int, amplitude: float = 0.5) -> Floats:
    """A smooth random joint table, shape (T, m): two harmonics per joint, no symmetry."""
    phase = 2 * np.pi * np.arange(count)[:, None] / count
    joints = model.body.joint_count
    table = rng.normal(size=joints) + sum(
        rng.normal(size=joints) / k * np.cos(k * phase + rng.uniform(0, 2 * np.pi, joints)) for k in (1, 2)
    )
    return amplitude * table


def oracle_run(model: Model, table: Floats, **options: object) -> Run:
    """The same motion by the independent integrator."""
    body, medium = model.body, model.medium
    values = {"dissipation": medium.dissipation, "joints": body.joint_vertices} | options
    return simulate(table, body.edges_m, body.vertex_weights, medium.anisotropy_ratio, **values)


def compose(first: Floats, then: Floats) -> Floats:
    """SE(2) product of poses (x, y, heading)."""
    c, s = np.cos(first[2]), np.sin(first[2])
    return first + np.array([c * then[0] - s * then[1], s * then[0] + c * then[1], then[2]])


def inverse(pose: Floats) -> Floats:
    """SE(2) inverse."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.array([-c * pose[0] - s * pose[1], s * pose[0] - c * pose[1], -pose[2]])


def agree(motion: Trajectory, run: Run, tolerance: float) -> None:
    """Poses, vertices and energies of the two routes are the same."""
    assert motion.status.ok
    np.testing.assert_allclose(motion.poses, run.poses, atol=tolerance, rtol=0)
    np.testing.assert_allclose(motion.vertices, run.vertices, atol=tolerance, rtol=0)
    np.testing.assert_allclose(motion.step_energy, run.energies, atol=tolerance, rtol=0)


def animal_campaign(folder: Path, name: str, time: np.ndarray, points: np.ndarray, unit: str) -> Path:
    """A campaign of one crawler, whose points (F, N, 2) at times (F,) are in `unit`."""
    count = points.shape[1]
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(count))
    rows = np.column_stack([time, points.reshape(len(time), -1)])
    np.savetxt(folder / f"{name}.csv", rows, fmt="%.5f", delimiter=",", header=header, comments="")
    (folder / "campaign.toml").write_text(
        f'format = 1\nname = "{name}"\n[body]\nvertices = {count}\nkind = "crawler"\n'
        f'[motion]\nformat = "tidy"\nlength_unit = "{unit}"\n[[trial]]\nname = "crawl"\nmotion = "{name}.csv"\n'
    )
    return folder
