"""Gaits in space: a wave of bending, a wave of lifting; sidewinding comes out where nothing flat can move.

Everything is asked by the same objectives and demands as in the plane, in the same NLP.
"""

from __future__ import annotations

import json
from pathlib import Path

import casadi as ca
import numpy as np
import pytest
from pydantic import ValidationError

from optimise.test_free_gaits import LINE, differences
from serpenoid import group
from serpenoid.body import Body, Floats
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.gaits.fourier import FourierGait
from serpenoid.gaits.lifted import Lift, LiftedGait, lifted
from serpenoid.mechanics import functions, spatial
from serpenoid.mechanics.wide import Columns
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.objectives import Demand, Term, demands, terms
from serpenoid.objectives.term import after
from serpenoid.optimise.multistart import solve_one
from serpenoid.optimise.program.nlp import gait_nlp
from serpenoid.optimise.program.transcription import GaitNLP
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solver import GaitSolver
from serpenoid.problem import Problem, Task
from serpenoid.results import write_solution
from serpenoid.simulation import lifted as simulation
from serpenoid.simulation import simulate_in_space
from serpenoid.simulation.gaits import simulate_gait
from serpenoid.simulation.lifted import simulate_lifted
from serpenoid.simulation.problem import simulate
from serpenoid.status import Status
from serpenoid.trajectory import LiftedTrajectory
from specimens import PROBLEMS, nlp_of, problem, uneven

SMALL = "body.vertices=10", "task.steps=24"
SIDEWINDER = {"a": 8.0, "xi": 1.2}


def small(*changes: str) -> Problem:
    return problem("sidewinding", *SMALL, *changes)


def played(model: Model, gait: LiftedGait, steps: int = 24) -> LiftedTrajectory:
    family = gait.of(model.body.joint_count, steps)
    return simulate_lifted(model, family, family.start())


def wave(phase: float = 0.1, bias: float = 0.2, lift: Lift | None = None, **bend: float) -> LiftedGait:
    return LiftedGait(bend=EllipseGait(**(SIDEWINDER | bend)), phase=phase, bias=bias, lift=lift or Lift())


def gradient(nlp: GaitNLP, x: Floats, parameters: Floats, poses: int) -> Floats:
    """Of the objective by the gait alone: poses follow, as their equations have it."""
    made = nlp.functions()
    slope = made["grad_f"](x, parameters)[1].full()[:, 0]
    jacobian = ca.densify(made["jac_g"](x, parameters)[1]).full()
    adjoint = np.linalg.solve(jacobian[:, :poses].T, slope[:poses])
    return np.asarray(slope[poses:] - adjoint @ jacobian[:, poses:])


@pytest.mark.usefixtures("virtual_machine")
@pytest.mark.parametrize("dissipation", ["vertex", "edge"])
def test_with_constant_contact_a_gait_in_space_is_that_of_the_plane_and_so_is_its_gradient(dissipation: str) -> None:
    model, bend = uneven(dissipation), EllipseGait(sigma=0.6, a=6.0, xi=0.9, x_c=1.0, y_c=-1.5, theta=0.4)
    still = wave(lift=Lift(height=0.0, air=1.0)).model_copy(update={"bend": bend})
    found = {}
    for gait in (bend, still):
        family, nlp = gait.of(model.body.joint_count, 12), nlp_of(model, 12, gait=gait)
        motion, n = simulate_gait(model, family, family.start()), 12 * family.pose_size
        x = np.concatenate([motion.poses[1:].ravel(), family.start()])
        found[gait.family] = motion, gradient(nlp, x, np.concatenate([[0.7], model.parameters]), n)
    (flat, expected), (space, slope) = found["ellipse"], found["lifted"]
    np.testing.assert_allclose(space.poses[:, :3], flat.poses, atol=1e-10)
    np.testing.assert_allclose(space.poses[:, 3:], 0.0, atol=1e-12)
    np.testing.assert_allclose(space.vertices[:, :, :2], flat.vertices, atol=1e-10)
    assert space.dissipation == pytest.approx(flat.dissipation, abs=1e-10)
    np.testing.assert_allclose(slope, [*expected, 0.0, 0.0], atol=1e-9)  # phase and bias of no wave


def test_without_the_floors_support_steps_have_the_roots_of_any_motion_in_space(
    monkeypatch: pytest.MonkeyPatch, virtual_machine: None
) -> None:
    """Shares are constant, the body rises and falls: `simulate_in_space` places the same chains."""
    model = uneven("vertex")
    with monkeypatch.context() as without:
        without.setattr(spatial, "SUPPORT", 0.0)
        element = spatial.element_functions.__wrapped__(1)[0]
    monkeypatch.setattr(simulation, "_element", lambda: Columns(element, element.n_in() - 1))
    simulation._over.cache_clear()
    family = wave(lift=Lift(height=0.03, air=1.0)).of(model.body.joint_count, 12)
    motion = simulate_lifted(model, family, family.start())
    simulation._over.cache_clear()
    row = functions.lifted_row(model.structure, family.lift)
    at = [row(family.at(family.start(), data), model.parameters)[0].full().T for data in [*family.data, family.data[0]]]
    expected = simulate_in_space(model, np.array(at))
    assert motion.status.ok
    assert expected.status.ok
    np.testing.assert_allclose(motion.vertices, expected.vertices, atol=1e-9)  # rolls that hardly matter: 1e-10
    np.testing.assert_allclose(motion.step_energy, expected.step_energy, atol=1e-12)


def test_on_a_floor_without_direction_the_way_is_across_and_its_side_is_the_phases() -> None:
    model = small().model
    right, left, along = (played(model, wave(phase, bias=0.0)) for phase in (0.0, 0.5, 0.25))
    assert right.poses[-1, 1] > 0.2
    assert left.poses[-1, 1] == pytest.approx(-right.poses[-1, 1], rel=0.05)
    assert along.displacement < 0.25 * right.displacement
    assert abs(along.heading_change) > 0.2  # and there it turns: differential turning


def test_forces_on_what_rests_are_in_balance_in_every_step() -> None:
    """Isotropic drag, by sums written here: no force along the floor, no moment about the vertical."""
    model = small().model
    motion = played(model, wave())
    assert motion.status.ok
    weights = model.body.vertex_weights * (motion.contact[1:] + motion.contact[:-1]) / 2
    change = np.diff(motion.vertices, axis=0)
    forces = weights[..., None] * change
    # the body's plane is tilted by up to 0.02 rad: the floor's support has this share along it
    assert np.abs(forces.sum(1)[:, :2]).max() < 1e-3 * np.abs(forces).sum(1).max()
    after = motion.vertices[1:]
    moments = (after[:, :, 0] * forces[..., 1] - after[:, :, 1] * forces[..., 0]).sum(1)
    assert np.abs(moments).max() < 1e-3 * np.abs(forces).sum(1).max()


@pytest.mark.parametrize("model", [small().model, uneven()], ids=["every vertex", "rigid links"])
def test_edges_keep_their_lengths_links_stay_straight_and_contact_carries_the_whole_weight(model: Model) -> None:
    motion = played(model, wave(lift=Lift(height=0.02)))
    edges = np.diff(motion.vertices, axis=1)
    lengths = np.linalg.norm(edges, axis=2)
    np.testing.assert_allclose(lengths, np.tile(model.body.edges, (25, 1)), atol=1e-12)
    np.testing.assert_allclose(motion.contact @ model.body.vertex_weights, 1.0, atol=1e-12)
    for rigid in set(range(1, model.body.vertices - 1)) - set(model.body.joint_vertices):
        apart = np.cross(edges[:, rigid - 1] / lengths[:, [rigid - 1]], edges[:, rigid] / lengths[:, [rigid]])
        assert np.abs(apart).max() < 1e-12


ASKED = {
    "displacement": [{"kind": "displacement"}],
    "position": [{"kind": "position", "target": (0.3, 0.1), "cycles": 2, "weight": 2.0}],
    "heading": [{"kind": "heading", "target_rad": 0.3, "cycles": 2}],
    "path": [{"kind": "path", "line": LINE, "cycles": 2}, {"kind": "path", "line": LINE, "point": "head"}],
    "rates": [{"kind": "efficiency"}, {"kind": "transport", "idle": 0.4, "weight": 0.1}],
    "bending": [{"kind": "bending"}, {"kind": "effort"}],
}
DEMANDED = [
    {"kind": "reach", "target": (0.2, 0.0), "cycles": 3, "heading_rad": 0.1},
    {"kind": "reach", "target": (0.2, 0.0), "at": 0.5, "radius": 0.1},
    {"kind": "travel", "least": 0.1},
    {"kind": "shape", "at": 0.5, "still": True},
    {"kind": "swing"},
]


@pytest.mark.usefixtures("virtual_machine")
@pytest.mark.parametrize("objective", [*ASKED, "limits"])
def test_derivatives_are_differences_for_every_objective_with_every_demand_in_space(objective: str) -> None:
    model, steps, rows = Model(Body(vertices=5), Medium(anisotropy_ratio=0.3)), 4, int(objective == "limits")
    asked = {"objectives": ASKED.get(objective, ASKED["displacement"]), "demands": [] if rows else DEMANDED}
    bend = FourierGait(orders=(1, 3)) if objective == "position" else EllipseGait(sigma=0.6)
    gait = lifted(bend, Lift(phase=(0.1, 0.1)))
    nlp = nlp_of(model, steps, rows, gait, task=Task.model_validate(asked))
    rng = np.random.default_rng(7)
    x = 0.2 * rng.normal(size=6 * steps)
    x[-6] = 0.8  # away from rest: what is divided by the way is steep there
    q = nlp.family.start() + 0.1 * rng.normal(size=nlp.family.size)
    phases = np.repeat([0.1, 0.1 + 1 / steps], 2)
    x = np.concatenate([x, [0.4] if nlp.priced else [], q])
    differences(nlp, x, np.concatenate([[0.7], phases[: 4 * rows], model.parameters]), seed=6)


def test_no_objective_or_demand_is_left_out_but_those_that_are_refused() -> None:
    parts = [part["kind"] for group in (*ASKED.values(), DEMANDED) for part in group]
    kinds: list[type[Term | Demand]] = [*terms(), *demands()]
    assert set(parts) == {str(kind.model_fields["kind"].default) for kind in kinds if not kind.flat}


@pytest.mark.parametrize("tilt", [0.0, 0.03])
def test_headings_count_turns_in_space_and_cycles_compose(tilt: float) -> None:
    motion = np.array([0.1, 0.2, 2.0, tilt, tilt, -tilt])
    there = after(np.array([np.zeros(6), motion]), 5)
    turn, place = group.spatial_rotation(motion), motion[[0, 1, 3]]
    np.testing.assert_allclose(group.spatial_rotation(there), np.linalg.matrix_power(turn, 5), atol=1e-12)
    expected = sum(np.linalg.matrix_power(turn, k) @ place for k in range(5))
    np.testing.assert_allclose(there[[0, 1, 3]], expected, atol=1e-12)
    assert there[2] == pytest.approx(10.0, abs=2 * tilt)  # beyond three half turns
    flat = after(np.array([np.zeros(3), motion[:3]]), 5)
    np.testing.assert_allclose(there[:3], flat, atol=1e-12 if tilt == 0 else 2 * tilt)


@pytest.fixture(scope="module")
def sidewinder() -> Solution:
    solver = GaitSolver(small())
    return solve_one(solver, np.array([1.0, 0, 0, 0, 6.0, 1.0, 0.1, 0.1]), 1.0, polish=True)[0]


def test_sidewinding_comes_out_with_a_quarter_of_a_cycle_between_the_waves(sidewinder: Solution) -> None:
    motion = sidewinder.trajectory
    assert sidewinder.status is Status.SOLVED
    assert sidewinder.residuals.largest <= 1e-8
    assert sidewinder.resimulation_error <= 1e-8
    assert isinstance(motion, LiftedTrajectory)
    assert motion.displacement > 0.4
    assert motion.sideways_deg > 70
    assert motion.tilt < 0.05
    # curvature is a sine, contact a cosine of the same wave: no phase between them is a quarter of a cycle
    assert abs(sidewinder.q[-2] - round(2 * sidewinder.q[-2]) / 2) < 0.05


def test_a_gait_in_space_is_written_whole(sidewinder: Solution, tmp_path: Path) -> None:
    write_solution(tmp_path, sidewinder, figures=False)
    record = json.loads((tmp_path / "solution.json").read_text())
    assert record["status"] == "solved"
    assert record["sideways_deg"] == sidewinder.trajectory.sideways_deg
    assert record["gait"]["bend"]["a"] == sidewinder.q[4]
    assert (tmp_path / "joint_table.csv").read_text().startswith("joint_1_yaw,")
    assert len((tmp_path / "trajectory.csv").read_text().splitlines()) == 26


def test_the_optimum_of_an_opened_nlp_stands_where_the_simulation_has_it(sidewinder: Solution) -> None:
    nlp = gait_nlp(sidewinder.problem)
    x = np.concatenate([sidewinder.trajectory.poses[1:].ravel(), sidewinder.q])
    p = np.concatenate([[1.0], sidewinder.problem.model.parameters])
    places = ca.Function("vertices", [nlp.variables, nlp.parameters], [nlp.vertices])(x, p).full()
    np.testing.assert_allclose(places.T, sidewinder.trajectory.vertices.reshape(-1, 3), atol=1e-12)


def test_standing_counts_rows_whose_centre_is_over_what_rests() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    motion = LiftedTrajectory(
        Status.SOLVED, np.zeros((2, 6)), np.stack([square, square]), np.zeros(1), 0.0, 1,
        contact=np.array([[1.0, 1, 1, 1], [1, 1, 0, 0]]), weights=np.full(4, 0.25),
    )  # fmt: skip
    assert motion.standing == 0.5


@pytest.mark.parametrize("change", [
    'gait={family="table"}', 'gait={family="fourier",xi=[1.0,2.0]}', 'medium.law="coulomb"', "lift.height=0.4",
    'task.demands=[{kind="self",distance=0.1}]', 'task.demands=[{kind="disc",centre=[0.9,0.4],radius=0.2}]',
])  # fmt: skip
def test_what_gaits_in_space_cannot_do_is_refused_when_the_file_is_read(change: str) -> None:
    bounds = ["task.bounds={}"] if "family" in change else []
    with pytest.raises(InputError, match=r"\[lift\]"):
        small(change, *bounds)


def test_what_cannot_be_lifted_is_named_with_what_can() -> None:
    with pytest.raises(InputError, match=r"linear drag alone \(law = \"viscous\"\).*; leave out dry friction, or") as e:
        small('medium.law="coulomb"')
    assert "quadratic" not in str(e.value)


def test_a_gait_in_space_is_simulated_as_it_is_lifted_and_cycles_repeat() -> None:
    """Two cycles are one, moved by what one does."""
    exact = small("lift.phase=[0.1,0.1]", "lift.bias=[0.2,0.2]", "gait.a=8.0", "gait.xi=1.2")
    once, twice = (simulate(exact.model_copy(update={"task": exact.task.model_copy(update={"cycles": n})})).trajectory
                   for n in (1, 2))  # fmt: skip
    assert isinstance(once, LiftedTrajectory)
    assert isinstance(twice, LiftedTrajectory)
    np.testing.assert_allclose(once.poses, played(exact.model, wave()).poses, atol=1e-12)
    moved = once.vertices @ once.rotations[-1].T + once.poses[-1, [0, 1, 3]]
    np.testing.assert_allclose(twice.vertices[24:], moved, atol=1e-12)
    np.testing.assert_allclose(twice.contact[24:], once.contact, atol=1e-12)


def test_what_plays_one_angle_a_joint_refuses_a_problem_in_space(tmp_path: Path) -> None:
    for kind in ("protocol", "campaign"):
        words = ["new", kind, str(tmp_path / kind), "--problem", str(PROBLEMS / "sidewinding.toml"), "--yes"]
        assert main(words) == 2


@pytest.mark.parametrize("name", ["phase", "bias"])
def test_ranges_that_no_gait_may_have_are_refused_as_they_are_read(name: str) -> None:
    with pytest.raises(ValidationError, match="must be within"):
        Lift.model_validate({name: [-1e300, 0.5]})
