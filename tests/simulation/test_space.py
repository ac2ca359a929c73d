"""Motion in space, SE(3): planar gaits stay planar, rigid rotations commute, six momenta vanish."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.mechanics import functions
from serpenoid.model import Model
from serpenoid.simulation import simulate_in_space, simulate_joint_angles
from serpenoid.simulation.steps import shape_rows
from serpenoid.status import Status
from specimens import BODIES, reference, serpenoid_table, uneven

pytestmark = pytest.mark.usefixtures("virtual_machine")
TOLERANCE = 1e-10  # the project's bound for planar motion in space


def planar_shapes(model: Model, count: int = 16, **gait: float) -> Floats:
    """One cycle of an elliptical gait as chains in the plane z = 0, shape (T + 1, N, 3)."""
    table = serpenoid_table(model, count, **gait)
    shapes, _ = shape_rows(model, np.concatenate([table, table[:1]]))
    return np.concatenate([shapes, np.zeros((*shapes.shape[:2], 1))], axis=2)


def spatial_shapes(seed: int, rows: int = 10, vertices: int = 9) -> Floats:
    """Chains that bend and twist: directions wander smoothly along the body and in time, shape (R, N, 3)."""
    rng = np.random.default_rng(seed)
    s, t = np.linspace(0, 1, vertices - 1)[None, :, None], np.linspace(0, 1, rows)[:, None, None]
    phase = rng.uniform(0, 2 * np.pi, size=(1, 1, 3))
    directions = np.array([2.0, 0.0, 0.0]) + np.sin(2 * np.pi * (s * np.array([1.0, 1.3, 0.7]) - t) + phase)
    edges = directions / np.linalg.norm(directions, axis=2, keepdims=True) / (vertices - 1)
    return np.concatenate([np.zeros((rows, 1, 3)), np.cumsum(edges, axis=1)], axis=1)


def spatial_momentum(model: Model, before: Floats, after: Floats) -> Floats:
    """The paper's sums in the laboratory frame, vertex dissipation: (1/2 sum mu_rot, sum mu_tran)."""
    weights, eps = model.body.vertex_weights, model.medium.anisotropy_ratio

    def metric(chain: Floats) -> Floats:
        unit = np.diff(chain, axis=0)
        unit /= np.linalg.norm(unit, axis=1, keepdims=True)
        tangent = np.concatenate([unit[:1], unit[1:] + unit[:-1], unit[-1:]])
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        return weights[:, None, None] * (np.eye(3) + (eps - 1) * tangent[:, :, None] * tangent[:, None, :])

    first, second, dp = metric(before), metric(after), after - before
    rotation = np.cross(after, np.einsum("kij,kj->ki", first, dp)) + np.cross(
        before, np.einsum("kij,kj->ki", second, dp)
    )
    return np.array([*rotation.sum(0) / 2, *np.einsum("kij,kj->i", (first + second) / 2, dp)])


@pytest.mark.parametrize("model", BODIES.values(), ids=BODIES)
def test_a_planar_gait_in_space_stays_planar_and_is_the_planar_motion(model: Model) -> None:
    motion = simulate_in_space(model, planar_shapes(model))
    flat = simulate_joint_angles(model, serpenoid_table(model, 16))
    assert motion.status.ok
    assert np.abs(motion.vertices[..., 2]).max() < TOLERANCE
    np.testing.assert_allclose(motion.vertices[..., :2], flat.vertices, atol=TOLERANCE)
    np.testing.assert_allclose(motion.step_energy, flat.step_energy, atol=TOLERANCE)


@pytest.mark.parametrize("degrees", [20.0, 90.0, 179.0, 180.0])
def test_a_first_chain_placed_elsewhere_takes_the_whole_motion_with_it(degrees: float) -> None:
    model, shapes = uneven(), spatial_shapes(30)
    plain = simulate_in_space(model, shapes)
    turn = Rotation.from_rotvec(np.deg2rad(degrees) * np.array([1.0, 2.0, -2.0]) / 3)
    placed = shapes.copy()
    placed[0] = turn.apply(shapes[0]) + [0.3, -0.2, 0.7]
    moved = simulate_in_space(model, placed)
    assert moved.status.ok
    expected = turn.apply(plain.vertices.reshape(-1, 3)).reshape(plain.vertices.shape) + [0.3, -0.2, 0.7]
    np.testing.assert_allclose(moved.vertices, expected, atol=TOLERANCE)


def test_rotating_the_input_rotates_the_output() -> None:
    model, shapes = uneven(), spatial_shapes(31)
    turn = Rotation.from_rotvec([0.4, -1.1, 0.7])
    plain = simulate_in_space(model, shapes)
    turned = simulate_in_space(model, turn.apply(shapes.reshape(-1, 3)).reshape(shapes.shape))
    expected = turn.apply(plain.vertices.reshape(-1, 3)).reshape(shapes.shape)
    np.testing.assert_allclose(turned.vertices, expected, atol=TOLERANCE)
    np.testing.assert_allclose(turned.step_energy, plain.step_energy, atol=1e-14)


def test_only_the_shapes_count_in_space_too() -> None:
    model, shapes, rng = uneven(), spatial_shapes(32), np.random.default_rng(33)
    turns = Rotation.random(len(shapes), rng=rng)
    scattered = np.array([turn.apply(chain) + rng.normal(size=3) for turn, chain in zip(turns, shapes, strict=True)])
    scattered[0] = shapes[0]
    motion = simulate_in_space(model, scattered)
    assert motion.status.ok
    np.testing.assert_allclose(motion.vertices, simulate_in_space(model, shapes).vertices, atol=TOLERANCE)


@pytest.mark.parametrize("seed", range(4))
def test_all_six_momenta_of_a_twisting_chain_vanish(seed: int) -> None:
    model = uneven()
    motion = simulate_in_space(model, spatial_shapes(seed))
    assert motion.status.ok
    pairs = zip(motion.vertices[:-1], motion.vertices[1:], strict=True)
    worst = max(np.abs(spatial_momentum(model, before, after)).max() for before, after in pairs)
    assert worst < 2e-12  # the solver's 1e-12 in the body's frame, seen from the laboratory's origin
    assert np.abs(np.diff(motion.vertices.mean(1), axis=0)).max() > 1e-3  # it does swim


def test_time_reversal_in_space_leads_back() -> None:
    model, shapes = uneven(), spatial_shapes(34)
    there_and_back = np.concatenate([shapes, shapes[-2::-1]])
    motion = simulate_in_space(model, there_and_back)
    np.testing.assert_allclose(motion.vertices[-1], motion.vertices[0], atol=TOLERANCE)
    np.testing.assert_allclose(motion.step_energy, motion.step_energy[::-1], atol=1e-14)


def test_mirrored_chains_mirror_the_motion_in_space() -> None:
    model, shapes, mirror = uneven(), spatial_shapes(35), np.array([1.0, 1.0, -1.0])
    plain, image = simulate_in_space(model, shapes), simulate_in_space(model, shapes * mirror)
    np.testing.assert_allclose(image.vertices, plain.vertices * mirror, atol=TOLERANCE)


def test_a_straight_chain_whose_roll_is_undetermined_is_no_obstacle() -> None:
    model = reference()
    shapes = planar_shapes(model, x_c=0.0, y_c=0.0, sigma=1.0, a=4.0)
    straight = np.zeros((1, 12, 3))
    straight[0, :, 0] = np.linspace(0, 1, 12)
    motion = simulate_in_space(model, np.concatenate([straight, straight, shapes]))
    assert motion.status.ok
    np.testing.assert_allclose(motion.vertices[1], straight[0], atol=TOLERANCE)
    flat = motion.vertices[2:] - motion.vertices[2:].mean((0, 1))
    assert np.linalg.svd(flat.reshape(-1, 3), compute_uv=False)[2] < 1e-9  # one plane, whichever the roll


def wandering_chains(spread: float, rows: int) -> Floats:
    """Chains whose edges leave the first axis at random, every row anew: shape (R, 9, 3)."""
    rng = np.random.default_rng(37)
    edges = np.array([1.0, 0.0, 0.0]) + spread * rng.normal(size=(rows, 8, 3))
    edges /= 8 * np.linalg.norm(edges, axis=2, keepdims=True)
    return np.concatenate([np.zeros((rows, 1, 3)), np.cumsum(edges, axis=1)], axis=1)


@pytest.mark.parametrize("spread", [1e-8, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 0.5, 1.0, 4.0])
def test_every_step_in_space_ends_in_a_minimum_from_nearly_straight_to_tangled(spread: float) -> None:
    model, shapes, rng = uneven(), wandering_chains(spread, 12), np.random.default_rng(38)
    motion = simulate_in_space(model, shapes)
    assert motion.status.ok
    placed = motion.vertices
    energy, elements = functions.step_energy(model.structure, 3), functions.shape_elements(model.structure, 3)
    for before, after, value in zip(placed[:-1], placed[1:], motion.step_energy, strict=True):
        middle, fixed = after.mean(0), elements(before.T)
        for turn in Rotation.from_rotvec(1e-3 * rng.normal(size=(6, 3))):
            nudged = elements((turn.apply(after - middle) + middle).T)
            assert float(energy(fixed, nudged, np.zeros(6), model.parameters)) > value - 1e-16


def test_a_chain_folded_back_on_itself_in_space_is_a_status() -> None:
    model, shapes = uneven(), spatial_shapes(39)
    edges = np.array([1.0, 1, 1, -1, 1, 1, 1, 1])[:, None] * [0.125, 0, 0]  # back along itself once: no tangent there
    shapes[2] = np.concatenate([np.zeros((1, 3)), np.cumsum(edges, axis=0)])
    assert simulate_in_space(model, shapes).status is Status.STEP_UNSOLVED


def test_unknown_points_in_space_are_a_status_and_coinciding_ones_are_refused() -> None:
    model, shapes = uneven(), spatial_shapes(36)
    shapes[3, 2, 1] = np.nan
    assert simulate_in_space(model, shapes).status is Status.BAD_SHAPE
    shapes[3, 2] = shapes[3, 1]
    with pytest.raises(InputError, match="`vertices` 2 and 3 of row 3 are one point"):
        simulate_in_space(model, shapes)
