"""A film from which frames are missing though its clock says otherwise, beside a servo log that goes on."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.measure.consistency.check import Claim, check
from serpenoid.measure.consistency.lost_frames import lost_frames
from serpenoid.measure.consistency.signals import Signal

RATE, LAG = 50.0, 0.04


def angles(time: np.ndarray) -> np.ndarray:
    """Two cycles of 3 s with pauses of 1 s, of four joints (F, 4); at rest before and after."""
    phase = np.clip(np.stack([time - 1.0, time - 5.0]), 0.0, 3.0).sum(axis=0) / 3.0
    return 0.6 * np.sin(2 * np.pi * (phase[:, None] + np.arange(4) / 5))


def witnesses(lost: slice | None, rate: float = 0.0, seed: int = 0) -> tuple[Signal, Signal]:
    """Film and log, each with noise, on clocks of their own; frames lost without a word."""
    rng, true = np.random.default_rng(seed), np.arange(0, 10, 1 / RATE)
    kept = np.ones(len(true), dtype=bool)
    if lost is not None:
        kept[lost] = False
    seen = angles(true[kept] - LAG) + rng.normal(scale=4e-3, size=(kept.sum(), 4))
    log_s = np.arange(0, 10, 0.02)
    read = np.round(angles(log_s) / 1.5e-3) * 1.5e-3
    return Signal(1e9 + (1 + rate) * np.arange(kept.sum()) / RATE, seen), Signal(log_s + 4.63, read)


@pytest.mark.parametrize(("first", "count"), [(100, 25), (130, 10), (300, 40)])
def test_frames_that_were_lost_without_a_word_are_told_with_place_and_time(first, count):
    found = lost_frames(*witnesses(slice(first, first + count)))
    assert found is not None
    assert found.at_s - 1e9 == pytest.approx(first / RATE, abs=0.1)
    assert found.seconds == pytest.approx(count / RATE, abs=0.05)  # the grid of shifts has 4 s / 80


@pytest.mark.parametrize("rate", [0.0, 0.01, -0.02])
def test_clocks_that_run_at_different_rates_have_lost_nothing(rate):
    assert all(lost_frames(*witnesses(None, rate, seed)) is None for seed in range(5))


def test_a_trial_with_lost_frames_is_remarked_on_and_no_other():
    films = {"whole": None, "torn": slice(130, 150)}
    claims = [Claim(name, "table", None, *witnesses(lost)) for name, lost in films.items()]
    ((trial, said),) = check(claims, {}).remarks
    assert trial == "torn"
    assert "0.4 s are missing from the film near 1000000002.6 s" in said
