"""The right root among several, checked by a dense scan that shares no code with the package; failures as values."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from oracle import integrator
from oracle.chain import place, shape_vertices
from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.model import Model
from serpenoid.simulation import simulate_batch, simulate_joint_angles, simulate_vertices
from serpenoid.status import Status
from specimens import BODIES, reference, serpenoid_table

pytestmark = pytest.mark.usefixtures("virtual_machine")


def energy_at(model: Model, turns: Floats, before: Floats, after: Floats) -> Floats:
    """Least energy over all translations at each turn (P,), chains (N, 2), by the oracle's tensors."""
    edge = model.medium.dissipation == "edge"
    elements = integrator.edge_elements if edge else integrator.vertex_elements
    w = model.body.vertex_weights
    w = integrator.edge_weights(w, model.body.edges) if edge else w
    p0, t0 = elements(before)
    moved = [elements(place([0, 0, turn], after)) for turn in turns]
    p1, t1 = np.array([p for p, _ in moved]), np.array([t for _, t in moved])
    eps = model.medium.anisotropy_ratio
    d = [w[:, None, None] * (np.eye(2) + (eps - 1) * t[..., :, None] * t[..., None, :]) for t in (t0, t1)]
    d = (d[0] + d[1]) / 2
    force, stiffness = np.einsum("pkij,pkj->pi", d, p1 - p0), d.sum(1)
    shift = -np.linalg.solve(stiffness, force[..., None])[..., 0]
    dp = p1 - p0 + shift[:, None]
    return 0.5 * np.einsum("pki,pkij,pkj->p", dp, d, dp)


def minima(model: Model, before: Floats, after: Floats, samples: int = 3000) -> Floats:
    """Turns at all minima of the energy over a full turn."""
    turns = np.linspace(-np.pi, np.pi, samples, endpoint=False)
    value, width = energy_at(model, turns, before, after), 2 * np.pi / samples
    places = np.flatnonzero((value < np.roll(value, 1)) & (value <= np.roll(value, -1)))

    def polished(turn: float) -> float:
        inside = (turn - width, turn + width)
        found = minimize_scalar(
            lambda x: float(energy_at(model, np.array([x]), before, after)[0]),
            bounds=inside,
            method="bounded",
            options={"xatol": 1e-10},
        )
        return float(found.x)

    return np.array([polished(turns[i]) for i in places])


@pytest.mark.parametrize("model", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("amplitude", [0.4, pytest.param(1.0, marks=pytest.mark.slow), 2.0])
def test_however_large_the_shape_change_the_root_is_the_minimum_with_the_least_turn(
    model: Model, amplitude: float
) -> None:
    rng, body = np.random.default_rng(20), model.body
    table = np.clip(rng.normal(size=(9, body.joint_count)) * amplitude, -3, 3)
    motion = simulate_joint_angles(model, table, closed=False)
    assert motion.status.ok
    assert motion.residual <= 1e-12
    shapes = shape_vertices(table, body.edges, body.vertex_weights, body.joint_vertices)
    for before, after, turn in zip(shapes[:-1], shapes[1:], np.diff(motion.poses[:, 2]), strict=True):
        all_turns = minima(model, before, after)
        least = all_turns[np.abs(all_turns).argmin()]
        # a minimiser without derivatives finds a flat minimum to the square root of rounding only
        assert turn == pytest.approx(least, abs=2e-6), f"chose {turn}, minima at {all_turns}"


def test_a_body_that_coils_up_in_one_step_still_gets_a_sound_root() -> None:
    model = reference()
    table = np.array([np.zeros(10), np.full(10, 0.55), np.zeros(10), np.full(10, -0.55)])
    motion = simulate_joint_angles(model, table)
    assert motion.status.ok
    assert np.abs(motion.net_motion[1:]).max() < 1e-9  # its mirror image undoes the sideways motion and the turn


def test_a_table_that_is_not_a_number_is_a_status_and_no_exception() -> None:
    model = reference()
    table = serpenoid_table(model)
    table[3, 4] = np.nan
    motion = simulate_joint_angles(model, table)
    assert motion.status is Status.BAD_SHAPE
    assert motion.poses.shape == (21, 3)
    assert np.isnan(motion.poses).all()
    table[3, 4] = np.inf
    assert simulate_joint_angles(model, table).status is Status.BAD_SHAPE


def test_one_bad_gait_in_a_batch_spoils_no_other() -> None:
    model = reference()
    good = serpenoid_table(model)
    bad = good.copy()
    bad[3, 4] = np.nan
    batch = simulate_batch(model, np.array([good, bad, good]))
    assert batch.sound.tolist() == [True, False, True]
    np.testing.assert_array_equal(batch.poses[0], batch.poses[2])
    np.testing.assert_allclose(batch.poses[0], simulate_joint_angles(model, good).poses, atol=1e-12)


def test_a_joint_folded_back_on_itself_has_no_tangent_and_is_a_status() -> None:
    model = reference()
    table = serpenoid_table(model)
    table[5, 4] = np.pi
    motion = simulate_joint_angles(model, table)
    # cos and sin of pi differ from (-1, 0) by rounding: the tangent exists in floating point or it does not
    assert motion.status in (Status.SOLVED, Status.STEP_UNSOLVED)


def test_vertices_that_coincide_are_refused_and_unknown_ones_are_a_status() -> None:
    model = reference()
    shapes = np.zeros((3, 12, 2))
    shapes[..., 0] = np.linspace(0, 1, 12)
    shapes[1, 5] = shapes[1, 4]
    with pytest.raises(InputError, match="`vertices` 5 and 6 of row 1 are one point"):
        simulate_vertices(model, shapes)
    shapes[1, 5] = np.nan
    assert simulate_vertices(model, shapes).status is Status.BAD_SHAPE


def test_every_status_says_what_to_do() -> None:
    for status in Status:
        assert status.ok is (status is Status.SOLVED)
        if status not in (Status.SOLVED, Status.STOPPED):
            assert ":" in status.value, f"{status.name} has no remedy"
