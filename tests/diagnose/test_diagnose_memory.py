"""Chance that lasts: pushes that are forgotten within a cycle are told from repeats, and raise no doubt."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.data.noise.memory import Memory, _likelihood, _scattered, covariance, roots, share_of_poses
from serpenoid.diagnose.data.noise.motion import Motion, Noise
from serpenoid.diagnose.data.noise.noise import window_noise
from serpenoid.diagnose.data.noise.paths import path_error, path_noise, repeated
from serpenoid.diagnose.residuals.residual_words import pattern
from serpenoid.group import accumulate

PHASES, WINDOW_S, FINE, PUSH, POSE = 8, 0.4, 20, 1e-3, 5e-4
LEAST = POSE * np.sqrt(2)
STEP = np.array([0.01, 0.0, 0.02])


def pushed_windows(rng: np.random.Generator, count: int, time: float) -> np.ndarray:
    """What pushes of unit size, forgotten in `time` [s], add up to over successive windows (count, 3)."""
    steps = rng.normal(size=(count * FINE, 3))
    kept = np.exp(-WINDOW_S / FINE / time) if time else 0.0
    for i in range(1, len(steps)):
        steps[i] = kept * steps[i - 1] + np.sqrt(1 - kept**2) * steps[i]
    windows = steps.reshape(count, FINE, 3).sum(axis=1)
    return np.asarray(windows / (FINE if time else np.sqrt(FINE)))


def campaign(
    seed: int, time: float, cycles: int = 6, settings: int = 6, gust: float = 0.0, floors: float = 0.0
) -> tuple[Motion, list[Any]]:
    """Every setting twice; markers' noise of poses, and pushes whose memory is `time` [s].

    gust: a push [m a window] of the first of each two trials, over three windows somewhere; floors: by which share (SD)
    the body moves farther in a trial, from its beginning to its end.
    """
    rng = np.random.default_rng(seed)
    count = PHASES * cycles
    true = np.tile(STEP, (count, 1))
    tracks = []
    for name in [f"{i // 2}" for i in range(2 * settings)]:
        moved = true + PUSH * pushed_windows(rng, count, time)
        if gust and len(tracks) % 2 == 0:
            begin = int(rng.integers(count - 3))
            moved[begin : begin + 3, :2] += gust * rng.normal(size=2)
        moved += floors * rng.normal() * true if floors else 0.0
        path = accumulate(moved, np.zeros(3))
        seen = path + rng.normal(0, POSE, path.shape)
        c, s = np.cos(seen[:-1, 2]), np.sin(seen[:-1, 2])
        moved = np.diff(seen, axis=0)
        moved = np.column_stack([c * moved[:, 0] + s * moved[:, 1], c * moved[:, 1] - s * moved[:, 0], moved[:, 2]])
        tracks.append(
            SimpleNamespace(
                recording=SimpleNamespace(
                    name=name, length_unit="m", setting=(name, 3.0), body=SimpleNamespace(total_length_m=0.5)
                ),
                phase=np.tile((np.arange(PHASES) + 0.5) / PHASES, cycles), cycle=np.repeat(np.arange(cycles), PHASES),
                playing=np.ones(count, dtype=bool), usable=np.ones(count, dtype=bool), noise=None, doubt=0.0,
                gap_windows=np.zeros(count, dtype=bool), time=WINDOW_S * np.arange(count + 1), poses=seen,
                boundaries=np.arange(count + 1), duration=np.full(count, WINDOW_S), measured=seen, displacement=moved,
                least=np.full((count, 3), LEAST), on_floor=seen, first_seen=0,
            )
        )  # fmt: skip
    left = [t.displacement - true for t in tracks]
    noise, _ = window_noise(tracks, left)
    predictions = [SimpleNamespace(displacement=true) for _ in tracks]
    return Motion(tuple(tracks), noise, tuple(range(len(tracks)))), predictions


def unrepeated(motion: Motion) -> Motion:
    """With the same noise of windows, as if every trial were of a setting of its own."""
    tracks = []
    for i, track in enumerate(motion.tracks):
        recording = SimpleNamespace(**{**vars(track.recording), "setting": (str(i), 3.0)})
        tracks.append(SimpleNamespace(**{**vars(track), "recording": recording}))
    return replace(motion, tracks=tuple(tracks))


def strays(motion: Motion, predictions: list[Any], after: float) -> bool:
    noise = path_noise(motion, predictions)
    return after > noise.farthest * noise.level_m


@pytest.mark.parametrize("time", [0.1, pytest.param(0.5, marks=pytest.mark.slow), 2.0])
def test_covariance_is_that_of_pushes_and_of_poses_in_common(time: float) -> None:
    rng = np.random.default_rng(0)
    motion, _ = campaign(0, time, cycles=1, settings=1)
    track, count = motion.tracks[0], PHASES
    drawn = np.stack([PUSH * pushed_windows(rng, 10 * count, time).reshape(10, count, 3) for _ in range(100)])
    poses = rng.normal(0, POSE, (*drawn.shape[:2], count + 1, 3))
    values = (drawn + np.diff(poses, axis=2))[..., 0].reshape(-1, count)
    size = np.full((count, 3), values.std())
    # 1000 rows, ten of one run of pushes: a correlation is good to 0.05 or so where runs are long
    np.testing.assert_allclose(
        covariance(track, size, time)[0] / values.var(), np.cov(values.T) / values.var(), atol=0.1
    )


def test_of_several_times_covariance_and_likelihood_are_those_of_each() -> None:
    times = np.array([0.0, 0.1, 2.0])
    track = campaign(0, 0.5, cycles=10, settings=1)[0].tracks[0]  # 80 windows: two blocks
    rng = np.random.default_rng(0)
    size, windows = 1e-3 * rng.uniform(1, 2, size=(80, 3)), np.flatnonzero(rng.uniform(size=80) > 0.05)
    values = 1e-3 * rng.normal(size=(len(windows), 3))
    together = _likelihood(values, roots(partial(covariance, track, size, times, 0.0), windows))
    for i, time in enumerate(times):
        one = covariance(track, size, float(time), windows=windows)
        np.testing.assert_allclose(covariance(track, size, times, windows=windows)[i], one, rtol=1e-12, atol=0)
        alone = _likelihood(values, roots(partial(covariance, track, size, float(time), 0.0), windows))
        assert together[i] == pytest.approx(float(alone), rel=1e-10)


def test_the_time_in_which_pushes_are_forgotten_is_told_by_repeats() -> None:
    for time in (0.25, 1.0):
        found = campaign(1, time)[0].noise.memory
        mean = float(np.exp(np.dot(np.log(np.maximum(found.times, 1e-3)), found.weights)))
        assert mean == pytest.approx(time, rel=0.5)  # times are tried in factors of about two
    found = campaign(1, 0.0)[0].noise.memory
    assert np.dot(found.times, found.weights) < WINDOW_S / 3


def test_what_comes_again_in_every_cycle_is_told_by_repeats() -> None:
    """A floor that carries the body farther in one trial than in another does so in all its cycles: variance of a
    window 0.05 STEP beside PUSH and POSE."""
    for seed in range(2):
        found = campaign(seed, 0.0, cycles=12, floors=0.05)[0].noise.memory
        share = float(np.dot(found.recurring, found.weights))
        pushes = PUSH**2 * np.ones(3)
        true = ((0.05 * STEP) ** 2 / ((0.05 * STEP) ** 2 + pushes)).mean()
        assert share == pytest.approx(true, abs=0.2)
        assert found.lasts
        still = campaign(seed, 0.0, cycles=12)[0].noise.memory
        assert np.dot(still.recurring, still.weights) < 0.1
        assert still.fewer == 1


def test_covariance_of_what_comes_again() -> None:
    """One number for each phase, in every cycle; beside it what is forgotten at once."""
    track = campaign(0, 0.0, cycles=3, settings=1)[0].tracks[0]
    size = np.full((3 * PHASES, 3), 1e-3)
    pushes = 1e-6 - LEAST**2
    found = covariance(track, size, 0.0, 0.6)[1]
    np.testing.assert_allclose(np.diag(found), 1e-6, rtol=1e-6)
    np.testing.assert_allclose(found[0, PHASES::PHASES], 0.6 * pushes, rtol=1e-9)
    np.testing.assert_allclose(found[0, 2:PHASES], 0.0, atol=1e-12)


@pytest.mark.parametrize("degrees", [24, 6, 3])
def test_how_many_numbers_a_trial_is_worth_is_told_by_sums_and_differences(degrees: int) -> None:
    rng = np.random.default_rng(degrees)
    told = []
    for _ in range(20):
        drawn = 2.5 * rng.chisquare(degrees, (2, 24)) / degrees  # what repeats share makes sums larger alike
        drawn[1] /= 2.5
        told.append(Memory(scattered=_scattered(drawn, np.full(24, 24.0))).fewer)
    assert np.mean(told) == pytest.approx(24 / degrees, rel=0.3)


def test_what_an_earlier_campaign_told_counts_too() -> None:
    few = _scattered(np.array([[9.0, 0.2], [0.3, 5.0]]), np.full(2, 24.0))
    alone = Memory(scattered=few)
    assert alone.beside(()) == alone
    assert Memory().beside(few).fewer == alone.fewer
    assert alone.beside(few).fewer > alone.fewer


@pytest.mark.parametrize("time", [1.0, *(pytest.param(t, marks=pytest.mark.slow) for t in (0.0, 0.25))])
def test_pushes_that_last_for_some_windows_raise_no_doubt(time: float) -> None:
    """As independent windows draw them, paths of most campaigns whose pushes last for a second stray."""
    doubts, ratios, alone = 0, [], 0
    for seed in range(8):
        motion, predictions = campaign(seed, time)
        after = path_error(motion, predictions)
        doubts += bool(pattern(motion, predictions, after))
        ratios.append(after / path_noise(motion, predictions).level_m)
        independent = replace(motion, noise=Noise(motion.noise.playing, motion.noise.pause))
        alone += strays(unrepeated(independent), predictions, after)
    assert doubts <= 1  # 8 * ERROR, and three binomial standard deviations more
    assert np.median(ratios) == pytest.approx(1, abs=0.2)
    assert alone > 4 or time < 1


@pytest.mark.slow
def test_floors_that_differ_from_trial_to_trial_raise_no_doubt() -> None:
    """A window shows a third of its noise of them; strung together, windows' noise is a third of what they make."""
    doubts, ratios, alone = 0, [], 0
    for seed in range(8):
        motion, predictions = campaign(seed, 0.0, cycles=12, floors=0.05)
        after = path_error(motion, predictions)
        doubts += bool(pattern(motion, predictions, after))
        ratios.append(after / path_noise(motion, predictions).level_m)
        forgotten = replace(motion, noise=replace(motion.noise, memory=Memory()))
        alone += strays(unrepeated(forgotten), predictions, after)
    assert doubts <= 1
    assert np.median(ratios) == pytest.approx(1, abs=0.2)
    assert alone > 5


def test_what_paths_of_an_earlier_campaign_differed_by_is_chance_of_this_one() -> None:
    motion, predictions = campaign(1, 0.0, cycles=12, floors=0.05)
    motion = replace(motion, noise=replace(motion.noise, memory=Memory()))  # as if it were not seen that they recur
    then, alone = repeated(motion, predictions), campaign(2, 0.0, cycles=12)[0]
    assert then.square > 4
    assert then.pairs == 6
    level = path_noise(alone, predictions).level_m
    assert level == pytest.approx(path_error(alone, predictions), rel=0.4)
    beside = path_noise(replace(alone, earlier=then), predictions)
    assert beside.level_m == pytest.approx(level * np.sqrt((then.square + repeated(alone, predictions).square) / 2))
    assert beside.farthest < path_noise(motion, predictions).farthest  # twice as many pairs tell


def test_a_gust_in_every_second_trial_is_no_chance_that_lasts() -> None:
    """It is most of what repeats differ by: as chance, its trace in the path would be no more than noise."""
    for seed in range(3):
        motion, predictions = campaign(seed, 0.0, cycles=2, gust=0.03)
        words = pattern(motion, predictions, path_error(motion, predictions))
        assert any("single trials were pushed" in w for w in words)


def beside(earlier: Motion, later: Motion, recurs: bool) -> tuple[Motion, list[Any]]:
    """The later trials beside what the earlier ones were off by in the same windows, whose noise is doubt."""
    tracks, predictions = [], []
    for i, track in enumerate(later.tracks):
        same = earlier.tracks[i // 2 * 2 : i // 2 * 2 + 2]
        shown = np.mean([t.displacement for t in same], axis=0)
        predictions.append(SimpleNamespace(displacement=shown))
        doubt = earlier.noise.chance(same[0]) / np.sqrt(len(same))
        tracks.append(SimpleNamespace(**{**vars(track), "doubt": doubt, "recurs": recurs}))
    return replace(later, tracks=tuple(tracks)), predictions


@pytest.mark.parametrize("time", [pytest.param(0.0, marks=pytest.mark.slow), 1.0])
def test_paths_beside_those_of_earlier_trials_stray_by_the_noise_of_both(time: float) -> None:
    """What was seen in a window of an earlier trial had its own chance in each cycle: as if it recurred in every cycle,
    it would add up to a noise level that hides changes."""
    ratios: dict[bool, list[float]] = {True: [], False: []}
    for seed in range(8):
        earlier, later = campaign(seed, time)[0], campaign(100 + seed, time)[0]
        for recurs, found in ratios.items():
            motion, predictions = beside(earlier, later, recurs)
            level = path_noise(motion, predictions, [t.displacement - STEP for t in motion.tracks]).level_m
            found.append(path_error(motion, predictions) / level)
    assert np.median(ratios[False]) == pytest.approx(1, abs=0.2)
    assert np.median(ratios[True]) < 0.8 or time > 0  # pushes that last add up within a cycle, too


@pytest.mark.parametrize("share", [0.0, 0.4, 1.0])
def test_draws_tell_how_much_of_a_window_is_of_the_poses_that_its_neighbours_share(share: float) -> None:
    """Differences of poses of variance 1/2 have variance 1, and correlate with their neighbours by -1/2; of 24 draws of
    four parts the share is known to about 0.05."""
    rng = np.random.default_rng(4)
    poses, alone = rng.normal(0, np.sqrt(0.5), (4, 24, 31, 3)), rng.normal(size=(4, 24, 30, 3))
    draws = np.sqrt(share) * np.diff(poses, axis=2) + np.sqrt(1 - share) * alone
    np.testing.assert_allclose(share_of_poses(list(draws)), share, atol=0.1)


def test_a_part_without_roots_tells_no_share_of_poses() -> None:
    rng = np.random.default_rng(4)
    told = np.diff(rng.normal(0, np.sqrt(0.5), (24, 31, 3)), axis=1)
    none = np.full((24, 30, 3), np.nan)
    assert np.array_equal(share_of_poses([none, told]), share_of_poses([told]))


def test_noise_of_poses_does_not_add_up_along_a_path() -> None:
    """However many windows, their sum is the difference of two poses; of independent windows it grows with the root."""
    count = 40
    track: Any = SimpleNamespace(
        least=np.full((count, 3), 1.0), playing=np.ones(count, dtype=bool), boundaries=np.arange(count + 1),
        time=WINDOW_S * np.arange(count + 1), phase=np.arange(count) % PHASES,
    )  # fmt: skip
    rng, chance = np.random.default_rng(0), np.ones((count, 3))
    ends = [memory.draws(track, chance, rng, 400).sum(axis=1).std() for memory in (Memory.of_poses(), Memory())]
    assert ends[0] == pytest.approx(1.0, rel=0.1)
    assert ends[1] == pytest.approx(np.sqrt(count), rel=0.1)
