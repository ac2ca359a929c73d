"""The mean beat of an animal: that of a film whose beats differ, and one that moves as the film's animal does."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import serpenoid as sp
from measure.test_beat import JOINTS, SIZE, wave
from serpenoid.cli.main import main
from serpenoid.measure.animals.beat import beat
from serpenoid.measure.animals.mean_beat import ROWS, mean_beat

WORM = Path(__file__).parents[2] / "problems" / "campaigns" / "worm.toml"


@pytest.mark.parametrize("jitter", [0.0, 0.1])
def test_the_mean_beat_is_the_wave_of_which_all_beats_are_made(jitter: float) -> None:
    film, _ = wave(30.0, 30, jitter=jitter, harmonic=0.3, noise=0.02)
    mean = mean_beat(film, beat(film))
    starts = np.linspace(0, 1, 721)[:, None, None]
    phase = 2 * np.pi * (starts + np.arange(ROWS)[:, None] / ROWS + JOINTS)
    waves = SIZE * (np.cos(phase) + 0.3 * np.cos(2 * phase + 1))
    nearest = np.sqrt(((waves - mean.angles) ** 2).mean(axis=(1, 2))).min()
    # phases are told to a few hundredths of a beat where beats differ by a tenth: the second harmonic blurs
    assert nearest < (0.01 if jitter == 0 else 0.06) * SIZE
    assert mean.share > (0.995 if jitter == 0 else 0.97)


def test_the_worms_mean_beat_goes_as_far_as_the_worm_and_no_farther_than_the_best(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    assert main(["measure", str(WORM), "--out", str(tmp_path / "m"), "--no-figures"]) == 0
    said = capsys.readouterr().out
    assert re.search(r"mean beat +beat-worm.toml plays it: 99.[0-9]% of the bending repeats", said)
    mean = sp.simulate(tmp_path / "m" / "beat-worm.toml").trajectory
    # four beats in 8 s, 1.36 body lengths; a chain of 14 straight edges is not the smooth body: 4 % here
    assert mean.displacement == pytest.approx(1.36 / 4, rel=0.05)
    best = sp.sweep(sp.load(tmp_path / "m" / "beat-worm.toml", set=["gait.family=ellipse"]), [3.0], starts=2)
    found = best.points[0].solution
    assert found is not None
    cost = -found.trajectory.displacement + 3.0 * found.trajectory.dissipation
    assert cost < -mean.displacement + 3.0 * mean.dissipation


def test_a_fish_filmed_in_pixels_is_one_body_length_long(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    prickleback = WORM.with_name("prickleback.toml")
    assert main(["measure", str(prickleback), "--out", str(tmp_path / "m"), "--no-figures", "--quiet"]) == 0
    (beat_of_it,) = (tmp_path / "m").glob("beat-*.toml")
    problem = sp.load(beat_of_it)
    assert problem.body.total_length_m == pytest.approx(1.0, rel=1e-5)
