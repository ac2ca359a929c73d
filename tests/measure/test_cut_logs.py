"""A servo log that is cut where the motion repeats is told to be unsure by whole cycles, and a whole one is not."""

from __future__ import annotations

from pathlib import Path

import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.measure.load import load_campaign

CYCLE_S, STILL_S, CYCLES, LOG_HZ = 3.0, 1.0, 3, 50.0


def notes(folder: Path, since_s: float, until_s: float) -> list[str]:
    """Of three cycles, filmed whole; since_s, until_s: what is left of the log, from the first command on."""
    lab = Laboratory(frames_per_second=40.0, still_s=STILL_S, servo_log_hz=LOG_HZ)
    write_campaign(folder, snake(), {"g": serpenoid_table(40)}, lab, 1, 0, CYCLE_S, CYCLES, 0.0)
    (log,) = folder.glob("*/servo.csv")
    header, *rows = log.read_text().splitlines()
    begin = float(rows[0].split(",")[0])
    kept = [row for row in rows if since_s <= float(row.split(",")[0]) - begin <= until_s]
    log.write_text("\n".join([header, *kept]) + "\n")
    (trial,) = load_campaign(folder).trials
    return [note for note in trial.notes if "cut where the motion repeats" in note]


@pytest.mark.parametrize(("since_s", "until_s"), [(0.0, 3.0), (1.0, 5.0)])
def test_a_log_within_the_motion_is_unsure_by_whole_cycles(tmp_path, since_s, until_s):
    (said,) = notes(tmp_path, since_s, until_s)
    clock = Laboratory().servo_clock_s
    offsets = [clock + k * CYCLE_S for k in range(-2, 3)]
    told = [float(word.split(" s")[0]) for word in said.replace(",", "").split("+")[1:]]
    assert len(told) >= 2
    for one in told:
        assert min(abs(one - offset) for offset in offsets) < 0.05
    assert "leave `servo_log` out" in said


def test_a_whole_log_is_not(tmp_path):
    assert notes(tmp_path, 0.0, 100.0) == []
