"""Beats that vary: how many there are, whatever the film; and none where a body rests, trembles, turns or wanders."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from serpenoid.cli.measure import trial_lines
from serpenoid.measure.animals.beat import beat
from serpenoid.measure.load import load_campaign
from specimens import animal_campaign
from swimmers_by_curves import Curve

JOINTS = np.arange(8) / 9
SIZE = 0.6


def motion(time_s, angles, noise=0.0):
    noisy = angles + noise * np.random.default_rng(1).normal(size=angles.shape)
    covariance = np.broadcast_to(
        max(noise, 1e-6) ** 2 * np.eye(3 + angles.shape[1]), (len(time_s), *2 * [3 + angles.shape[1]])
    )
    return SimpleNamespace(
        time_s=time_s, joint_angles=noisy, smooth_angles=noisy, runs=(slice(0, len(time_s)),), covariance=covariance
    )  # a stand-in: of a Motion, no more is asked


def wave(beats, frames_a_beat, jitter=0.0, harmonic=0.0, noise=0.0, waves=1.0, hidden=0.0, seed=0):
    """Film of so many beats of about 1 s, each as long as chance says, and the beats in its seconds."""
    rng = np.random.default_rng(seed)
    ends = np.concatenate([[0.0], np.cumsum(np.maximum(1 + jitter * rng.normal(size=4 * int(beats) + 9), 0.3))])
    time = np.arange(int(beats * frames_a_beat)) / frames_a_beat
    time = time[rng.random(len(time)) >= hidden]
    turn = PchipInterpolator(ends, np.arange(len(ends)))(time + rng.uniform(0, 1))
    phase = 2 * np.pi * (turn[:, None] + waves * JOINTS)
    angles = SIZE * (np.cos(phase) + harmonic * np.cos(2 * phase + 1))
    return motion(time, angles, noise), (turn[-1] - turn[0]) / (time[-1] - time[0])


@pytest.mark.parametrize("frames_a_beat", [8, 30, 250])
@pytest.mark.parametrize("beats", [3.2, 6.0, 30.0])
@pytest.mark.parametrize("waves", [1.0, 0.0])
def test_beats_that_are_alike_are_found_as_they_are(beats, frames_a_beat, waves):
    film, rate = wave(beats, frames_a_beat, harmonic=0.3, noise=0.01, waves=waves)
    found = beat(film)
    assert 1 / found.period_s == pytest.approx(rate, rel=0.01)
    assert found.spread_s < 0.04
    np.testing.assert_allclose(found.amplitude_rad, SIZE, rtol=0.05)
    assert found.waves == pytest.approx(waves, abs=0.03)


@pytest.mark.parametrize("beats", [1.5, 2.0])
def test_a_beat_and_a_half_is_enough(beats):
    film, rate = wave(beats, 30, harmonic=0.3, noise=0.01)
    assert 1 / beat(film).period_s == pytest.approx(rate, rel=0.02)


@pytest.mark.parametrize(
    ("beats", "frames_a_beat", "jitter"), [(6, 30, 0.2), (6, 250, 0.2), (12, 15, 0.3), (30, 12, 0.3), (30, 60, 0.1)]
)
def test_beats_that_vary_are_counted(beats, frames_a_beat, jitter):
    """Within twice what chance moves a mean of so many: those at the ends of the film count less."""
    within = 2 * jitter / np.sqrt(beats)
    for seed in range(6):
        film, rate = wave(beats, frames_a_beat, jitter, harmonic=0.2, noise=0.05, hidden=0.1, seed=seed)
        found = beat(film)
        assert 1 / found.period_s == pytest.approx(rate, rel=within)
        assert 0.2 * jitter < found.spread_s < 1.5 * jitter  # s: a beat is 1 s; and the next is another one
        assert found.amplitude_rad.mean() == pytest.approx(SIZE, rel=0.15)


def test_trifles_do_not_change_the_beat():
    film, _ = wave(6, 30, 0.15, seed=3)
    rng = np.random.default_rng(0)
    clock = motion(film.time_s + rng.uniform(-0.012, 0.012, len(film.time_s)), film.smooth_angles)
    backwards = motion(film.time_s, film.smooth_angles[::-1])
    found = [beat(each) for each in (film, clock, backwards)]
    np.testing.assert_allclose([each.period_s for each in found], found[0].period_s, rtol=0.01)
    assert found[2].waves == pytest.approx(-found[0].waves, rel=0.01)


def test_what_does_not_repeat_has_no_beat():
    rng = np.random.default_rng(0)
    time = np.arange(300) / 30
    bell = np.exp(-(np.arange(-20, 21) ** 2) / 72)
    smooth = np.stack([np.convolve(column, bell, "valid") for column in rng.normal(size=(340, 8)).T], axis=1)
    still = np.full((300, 8), 0.3)
    once = np.tanh((time - 5) / 2)[:, None] * np.ones(8)
    there_and_back = np.exp(-(((time - 5) / 2) ** 2))[:, None] * np.linspace(0.5, 1, 8)
    wandering = np.cumsum(rng.normal(size=(300, 8)), axis=0)
    for angles in (still, still + 0.01 * rng.normal(size=(300, 8)), smooth, once, there_and_back, wandering):
        assert beat(motion(time, angles)) is None
    assert beat(motion(time[:5], smooth[:5])) is None


def test_a_beat_whose_noise_is_most_of_every_joint_angle_is_counted_by_bends_of_the_whole_body(tmp_path):
    """40 points with a noise of a tenth of their distance: of a joint angle's variance 8 in 10 parts are noise."""
    time, points, _ = Curve(ratio=15.0, waves=1.8, amplitude=0.5, turn=0.1).film(40, 200, 8)
    noisy = points + 0.0025 * np.random.default_rng(5).normal(size=points.shape)
    (trial,) = load_campaign(animal_campaign(tmp_path, "a", 2 * time, 100 * noisy, "mm")).trials
    angles = trial.motion.joint_angles
    assert (np.diff(angles, n=2, axis=0) ** 2).mean() / 6 > 0.8 * angles.var(axis=0).mean()
    assert trial.motion.beat.period_s == pytest.approx(2.0, rel=0.02)
    assert trial.motion.beat.waves == pytest.approx(1.8, rel=0.05)


@pytest.mark.parametrize(("back", "way"), [(0.3, 1), (0.5, None), (0.7, -1)])
def test_waves_of_an_animal_that_reverses_are_as_long_as_ever(back, way):
    """Those that ran back were taken off: of as many as ran forward nothing was left."""
    film, _ = wave(12.0, 30, noise=0.01, waves=1.4)
    turned = int((1 - back) * len(film.time_s))
    there = np.concatenate([np.arange(turned), turned - np.arange(len(film.time_s) - turned)])
    found = beat(motion(film.time_s, film.joint_angles[there]))
    assert abs(found.waves) == pytest.approx(1.4, rel=0.05)
    assert way is None or np.sign(found.waves) == way


@pytest.mark.parametrize(("waves", "runs"), [(0.0, False), (0.2, True)])
def test_bends_that_stand_run_nowhere(waves, runs):
    assert beat(wave(6.0, 30, noise=0.01, waves=waves)[0]).runs is runs


def test_of_bends_that_run_to_and_fro_no_direction_is_said(tmp_path):
    _, points, _ = Curve(ratio=5.0, waves=1.2, amplitude=0.5, turn=0.0).film(11, 120, 4)
    both = np.concatenate([points, points[-2::-1]])
    (trial,) = load_campaign(animal_campaign(tmp_path, "a", np.arange(len(both)) / 30, 100 * both, "mm")).trials
    said = "\n".join(trial_lines(trial))
    assert re.search(r"Hz, 1\.[12]\d* waves on the body$", said, re.MULTILINE)
    assert "its bends stand, or run to and fro" in said
