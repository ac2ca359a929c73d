"""What repeats share is told in metres: model error of known size is found beside noise, and noise alone is none."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.data.noise.motion import Motion, Noise
from serpenoid.diagnose.data.noise.shared import discrepancy

WINDOWS, SETTINGS, NOISE = 40, 12, 1e-3


def campaign(missed_m: float, seed: int, *, turns: bool = False, noisy: int = 0) -> tuple[Motion, list[Any]]:
    """Two trials of each setting: noise, and an error of every window [m, RMS of both components] that both share.

    turns: the error is all in turning, as the way of the points of a rod 1 m long; noisy: of so many settings the
    noise is a hundred times as large.
    """
    rng = np.random.default_rng(seed)
    tracks = []
    for setting in range(SETTINGS):
        shared = rng.normal(0, missed_m, (WINDOWS, 3)) * ([0, 0, 12**0.5] if turns else [2**-0.5, 2**-0.5, 0])
        noise = NOISE * (100 if setting < noisy else 1)
        tracks += [
            SimpleNamespace(
                recording=SimpleNamespace(setting=(f"{setting}", 2.0), body=SimpleNamespace(total_length_m=1.0)),
                usable=np.ones(WINDOWS, dtype=bool), noise=None, on_floor=np.zeros((1, 3)),
                displacement=shared + rng.normal(0, noise, (WINDOWS, 3)), doubt=np.zeros((WINDOWS, 3)), least=0.0,
                playing=np.ones(WINDOWS, dtype=bool), name=f"{setting}",
            )
            for _ in range(2)
        ]  # fmt: skip
    level, loud = np.full(3, NOISE), {(f"{i}", 2.0): np.full(3, 100 * NOISE) for i in range(noisy)}
    predictions = [SimpleNamespace(displacement=np.zeros((WINDOWS, 3))) for _ in tracks]
    return Motion(tuple(tracks), Noise(level, level, loud), tuple(range(len(tracks)))), predictions


@pytest.mark.parametrize("missed_m", [3e-3, 1e-2])
def test_an_error_that_repeats_share_is_found_in_its_size(missed_m: float) -> None:
    # 960 products tell a variance to 5 %, its root to 2.5 %: three of these
    assert discrepancy(*campaign(missed_m, 1)) == pytest.approx(missed_m, rel=0.08)


def test_an_error_in_turning_counts_as_the_way_of_the_points() -> None:
    assert discrepancy(*campaign(3e-3, 1, turns=True)) == pytest.approx(3e-3, rel=0.08)


@pytest.mark.parametrize("seed", range(6))
def test_what_is_news_has_a_size_beside_noisy_settings(seed: int) -> None:
    """What the mean of all windows tells is lost in the noise of a few of them."""
    # 440 of 480 products are of windows with little noise; noise of its own size adds to the scatter
    assert discrepancy(*campaign(3e-3, seed, turns=True, noisy=1)) > 2.7e-3


def test_noise_alone_is_no_discrepancy() -> None:
    assert [discrepancy(*campaign(0.0, seed)) for seed in range(5)] == [0.0] * 5
