"""Floors that change from trial to trial, which repeats alone would take for chance."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from blind.protocol import usual
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline

SEED = 611
FLOORS = 0.2, 0.28


def diagnosed(folder: Path, other: Callable[[int], bool], settings: int = 1) -> Diagnosis:
    """Of a healthy robot, some of whose trials (by number) were played on another floor."""
    protocol = usual(SEED, COMBINATIONS[:settings])
    here, there = (make(SEED, [], protocol=replace(protocol, eps=eps)) for eps in FLOORS)
    trials = zip(here.trials, there.trials, strict=True)
    write(replace(here, trials=tuple(b if other(i) else a for i, (a, b) in enumerate(trials))), folder)
    file, recordings = read_recordings(folder)
    return diagnose(recordings, Baseline(baseline(None, file, file.body)), lambda text: None)


@pytest.mark.slow
def test_another_floor_in_every_repeat_is_no_chance(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, lambda i: i % 2 == 1)
    assert found.verdict == "unexplained"
    (said,) = [w for w in found.words if "trials of one setting differ" in w]
    least, most = (float(word) for word in said.split() if word.startswith("0."))
    assert least == pytest.approx(FLOORS[0], rel=0.1)
    assert most == pytest.approx(FLOORS[1], rel=0.1)


@pytest.mark.slow  # a search that nothing of the catalogue ends
def test_another_floor_in_some_gaits_is_told_by_its_ratio(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, lambda i: i >= 4, settings=4)
    assert found.verdict == "unexplained"
    assert any("an anisotropy ratio of its own in each trial" in w for w in found.words)


@pytest.mark.slow  # "nothing", as of the other healthy robots
def test_trials_on_one_floor_differ_by_chance(tmp_path: Path) -> None:
    found = diagnosed(tmp_path, lambda i: False)
    assert found.verdict == "nothing"
    assert not found.words
