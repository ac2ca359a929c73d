"""Trials in which fewer cycles were played than promised: a robot at rest is none of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehearsal import serpenoid_table, snake
from serpenoid.compare.rehearse import Laboratory, write_campaign
from serpenoid.measure.load import load_campaign
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


@pytest.mark.parametrize("labels", [True, False])
@pytest.mark.parametrize("pause_s", [0.0, 1.0])
def test_a_robot_at_rest_is_no_cycle(tmp_path, pause_s, labels):
    found = trial(tmp_path, 3, 8.0, pause_s, labels)
    starts = [found.motion.time_s[passage.first] for passage in found.passages]
    np.testing.assert_allclose(starts, [8.0, 8.0 + CYCLE_S + pause_s], atol=0.15)  # the lag goes into a start by shape
    (said,) = (note for note in found.notes if "nothing bends" in note)
    assert said.startswith("in cycle ")
    assert said.endswith("Is `cycles = 3` right?")


def test_of_cycles_that_were_played_none_rests(tmp_path):
    found = trial(tmp_path, 2, 1.0, 8.0, True)  # pauses that last longer than cycles
    assert [passage.cycle for passage in found.passages] == [0, 1]
    assert not any("nothing bends" in note for note in found.notes)
