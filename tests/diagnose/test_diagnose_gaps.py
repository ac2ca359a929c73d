"""Gaps of all markers: blank rows, or no rows at all, as some trackers write them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.windows.tracks import _crossed
from serpenoid.diagnose.diagnose import Diagnosis, diagnose
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.start import baseline

SIZE = 0.02


def diagnosed(folder: Path) -> Diagnosis:
    file, recordings = read_recordings(folder)
    return diagnose(recordings, Baseline(baseline(None, file, file.body)), lambda text: None)


def without_blank_rows(folder: Path) -> int:
    """Frames without any marker are taken out of the files; how many."""
    gone = 0
    for path in folder.glob("*/motion.csv"):
        header, *rows = list(csv.reader(path.read_text(encoding="utf-8").splitlines()))
        kept = [row for row in rows if any(cell not in ("", "nan") for cell in row[1:])]
        gone += len(rows) - len(kept)
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([header, *kept])
    return gone


@pytest.mark.slow
def test_steps_across_gaps_are_found_though_their_frames_are_not_in_the_file(tmp_path: Path) -> None:
    write(make(31, [Effect("position_jumps", None, {"size": SIZE})], combinations=COMBINATIONS[:2]), tmp_path)
    assert without_blank_rows(tmp_path) > 0
    found = diagnosed(tmp_path)
    (named,) = found.named
    assert named.effect.name == "position_jumps"
    low, high = named.intervals["size"]
    assert low is not None
    assert high is not None
    assert low <= SIZE <= high
    assert found.verdict == "explained"


def test_a_gap_is_a_gap_where_it_lasts() -> None:
    """From 1.0 to 1.2 s nothing is seen; single frames are missing all the time."""
    time = np.arange(0.0, 3.0, 0.01)
    seen = np.ones(len(time), dtype=bool)
    seen[7::13] = False
    seen[(time > 1.0) & (time < 1.2)] = False
    crossed = _crossed(time[seen], 0.01, np.arange(0.0, 2.6, 0.5))
    assert crossed.tolist() == [False, False, True, False, False]


@pytest.mark.parametrize("frames_per_second", [10.0, 25.0, 60.0])
def test_a_frame_alone_is_no_gap_at_any_rate(frames_per_second: float) -> None:
    """Three in a row, from 1.6 s on, are one."""
    time = np.arange(0.0, 3.0, 1 / frames_per_second)
    seen = np.ones(len(time), dtype=bool)
    seen[5::7] = False
    assert not _crossed(time[seen], 1 / frames_per_second, np.arange(0.0, 2.6, 0.5)).any()
    first = int(np.searchsorted(time, 1.6))
    seen[first : first + 3] = False
    crossed = _crossed(time[seen], 1 / frames_per_second, np.arange(0.0, 2.6, 0.5))
    assert crossed[3]
    assert not crossed[:2].any()
