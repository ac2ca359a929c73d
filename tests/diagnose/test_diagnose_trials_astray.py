"""Trials in which a joint strays are told where the others do not; which of many leave a little more than noise is
chance."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np
import pytest

from serpenoid.diagnose.inference.fits.finding import Divided
from serpenoid.diagnose.stages.actuation.trials_astray import trials_astray

ROWS = 200
TOLD = np.sin(np.linspace(0, 4 * np.pi, ROWS))[:, None] * np.array([1.0, 0.7, 0.4])


@dataclass(frozen=True)
class Left:
    """Four trials of one gait each; what is left of each is stated, its mean square is its structure."""

    each: tuple[np.ndarray, ...]

    @property
    def recordings(self):
        return [SimpleNamespace(name=f"g{n}-1", gait=f"g{n}") for n in range(len(self.each))]

    @property
    def trials(self):
        return np.repeat(np.arange(len(self.each)), ROWS)

    moved_by: list = field(default_factory=list)  # which joints said when trials began

    def left(self, played, by=True):
        self.moved_by.append(by)
        return np.concatenate(self.each)

    def structure_of(self, left, rows=slice(None)):
        return (left[rows] ** 2).mean(axis=0)


def wave(size: float) -> np.ndarray:
    """Of this RMS at all joints, beside what is told of quarter a period."""
    return size * np.sqrt(2) * np.cos(np.linspace(0, 4 * np.pi, ROWS))[:, None] * np.ones(3)


def said(*each: np.ndarray) -> Divided | None:
    return trials_astray(Left(each), np.tile(TOLD, (len(each), 1)), 0)


def test_what_all_trials_leave_about_as_much_of_as_noise_is_told_of_none():
    assert said(wave(1.12), wave(1.41), wave(0.63), wave(1.16)) is None
    assert said(wave(0.8), wave(1.24)) is None


def test_a_trial_that_strays_far_is_told_and_so_is_one_that_alone_follows():
    names = ("g0-1", "g1-1", "g2-1", "g3-1")
    one, others = names[2:3], (*names[:2], names[3])
    told = said(wave(0.5), wave(0.3), wave(4.0), wave(0.0))
    assert told is not None
    assert (told.words, told.changed, told.others) == ("all joints stray in `g2` alone", one, others)
    told = said(wave(3.0), wave(4.0), wave(0.2), wave(3.0))
    assert told is not None
    assert (told.words, told.changed, told.others) == ("all joints follow their commands in `g2` alone", others, one)


def test_a_trial_a_little_beyond_noise_is_one_of_the_others_where_some_stray_far():
    """Servos that lag leave a little more than noise in every trial, in some by chance less."""
    told = said(wave(0.7), wave(1.4), wave(80.0), wave(110.0))
    assert told is not None
    assert (told.changed, told.others) == (("g2-1", "g3-1"), ("g0-1", "g1-1"))
    assert said(wave(0.7), wave(1.4), wave(5.0), wave(2.0)) is None  # there is no gap between those that stray


@pytest.mark.parametrize("gain", [0.0, 0.75, 1.5])
def test_how_far_joints_go_is_told_where_that_is_what_they_stray_by(gain):
    told = 20 * (gain - 1) * TOLD
    found = trials_astray(Left((wave(0.1), wave(0.1), told)), 20 * np.tile(TOLD, (3, 1)), 0)
    assert found is not None
    assert found.words == f"all joints stray in `g2` alone, {gain:.2f} times as far as told"
    assert found.any_gait == (gain == 0)  # that a joint stands still no gait makes


def test_what_grows_from_nothing_is_told_as_growing_though_the_first_trials_follow():
    """Of four trials the first does as it was told, and each after it moves a tenth less than the one before."""
    each = tuple(wave(0.1) - 20 * gain * TOLD for gain in (0.0, 0.1, 0.2, 0.3))
    found = trials_astray(Left(each), 20 * np.tile(TOLD, (4, 1)), 0)
    assert found is not None
    assert not found.changed
    assert found.words.startswith("all joints move less from trial to trial: 1.00 times as far as told in `g0-1`, 0.70")
    one = tuple(x * np.array([1.0, 0.0, 0.0]) for x in each)
    found = trials_astray(Left(one), 20 * np.tile(TOLD, (4, 1)), 0)
    assert found is not None
    assert found.words.startswith("joint 1 moves less from trial to trial: 1.00 times as far as told in `g0-1`, 0.70")


def test_joints_that_stray_do_not_say_when_their_trials_began():
    for strays, by in (([4.0, 0.3, 0.3], [False, True, True]), ([4.0, 4.0, 0.3], [False, False, True])):
        data = Left((wave(0.1), wave(0.1), wave(1.0) * np.array(strays)))
        assert trials_astray(data, np.tile(TOLD, (3, 1)), 0) is not None
        assert np.asarray(data.moved_by[-1]).tolist() == by
    data = Left((wave(0.1), wave(0.1), wave(4.0)))  # all alike
    trials_astray(data, np.tile(TOLD, (3, 1)), 0)
    assert data.moved_by[-1] is True
