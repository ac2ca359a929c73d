"""Trials in which fewer cycles were played than promised: a robot at rest is none of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.measure.consistency.unplayed import as_filmed
from serpenoid.measure.load import load_campaign
from serpenoid.measure.logs import ServoLog
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.trial import Trial

PLAYED, CYCLE_S = 2, 3.0


def trial(folder: Path, promised: int, still_s: float, pause_s: float, labels: bool) -> Trial:
    """Two cycles, filmed so many seconds longer at either end, with a lag of servos."""
    lab = Laboratory(frames_per_second=40.0, still_s=still_s, lag_s=0.1)
    write_campaign(folder, snake(), {"g": serpenoid_table(40)}, lab, 1, 0, CYCLE_S, PLAYED, pause_s)
    toml = (folder / "campaign.toml").read_text().replace(f"cycles = {PLAYED}", f"cycles = {promised}")
    if not labels:
        toml += '\n[servo_log]\ncolumns = { phase = "none", cycle = "none", step = "none" }\n'
    (folder / "campaign.toml").write_text(toml)
    return load_campaign(folder).trials[0]


@pytest.mark.parametrize(
    ("pause_s", "labels"),
    [
        (0.0, True),
        (1.0, False),
        pytest.param(0.0, False, marks=pytest.mark.slow),
        pytest.param(1.0, True, marks=pytest.mark.slow),
    ],
)
def test_a_robot_at_rest_is_no_cycle(tmp_path, pause_s, labels):
    found = trial(tmp_path, 3, 8.0, pause_s, labels)
    starts = [found.motion.time_s[passage.first] for passage in found.passages]
    np.testing.assert_allclose(starts, [8.0, 8.0 + CYCLE_S + pause_s], atol=0.15)  # the lag goes into a start by shape
    assert any("the film shows 2 cycles" in note and "`cycles = 3`" in note for note in found.notes)


def test_of_cycles_that_were_played_none_rests(tmp_path):
    found = trial(tmp_path, 2, 1.0, 8.0, True)  # pauses that last longer than cycles
    assert [passage.cycle for passage in found.passages] == [0, 1]
    assert not any("the film shows" in note for note in found.notes)


def test_a_film_that_begins_or_ends_amid_motion_says_nothing_of_the_cycles():
    schedule = Schedule(serpenoid_table(40), CYCLE_S, 3, 1.0)
    time = np.arange(-4.0, 16.0, 1 / 40)
    assert as_filmed(schedule, time, schedule.commanded(time)).cycles == 3
    two = Schedule(serpenoid_table(40), CYCLE_S, PLAYED, 1.0)
    angles = two.commanded(time)
    assert as_filmed(schedule, time, angles).cycles == PLAYED
    log = ServoLog(time, schedule.commanded(time), None, None, None, None, "log")
    assert as_filmed(schedule, time, angles, log).cycles == 3  # servos read that the third was played
    rests = ServoLog(time, angles, None, None, None, None, "log")
    assert as_filmed(schedule, time, angles, rests).cycles == PLAYED
    for cut in (time > 1.0, time < 6.0, time < 7.5):  # the last ends within what a pause may be
        assert as_filmed(schedule, time[cut], angles[cut]).cycles == 3
