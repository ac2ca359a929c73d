"""Readers: the real files read whole, round trips exact, and every kind of rubbish refused with its place."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from rehearsal import DATA, ROOT, write_c3d
from serpenoid.errors import InputError
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.formats.columns import MotionColumns, ServoColumns, ServoKeys
from serpenoid.measure.formats.motive import read_motive
from serpenoid.measure.formats.points import read_c3d, read_long, read_sleap
from serpenoid.measure.formats.tidy import read_tidy
from serpenoid.measure.logs import read_power_log, read_servo_log
from serpenoid.measure.trial_files import read_files
from serpenoid.measure.write import write_motive, write_power_log, write_servo_log
from serpenoid.table_file import read_table as read_joint_table

RECORDINGS = ROOT / "problems" / "recordings"
needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="the recordings of others are not beside the repository")
LAMPREY = {"time": "t", "frame": "frame", "point": "point", "x": "mxmm", "y": "mymm"}


@needs_data
def test_real_motive_export_gives_measured_markers_and_no_solved_rigid_bodies():
    tracks = read_motive(DATA / "motive/sample_optitrack_take_v1.21.csv")
    assert tracks.floor.shape == (250, 9, 2)
    assert "Rigid Body 1:Marker1" in tracks.names
    assert sum(tracks.unlabelled) == 6
    assert tracks.frame_s == pytest.approx(1 / 120, abs=1e-5)  # times are written to a microsecond
    row = tracks.names.index("Rigid Body 1:Marker2")
    # first data row of the file: X 0.009910, Z 0.210209; floor x = file z, floor y = file x
    np.testing.assert_allclose(tracks.floor[0, row], [0.210209, 0.009910], atol=1e-12)


def test_real_lamprey_has_two_empty_frames_and_metres():
    tracks = read_long(RECORDINGS / "lamprey.csv", LAMPREY, "mm")
    assert tracks.floor.shape == (80, 20, 2)
    assert not tracks.seen[:2].any()
    assert tracks.seen[2:].all()
    np.testing.assert_allclose(tracks.floor[2, 0], [0.415076869235609, 0.135858332240892], rtol=1e-12)


def test_real_sleap_export_is_in_pixels_with_y_up():
    tracks = read_sleap(RECORDINGS / "prickleback_sleap.csv", 60.0)
    assert tracks.floor.shape == (711, 8, 2)
    assert not tracks.scale_known
    np.testing.assert_allclose(tracks.floor[0, 0], [1752.669189453125, -821.0576782226562])


@pytest.mark.parametrize("version", ["1.21", "1.23", "1.25"])
@pytest.mark.parametrize("unit", ["Meters", "Centimeters", "Millimeters"])
def test_motive_round_trip_in_every_version_and_unit(tmp_path, version, unit):
    rng = np.random.default_rng(0)
    floor = rng.normal(size=(7, 3, 2))
    floor[2, 1] = np.nan
    time = np.arange(7) / 120
    write_motive(tmp_path / "a.csv", time, floor, ["S:a", "S:b", "Unlabeled 12"], version, unit)
    tracks = read_motive(tmp_path / "a.csv")
    assert tracks.names == ("S:a", "S:b", "Unlabeled 12")
    assert tracks.unlabelled == (False, False, True)
    np.testing.assert_allclose(tracks.floor, floor, atol=6e-7)  # six decimals are written, in metres at worst
    np.testing.assert_array_equal(tracks.seen[2], [True, False, True])


def test_a_take_of_motive_may_have_a_comma_in_its_name(tmp_path):
    path, lines = _motive(tmp_path)
    path.write_text("\n".join([lines[0].replace("rehearsal", "a, b"), *lines[1:]]) + "\n")
    np.testing.assert_allclose(read_motive(path).floor, 1.0)


def test_motive_timecode_column_is_no_coordinate(tmp_path):
    write_motive(tmp_path / "a.csv", np.arange(3) / 120, np.ones((3, 1, 2)), ["S:a"])
    lines = (tmp_path / "a.csv").read_text().splitlines()
    for row, word in [(2, "Type"), (3, "Name"), (4, "ID"), (5, ""), (6, "TimeCode")]:
        cells = lines[row].split(",")
        lines[row] = ",".join([*cells[:2], "" if word != "TimeCode" else word, *cells[2:]])
    for row in range(7, 10):
        cells = lines[row].split(",")
        lines[row] = ",".join([*cells[:2], "00:00:01:05", *cells[2:]])
    (tmp_path / "a.csv").write_text("\n".join(lines) + "\n")
    np.testing.assert_allclose(read_motive(tmp_path / "a.csv").floor, 1.0)


def _motive(tmp_path: Path) -> tuple[Path, list[str]]:
    path = tmp_path / "a.csv"
    write_motive(path, np.arange(5) / 120, np.ones((5, 2, 2)), ["S:a", "S:b"])
    return path, path.read_text().splitlines()


@pytest.mark.parametrize(
    ("edit", "match"),
    [
        (lambda lines: lines[:-2], "row 10: the file ends after 3 frames and its first line promises 5"),
        (lambda lines: [*lines[:-1], lines[-1][:20]], "row 12: has .* cells where the header has 8"),
        (
            lambda lines: [*lines[:9], lines[9].replace("1.000000", "abc", 1), *lines[10:]],
            r"row 10, column C \(`S:a`\)",
        ),
        (lambda lines: [*lines[:9], lines[9].replace("1.000000", "", 1), *lines[10:]], "all its coordinates or none"),
        (lambda lines: [lines[0].replace("Meters", "Inches"), *lines[1:]], "`Length Units` must be one of Meters"),
        (lambda lines: [lines[0].replace("1.23", "2.0"), *lines[1:]], "version must be 1.21 to 1.25, got .*or as C3D"),
        (lambda lines: lines[2:], "a Motive export starts with"),
        (lambda lines: [*lines[:8], lines[7], *lines[9:]], r"row 9, column B \(`Time`\): times must increase"),
        (lambda lines: [line.replace("Marker", "Rigid Body") for line in lines], "no measured markers"),
        (lambda lines: [], "is empty"),
        (lambda lines: lines[:6], "no row starts with `Frame`"),
        (lambda lines: lines[:7], "a header and no data rows"),
    ],
)
def test_broken_motive_files_are_refused_with_their_place(tmp_path, edit, match):
    path, lines = _motive(tmp_path)
    path.write_text("\n".join(edit(lines)) + "\n")
    with pytest.raises(InputError, match=match):
        read_motive(path)


def test_binary_rubbish_is_refused(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes(bytes(range(256)))
    for reader in (read_motive, read_tidy, read_servo_log, read_power_log, read_joint_table):
        with pytest.raises(InputError, match="not a text file"):
            reader(path)


@pytest.mark.parametrize("header", ["x_0,y_0,x_1,y_1", "x_0,x_1,y_0,y_1"])
def test_a_tidy_film_without_times_is_told_how_to_name_its_own_columns(tmp_path, header):
    path = tmp_path / "t.csv"
    path.write_text(f"{header}\n1,2,3,4\n")
    with pytest.raises(InputError, match=r'`columns = { x = "x_\*", y = "y_\*" }` and `frames_per_second` in') as error:
        read_tidy(path)
    assert "time =" not in str(error.value)


def test_tidy_round_trip_and_faults(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("t_s,x_0,y_0,x_1,y_1\n0,1,2,,\n0.1,1,2,3,4\n")
    tracks = read_tidy(path, "cm")
    np.testing.assert_allclose(tracks.floor[1], [[0.01, 0.02], [0.03, 0.04]])
    assert not tracks.seen[0, 1]
    path.write_text("t_s,x_0,z_0\n0,1,2\n")
    with pytest.raises(InputError, match="row 1, column C: a tidy file has `y_0` here, got 'z_0'"):
        read_tidy(path)


def test_a_table_without_a_clock_has_a_frame_in_each_row(tmp_path):
    path = tmp_path / "midline.csv"
    path.write_text("x1,x2,y1,y2\n1,2,3,4\nNaN,2,NaN,4\n5,6,7,8\n")
    tracks = read_tidy(path, "mm", 20.0, MotionColumns(x="x*", y="y*"))
    np.testing.assert_allclose(tracks.time_s, [0, 0.05, 0.1])
    np.testing.assert_allclose(tracks.floor[2], [[5e-3, 7e-3], [6e-3, 8e-3]])
    np.testing.assert_array_equal(tracks.seen[1], [False, True])
    with pytest.raises(InputError, match=r'`columns = \{ x = "x\*", y = "y\*" \}` and `frames_per_second`'):
        read_tidy(path, "mm", 20.0)


def test_times_are_not_taken_for_numbers_of_frames(tmp_path):
    path = tmp_path / "m.csv"
    refusal = r"row {}, column A \(`t`\): frame numbers are whole, got 0.05. Are these times"
    path.write_text("t,x,y\n0,1,2\n0.05,1,2\n")
    with pytest.raises(InputError, match=refusal.format(3)):
        read_tidy(path, "mm", 20.0, MotionColumns(frame="t", x=("x",), y=("y",)))
    path.write_text("t,p,x,y\n0,1,1,2\n0,2,3,4\n0.05,1,1,2\n0.05,2,3,4\n")
    with pytest.raises(InputError, match=refusal.format(4)):
        read_long(path, {"frame": "t", "point": "p", "x": "x", "y": "y"}, "mm", 20.0)


def test_tidy_columns_of_ones_own_are_those_that_are_named_in_their_order(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("no,ms,M11_y,M9_x,M9_y,M10_x,M10_y,M11_x\n7,0,6,1,2,3,4,5\n8,100,6,1,2,3,4,5\n")
    tracks = read_tidy(path, "cm", None, MotionColumns(time="ms", x="M*_x", y="M*_y"), "ms")
    np.testing.assert_allclose(tracks.floor[1], [[0.01, 0.02], [0.03, 0.04], [0.05, 0.06]])
    np.testing.assert_allclose(tracks.time_s, [0.0, 0.1])
    listed = MotionColumns(time="ms", x=("M10_x", "M9_x"), y=("M10_y", "M9_y"))
    np.testing.assert_allclose(read_tidy(path, "m", None, listed).floor[0], [[3, 4], [1, 2]])
    for columns, match in [
        ({"time": "s", "x": "M*_x", "y": "M*_y"}, r"no column `s` \(for `time`\)"),
        ({"time": "ms", "x": "N*_x", "y": "M*_y"}, r"`columns` names 0 for x and 3 for y"),
        ({"time": "ms", "x": "M9_x", "y": "M*_y"}, r"`x` must be a list of names"),
        ({"time": "ms", "x": "M*_x"}, "needs `x` and `y`"),
        ({"x": "M*_x", "y": "M*_y"}, "has no column of times: give `frames_per_second`"),
    ]:
        with pytest.raises(InputError, match=match):
            read_tidy(path, "m", None, MotionColumns.model_validate(columns))
    path.write_text("ms,M1_x,M1_y,M3_x,M3_y\n0,1,2,3,4\n")
    with pytest.raises(InputError, match="column `M2_x` is missing before `M3_x`"):
        read_tidy(path, "m", None, MotionColumns(time="ms", x="M*_x", y="M*_y"))


def test_ticks_of_another_resolution_are_read_by_it_and_asked_for(tmp_path):
    path = tmp_path / "s.csv"
    path.write_text("t_s,position_1,position_2\n0,512,0\n1,819.2,1023\n")
    told = ServoKeys(angle_unit="ticks", ticks_per_turn=1228.8, zero_ticks=512)  # 1024 ticks in 300 degrees
    np.testing.assert_allclose(np.degrees(read_servo_log(path, told).position), [[0, -150], [90, 511 / 1024 * 300]])
    with pytest.raises(InputError, match=r"no position is above 1023.*`ticks_per_turn = 1228.8` and `zero_"):
        read_servo_log(path, ServoKeys(angle_unit="ticks"))
    path.write_text("t_s,position_1,position_2\n0,1020,2048\n1,1000,2049\n")
    assert read_servo_log(path, ServoKeys(angle_unit="ticks")).position[0, 1] == 0


def test_a_servo_log_has_its_own_names_and_units(tmp_path):
    path = tmp_path / "s.csv"
    path.write_text("date,millis,deg_2,deg_1,goal_1,goal_2\nMon,0,90,180,1,2\nMon,500,90,180,1,2\n")
    columns = ServoColumns(time="millis", position="deg_*", command="goal_*")
    log = read_servo_log(path, ServoKeys(columns=columns, time_unit="ms", angle_unit="deg"))
    np.testing.assert_allclose(log.time_s, [0.0, 0.5])
    np.testing.assert_allclose(log.position[0], [np.pi, np.pi / 2])
    np.testing.assert_allclose(log.command[0], np.radians([1, 2]))
    with pytest.raises(InputError, match=r"no column is called `position_\*`.*\[servo_log\]"):
        read_servo_log(path)
    with pytest.raises(InputError, match=r"column D \(`deg_1`\): joint angles are within a turn.*angle_unit = \"deg\""):
        read_servo_log(path, ServoKeys(columns=columns))
    path.write_text("millis,deg_1,deg_2,goal_1,goal_2\n0,2048,3072,1024,0\n")
    ticks = read_servo_log(path, ServoKeys(columns=columns, time_unit="ms", angle_unit="ticks"))
    np.testing.assert_allclose(ticks.position[0], [0, np.pi / 2])
    np.testing.assert_allclose(ticks.command[0], [-np.pi / 2, -np.pi])
    with pytest.raises(
        InputError, match=r"got 2048 with `angle_unit = \"deg\".*servo's ticks.*`angle_unit = \"ticks\"`"
    ):
        read_servo_log(path, ServoKeys(columns=columns, angle_unit="deg"))
    with pytest.raises(InputError, match="2 columns `deg_1`, ... and 1 `goal_1`.*one `command` is needed for every"):
        read_servo_log(path, ServoKeys(columns=columns.model_copy(update={"command": ("goal_1",)})))


def test_a_fault_that_all_trials_share_is_said_once_with_the_trials(tmp_path):
    names = ["one", "two", "three"]
    for name in names:
        (tmp_path / f"{name}.csv").write_text("ms,a\n0,1\n")
    trials = "".join(f'[[trial]]\nname = "{name}"\nmotion = "{name}.csv"\n' for name in names)
    text = 'format = 1\nname = "c"\n[body]\nvertices = 4\nlength_m = 1.0\n[motion]\nformat = "tidy"\n'
    (tmp_path / "campaign.toml").write_text(text + trials)
    with pytest.raises(
        InputError, match="trials `one`, `two`, `three`: .*one.csv, two.csv, three.csv: row 1, col"
    ) as error:
        read_files(*load_campaign_file(tmp_path))
    assert str(error.value).count("a tidy file has `t_s` here") == 1
    for second, name in enumerate(names):
        (tmp_path / f"{name}.csv").write_text(f"t_s,x_0,y_0\n2026-03-04T10:20:3{second}.5,0.1,0.2\n")
    with pytest.raises(InputError, match=r"trials `one`, `two`, `three`: .*got '2026-03-04T10:20:30.5'") as error:
        read_files(*load_campaign_file(tmp_path))
    assert str(error.value).count("Dates and times of day are not read") == 1


def test_a_film_whose_name_ends_as_a_joint_table_is_called_is_named_in_full(tmp_path):
    for name in ("back", "turn"):
        (tmp_path / f"{name}.csv").write_text("joint_1,joint_2\n0,0\n0.1,0.1\n")
        (tmp_path / f"t04-{name}.csv").write_text("ms,a\n0,1\n")
    keys = 'cycle_duration_s = 1.0\njoint_table = "{0}.csv"\nmotion = "t04-{0}.csv"\n'
    trials = "".join(f'[[trial]]\nname = "{name}"\n{keys.format(name)}' for name in ("back", "turn"))
    text = 'format = 1\nname = "c"\n[body]\nvertices = 4\nlength_m = 1.0\n[motion]\nformat = "tidy"\n'
    (tmp_path / "campaign.toml").write_text(text + trials)
    with pytest.raises(InputError, match=r"trials `back`, `turn`: [^ ]*t04-back\.csv, t04-turn\.csv: row 1, col"):
        read_files(*load_campaign_file(tmp_path))


def test_long_form_refuses_a_point_given_twice_and_a_missing_column(tmp_path):
    path = tmp_path / "l.csv"
    path.write_text("t,point,x,y\n0,1,1,1\n0,1,2,2\n")
    columns = {"time": "t", "point": "point", "x": "x", "y": "y"}
    with pytest.raises(InputError, match=r"row 3, column B .*twice in one frame"):
        read_long(path, columns, "m")
    with pytest.raises(InputError, match="no column `mx`"):
        read_long(path, {**columns, "x": "mx"}, "m")


def test_servo_log_round_trip_and_a_cut_last_row_is_dropped(tmp_path):
    path = tmp_path / "s.csv"
    time, angle = np.arange(4) / 50, np.linspace(-1, 1, 8).reshape(4, 2)
    schedule = [("approach", 0, 0), ("play", 0, 0), ("play", 0, 1), ("end", 0, 1)]
    write_servo_log(path, time, angle, angle + 0.1, schedule)
    log = read_servo_log(path)
    np.testing.assert_array_equal(log.position, angle)
    assert float(log.time_s[log.phase.index("play")]) == time[1]
    text = path.read_text()
    path.write_text(text[:-9])
    assert len(read_servo_log(path).time_s) == 3


def test_rows_without_a_reading_are_a_gap_and_a_servo_that_never_answers_is_named(tmp_path):
    path = tmp_path / "s.csv"
    angle = np.linspace(-1, 1, 8).reshape(4, 2)
    angle[1, 0] = np.nan
    write_servo_log(path, np.arange(4) / 50, angle)
    np.testing.assert_array_equal(read_servo_log(path).position, angle[[0, 2, 3]])
    write_servo_log(path, np.arange(4) / 50, np.column_stack([angle[:, 1], np.full(4, np.nan)]))
    with pytest.raises(InputError, match="`position_2` is empty throughout"):
        read_servo_log(path)


@pytest.mark.parametrize("separator", [";", "\t", "|"])
def test_semicolons_tabs_and_decimal_commas_of_a_spreadsheet_are_read(tmp_path, separator):
    path = tmp_path / "m.csv"
    path.write_text(separator.join(["t_s", "x_0", "y_0"]) + "\n" + separator.join(["0,5", "-1,25", "3e-1"]) + "\n")
    tracks = read_tidy(path)
    assert (tracks.time_s[0], *tracks.floor[0, 0]) == (0.5, -1.25, 0.3)


@pytest.mark.parametrize(
    ("text", "cure"),
    [
        ("t_s x_0 y_0\n0.0 1 2\n0.1 1 2\n", "one cell of 3 words.*commas, semicolons or tabs"),
        (
            "t_s,x_0,y_0\n0,0,1,2,2,5\n0,1,1,2,2,5\n",
            "row 2: has 6 cells where.*3. Twice as many: are commas in its num",
        ),
        ("scorer,a,a\nbodyparts,tail,tail\n", 'another kind of file begins: `format = "deeplabcut"`'),
        ("t_s,x_0,y_0\n0.2,1,2\n0.1,1,2\n0.0,1,2\n", "All rows run backwards: sort them by their time"),
        ("t_s,x_0,y_0\n0.1,1,2\n0.2,1,2\n0.0,1,2\n", "Two recordings in one file"),
    ],
)
def test_a_file_that_cannot_be_read_is_told_what_is_wrong_with_it(tmp_path, text, cure):
    (tmp_path / "m.csv").write_text(text)
    with pytest.raises(InputError, match=cure):
        read_tidy(tmp_path / "m.csv")


def test_servo_log_in_degrees_is_refused(tmp_path):
    write_servo_log(tmp_path / "s.csv", np.arange(3) / 50, np.full((3, 2), 30.0))
    with pytest.raises(InputError, match=r"row 2, column B \(`position_1`\): joint angles are within a turn"):
        read_servo_log(tmp_path / "s.csv")


def test_power_log_round_trip_and_negative_power(tmp_path):
    write_power_log(tmp_path / "p.csv", np.arange(3) / 10, np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(read_power_log(tmp_path / "p.csv").power_W, [1, 2, 3])
    noted = (tmp_path / "p.csv").read_text().replace("\n", ",ok\n").replace("ok", "note", 1)
    (tmp_path / "noted.csv").write_text(noted)
    np.testing.assert_array_equal(read_power_log(tmp_path / "noted.csv").power_W, [1, 2, 3])
    write_power_log(tmp_path / "p.csv", np.arange(3) / 10, np.array([1.0, -2.0, 3.0]))
    with pytest.raises(InputError, match=r"row 3, column D .*power must be"):
        read_power_log(tmp_path / "p.csv")


def test_c3d_round_trip_and_a_file_that_is_none(tmp_path):
    pytest.importorskip("ezc3d")
    write_c3d(tmp_path / "a.c3d", hidden=(1, 2))
    tracks = read_c3d(tmp_path / "a.c3d")
    assert tracks.names == ("a", "b")
    assert not tracks.seen[2, 1]
    np.testing.assert_allclose(tracks.floor[tracks.seen], 1.0)
    (tmp_path / "b.c3d").write_bytes(b"nothing of the kind")
    with pytest.raises(InputError, match="not a C3D file"):
        read_c3d(tmp_path / "b.c3d")


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("joint_1,joint_2\n0,0\n0,60\n0,0\n", r":3: joint_2 must be within .*degrees"),
        ("joint_1,joint_3\n0,0\n", "header must be joint_1,joint_2"),
        ("joint_1\n0\n,1\n0\n", ":3: needs 1 number, got 2"),
        ("joint_1\n0\n,\n0\n", ":3: joint_1 is .., not a number"),
        ("joint_1\n0\n0\n", "at least 3 rows"),
    ],
)
def test_joint_tables_that_are_none(tmp_path, text, match):
    (tmp_path / "g.csv").write_text(text)
    with pytest.raises(InputError, match=match):
        read_joint_table(tmp_path / "g.csv")


@pytest.mark.parametrize("spike", [1e308, 2e4, 900.0])
def test_one_absurd_reading_of_power_is_refused_by_its_place(tmp_path, spike):
    power = 5 + np.sin(np.arange(400.0))
    write_power_log(tmp_path / "p.csv", np.arange(400) / 50, power)
    assert len(read_power_log(tmp_path / "p.csv").power_W) == 400
    power[7] = spike
    write_power_log(tmp_path / "p.csv", np.arange(400) / 50, power)
    with pytest.raises(InputError, match=r"row 9, column [CD] .*(median|must be a number)"):
        read_power_log(tmp_path / "p.csv")


@pytest.mark.parametrize("cell", ["inf", "1_000", "\uff11", "1e999", "0x1", "1e300"])
def test_what_is_no_plain_number_is_refused_by_its_place(tmp_path, cell):
    (tmp_path / "t.csv").write_text(f"t_s,x_0,y_0\n0,1,2\n0.1,{cell},2\n", encoding="utf-8")
    with pytest.raises(InputError, match="row 3, column B .*must be a number or empty"):
        read_tidy(tmp_path / "t.csv")


@pytest.mark.parametrize(
    "cell",
    [
        "2023-11-14 22:13:20",
        "2023-11-14T22:13:20.031Z",
        "11.05.2023 14:00:00",
        "5/11/2023 2:00 PM",
        "00:00.03",
        "May-23",
    ],
)
def test_of_times_that_are_dates_it_is_said_what_to_write_instead(tmp_path, cell):
    (tmp_path / "t.csv").write_text(f"t_s,x_0,y_0\n{cell},1,2\n", encoding="utf-8")
    with pytest.raises(InputError, match="row 2, column A .*write seconds .*frames_per_second"):
        read_tidy(tmp_path / "t.csv")


@pytest.mark.parametrize(
    ("cell", "cure"),
    [
        ("11. Mai", "date was made one by a spreadsheet"),
        ("02. M\u00e4rz 1900", "date was made one by a spreadsheet"),
        ("Sep 12", "date was made one by a spreadsheet"),
        ("#WERT!", "formula failed"),
        ("#DIV/0!", "formula failed"),
        ("########", "too narrow"),
        ("1.234,5", "nothing between thousands"),
        ("12.345.678", "nothing between thousands"),
    ],
)
def test_of_what_a_spreadsheet_made_of_numbers_it_is_said_how_to_get_them_back(tmp_path, cell, cure):
    (tmp_path / "t.csv").write_text(f"t_s;x_0;y_0\n0;1;2\n1;{cell};2\n", encoding="utf-8")
    with pytest.raises(InputError, match=f"row 3, column B .*{cure}"):
        read_tidy(tmp_path / "t.csv")


def test_a_point_with_one_coordinate_is_refused_by_its_place(tmp_path):
    (tmp_path / "t.csv").write_text("t_s,x_0,y_0\n0,1,2\n0.1,1,\n")
    with pytest.raises(InputError, match="row 3, column B .*all its coordinates or none"):
        read_tidy(tmp_path / "t.csv")


def test_a_table_with_a_row_for_each_quantity_says_how_to_turn_it_round(tmp_path):
    """Of a file of FIMTrack it was said that column A has no name."""
    names = [f"{point}_{axis}({frame})" for point in ("head", "tail") for axis in "xy" for frame in range(9)]
    text = ",larva(1),larva(2)\n" + "".join(f"{name},{k},{2 * k}\n" for k, name in enumerate(names))
    (tmp_path / "larvae.csv").write_text(text)
    with pytest.raises(InputError, match=r"`head_x\(0\)` is a quantity in one frame(.|\n)*Turn the table round"):
        read_tidy(tmp_path / "larvae.csv", frames_per_second=10)
