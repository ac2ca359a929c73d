"""A larva that crawls by peristalsis, generated: it hardly bends, and its length changes, which no model here does."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.diagnose.data.tracked import _variance, tracked_recordings
from serpenoid.diagnose.stages.motion.choose_tracked import GLIDES, STILL, moving
from serpenoid.errors import InputError
from serpenoid.measure.animals.animal import stretching
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
    found = stretching(trial.body, trial.motion)
    spread, noise, share = found.spread, found.noise, found.share
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
    assert not any("of the cycle" in words for words in found["residual_pattern"])  # nobody plays an animal's beats
    gain = found["gain"]["path_rms_m"]
    assert gain["after"] > 0.8 * gain["before"]  # several laws, none of them a name, predict a little of it
    assert found["drag_ratio"]["value"] is None  # it hardly bends: its interval is all that eps can be


def test_a_larva_whose_points_run_into_each_other_is_refused_by_that(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stride of 0.22 with points 0.14 apart, each carried on before the next has begun: edges shrink to nothing."""
    coarse = {"POINTS": 8, "RATE": 16, "SECONDS": 8, "LAG": 0.8, "SWING": 0.22, "NOISE": 0.006}
    for name, value in coarse.items():
        monkeypatch.setattr(sys.modules[__name__], name, value)
    _, points = crawl()
    assert np.diff(points[..., 0], axis=1).min() < 0
    with pytest.raises(
        InputError, match=r"without a hole.* In \d+ of the \d+ frames that are left out neighbouring points are"
    ):
        tracked_recordings(load_campaign(written(tmp_path)))


@dataclass(frozen=True)
class Name:
    """What is named."""

    stand_in: bool = False


@dataclass(frozen=True)
class Stage:
    """What a stage of a diagnosis names, and its words."""

    named: tuple[Name, ...] = ()
    words: tuple[str, ...] = ()


@dataclass(frozen=True)
class Found:
    """What `moving` asks of a finding."""

    selection: Any
    stage: Stage


COST = 5.0  # of a coordinate


def found(left: float, named: tuple[Name, ...], moves: np.ndarray) -> Any:
    """Displacements (100,) in standard deviations, of which the best fit, with one coordinate, leaves so much."""
    by = np.zeros((100, 3))
    by[:, 0] = moves
    track = SimpleNamespace(displacement=by, usable=np.ones(100, bool), duration=np.ones(100))
    white = SimpleNamespace(of=lambda values, known: values[known].reshape(-1))  # in standard deviations already
    motion = SimpleNamespace(tracks=[track], white=[white])
    fit = SimpleNamespace(
        chi2=left - COST, evidence=SimpleNamespace(toll=lambda columns: columns * COST), coordinates=[0]
    )
    return Found(SimpleNamespace(motion=motion, null=fit, best=fit), Stage(named))


@pytest.mark.parametrize(("left", "said"), [(90.0, False), (120.0, True)])
def test_where_drag_leaves_no_less_than_standing_still_it_is_not_called_the_explanation(
    left: float, said: bool
) -> None:
    assert (STILL in moving(found(left, (), np.ones(100))).stage.words) == said


def test_what_explains_no_more_than_that_the_body_glides_on_may_be_a_stand_in() -> None:
    """Three velocities cost as much as three coordinates."""
    beating = np.where(np.arange(100) % 2, 2.0, 0.0)  # about 1, of which gliding leaves 100
    few, many = moving(found(100 + 3 * COST - 1, (Name(),), beating)), moving(found(100 + 3 * COST, (Name(),), beating))
    assert (few.stage.words, few.stage.named) == ((), (Name(),))
    assert (many.stage.words, many.stage.named) == ((GLIDES,), (Name(stand_in=True),))


def test_a_root_farther_than_a_body_length_away_tells_nothing_of_noise() -> None:
    near, far = np.full((2, 3), 0.01), np.array([[0.01, 0.01, 0.01], [40.0, 3.0, 0.01]])
    variance = _variance([near, -near, far], length_m=0.5)
    np.testing.assert_allclose(variance[0], 1e-4)
    assert np.isnan(variance[1]).all()
