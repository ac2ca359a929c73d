"""Windows in units of their noise: where chance lasts, what is fitted and scored is independent window by window."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from test_diagnose_memory import LEAST, PHASES, WINDOW_S, campaign

from serpenoid.diagnose.data.chance import NORMAL
from serpenoid.diagnose.data.noise.memory import BLOCK, Memory, roots
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import window_noise
from serpenoid.diagnose.data.noise.white import White
from serpenoid.diagnose.inference.fits.medium import of_windows
from serpenoid.diagnose.inference.search.null import Scored, largest_by_chance

CANDIDATES, CAMPAIGNS = 20, 20
LASTING = Memory((0.0, 1.0), (0.0, 1.0), (0.0, 0.0))


def track(count: int, least: float = 0.5) -> SimpleNamespace:
    return SimpleNamespace(
        least=np.full((count, 3), least), doubt=0.0, playing=np.ones(count, dtype=bool),
        boundaries=np.arange(count + 1), time=WINDOW_S * np.arange(count + 1), phase=np.arange(count) % PHASES,
    )  # fmt: skip


def independent(motion: Motion) -> Motion:
    """As if nothing were known of how long chance lasts."""
    return replace(motion, noise=replace(motion.noise, memory=Memory()))


def test_where_chance_does_not_last_values_are_divided_by_their_deviations_and_nothing_else() -> None:
    rng = np.random.default_rng(0)
    t, chance, known = track(12), rng.uniform(0.6, 2, (12, 3)), rng.random(12) > 0.2
    t.doubt = rng.uniform(0, 1, (12, 3))
    values, deviations = rng.normal(size=(12, 3, 4)), np.hypot(chance, t.doubt)
    for memory in (Memory(), Memory((0.0, 1.0), (0.1, 0.9), (0.0, 0.0))):  # independent windows are not excluded
        white = White(t, chance, memory)  # type: ignore[arg-type]
        assert np.array_equal(white.of(values, known), (values / deviations[..., None])[known].reshape(-1, 4))
        assert np.array_equal(white.spreads(known), deviations[known].ravel())
        assert not white._found  # nothing is made that nothing needs


@pytest.mark.parametrize("count", [1, 20, 3 * BLOCK])
def test_what_lasts_is_independent_once_it_is_white(count: int) -> None:
    """Its covariance is the identity, and the determinant that of the covariance: of a long trial, nearly."""
    t, chance, known = track(count), np.full((count, 3), 1.0), np.ones(count, dtype=bool)
    t.doubt = 0.3
    known[5:7] = False
    white, windows = White(t, chance, LASTING), np.flatnonzero(known)  # type: ignore[arg-type]
    covariance = LASTING.covariance(t, chance, windows)[0] + 0.3**2 * np.eye(len(windows))  # type: ignore[arg-type]
    full = np.zeros((count, 3, count))
    full[:, 0, :] = np.eye(count)
    inverse = white.of(full, known)[::3][:, windows]
    np.testing.assert_allclose(inverse @ covariance @ inverse.T, np.eye(len(windows)), atol=1e-9)
    half = np.linalg.slogdet(covariance)[1] / 2
    assert np.log(white.spreads(known)[::3]).sum() == pytest.approx(half, abs=1e-6)


def test_a_long_trial_costs_as_much_as_its_blocks() -> None:
    found = list(roots(lambda windows: np.stack([np.eye(len(windows))] * 3), np.arange(20 * BLOCK + 1)))
    assert len(found) == 21
    assert max(rows.shape[2] for _, rows in found) == 2 * BLOCK


def test_means_of_repeats_are_white_by_as_many_as_they_are_of() -> None:
    t, chance, known = track(10), np.full((10, 3), 1.0), np.ones(10, dtype=bool)
    values = np.random.default_rng(0).normal(size=(10, 3))
    one, two = (White(t, chance, LASTING, times).of(values, known) for times in (1, 4))  # type: ignore[arg-type]
    np.testing.assert_allclose(two, 2 * one)


def test_doubt_that_repeats_share_is_in_their_mean_once() -> None:
    """Repeats of their own chance c and one doubt d tell their mean to c^2 / k + d^2, as k that are independent do with
    k d^2 each."""
    t, repeats = track(6), 3
    t.doubt = 0.7
    chance = np.random.default_rng(0).uniform(0.6, 2, (6, 3))
    each = White(t, chance, Memory(), repeats=repeats).deviations  # type: ignore[arg-type]
    np.testing.assert_allclose(each**2 / repeats, chance**2 / repeats + 0.7**2)


def columns(rng: np.random.Generator, cycles: int) -> np.ndarray:
    """What candidates do to the windows of a gait (W, 3, CANDIDATES): all the time, and by phase."""
    angle = 2 * np.pi * np.tile((np.arange(PHASES) + 0.5) / PHASES, cycles)
    basis = np.stack([np.ones(len(angle)), np.cos(angle), np.sin(angle)], axis=1)
    return np.asarray(1e-4 * np.einsum("wb,bkp->wkp", basis, rng.normal(size=(3, 3, CANDIDATES))))


def judged(motion: Motion, left: list[np.ndarray], by: list[np.ndarray]) -> tuple[bool, list[bool]]:
    """Whether any candidate gains a name on chance alone, and which intervals hold the true value, nothing."""
    predictions = [SimpleNamespace(displacement=t.displacement - x) for t, x in zip(motion.tracks, left, strict=True)]
    evidence = of_windows(motion, predictions, by)  # type: ignore[arg-type]
    groups = tuple((i,) for i in range(1, CANDIDATES))
    gains = [evidence.chi2([0]) - evidence.chi2([0, *g]) for g in groups]
    fits = [evidence.solve(g) for g in groups]
    held = [abs(float(value[0])) < NORMAL * float(np.sqrt(variance[0, 0])) for value, variance in fits]
    return max(gains) > largest_by_chance([Scored(evidence, 1, groups)]), held


def test_of_chance_that_lasts_no_names_are_made_and_intervals_hold() -> None:
    """Taken for independent, windows whose chance lasts for a second make names, and intervals that are too narrow."""
    names, held = np.zeros((CAMPAIGNS, 2)), np.zeros((CAMPAIGNS, 2))
    for seed in range(CAMPAIGNS):
        rng = np.random.default_rng([seed, 7])
        motion, predictions = campaign(seed, 1.0)
        motion = replace(motion, labels=tuple(i // 2 for i in range(len(motion.tracks))))
        left = [t.displacement - p.displacement for t, p in zip(motion.tracks, predictions, strict=True)]
        by = [d for _ in left[::2] for d in [columns(rng, 6)] * 2]
        found = [judged(m, left, by) for m in (motion, independent(motion))]
        names[seed], held[seed] = [name for name, _ in found], [np.mean(intervals) for _, intervals in found]
    (now, before), (covered, alone) = names.sum(axis=0), held.mean(axis=0)
    assert now <= 1  # 1 % of each campaign, and three binomial standard deviations
    assert before >= 3  # of 40: 12, and none now
    assert covered == pytest.approx(
        0.95, abs=0.06
    )  # of 40: 92 %, before that 81 %; how long it lasts is uncertain, too
    assert alone < covered - 0.05


@pytest.mark.parametrize("size", [0.0, 10.0])
def test_an_error_of_the_law_counts_for_no_more_because_chance_lasts(size: float) -> None:
    """Windows are white by what they leave: where that is the law's error, they are as good as independent."""
    rng = np.random.default_rng(3)
    motion, predictions = campaign(3, 4.0)
    wrong = [size * LEAST * np.tile(rng.normal(size=(PHASES, 3)), (6, 1)) for _ in motion.tracks[::2] for _ in "ab"]
    wrong = [wrong[i - i % 2] for i in range(len(wrong))]  # of a gait, in both its trials
    left = [t.displacement - p.displacement + w for t, p, w in zip(motion.tracks, predictions, wrong, strict=True)]
    noise = window_noise(motion.tracks, left)[0]
    assert noise.memory.lasts
    motion = replace(motion, noise=noise)
    known = np.ones(len(left[0]), dtype=bool)
    squares = [
        np.mean([np.mean(w.of(x, known) ** 2) for w, x in zip(m.white, left, strict=True)])
        for m in (motion, independent(motion))
    ]
    assert squares[0] == pytest.approx(squares[1], rel=0.15)  # by chance's covariance alone: 1.7 times, at ten times


def test_windows_that_share_no_pose_are_divided_by_their_deviations() -> None:
    """Where draws say that neighbours have nothing in common, knowing so changes nothing; where they do, it does."""
    rng = np.random.default_rng(0)
    chance, known, values = rng.uniform(0.6, 2, (12, 3)), np.ones(12, dtype=bool), rng.normal(size=(12, 3))
    alone, bound = (White(track(12, least), chance, Memory.of_poses()) for least in (0.0, 0.5))  # type: ignore[arg-type]
    np.testing.assert_allclose(alone.of(values, known), (values / chance).ravel(), rtol=1e-8)
    assert np.abs(bound.of(values, known) - (values / chance).ravel()).max() > 0.1
