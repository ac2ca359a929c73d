"""Chance along an effect, by how its score differs between trials that were laid alike."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.fits.prices import Priced, least_idle
from serpenoid.diagnose.inference.search.by_trial import _beyond

SETTINGS, WINDOWS = 8, 72
PAIRS = [(2 * i, 2 * i + 1) for i in range(SETTINGS)]


def trials(rng: np.random.Generator, lasting: float) -> list[Evidence]:
    """White windows of each two trials of a setting, and what the fit's columns (eps, an effect of one and one of two
    parameters) do there; lasting: SD, in units of a window, of what a trial has along the effect of one."""
    found = []
    for _ in range(SETTINGS):
        columns = rng.normal(size=(WINDOWS, 4))
        for _ in "ab":
            rows = rng.normal(size=WINDOWS) + lasting * rng.normal() * columns[:, 1]
            found.append(Evidence.of(rows, columns, np.zeros(WINDOWS)))
    return found


@pytest.mark.parametrize("columns", [range(1, 2), range(2, 4)])
def test_where_windows_are_all_there_is_chance_is_as_large_as_they_say(columns: range) -> None:
    rng = np.random.default_rng(columns.start)
    told = [_beyond(trials(rng, 0.0), PAIRS, columns) for _ in range(300)]
    assert np.mean(np.array(told) > 1) <= 0.01 + 3 * np.sqrt(0.01 / 300)


def test_what_differs_from_trial_to_trial_along_an_effect_is_chance_of_that_effect_alone() -> None:
    rng = np.random.default_rng(3)
    lasting = 0.5  # a quarter of a window's variance: of 72 windows it is 18 times as much as these
    drawn = [trials(rng, lasting) for _ in range(60)]
    told = [_beyond(t, PAIRS, range(1, 2)) for t in drawn]
    assert np.median(told) == pytest.approx(1 + lasting**2 * WINDOWS, rel=0.25)
    assert np.mean([_beyond(t, PAIRS, range(2, 4)) > 1 for t in drawn]) < 0.1


def test_an_effect_must_take_away_as_much_more() -> None:
    best, bases = Priced(100.0, 3, 100.0), [Priced(160.0, 2, 100.0), Priced(130.0, 2, 100.0)]
    everything = lambda likely: set(likely)  # noqa: E731
    assert least_idle(best, bases, 16.0, everything) is None
    assert least_idle(best, bases, 16.0, everything, [60.0, 0.0]) == 0
