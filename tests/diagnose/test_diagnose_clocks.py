"""Two clocks laid over each other: readings of a slow log beside a fast film."""

from __future__ import annotations

import numpy as np

from serpenoid.body import Body
from serpenoid.diagnose.data.clocks import align
from serpenoid.diagnose.data.noise import TICK
from serpenoid.measure.links import chain_vertices
from serpenoid.measure.logs import ServoLog

FRAMES_PER_SECOND, LOG_HERTZ, MARKER_M, SECONDS, CYCLE_S = 200.0, 14.0, 1.5e-4, 6.0, 2.5
DRAWS = 12


def bent(time: np.ndarray, joints: int) -> np.ndarray:
    """Two waves; at rest before and after."""
    phase = 2 * np.pi * np.clip(time, 0, 2 * CYCLE_S)[:, None] / CYCLE_S + np.arange(joints)
    return 0.5 * np.sin(phase) + 0.15 * np.sin(2 * phase)


def test_a_slow_log_beside_a_fast_film_has_no_other_rate_than_its_deviation_says() -> None:
    """Straight lines between readings cut off the bends, and a reading's error lasts for all frames beside it: rates
    of clocks that run alike were 4 to 9 deviations."""
    body = Body(vertices=6, edge_lengths=(0.1,) * 5)
    far = []
    for draw in range(DRAWS):
        rng = np.random.default_rng(draw)
        film = np.arange(-0.5, SECONDS, 1 / FRAMES_PER_SECOND)
        markers = chain_vertices(body, np.zeros((len(film), 3)), bent(film, body.joint_count))
        markers = markers + rng.normal(0, MARKER_M, markers.shape)
        time = np.arange(-0.6, SECONDS + 0.2, 1 / LOG_HERTZ) + rng.uniform(0, 0.01)
        read = np.round((bent(time, body.joint_count) + rng.normal(0, 0.4 * TICK, (len(time), 4))) / TICK) * TICK
        clock = align(body, film, markers, ServoLog(time, read, None, None, None, None, {}, "log.csv"))
        far.append(clock.rate / clock.rate_sd)
    assert 0.3 < np.sqrt(np.mean(np.square(far))) < 1.7  # chi squared of twelve, beyond 1 in 1000
