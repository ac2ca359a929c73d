"""Gaits in space: a wave of bending, a wave of lifting; sidewinding comes out where nothing flat can move."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait
from serpenoid.optimise.in_space import SpatialSolution, SpatialSolver, standing
from serpenoid.optimise.lifted import LiftedBody
from serpenoid.problem import Problem
from serpenoid.simulation.problem import simulate
from serpenoid.status import Status
from serpenoid.studies.space_results import write_in_space
from specimens import problem

SMALL = "body.vertices=10", "task.steps=24"


def small(*changes: str) -> Problem:
    return problem("sidewinding", *SMALL, *changes)


def test_what_is_hardly_lifted_moves_as_in_the_plane() -> None:
    lift = "lift={height=1e-6, air=0.999999}"
    wanted = small(lift, "medium.anisotropy_ratio=0.2", "task.constraints={}")
    motion = LiftedBody(wanted).play(np.array([6.0, 1.0, 0.3, 0.0]), 24)
    flat = wanted.model_copy(update={"lift": None, "gait": EllipseGait(sigma=1.0, a=6.0, xi=1.0)})
    expected = simulate(flat).trajectory
    np.testing.assert_allclose(motion.places[:, :2], expected.poses[:, :2], atol=1e-5)  # ten times what is lifted
    assert motion.dissipation == pytest.approx(expected.dissipation, rel=1e-5)


def test_on_a_floor_without_direction_the_way_is_across_and_its_side_is_the_phases() -> None:
    body = LiftedBody(small())
    right, left, along = (body.play(np.array([8.0, 1.2, phase, 0.0]), 24) for phase in (0.0, 0.5, 0.25))
    assert right.places[-1, 1] > 0.2
    assert left.places[-1, 1] == pytest.approx(-right.places[-1, 1], rel=0.05)
    assert along.displacement < 0.25 * right.displacement
    assert abs(along.heading_change) > 0.2  # and there it turns: differential turning


def test_forces_on_what_rests_are_in_balance_in_every_step() -> None:
    """Isotropic drag, by sums written here: no force along the floor, no moment about the vertical."""
    body = LiftedBody(small())
    q = np.array([8.0, 1.2, 0.1, 0.2])
    motion, (vertices, contact, _) = body.play(q, 24), body.rows(q, 24)
    assert motion.sound
    placed = np.einsum("rij,rnj->rni", motion.rotations, vertices) + motion.places[:, None]
    weights = body.model.body.vertex_weights * (contact[1:] + contact[:-1]) / 2
    change = np.diff(placed, axis=0)
    forces = weights[..., None] * change
    # the body's plane is tilted by up to 0.02 rad: the floor's support has this share along it
    assert np.abs(forces.sum(1)[:, :2]).max() < 1e-3 * np.abs(forces).sum(1).max()
    moments = (placed[1:, :, 0] * forces[..., 1] - placed[1:, :, 1] * forces[..., 0]).sum(1)
    assert np.abs(moments).max() < 1e-3 * np.abs(forces).sum(1).max()


def test_edges_keep_their_lengths_and_contact_carries_the_whole_weight() -> None:
    body = LiftedBody(small())
    vertices, contact, joints = body.rows(np.array([8.0, 1.2, 0.1, 0.2]), 24)
    lengths = np.linalg.norm(np.diff(vertices, axis=1), axis=2)
    np.testing.assert_allclose(lengths, np.tile(body.model.body.edges, (25, 1)), atol=1e-12)
    np.testing.assert_allclose(contact @ body.model.body.vertex_weights, 1.0, atol=1e-12)
    assert joints.shape == (24, 16)


@pytest.fixture(scope="module")
def sidewinder() -> SpatialSolution:
    return SpatialSolver(small()).solve(np.array([6.0, 1.0, 0.1, 0.1]), 1.0)


def test_sidewinding_comes_out_with_a_quarter_of_a_cycle_between_the_waves(sidewinder: SpatialSolution) -> None:
    assert sidewinder.status is Status.SOLVED
    assert sidewinder.residuals.largest <= 1e-8
    assert sidewinder.resimulation_error <= 1e-8
    assert sidewinder.motion.displacement > 0.4
    assert sidewinder.sideways_deg > 70
    assert sidewinder.motion.tilt < 0.05
    # curvature is a sine, contact a cosine of the same wave: no phase between them is a quarter of a cycle
    assert abs(sidewinder.q[2] - round(2 * sidewinder.q[2]) / 2) < 0.05


def test_a_gait_in_space_is_written_whole(sidewinder: SpatialSolution, tmp_path: Path) -> None:
    write_in_space(tmp_path, [sidewinder], figures=False)
    record = json.loads((tmp_path / "solution.json").read_text())
    assert record["status"] == "solved"
    assert record["sideways_deg"] == sidewinder.sideways_deg
    assert (tmp_path / "joint_table.csv").read_text().startswith("joint_1_yaw,")
    assert len((tmp_path / "trajectory.csv").read_text().splitlines()) == 26


def test_standing_counts_rows_whose_centre_is_over_what_rests() -> None:
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    contact = np.array([[1.0, 1, 1, 1], [1, 1, 0, 0]])
    assert standing(np.stack([square, square]), contact, np.full(4, 0.25)) == 0.5


@pytest.mark.parametrize("change", [
    'gait={family="table"}', 'medium.law="coulomb"', "task.transient=true", "task.constraints.straight=true",
    'task.demands=[{kind="travel",least=0.1}]', 'task.objectives=[{kind="effort"}]', "lift.height=0.4",
])  # fmt: skip
def test_what_gaits_in_space_cannot_do_is_refused(change: str) -> None:
    bounds = ["task.bounds={}"] if "table" in change else []
    with pytest.raises(InputError, match=r"\[lift\]"):
        LiftedBody(small(change, *bounds))


def test_a_problem_in_space_is_not_simulated_as_if_it_were_flat() -> None:
    with pytest.raises(InputError, match=r"\[lift\]"):
        simulate(small())
