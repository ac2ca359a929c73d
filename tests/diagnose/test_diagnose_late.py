"""Films and logs that do not show all that a campaign promises: begun late, ended early, played less."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline

SETTINGS = 1


@pytest.fixture
def campaign(tmp_path: Path) -> Path:
    write(make(501, [], combinations=COMBINATIONS[:SETTINGS]), tmp_path)
    return tmp_path


def diagnosed(folder: Path) -> Diagnosis:
    file, recordings = read_recordings(folder)
    return diagnose(recordings, Baseline(baseline(None, file, file.body)), lambda text: None)


def filmed_late(folder: Path, share: float) -> None:
    """The first part of every film is not there."""
    for path in folder.glob("*/motion.csv"):
        header, *rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([header, *rows[int(share * len(rows)) :]])


def promised(folder: Path, cycles: int) -> None:
    path = folder / "campaign.toml"
    lines = path.read_text(encoding="utf-8").splitlines()
    assert any(line.startswith("cycles = ") for line in lines)
    kept = [f"cycles = {cycles}" if line.startswith("cycles = ") else line for line in lines]
    path.write_text("\n".join(kept) + "\n", encoding="utf-8")


def without_labels(folder: Path) -> None:
    for path in folder.glob("*/servo.csv"):
        header, *rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
        kept = [i for i, name in enumerate(header) if name == "t_s" or name.startswith("position")]
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([[row[i] for i in kept] for row in [header, *rows]])


@pytest.mark.parametrize("labelled", [pytest.param(True, marks=pytest.mark.slow), False])
def test_a_film_that_begins_late_is_compared_from_there_on(campaign: Path, labelled: bool) -> None:
    filmed_late(campaign, 0.3)
    if not labelled:
        without_labels(campaign)
    found = diagnosed(campaign)
    assert found.verdict == "nothing"
    assert found.motion.after_m < 2 * found.motion.selection.noise_level_m
    assert all(t.first_seen > 0 for t in found.motion.selection.motion.tracks)
    # what is not seen has a guess that meets the first pose that is
    for t in found.motion.selection.motion.tracks:
        assert np.isfinite(t.poses).all()


@pytest.mark.slow  # what is said of them: test_diagnose_protocols.py
def test_cycles_that_were_not_played_are_no_fault_of_the_servos(campaign: Path) -> None:
    promised(campaign, 4)
    found = diagnosed(campaign)
    assert found.verdict == "nothing"
    remarks = [r.words for t in found.motion.selection.motion.tracks for r in t.recording.remarks]
    assert remarks == 2 * SETTINGS * ["2 of 4 promised cycles were played, say the log's labels"]


@pytest.mark.slow
def test_without_labels_fewer_cycles_than_promised_are_the_first_ones_and_nothing_is_wrong(campaign: Path) -> None:
    promised(campaign, 4)
    without_labels(campaign)
    assert diagnosed(campaign).verdict == "nothing"


@pytest.mark.parametrize("share", [0.45, 0.6, 0.75, 0.9])
def test_a_trial_that_was_aborted_lacks_its_last_cycles_and_not_its_first(campaign: Path, share: float) -> None:
    """share: of what was recorded."""
    whole = [r.time[0] for r in read_recordings(campaign)[1]]
    promised(campaign, 3)
    without_labels(campaign)
    for path in campaign.glob("*/*.csv"):
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
        if path.name in ("motion.csv", "servo.csv"):
            path.write_text("".join(lines[: int(share * len(lines))]), encoding="utf-8")
    _, recordings = read_recordings(campaign)
    assert [r.time[0] for r in recordings] == pytest.approx(whole, abs=0.1)
    assert not any("before the recording begins" in remark.words for r in recordings for remark in r.remarks)
