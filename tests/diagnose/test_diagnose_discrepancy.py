"""What repeats share is told in metres: model error of known size is found beside noise, and noise alone is none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.data.motion import Motion, Noise
from serpenoid.diagnose.data.shared import discrepancy

WINDOWS, SETTINGS, NOISE = 40, 12, 1e-3


def campaign(missed_m: float, seed: int) -> tuple[Motion, list[Any]]:
    """Two trials of each setting: noise, and an error of every window [m, RMS of both components] that both share."""
    rng = np.random.default_rng(seed)
    tracks = []
    for setting in range(SETTINGS):
        shared = rng.normal(0, missed_m / np.sqrt(2), (WINDOWS, 3)) * [1, 1, 0]
        tracks += [
            SimpleNamespace(
                recording=SimpleNamespace(setting=(f"{setting}", 2.0), body=SimpleNamespace(total_length_m=1.0)),
                usable=np.ones(WINDOWS, dtype=bool), noise=None, on_floor=np.zeros((1, 3)),
                displacement=shared + rng.normal(0, NOISE, (WINDOWS, 3)), doubt=np.zeros((WINDOWS, 3)), least=0.0,
                playing=np.ones(WINDOWS, dtype=bool), name=f"{setting}",
            )
            for _ in range(2)
        ]  # fmt: skip
    level = np.full(3, NOISE)
    predictions = [SimpleNamespace(displacement=np.zeros((WINDOWS, 3))) for _ in tracks]
    return Motion(tuple(tracks), Noise(level, level), tuple(range(len(tracks)))), predictions


@pytest.mark.parametrize("missed_m", [3e-3, 1e-2])
def test_an_error_that_repeats_share_is_found_in_its_size(missed_m: float) -> None:
    # 960 products tell a variance to 5 %, its root to 2.5 %: three of these
    assert discrepancy(*campaign(missed_m, 1)) == pytest.approx(missed_m, rel=0.08)


def test_noise_alone_is_no_discrepancy() -> None:
    assert [discrepancy(*campaign(0.0, seed)) for seed in range(5)] == [0.0] * 5
