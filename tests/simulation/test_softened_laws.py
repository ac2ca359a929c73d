"""What every softened law keeps: it is blind to speed, goes back the way it came, and rests in pauses."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from serpenoid.media import LAWS
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_batch, simulate_joint_angles, simulate_vertices
from specimens import random_table, reference, serpenoid_table

RATIOS = {"coulomb": 0.1865, "quadratic": 0.4, "coulomb_by_components": 0.1865, "coulomb_plain": 0.1865}
EXACT = (
    1e-9  # residual 1e-12 over a stiffness that is small along the body's easiest direction, or where it slips little
)
Bodies = Callable[..., Model]


@pytest.fixture(params=[law.name for law in LAWS.values() if law.softened])
def body(request: pytest.FixtureRequest) -> Bodies:
    """The reference body in a medium of one law."""
    medium = Medium(anisotropy_ratio=RATIOS[request.param], law=request.param)
    return lambda **model: Model(reference().body, medium, **model)


def test_a_gait_played_slower_or_on_two_clocks_goes_the_same_way(body: Bodies) -> None:
    table = serpenoid_table(reference(), 20)
    quick, slow = (simulate_joint_angles(body(cycle_duration_s=t), table) for t in (0.5, 50.0))
    np.testing.assert_allclose(quick.poses, slow.poses, atol=EXACT)
    assert quick.dissipation == pytest.approx(slow.dissipation, rel=1e-9)


def test_the_table_played_backwards_takes_the_body_back(body: Bodies) -> None:
    table = random_table(reference(), np.random.default_rng(2), 16)
    there_and_back = np.concatenate([table, table[-2::-1]])
    motion = simulate_joint_angles(body(), there_and_back, closed=False)
    assert motion.status.ok
    assert np.abs(motion.poses).max() > 0.01
    assert np.abs(motion.net_motion).max() < EXACT


def test_mirrored_shapes_mirror_the_motion(body: Bodies) -> None:
    table = serpenoid_table(reference(), 20)
    a, b = simulate_joint_angles(body(), table), simulate_joint_angles(body(), -table)
    np.testing.assert_allclose(a.poses * [1, -1, -1], b.poses, atol=EXACT)


@pytest.mark.parametrize(
    "table",
    [serpenoid_table(reference(), 20), random_table(reference(), np.random.default_rng(2), 16)],
    ids=["serpenoid", "random"],
)
def test_pauses_move_nothing(body: Bodies, table: np.ndarray) -> None:
    whole = simulate_joint_angles(body(), table)
    paused = simulate_joint_angles(body(), np.repeat(table, 2, axis=0))
    np.testing.assert_allclose(paused.poses[::2], whole.poses, atol=EXACT)


def test_batches_sweep_the_same_motion_and_vertices_too(body: Bodies) -> None:
    tables = np.stack([serpenoid_table(reference(), 20, a=a) for a in (2.0, 6.0)])
    batch = simulate_batch(body(), tables)
    for i, table in enumerate(tables):
        single = simulate_joint_angles(body(), table)
        np.testing.assert_allclose(batch.poses[i], single.poses, atol=EXACT)
        assert batch.dissipation[i] == pytest.approx(single.dissipation, rel=1e-9)
    again = simulate_vertices(body(), single.vertices)
    np.testing.assert_allclose(again.poses, single.poses, atol=EXACT)
