"""A larva that crawls by peristalsis, generated: it hardly bends, and its length changes, which no model here does."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from serpenoid.measure.animal import stretching
from serpenoid.measure.load import load_campaign
from serpenoid.measure.trial import Trial
from specimens import animal_campaign

POINTS, RATE, SECONDS = 6, 30.0, 4.0
STRIDE, BEAT = 0.2, 1.3  # body lengths a wave; waves a second
LAG, SWING = 0.5, 0.6  # of a beat: from tail to head, and for how long a point is on its way
NOISE = 0.002  # of a point [body lengths]


def steps(phase: np.ndarray) -> np.ndarray:
    """A point rests on the floor and is carried on by one stride while the wave passes it."""
    whole = np.floor(phase)
    share = np.clip((phase - whole) / SWING, 0, 1)
    return whole + share - np.sin(2 * np.pi * share) / (2 * np.pi)


def crawl() -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) and points (F, POINTS, 2), tail first; the wave runs from tail to head."""
    time, arc = np.arange(int(SECONDS * RATE)) / RATE, np.linspace(0, 1, POINTS)
    along = arc + STRIDE * steps(BEAT * time[:, None] - LAG * arc)
    points = np.stack([along, 0.03 * np.sin(0.7 * along)], axis=2)
    return time, points + np.random.default_rng(3).normal(0, NOISE, points.shape)


@pytest.fixture(scope="module")
def larva(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("larva"))


def written(folder: Path) -> Path:
    time, points = crawl()
    return animal_campaign(folder, "larva", time, 4 * points, "mm")


@pytest.fixture(scope="module")
def trial(larva: Path) -> Trial:
    return load_campaign(larva).trials[0]


def test_what_a_larva_lengthens_is_its_whole_path(trial: Trial) -> None:
    spread, noise, share = stretching(trial.body, trial.motion)
    assert noise == pytest.approx(NOISE * np.sqrt(2), rel=0.5)  # of both ends; the wave adds a little
    assert spread > 2 * noise
    assert share == pytest.approx(1, abs=0.15)  # by a stride it lengthens and goes on; noise and smoothing move that
    assert any("peristalsis" in note for note in trial.notes)


def diagnosed(campaign: Path, out: Path) -> dict[str, Any]:
    command = [sys.executable, "-m", "serpenoid", "diagnose", str(campaign), "--out", str(out)]
    subprocess.run([*command, "--no-figures", "--quiet"], check=True)
    found: dict[str, Any] = json.loads((out / "diagnosis.json").read_text())
    return found


@pytest.mark.slow
def test_peristalsis_is_explained_by_nothing_that_bends(larva: Path, tmp_path: Path) -> None:
    found = diagnosed(larva, tmp_path / "out")
    assert found["verdict"] == "unexplained"
    assert not found["effects"]
    assert found["gain"]["path_rms_m"]["after"] == found["gain"]["path_rms_m"]["before"]
    low, high = found["drag_ratio"]["interval"]
    assert low <= found["drag_ratio"]["value"] <= high


@pytest.mark.slow
def test_where_points_are_too_unsure_to_show_motion_drag_is_not_called_the_explanation(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    coarse = {"POINTS": 8, "RATE": 16, "SECONDS": 8, "LAG": 0.8, "SWING": 0.2, "NOISE": 0.006}
    for name, value in coarse.items():
        monkeypatch.setattr(sys.modules[__name__], name, value)
    found = diagnosed(written(tmp_path), tmp_path / "out")
    assert found["verdict"] == "unexplained"
    assert any("stood still would leave no more" in words for words in found["residual_pattern"])
