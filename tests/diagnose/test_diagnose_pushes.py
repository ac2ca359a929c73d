"""A push in one trial is told from the chance of repeats, whatever their number and however unlike settings are."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.residuals.pushes import pushed
from serpenoid.diagnose.residuals.residual_words import where_pushed

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
            recording=SimpleNamespace(setting=(f"gait-{s}", 2.0), name="abcdefghijkl"[2 * s + repeat]),
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
