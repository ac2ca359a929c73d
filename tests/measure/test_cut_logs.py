"""A servo log that is cut where the motion repeats is told to be unsure by whole cycles, and a whole one is not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.measure.clock import is_cut
from serpenoid.measure.load import load_campaign

CYCLE_S, STILL_S, CYCLES, LOG_HZ = 3.0, 1.0, 3, 50.0


def notes(folder: Path, since_s: float, until_s: float) -> list[str]:
    """Of three cycles, filmed whole; since_s, until_s: what is left of the log, from its first row on."""
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


@pytest.mark.parametrize(("since_s", "until_s", "cut"), [(0.5, 10.4, False), (0.5, 8.0, True), (2.0, 10.4, True)])
@pytest.mark.parametrize(("marker_sd_m", "frames_per_second"), [(0.0002, 15), (0.0015, 120), (0.002, 40), (0.002, 25)])
def test_noise_of_a_film_at_rest_is_no_motion_that_a_log_lacks(since_s, until_s, cut, marker_sd_m, frames_per_second):
    """At rest for a second, for nine seconds in motion, and at rest again; angles of markers on links of 8 cm."""

    def shapes(time_s):
        moving = np.clip(time_s - 1, 0, 9)
        return np.array([0.5 * np.sin(2 * np.pi * moving / 3 + j) for j in range(8)]).T

    film_s, log_s = np.arange(0, 11, 1 / frames_per_second), np.arange(since_s, until_s, 1 / LOG_HZ)
    bends = np.diff(np.random.default_rng(3).normal(0, marker_sd_m / 0.08, (len(film_s), 10)), n=2, axis=1)
    assert is_cut(film_s, shapes(film_s) + bends, log_s, shapes(log_s)) == cut
