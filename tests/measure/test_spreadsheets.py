"""Tables that another program saved again: the same numbers, or what to do; never another unit without a word."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.files.inputs import csv_rows
from serpenoid.measure.campaign import load_campaign_file
from serpenoid.measure.formats.columns import MotionColumns, ServoColumns, ServoKeys
from serpenoid.measure.formats.motive import read_motive
from serpenoid.measure.formats.points import read_long
from serpenoid.measure.formats.tidy import read_tidy
from serpenoid.measure.logs import read_servo_log
from serpenoid.measure.write import write_motive
from serpenoid.table_file import read_table, write_table

TIDY = "t_s,x_0,y_0,x_1,y_1\n0,0,-0.5,0.125,0\n0.1,,,,\n0.2,0.02,-1.5,0.25,1e-3\n"


def resaved(text: str, separator: str, padded: bool) -> str:
    """As a spreadsheet with decimal commas writes what it read; padded: all rows are as wide as the widest."""
    rows = [[cell.replace(".", ",") for cell in row] for row in csv.reader(text.splitlines())]
    wide = max(len(row) for row in rows) + 2
    return "".join(separator.join(row + [""] * (wide - len(row)) * padded) + "\r\n" for row in rows)


@pytest.mark.parametrize("padded", [True, False])
@pytest.mark.parametrize(("separator", "encoding"), [(";", "utf-8-sig"), (";", "utf-8"), ("\t", "utf-16")])
def test_a_motive_export_that_a_spreadsheet_saved_again_is_the_same(tmp_path, separator, encoding, padded):
    floor = np.random.default_rng(0).normal(size=(9, 3, 2))
    floor[2, 1] = np.nan
    write_motive(tmp_path / "a.csv", np.arange(9) / 120, floor, ["S:a", "S:b", "Unlabeled 12"])
    saved = resaved((tmp_path / "a.csv").read_text(), separator, padded)
    (tmp_path / "b.csv").write_bytes(saved.encode(encoding))
    first, again = read_motive(tmp_path / "a.csv"), read_motive(tmp_path / "b.csv")
    np.testing.assert_array_equal(again.floor, first.floor)
    np.testing.assert_array_equal(again.time_s, first.time_s)
    assert again.names == first.names


@pytest.mark.parametrize(
    "change",
    [
        lambda text: "sep=;\n" + text.replace(",", ";"),
        lambda text: "sep=,\r\n" + text,
        lambda text: text.replace("\n", ",,\n"),
        lambda text: text.replace("\n", ",\n").replace(",\n", "\n", 1),
        lambda text: text.replace("\n", "\r\r\n"),
        lambda text: text.replace(",,,,", ",#N/A,null,NaN,None"),
        lambda text: text.replace(",,,,", ",-,-nan(ind),NA,1.#QNAN"),
        lambda text: resaved(text, ";", padded=True),
    ],
    ids=[
        "sep=;",
        "sep=,",
        "separators at ends",
        "and none in the header",
        "ends of lines twice",
        "words",
        "of C",
        "commas",
    ],
)
def test_a_tidy_file_that_was_saved_again_is_the_same(tmp_path, change):
    (tmp_path / "a.csv").write_text(TIDY)
    (tmp_path / "b.csv").write_bytes(change(TIDY).encode())
    first, again = read_tidy(tmp_path / "a.csv"), read_tidy(tmp_path / "b.csv")
    np.testing.assert_array_equal(again.floor, first.floor)
    np.testing.assert_array_equal(again.time_s, first.time_s)


@pytest.mark.parametrize(("text", "match"), [
    ("t_s;x_0;y_0\n1.5;1,234;0\n", r"column B .* got '1,234'. Write a point before decimals, and nothing between thou"),
    ('t_s,x_0,y_0\n0,"0,5",0\n', r"column B .* got '0,5'. Write a point"),
    ("t_s,x_0,y_0\n0,1'234.5,0\n", r"column B .*. Write a point"),
    ("t_s,x_0,y_0\ns,mm,mm\n0,1,0\n", r"row 2, column B: says mm, and the column is read in m: `length_unit"),
    ("t_s,x_0,y_0\n0,1,0\ns,m,m\n", r"row 3, column A .* got 's'. Is that a row of units\? Leave it out"),
    ("t_s,x_0,y_0\n00:00:01.5,1,0\n", "times of day are not read"),
    ("t_s,x_0,y_0\n0,1,0\n3,1,0\n1,1,0\n4,1,0\n2,1,0\n", "Rows in disorder"),
    ("t_s,x_0,y_0,speed\n0,1,0,3\n", 'Where others stand beside: `columns = { time = "t_s"'),
])  # fmt: skip
def test_what_could_be_two_numbers_or_none_is_refused_with_its_cure(tmp_path, text, match):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError, match=match):
        read_tidy(tmp_path / "a.csv")


def tenths_of_millimetres(write, decimals: str) -> str:
    """A film of two points about 1000 tenths of a millimetre off, as a spreadsheet writes it."""
    wave = 1000 + 200 * np.sin(np.arange(60) / 3)
    rows = (";".join([str(i), *[write(x + k) for k in (0, 30, 60, 90)]]) for i, x in enumerate(wave))
    return "frame;x_0;y_0;x_1;y_1\n" + "\n".join(rows).replace(".", decimals) + "\n"


@pytest.mark.parametrize("mark", [".", ","])
def test_marks_between_thousands_are_no_decimal_ones(tmp_path, mark):
    (tmp_path / "a.csv").write_text(tenths_of_millimetres(lambda x: f"{round(x):,}".replace(",", "."), mark))
    with pytest.raises(InputError, match="row 2, column B .*`1.000` and whole numbers below 1000 .*thousands"):
        read_tidy(tmp_path / "a.csv", frames_per_second=10.0)


@pytest.mark.parametrize(
    "write", [lambda x: f"{x / 1000:.3f}", lambda x: f"{x / 100:g}", lambda x: f"{round(x / 100 * 3) / 3:.7g}"]
)
def test_decimals_of_any_number_of_digits_are_read(tmp_path, write):
    (tmp_path / "a.csv").write_text(tenths_of_millimetres(write, "."))
    assert np.ptp(read_tidy(tmp_path / "a.csv", frames_per_second=10.0).floor) < 6


def test_points_that_were_interpolated_by_thirds_between_whole_pixels_are_no_thousands(tmp_path):
    rows = [f"{i},{x},{x}" for i, x in enumerate(f"{612 + i / 3:.3f}".removesuffix(".000") for i in range(30))]
    (tmp_path / "a.csv").write_text("frame,x_0,y_0\n" + "\n".join(rows) + "\n")
    assert np.ptp(read_tidy(tmp_path / "a.csv", frames_per_second=10.0).floor[..., 0]) < 10


@pytest.mark.parametrize("end", ["", ";;", ";;\r\n;;;", "\r\n"])
def test_a_joint_table_that_was_saved_again_is_the_same(tmp_path, end):
    angles = np.random.default_rng(0).uniform(-1, 1, (4, 2))
    write_table(tmp_path / "a.csv", angles)
    saved = resaved((tmp_path / "a.csv").read_text(), ";", padded=False)
    (tmp_path / "b.csv").write_bytes((saved.replace("\r\n", end.split("\r\n")[0] + "\r\n") + end).encode())
    np.testing.assert_array_equal(read_table(tmp_path / "b.csv"), read_table(tmp_path / "a.csv"))


def test_a_path_that_a_backslash_broke_is_told_so(tmp_path):
    (tmp_path / "campaign.toml").write_text(
        'format = 1\nname = "a"\n[body]\nvertices = 5\n[[trial]]\nname = "a"\nmotion = "films\\test.csv"\n'
    )
    with pytest.raises(InputError, match=r"motion: is no path: A backslash begins an escape in TOML"):
        load_campaign_file(tmp_path)


def test_what_separates_is_what_the_header_has_most_of_outside_quotes():
    assert csv_rows('"a, b";c;d\n1,5;2;3\n', "") == [["a, b", "c", "d"], ["1.5", "2", "3"]]
    assert csv_rows("a;b,c,d\n1,2,3\n", "") == [["a;b", "c", "d"], ["1", "2", "3"]]
    assert csv_rows("title\n1;2;3,5\n", "") == [["title"], ["1", "2", "3.5"]]


BRACKETS = MotionColumns(time="Time (ms)", x="x_* [mm]", y="y_* [mm]")


def test_units_in_the_names_of_columns_are_those_that_are_read(tmp_path: Path):
    film, log = tmp_path / "a.csv", tmp_path / "s.csv"
    film.write_text("Time (ms),x_0 [mm],y_0 [mm]\n0,1,2\n20,1,2\n")
    read = read_tidy(film, "mm", None, BRACKETS, "ms")
    np.testing.assert_allclose(read.floor[1, 0], [1e-3, 2e-3])
    with pytest.raises(InputError, match=r'`x_0 \[mm\]` says mm, and is read in m: `length_unit = "mm"`'):
        read_tidy(film, "m", None, BRACKETS, "ms")
    with pytest.raises(InputError, match=r'`Time \(ms\)` says ms, and is read in s: `time_unit = "ms"`'):
        read_tidy(film, "mm", None, BRACKETS)
    film.write_text("t,p,x (\N{MICRO SIGN}m),y (\N{MICRO SIGN}m)\n0,1,1,2\n")
    named = {"time": "t", "point": "p", "x": "x (\N{MICRO SIGN}m)", "y": "y (\N{MICRO SIGN}m)"}
    assert read_long(film, named, "um").floor[0, 0, 0] == pytest.approx(1e-6)
    with pytest.raises(InputError, match="says um, and is read in mm"):
        read_long(film, named, "mm")
    log.write_text("t_s,position_1 (deg),position_2 (deg)\n0,1,2\n1,2,3\n")
    position = ServoColumns(position="position_* (deg)")
    assert read_servo_log(log, ServoKeys(columns=position, angle_unit="deg")).position[0, 0] == np.deg2rad(1)
    with pytest.raises(InputError, match=r"`position_1 \(deg\)` says deg, and is read in rad"):
        read_servo_log(log, ServoKeys(columns=position))


def test_a_unit_behind_a_tidy_files_own_names_is_held_against_the_campaigns(tmp_path):
    film = tmp_path / "m.csv"
    film.write_text("t_s,x_0 [mm],y_0 [mm]\n0,1,2\n0.02,1,2\n")
    assert read_tidy(film, "mm").floor[0, 0].tolist() == pytest.approx([1e-3, 2e-3])
    with pytest.raises(InputError, match=r"`x_0 \[mm\]` says mm, and is read in m"):
        read_tidy(film, "m")
    film.write_text("t_s,x_0 [in],y_0 [in]\n0,1,2\n0.02,1,2\n")
    with pytest.raises(InputError, match="a tidy file has `x_0` here"):
        read_tidy(film, "mm")
