"""A push in one trial is told from the chance of repeats, whatever their number and however unlike settings are."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.residuals.pushes import pushed
from serpenoid.diagnose.residuals.residual_words import _moment, _where, where_pushed

PHASES, SETTINGS = 8, 6


def repeated(cycles: int) -> Motion:
    """Settings played twice; eight windows a cycle, and a pause."""
    phase = np.tile([*np.arange(PHASES) / PHASES, 1.0], cycles)
    tracks = [
        SimpleNamespace(
            phase=phase,
            playing=phase < 1,
            time=2.0 * np.arange(len(phase) + 1),
            boundaries=np.arange(len(phase) + 1),
            on_floor=np.zeros((1, 3)),
            recording=SimpleNamespace(
                setting=(f"gait-{s}", 2.0),
                length_unit="m",
                name="abcdefghijkl"[2 * s + repeat],
                body=SimpleNamespace(total_length_m=1.0),
            ),
        )
        for s in range(SETTINGS)
        for repeat in range(2)
    ]
    return cast(Motion, SimpleNamespace(tracks=tuple(tracks), unlike=0.0))


def chance(motion: Motion, seed: int) -> list[np.ndarray]:
    """Residuals (W, 3) whose noise varies fourfold between settings and twofold within a cycle."""
    rng = np.random.default_rng(seed)
    return [
        1e-3 * 4 ** (i // 2 / SETTINGS) * (1.5 + 0.5 * np.sin(2 * np.pi * t.phase))[:, None]
        * rng.normal(size=(len(t.phase), 3))
        for i, t in enumerate(motion.tracks)
    ]  # fmt: skip


@pytest.mark.parametrize("cycles", [3, 6])
def test_on_chance_alone_pushes_are_called_no_more_often_than_stated(cycles: int) -> None:
    motion = repeated(cycles)
    alarms = sum(bool(pushed(motion, chance(motion, seed))) for seed in range(40))
    assert alarms <= 2  # 40 * ERROR, and two and a half binomial standard deviations more


def test_a_push_of_one_trial_is_seen_and_one_that_is_no_news_is_not() -> None:
    motion = repeated(3)
    left = chance(motion, 1)
    left[2][4, 0] += 0.03  # sixteen times the noise of that setting and phase
    ((track, window, push),) = pushed(motion, left)
    assert (track, window) == (2, 4)
    assert push[0] == pytest.approx(0.03, abs=6e-3)  # three standard deviations of the two windows' chance
    assert where_pushed(motion, [(track, window, push)]).endswith("mm between 8.0 and 10.0 s of `c` or of its repeat")
    assert not pushed(cast(Motion, SimpleNamespace(tracks=motion.tracks, unlike=0.05)), left)


@pytest.mark.parametrize(("unit", "words"), [("m", "about x = 0.49 m, y"), ("bl", "about x = 0.49 body lengths, y")])
def test_what_is_gathered_on_the_floor_has_the_unit_of_the_recording(unit: str, words: str) -> None:
    motion, left = whole(repeated(3), unit), chance(repeated(3), 1)
    for track, x in zip(motion.tracks, left, strict=True):
        x[np.abs(track.on_floor[:-1, 0] - 0.5) < 0.05] *= 100
    (said,) = _where(motion, left)
    assert words in said


def test_one_bad_moment_is_not_told_as_a_phase_of_the_cycle() -> None:
    motion, left = whole(repeated(3), "m"), chance(repeated(3), 1)
    assert not _moment(motion, left)
    for x in left:
        x[4] = 30 * np.std(x)
    assert not _moment(motion, left)  # in all trials: a phase
    left = chance(motion, 1)
    left[2][4] = 30 * np.std(left[2])
    assert _moment(motion, left) == ["most of it between 8.0 and 10.0 s of `c` or just beside"]


def whole(motion: Motion, unit: str) -> Motion:
    """With places, along a line from 0 to 1, and a noise that is that of each setting."""
    for track in motion.tracks:
        track.recording.length_unit = unit  # type: ignore[misc]
        track.on_floor = np.linspace([0, 0, 0], [1, 0, 0], len(track.time))  # type: ignore[misc]
    sizes = {id(t): np.std(x) for t, x in zip(motion.tracks, chance(motion, 0), strict=True)}
    return cast(Motion, SimpleNamespace(tracks=motion.tracks, noise=SimpleNamespace(of=lambda t: sizes[id(t)])))
