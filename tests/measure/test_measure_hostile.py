"""Files that nobody means: each is told with its place, in a moment, and none ends in a traceback."""

from __future__ import annotations

import os
import time
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rehearsal import of_links, serpenoid_table
from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.files.store import file_digest
from serpenoid.measure.consistency.check import check
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.geometry import marker_faults
from serpenoid.measure.consistency.layout import layout
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.formats.columns import ServoColumns, ServoKeys
from serpenoid.measure.load import load_campaign
from serpenoid.measure.logs import ServoLog, read_servo_log
from serpenoid.measure.schedule import Schedule, start_by_shape
from serpenoid.measure.trial import build_motion, cut_passages
from serpenoid.measure.trial_files import content

TABLE = serpenoid_table(40)


@pytest.fixture(autouse=True)
def _without_a_word():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


@pytest.mark.parametrize("copied", [slice(0, 5), slice(2, 4)], ids=["all at one point", "one is a copy"])
def test_markers_in_one_place_are_told(copied):
    points = np.stack([np.linspace(0, 1, 5), np.zeros(5)], axis=1) + np.zeros((20, 1, 1))
    points[:, copied] = 0.25
    found = marker_faults(layout(points, of_links(np.full(4, 0.25))), list("abcde"), None)
    assert found[0].words == f"have `{'abcde'[copied.start]}` and `{'abcde'[copied.start + 1]}` in one place"


def seen(played: Schedule) -> Signal:
    at = np.arange(-1.0, played.end_s + 1.0, 1 / 60)
    return Signal(at, played.commanded(np.clip(at, 0.0, played.end_s)))


def test_a_hundred_thousand_promised_cycles_take_no_longer_than_those_recorded(virtual_machine):
    signal, began = seen(Schedule(TABLE, 2.0, 3, 1.0)), time.process_time()
    promised = Schedule(TABLE, 2.0, 100_000, 1.0)
    assert check([Claim("one", "gait", promised, cameras=signal)], {"gait": TABLE}).contradictions == ()
    found = start_by_shape(promised, signal.time_s, signal.values)
    assert found is not None
    assert found.correlation > 0.99
    assert time.process_time() - began < 10


def test_a_cycle_that_is_lost_beside_its_pause_is_no_division_by_nothing(virtual_machine):
    signal = seen(Schedule(TABLE, 2.0, 1, 1.0))
    verdict = check([Claim("one", "gait", Schedule(TABLE, 1e-300, 1, 1.0), cameras=signal)], {"gait": TABLE})
    assert verdict.contradictions != ()


def test_a_recording_between_whose_halves_lies_a_thousand_seconds_has_no_period():
    at = np.arange(100) / 60
    at[50:] += 1000.0
    assert Signal(at, np.sin(at)[:, None]).period_s is None


def bending(at: np.ndarray) -> np.ndarray:
    """Markers (F, 4, 2) of a body that bends every 40 median frames."""
    bend = 0.4 * np.sin(2 * np.pi * at[:, None] / (40 * np.median(np.diff(at))) + np.arange(3))
    edge = np.stack([np.cos(bend), np.sin(bend)], axis=2) / 3
    markers = np.concatenate([np.zeros((len(at), 1, 2)), np.cumsum(edge, axis=1)], axis=1)
    return markers + 1e-4 * np.random.default_rng(0).standard_normal(markers.shape)


@pytest.mark.parametrize(
    ("apart", "hole", "runs"), [(1 / 60, 1000.0, 2), (1 / 60, 0.05, 1), (0.3, 0.6, 2), (0.3, 0.3, 1), (0.3, 0.0, 1)]
)
def test_no_step_crosses_frames_that_are_missing_from_the_file(apart, hole, runs):
    at = apart * np.arange(60)
    at[30:] += hole
    motion, _, notes = build_motion(Body(vertices=4), at, bending(at), None, ((), ()))
    assert motion.runs == ((slice(0, 30), slice(30, 60)) if runs == 2 else (slice(0, 60),))
    assert any("frames are missing from the file in 1 place," in note for note in notes) is (runs == 2)


def test_links_in_a_circle_have_no_content(tmp_path):
    """Whoever reads them says so."""

    class Entry:
        joint_table, motion, servo_log, power_log = None, "a.csv", None, None

    class File:
        trial = (Entry(),)

    (tmp_path / "a.csv").symlink_to(tmp_path / "b.csv")
    (tmp_path / "b.csv").symlink_to(tmp_path / "a.csv")
    assert [digest for _, digest in content(File(), tmp_path)] == [""]
    assert file_digest(tmp_path / "a.csv") == ""


def test_what_is_no_file_has_no_digest_and_is_not_waited_for(tmp_path):
    """A pipe into which nobody writes, and a device that never ends."""
    os.mkfifo(tmp_path / "pipe.csv")
    (tmp_path / "endless.csv").symlink_to("/dev/zero")
    assert [file_digest(tmp_path / name) for name in ("pipe.csv", "endless.csv", ".")] == ["", "", ""]


def test_a_number_that_is_too_large_is_told_as_too_large(tmp_path):
    path = tmp_path / "servo.csv"
    path.write_text("t_s,position_1\n0,0.1\n1,1e300\n")
    with pytest.raises(InputError, match=r"row 3, column B \(`position_1`\): .* Larger than .* is no measurement"):
        read_servo_log(path)


@pytest.mark.parametrize("others", ["load_2", "current_1,load_2", "temperature_1,temperature_2", "error_7"])
def test_what_nothing_is_computed_of_may_be_there_of_some_servos_and_in_any_form(others, tmp_path):
    """Servos of several models tell several efforts; a firmware of one's own writes what it likes."""
    path = tmp_path / "servo.csv"
    cells = ",".join("hot" for _ in others.split(","))
    path.write_text(f"t_s,position_1,position_2,{others}\n0,0.1,0.2,{cells}\n1,0.2,0.3,{cells}\n")
    assert read_servo_log(path).position.tolist() == [[0.1, 0.2], [0.2, 0.3]]


def test_commands_are_there_for_every_joint_or_for_none(tmp_path):
    path = tmp_path / "servo.csv"
    path.write_text("t_s,position_1,position_2,command_1\n0,0.1,0.2,0.1\n1,0.2,0.3,0.2\n")
    with pytest.raises(InputError, match="2 columns `position_1`, ... and 1 `command_1`.*one `command` is needed for"):
        read_servo_log(path)


def test_columns_that_servo_log_names_and_a_log_has_not_are_told(tmp_path):
    """A misspelt name would cost the commands without a word; names that nobody gave are no promise."""
    path = tmp_path / "servo.csv"
    path.write_text("t_s,position_1,goal_1\n0,0.1,0.1\n1,0.2,0.2\n")
    misspelt = ServoKeys(columns=ServoColumns(command="gaol_*", cycle="round"))
    assert read_servo_log(path, misspelt).absent == ("`gaol_*` (command)", "`round` (cycle)")
    assert read_servo_log(path, ServoKeys(columns=ServoColumns(command="goal_*"))).absent == ()
    assert read_servo_log(path).absent == ()


@pytest.mark.parametrize("joints", [1, 2, 4])
def test_a_log_of_other_joints_than_the_body_has_is_refused(joints, tmp_path):
    at = np.arange(40) / 10
    points = np.stack([np.linspace(0, 1, 5) + 0 * at[:, None], 0.05 * np.sin(at[:, None] + np.arange(5))], axis=2)
    header = ",".join(f"x_{k},y_{k}" for k in range(5))
    film = np.column_stack([at, points.reshape(len(at), -1)])
    np.savetxt(tmp_path / "film.csv", film, delimiter=",", header="t_s," + header, comments="")
    log = np.column_stack([at, np.zeros((len(at), joints))])
    names = ",".join(f"position_{j + 1}" for j in range(joints))
    np.savetxt(tmp_path / "servo.csv", log, delimiter=",", header="t_s," + names, comments="")
    (tmp_path / "campaign.toml").write_text(
        'format = 1\nname = "one"\n[body]\nvertices = 5\nkind = "wheeled robot"\n[motion]\nformat = "tidy"\n'
        '[[trial]]\nname = "a"\nmotion = "film.csv"\nservo_log = "servo.csv"\n'
    )
    with pytest.raises(InputError, match=rf"servo.csv: has the positions of {joints} joints?, the body has 3\. Check"):
        load_campaign(tmp_path)


@pytest.mark.parametrize(("label", "cell"), [("cycle", "-1"), ("cycle", "0.5"), ("step", ""), ("step", "-3")])
def test_labels_of_a_servo_log_are_counted_from_nothing(label, cell, tmp_path: Path):
    row = {"t_s": "0.1", "phase": "play", "cycle": "0", "step": "0", "position_1": "0.2"}
    later = row | {"t_s": "0.2", label: cell}
    path = tmp_path / "servo.csv"
    path.write_text("\n".join([",".join(row), ",".join(row.values()), ",".join(later.values())]) + "\n")
    with pytest.raises(InputError, match=rf"row 3, column . \(`{label}`\): rows that are played count from 0"):
        read_servo_log(path)


def test_cycles_that_are_not_in_the_recording_are_one_note():
    at = np.arange(600) / 60
    motion, _, _ = build_motion(Body(vertices=4), at, bending(at), None, ((), ()))
    promised = Schedule(TABLE[:, :2], 2.0, 100_000, 0.0)
    passages, notes = cut_passages(motion, promised)
    assert len(passages) == 5
    assert notes == ["cycles 6 to 100000 are not wholly in the recording: left out"]
    assert cut_passages(motion, replace(promised, cycles=6))[1] == ["cycle 6 is not wholly in the recording: left out"]


@pytest.mark.parametrize("each", [1, 3])
@pytest.mark.parametrize(("last", "stopped"), [(0, 1), (12, 1), (24, 1), (49, None)])
def test_a_cycle_that_the_log_says_was_not_played_to_its_end_is_told(each, last, stopped):
    """Of 50 rows, at each row or every third: the second cycle ends at row `last`, and then servos are off."""
    steps = [*range(0, 50, each), *range(0, last + 1, each)]
    cycles = np.repeat([0.0, 1.0], [len(range(0, 50, each)), len(range(0, last + 1, each))])
    rows = len(steps)
    log = ServoLog(
        np.arange(rows) / 10, np.zeros((rows + 2, 2)), None, ("play",) * rows + ("end",) * 2,
        np.append(cycles, [1.0, 1.0]), np.append(np.array(steps, float), [last, last]), {}, "log.csv",
    )  # fmt: skip
    assert log.stopped_in(50) == stopped
    paused = replace(log, phase=("play",) * rows + ("pause", "end"))
    assert paused.stopped_in(50) is None
    assert replace(log, phase=None).stopped_in(50) is None


def test_rows_of_a_log_that_stand_there_twice_are_read_once(tmp_path):
    """To the last character; the same time with other readings is two recordings in one file."""
    path = tmp_path / "servo.csv"
    rows = [
        "t_s,position_1,position_2",
        "0,0.1,0.2",
        "1,0.1,0.3",
        "1,0.1,0.3",
        "1,0.1,0.3",
        "2,0.2,",
        "2,0.2,",
        "3,0,1",
    ]
    path.write_text("\n".join(rows) + "\n")
    log = read_servo_log(path)
    assert log.repeated == 3
    assert log.time_s.tolist() == [0, 1, 3]
    assert log.position[:, 1].tolist() == [0.2, 0.3, 1.0]
    path.write_text("\n".join([*rows, "3,0,1.1"]) + "\n")
    with pytest.raises(InputError, match=r"row 9, column A \(`t_s`\): times must increase, got 3 after 3.*there twice"):
        read_servo_log(path)
