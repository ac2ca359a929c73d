"""What holds exactly, whatever the body and the gait: each to rounding.

Legend: T steps, m joints. A step's turn is known to residual / curvature; Newton converges quadratically, so the true
error is rounding in the moments (1e-16) over the smallest curvature met (1e-3): 1e-13 per step, 1e-12 over a cycle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oracle.integrator import edge_weights
from serpenoid.body import Body
from serpenoid.mechanics import functions
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_batch, simulate_joint_angles, simulate_vertices
from serpenoid.simulation.steps import shape_rows
from specimens import BODIES, compose, inverse, random_table, reference, serpenoid_table, uneven

pytestmark = pytest.mark.usefixtures("virtual_machine")
EXACT = 1e-12
every_body = pytest.mark.parametrize("model", BODIES.values(), ids=BODIES)


def gaits(model: Model) -> list[np.ndarray]:
    """A turning elliptical gait and two random tables."""
    rng = np.random.default_rng(10)
    return [serpenoid_table(model), *(random_table(model, rng, 16) for _ in range(2))]


@pytest.mark.parametrize("seed", range(3))
def test_isotropic_dissipation_never_moves_the_weighted_centroid_but_may_turn_the_body(seed: int) -> None:
    model = uneven("vertex", anisotropy_ratio=1.0)
    table = random_table(model, np.random.default_rng(seed), 16)
    motion = simulate_joint_angles(model, table)
    assert np.abs(motion.poses[:, :2]).max() < EXACT
    assert abs(motion.heading_change) > 1e-4  # the area enclosed in shape space still turns it


def test_isotropic_dissipation_at_edges_keeps_the_centroid_of_the_edges_elements() -> None:
    model = uneven("edge", anisotropy_ratio=1.0)
    motion = simulate_joint_angles(model, serpenoid_table(model))
    middles = (motion.vertices[:, 1:] + motion.vertices[:, :-1]) / 2
    centroid = np.einsum("rni,n->ri", middles, edge_weights(model.body.vertex_weights, model.body.edges))
    assert np.ptp(centroid, axis=0).max() < EXACT


@every_body
def test_scallop_theorem_a_flat_ellipse_goes_nowhere(model: Model) -> None:
    motion = simulate_joint_angles(model, serpenoid_table(model, sigma=0.0))
    assert motion.status.ok
    assert np.abs(motion.net_motion).max() < EXACT
    assert np.abs(motion.poses).max() > 1e-3  # it did move in between


@every_body
def test_scallop_theorem_any_path_played_there_and_back_goes_nowhere(model: Model) -> None:
    there = random_table(model, np.random.default_rng(11), 12)
    motion = simulate_joint_angles(model, np.concatenate([there, there[-2:0:-1]]))
    assert np.abs(motion.net_motion).max() < EXACT


@every_body
def test_time_reversal_inverts_the_net_motion_and_keeps_the_energy(model: Model) -> None:
    for table in gaits(model):
        there, back = simulate_joint_angles(model, table), simulate_joint_angles(model, np.roll(table[::-1], 1, axis=0))
        np.testing.assert_allclose(back.net_motion, inverse(there.net_motion), atol=EXACT)
        np.testing.assert_allclose(back.step_energy, there.step_energy[::-1], rtol=1e-10, atol=1e-16)


@every_body
def test_holding_frames_changes_nothing(model: Model) -> None:
    for table in gaits(model):
        plain, held = simulate_joint_angles(model, table), simulate_joint_angles(model, np.repeat(table, 3, axis=0))
        np.testing.assert_allclose(held.poses[::3], plain.poses, atol=EXACT)
        np.testing.assert_allclose(held.poses[1::3], held.poses[:-1:3], atol=EXACT)
        assert held.energy_raw == pytest.approx(plain.energy_raw, rel=1e-12)


@every_body
def test_mirrored_shapes_mirror_the_motion(model: Model) -> None:
    for table in gaits(model):
        plain, mirrored = simulate_joint_angles(model, table), simulate_joint_angles(model, -table)
        np.testing.assert_allclose(mirrored.poses, plain.poses * [1, -1, -1], atol=EXACT)
        np.testing.assert_allclose(mirrored.vertices, plain.vertices * [1, -1], atol=EXACT)
        np.testing.assert_allclose(mirrored.step_energy, plain.step_energy, rtol=1e-10, atol=1e-16)


def test_the_chain_may_be_numbered_from_either_end() -> None:
    model = uneven()
    body = model.body
    turned = Body(
        vertices=body.vertices,
        edge_lengths=body.edge_lengths[::-1],
        weights=body.weights[::-1],
        joints=tuple(body.vertices - 1 - j for j in body.joint_vertices[::-1]),
    )
    for table in gaits(model):
        plain = simulate_joint_angles(model, table)
        swapped = simulate_joint_angles(replace(model, body=turned), -table[:, ::-1])
        np.testing.assert_allclose(swapped.poses, plain.poses * [-1, -1, 1], atol=EXACT)  # seen from the other side


@every_body
def test_the_start_pose_carries_the_whole_motion_with_it(model: Model) -> None:
    start = np.array([30.0, -7.0, 2.0])
    for table in gaits(model):
        plain, moved = simulate_joint_angles(model, table), simulate_joint_angles(model, table, start=start)
        expected = [compose(start, pose) for pose in plain.poses]
        np.testing.assert_allclose(moved.poses, expected, atol=EXACT)
        np.testing.assert_allclose(moved.step_energy, plain.step_energy, rtol=1e-12)
        np.testing.assert_allclose(moved.net_motion, plain.net_motion, atol=EXACT * 30)  # subtracts numbers near 30


@every_body
def test_cycles_compose(model: Model) -> None:
    table = gaits(model)[1]
    once, thrice = simulate_joint_angles(model, table), simulate_joint_angles(model, table, cycles=3)
    g = once.net_motion
    np.testing.assert_allclose(thrice.poses[-1], compose(g, compose(g, g)), atol=EXACT)
    np.testing.assert_allclose(thrice.poses[16], g, atol=EXACT)
    assert thrice.energy_raw == pytest.approx(3 * once.energy_raw, rel=1e-12)


@every_body
def test_a_motion_played_in_two_parts_is_the_whole_motion(model: Model) -> None:
    rows = gaits(model)[2]
    whole = simulate_joint_angles(model, rows, closed=False)
    first = simulate_joint_angles(model, rows[:7], closed=False)
    second = simulate_joint_angles(model, rows[6:], closed=False, start=first.poses[-1])
    np.testing.assert_allclose(np.concatenate([first.poses, second.poses[1:]]), whole.poses, atol=EXACT)


@every_body
def test_shapes_count_and_not_the_frame_in_which_they_are_given(model: Model) -> None:
    table, rng = gaits(model)[0], np.random.default_rng(12)
    rows = np.concatenate([table, table[:1]])
    shapes, _ = shape_rows(model, rows)
    turn = rng.uniform(-np.pi, np.pi, size=len(rows))
    rotations = np.moveaxis(np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]), -1, 0)
    scattered = np.einsum("rij,rnj->rni", rotations, shapes) + rng.normal(size=(len(rows), 1, 2))
    expected = simulate_joint_angles(model, table)
    np.testing.assert_allclose(simulate_vertices(model, scattered).poses, expected.poses, atol=EXACT)


def test_a_joint_that_never_bends_is_a_rigid_vertex() -> None:
    free = reference()
    stiff = replace(free, body=Body(vertices=12, joints=(1, 2, 3, 4, 6, 7, 8, 9, 10)))
    table = random_table(stiff, np.random.default_rng(13), 12)
    motion = simulate_joint_angles(free, np.insert(table, 4, 0.0, axis=1))
    np.testing.assert_allclose(simulate_joint_angles(stiff, table).vertices, motion.vertices, atol=EXACT)


def test_scaling_lengths_by_a_and_weights_by_b_gives_displacement_times_a_and_energy_times_a2_b() -> None:
    # the step's own function takes any units: here nothing has been normalised beforehand
    model, a, b = uneven(), 2.5, 7.0
    structure, n = model.structure, model.body.vertices
    table = serpenoid_table(model)
    scaled = model.parameters * np.concatenate([np.full(n - 1, a), np.ones(n), [1.0]])
    heavy = scaled * np.concatenate([np.ones(n - 1), np.full(n, b), [1.0]])
    step, shape = functions.step(structure), functions.shape(structure)
    for row, then in zip(table[:-1], table[1:], strict=True):
        plain = [shape(angles, model.parameters)[1] for angles in (row, then)]
        large = [shape(angles, scaled)[1] for angles in (row, then)]
        pose, _, _, energy = step(*plain, 0, model.parameters)
        pose_large, _, _, energy_large = step(*large, 0, heavy)
        expected = pose.full()[:, 0] * [a, a, 1]
        np.testing.assert_allclose(pose_large.full()[:, 0], expected, atol=EXACT)
        assert float(energy_large) == pytest.approx(float(energy) * a**2 * b, rel=1e-10)


def test_a_body_measured_in_other_units_makes_the_same_dimensionless_motion() -> None:
    small = uneven()
    body = small.body
    lengths, weights = (tuple(5.0 * x for x in values) for values in (body.edge_lengths, body.weights))
    large = replace(small, body=Body(vertices=9, edge_lengths=lengths, weights=weights, joints=body.joints))
    table = serpenoid_table(small)
    pair = [simulate_joint_angles(model, table).poses for model in (small, large)]
    np.testing.assert_allclose(*pair, atol=EXACT)
    assert large.body.total_length_m == pytest.approx(5 * small.body.total_length_m)


@every_body
def test_a_batch_is_its_gaits_one_by_one(model: Model) -> None:
    rng = np.random.default_rng(14)
    tables = np.array([random_table(model, rng, 16, amplitude) for amplitude in (0.1, 0.5, 1.2)])
    batch = simulate_batch(model, tables)
    for i, table in enumerate(tables):
        single = simulate_joint_angles(model, table)
        np.testing.assert_allclose(batch.poses[i], single.poses, atol=EXACT)
        assert batch.dissipation[i] == pytest.approx(single.dissipation, rel=1e-10)
        assert batch.displacement[i] == pytest.approx(single.displacement, abs=EXACT)
        assert bool(batch.sound[i]) == single.status.ok


def test_equal_edges_may_be_given_by_their_sum() -> None:
    medium = Medium(anisotropy_ratio=0.2)
    table = serpenoid_table(reference())
    bodies = [Body(vertices=12), Body(vertices=12, length_m=0.92), Body(vertices=12, edge_lengths=(3.0,) * 11)]
    first, *others = (simulate_joint_angles(Model(body, medium), table).poses for body in bodies)
    for poses in others:
        np.testing.assert_allclose(poses, first, atol=EXACT)
