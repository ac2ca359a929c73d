"""What does not move is told at once; what is slow, or bends where it lies, is never taken for it."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

from serpenoid.diagnose.data.still import refuse_still
from serpenoid.errors import InputError
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.load import load_campaign
from specimens import animal_campaign

TIME = np.arange(400) / 60
NOISE = 2e-4


def noisy(path: np.ndarray) -> np.ndarray:
    """Six markers (F, 6, 2) about a path (F, 6, 2), some hidden for a while."""
    markers = path + NOISE * np.random.default_rng(3).standard_normal(path.shape)
    markers[50:90, 2] = np.nan
    return markers


def still() -> np.ndarray:
    return np.stack([np.linspace(0, 0.8, 6), np.zeros(6)], axis=1) + np.zeros((len(TIME), 1, 1))


@pytest.mark.parametrize("markers", [still(), noisy(still())], ids=["to the last digit", "in noise"])
def test_nothing_moved(markers):
    with pytest.raises(InputError, match=r"nothing moved: no marker .* in the 6.65 s .* power off"):
        refuse_still(TIME, markers)


def test_a_slow_robot_moves():
    """A millimetre in all: five times the noise of a marker."""
    refuse_still(TIME, noisy(still() + 1e-3 * (TIME / TIME[-1])[:, None, None]))


def test_a_body_that_bends_where_it_lies_moves():
    """One marker of six swings to and fro by half a millimetre."""
    path = still()
    path[:, 5, 1] += 5e-4 * np.sin(2 * np.pi * TIME / 2)
    refuse_still(TIME, noisy(path))


def test_a_trial_of_which_nothing_is_seen_is_not_called_still():
    refuse_still(TIME, np.full((len(TIME), 6, 2), np.nan))


def test_readings_that_never_change_show_no_motion():
    """Their mean is rounded, and so is what is left of them: alike in every row."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not Signal(TIME, np.full((len(TIME), 3), 0.29090236061)).moves


def test_motion_is_told_from_rows_in_disorder_at_the_stated_error():
    """A wave that makes half of what 81 rows vary by, and the same rows shuffled: six joints each."""
    rng, rows, tries = np.random.default_rng(4), np.arange(81), 400
    seen = disorder = 0
    for _ in range(tries):
        wave = np.sin(2 * np.pi * (rows / 40 + rng.uniform()))[:, None] * np.array([1.0, 0, 0, 0, 0, 0])
        values = wave + np.sqrt(0.5) * rng.normal(size=(81, 6))
        seen += Signal(rows / 30, values).moves
        disorder += Signal(rows / 30, rng.permutation(values)).moves
    assert seen > 0.9 * tries
    assert disorder < 0.03 * tries


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_a_measured_recording_in_which_nothing_moves_says_so_and_no_fit_is_called_possible(tmp_path, share):
    slides = still() + 0.1 * share * (TIME / TIME[-1])[:, None, None]
    (trial,) = load_campaign(animal_campaign(tmp_path, "still", TIME, noisy(slides), "m")).trials
    assert any(note.startswith("nothing moved") for note in trial.notes) == (not share)
    assert any("a fit is possible" in note for note in trial.notes) == bool(share)
