"""Recordings of programs that write no plain table: the worm that was written, or what to do; never another one."""

from __future__ import annotations

import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.io import savemat

import recorders
from make_worm import RATIO, rows
from serpenoid.cli.main import main
from serpenoid.compare.likelihood import fit
from serpenoid.compare.segments import trial_segments
from serpenoid.compare.start import neutral_model
from serpenoid.errors import InputError
from serpenoid.files.workbook import table_text
from serpenoid.measure.campaign import MotionKeys
from serpenoid.measure.formats.readers import READERS
from serpenoid.measure.load import load_campaign
from serpenoid.measure.tracks import Tracks
from serpenoid.scaffold.film_format import format_of
from serpenoid.table_file import read_table

ROWS = rows()
TIME, POINTS = ROWS[:, 0], ROWS[:, 1:].reshape(len(ROWS), -1, 2)  # [s], [mm]
NAMES = recorders.names_of(POINTS)
FEW = POINTS[:20, :3]
HOLE = POINTS.copy()
HOLE[5, 3] = np.nan
NAMED = {"columns": {"time": "Trial time", "x": "X *", "y": "Y *"}, "length_unit": "mm"}
SIDE_BY_SIDE = {"columns": {"time": "tail t", "x": "* x", "y": "* y"}, "length_unit": "mm"}
SLICES = {"columns": {"frame": "Slice", "x": "X", "y": "Y"}, "length_unit": "px", "frames_per_second": 20.0}


def read(path: Path, form: str | None = None, **keys: object) -> Tracks:
    kind = form or format_of(path)
    return READERS[kind].read(path, MotionKeys.model_validate({"format": kind} | keys))


def refusal(path: Path, form: str | None = None, **keys: object) -> str:
    with pytest.raises(InputError) as told:
        read(path, form, **keys)
    assert str(told.value).startswith(str(path))
    return str(told.value)


def same(found: Tracks, points: np.ndarray = POINTS, per: float = 1e-3, first: int = 0) -> None:
    """The points, and where one is hidden, in the units they are read in."""
    np.testing.assert_array_equal(found.seen, np.isfinite(points[..., 0]))
    np.testing.assert_allclose(found.floor[found.seen], per * points[found.seen], atol=per * 1e-4)
    np.testing.assert_allclose(found.time_s, TIME[: len(points)] + first / 20, atol=1e-4)


@pytest.mark.parametrize("whole", [False, True])
def test_tracks_of_trackmate_are_read_with_y_upwards_and_in_its_units(tmp_path, whole):
    recorders.trackmate(tmp_path / "m.xml", TIME, HOLE, whole=whole)
    same(read(tmp_path / "m.xml"), HOLE)
    for unit, clock, per, times in (("\N{MICRO SIGN}m", "ms", 1e-6, 1e-3), ("cm", "min", 1e-2, 60.0)):
        recorders.trackmate(tmp_path / "m.xml", TIME, POINTS, unit, clock, whole)
        found = read(tmp_path / "m.xml")
        np.testing.assert_allclose(found.floor, per * POINTS, atol=per * 1e-4)
        np.testing.assert_allclose(found.time_s, times * TIME, rtol=1e-6)
    recorders.trackmate(tmp_path / "m.xml", TIME, POINTS, "pixels", "frame", whole)
    assert "counts frames: give `frames_per_second`" in refusal(tmp_path / "m.xml")
    assert not read(tmp_path / "m.xml", frames_per_second=20).scale_known
    recorders.trackmate(tmp_path / "m.xml", TIME, POINTS, "inch", whole=whole)
    assert "its unit of length is 'inch': give `length_unit`" in refusal(tmp_path / "m.xml")


def test_tracks_that_filters_of_trackmate_took_out_are_no_points(tmp_path):
    recorders.trackmate(tmp_path / "m.xml", TIME, POINTS, whole=True)
    text = (tmp_path / "m.xml").read_text().replace('<TrackID TRACK_ID="3" />', "")
    (tmp_path / "m.xml").write_text(text)
    assert [name for name in (f"Track_{k}" for k in range(15)) if name not in read(tmp_path / "m.xml").names] == [
        "Track_3"
    ]


@pytest.mark.parametrize(("change", "match"), [
    (lambda text: text[:5000], "not a readable XML file .* Was the copy cut off"),
    (lambda text: text.replace('SPOT_TARGET_ID="15"', 'SPOT_TARGET_ID="1"'), "`Track_0` has two spots in frame 0"),
    (lambda text: text.replace('SPOT_TARGET_ID="15"', 'SPOT_TARGET_ID="77777"'), "spot `77777`, which is not in the"),
    (lambda text: text.replace('POSITION_X="', 'POSITION_X="NaN'), "has no numbers for its frame and position"),
    (lambda text: '<Tracks nTracks="0"/>', "holds no tracks: track the points"),
    (lambda text: "<html><body/></html>", "begins with `html`.* as CSV"),
    (lambda text: '<!DOCTYPE a [<!ENTITY b "c">]><Tracks/>', "declares entities"),
    (lambda text: "", "not a readable XML file"),
])  # fmt: skip
def test_what_is_no_whole_file_of_trackmate_is_refused(tmp_path, change, match):
    recorders.trackmate(tmp_path / "m.xml", TIME[:20], POINTS[:20], whole=True)
    text = (tmp_path / "m.xml").read_text()
    (tmp_path / "m.xml").write_text(change(text))
    with pytest.raises(InputError, match=match):
        read(tmp_path / "m.xml")


def test_tracks_in_another_order_than_the_bodys_are_no_worm(tmp_path):
    order = np.random.default_rng(0).permutation(15)
    recorders.trackmate(tmp_path / "m.xml", TIME, POINTS[:, order])
    assert main(["new", "campaign", str(tmp_path / "c"), "--film", str(tmp_path / "m.xml"), "--yes"]) == 0
    with pytest.raises(
        InputError, match=r"exchanged along the body(.|\n)* or leave out points that are beside the midline"
    ):
        load_campaign(tmp_path / "c")


def book(path: Path, *sheets: list[list[Any]]) -> Path:
    openpyxl = pytest.importorskip("openpyxl")
    made = openpyxl.Workbook()
    made.remove(made.active)
    for k, cells in enumerate(sheets):
        sheet = made.create_sheet(f"sheet {k}")
        for row in cells:
            sheet.append(row)
    made.save(path)
    return path


TABLE: list[list[Any]] = [["t_s", "x_0", "y_0", "x_1", "y_1", "x_2", "y_2"]]
TABLE += [[float(t), *map(float, row.ravel())] for t, row in zip(TIME, FEW, strict=False)]


def test_a_workbook_is_read_as_the_csv_of_its_sheet(tmp_path):
    path = book(tmp_path / "m.xlsx", TABLE, [])
    same(read(path), FEW, 1.0)
    path.rename(tmp_path / "m.csv")
    same(read(tmp_path / "m.csv"), FEW, 1.0)
    same(read(book(path, [TABLE[0], *([str(x) for x in row] for row in TABLE[1:])])), FEW, 1.0)
    joints = [["joint_1", "joint_2"], [0.1, 1], [0.3, -0.25], [0.5, 1e-7]]
    assert read_table(book(path, joints)).tolist() == joints[1:]
    recorders.ethovision(path, TIME, HOLE, NAMES, range(15))
    same(read(path, "tidy", **NAMED), HOLE)
    assert "row 7, column C: says mm, and the column is read in cm" in refusal(
        path, "tidy", **NAMED | {"length_unit": "cm"}
    )
    assert '`columns = { time = "Trial time", x = "X *", y = "Y *" }`' in refusal(path)


@pytest.mark.parametrize(("sheets", "match"), [
    ([TABLE, TABLE], "has 2 sheets that hold anything, `sheet 0`, `sheet 1`, where one is read. Save the sheet"),
    ([[]], "is empty: no sheet"),
    ([[TABLE[0], *([row[0], *(f"={x}*2" for x in row[1:])] for row in TABLE[1:])]], "formulas were never computed"),
    ([[TABLE[0], *([*row[:3], "#DIV/0!", *row[4:]] for row in TABLE[1:])]], "row 2, column D .*formula failed"),
    ([[TABLE[0], *([str(x).replace(".", ",") for x in row] for row in TABLE[1:])]], "column A .*point before decimals"),
    ([[TABLE[0], *([np.datetime64("2024-01-01").item(), *row[1:]] for row in TABLE[1:])]], "Dates and times of day"),
])  # fmt: skip
def test_a_workbook_that_could_be_another_table_is_refused(tmp_path, sheets, match):
    with pytest.raises(InputError, match=match):
        read(book(tmp_path / "m.xlsx", *sheets), "tidy")


def test_a_broken_workbook_is_refused_and_one_without_openpyxl_told_what_to_do(tmp_path, monkeypatch):
    data = book(tmp_path / "m.xlsx", TABLE).read_bytes()
    for cut in (100, 1000, len(data) - 10):
        (tmp_path / "m.xlsx").write_bytes(data[:cut])
        assert "Was the copy cut off?" in refusal(tmp_path / "m.xlsx", "tidy")
    (tmp_path / "m.xlsx").write_bytes(data.replace(data[1500:1600], bytes(100)))
    assert "Save the sheet" in refusal(tmp_path / "m.xlsx", "tidy")
    with zipfile.ZipFile(tmp_path / "m.xlsx", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "<a/>")
        archive.writestr("xl/workbook.xml", "0" * 60_000_000)
    assert "holds 60 MB when unpacked" in refusal(tmp_path / "m.xlsx", "tidy")
    with zipfile.ZipFile(tmp_path / "m.ods", "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
    assert "but a spreadsheet (xlsx, ods) or another zip archive. Save the sheet" in refusal(tmp_path / "m.ods", "tidy")
    (tmp_path / "m.xlsx").write_bytes(data)
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    assert "needs openpyxl: pip install openpyxl. Or: Save the sheet" in refusal(tmp_path / "m.xlsx", "tidy")


def test_a_zip_archive_of_one_file_is_that_file(tmp_path):
    recorders.wcon(tmp_path / "m.wcon.zip", TIME, POINTS)
    same(read(tmp_path / "m.wcon.zip"))
    recorders.trackmate(tmp_path / "m.xml", TIME, POINTS)
    with zipfile.ZipFile(tmp_path / "m.xml.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("__MACOSX/._m.xml", "x")
        archive.writestr("films/", "")
        archive.write(tmp_path / "m.xml", "films/m.xml")
    same(read(tmp_path / "m.xml.zip"))
    with zipfile.ZipFile(tmp_path / "m.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.csv", "t_s,x_0,y_0\n")
        archive.writestr("b.csv", "t_s,x_0,y_0\n")
    assert "a zip archive of 2 files (`a.csv`, `b.csv`), where one is read. Unpack it" in refusal(tmp_path / "m.zip")
    with zipfile.ZipFile(tmp_path / "m.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("a.csv", "0," * 20_000_000)
    assert "packed by zip to less than a part in 100" in refusal(tmp_path / "m.zip")
    (tmp_path / "m.zip").write_bytes((tmp_path / "m.wcon.zip").read_bytes()[:-40])
    assert "cannot be unpacked" in refusal(tmp_path / "m.zip")


def test_tables_of_point_masses_beside_one_another_are_told_apart_by_the_names_above_them(tmp_path):
    path = tmp_path / "m.txt"
    recorders.tracker(path, TIME, POINTS, NAMES)
    same(read(path, **SIDE_BY_SIDE))
    assert '`columns = { time = "tail t", x = "* x", y = "* y" }`' in refusal(path)
    names, *lines = path.read_text().splitlines()
    path.write_text("\n".join(lines) + "\n")
    same(read(path, columns={"time": "t 1", "x": "x *", "y": "y *"}, length_unit="mm"))
    cells = lines[5].split("\t")
    path.write_text("\n".join([names, *lines[:5], "\t".join([*cells[:3], "", "", "", *cells[6:]]), *lines[6:]]) + "\n")
    assert np.argwhere(~read(path, **SIDE_BY_SIDE).seen).tolist() == [[4, 1]]
    path.write_text("\n".join([names, *lines[:5], "\t".join([*cells[:3], "9.9", *cells[4:]]), *lines[6:]]) + "\n")
    assert "row 7, column D (`p1 t`): is 9.9 where `tail t` is 0.2" in refusal(path, **SIDE_BY_SIDE)


@pytest.mark.parametrize(
    "names", [["", "tail", "", "mid", "", "head", ""], ["", "tail", "tail", "mid", "mid", "head", "head"]]
)
def test_names_of_points_may_stand_above_their_columns(tmp_path, names):
    lines = [names, ["t", *"xyxyxy"], *([f"{x:.6f}" for x in row] for row in TABLE[1:])]
    (tmp_path / "m.csv").write_text("\n".join(";".join(line) for line in lines) + "\n")
    found = read(tmp_path / "m.csv", columns={"time": "t", "x": "* x", "y": "* y"}, length_unit="mm")
    same(found, FEW)
    assert found.names == ("tail", "mid", "head")


def test_rows_of_a_frame_are_its_points_where_no_column_says_which_they_are(tmp_path):
    path = tmp_path / "m.csv"
    recorders.imagej_results(path, POINTS)
    same(read(path, "long", **SLICES), per=1.0, first=1)
    assert '`format = "long"`, `columns = { frame = "Slice", x = "X", y = "Y" }`' in refusal(path)
    lines = path.read_text().splitlines()
    path.write_text("\n".join(lines[:20] + lines[21:]) + "\n")
    assert "has 14 rows of 2, and 15 of most: which point is which?" in refusal(path, "long", **SLICES)
    path.write_text("\n".join(lines[:1] + lines[1::15]) + "\n")
    assert "most times have one row, which is one point of a body" in refusal(path, "long", **SLICES)


def test_a_table_without_names_of_columns_is_told_so(tmp_path):
    recorders.toxtrac(tmp_path / "Tracking_0.txt", TIME, POINTS)
    for form, keys in (("tidy", {}), ("tidy", NAMED), ("long", SLICES)):
        said = refusal(tmp_path / "Tracking_0.txt", form, **keys)
        assert "row 1: has numbers where names of columns belong. Write a line of names above it" in said
        assert "as ToxTrac writes it, none can be" in said


def test_what_qtm_exports_for_matlab_is_read(tmp_path):
    path = tmp_path / "m.mat"
    recorders.qtm_mat(path, TIME, HOLE, NAMES)
    found = read(path)
    same(found, HOLE)
    assert list(found.names) == NAMES
    for take, match in (
        ({"Trajectories": {"Unidentified": 1.0}, "FrameRate": 9.0}, "label the markers in QTM"),
        ({"Trajectories": 3.0, "FrameRate": 9.0}, "label the markers in QTM"),
        ({"Trajectories": {"Labeled": {"Labels": np.array(["a", "b"], dtype=object), "Data": np.ones((3, 4, 9))}},
          "FrameRate": 9.0, "Frames": 9.0}, "must be (markers, 4, frames) of 2 labels, got (3, 4, 9)"),
        ({"Trajectories": {"Labeled": {"Labels": np.array(["a", "b"], dtype=object), "Data": np.ones((2, 4, 9))}},
          "FrameRate": 9.0, "Frames": 12.0}, "holds 9 frames, and its header promises 12"),
    ):  # fmt: skip
        savemat(path, {"take": take})
        assert match in refusal(path)
    savemat(path, {"points": POINTS})
    assert "holds 0 structures with `Trajectories`" in refusal(path, "qualisys")


def test_an_array_of_another_name_is_told_how_to_be_saved(tmp_path):
    savemat(tmp_path / "m.trk", {"pTrk": POINTS.transpose(1, 2, 0)}, appendmat=False)
    assert "In MATLAB `points = permute(pTrk, [3 1 2]); save(" in refusal(tmp_path / "m.trk")
    np.savez(tmp_path / "m.npz", skeletons=POINTS.transpose(2, 1, 0))
    assert "Save `points=skeletons.transpose(2, 1, 0)`" in refusal(tmp_path / "m.npz")


def test_a_project_of_sleap_is_read_and_what_was_set_by_hand_goes_before(tmp_path):
    path = tmp_path / "m.slp"
    recorders.sleap_project(path, HOLE, NAMES, by_hand=3)
    found = read(path, frames_per_second=20)
    same(found, HOLE, 1.0)
    assert list(found.names) == NAMES
    assert "carries no time" in refusal(path)
    found = read(path, frames_per_second=20, minimum_score=0.95)
    assert np.flatnonzero(found.seen.any(axis=1)).tolist() == [3]
    recorders.sleap_project(path, POINTS, NAMES, ("one", "two"))
    assert "shows 2 individuals: `one`, `two`" in refusal(path, frames_per_second=20)
    same(read(path, frames_per_second=20, individual="one"), per=1.0)
    np.testing.assert_allclose(
        read(path, frames_per_second=20, individual="two").floor, POINTS + [1000, -1000], atol=1e-9
    )


def _instances(file: Any, name: str, change: Callable[[Any], Any], data: str = "instances") -> None:
    table = file[data][:]
    table[name] = change(table[name])
    file[data][...] = table


@pytest.mark.parametrize(("change", "match"), [
    (lambda file: file["metadata"].attrs.modify("json", "{}"), "its skeleton cannot be read"),
    (lambda file: file["metadata"].attrs.modify("json", "{"), "its description cannot be read"),
    (lambda file: file.pop("pred_points"), "holds `pred_points`; this one has"),
    (lambda file: _instances(file, "track", lambda tracks: 0 * tracks), "two animals of one track, or of none"),
    (lambda file: _instances(file, "track", lambda tracks: 0 * tracks - 1), "two animals of one track, or of none"),
    (lambda file: _instances(file, "video", lambda films: np.arange(len(films)), "frames"), "has points of 161 films"),
])  # fmt: skip
def test_a_project_of_sleap_that_does_not_say_which_body_is_which_is_refused(tmp_path, change, match):
    recorders.sleap_project(tmp_path / "m.slp", POINTS, NAMES, ("one", "two"))
    with h5py.File(tmp_path / "m.slp", "r+") as file:
        change(file)
    assert match in refusal(tmp_path / "m.slp", frames_per_second=20)


@pytest.mark.parametrize(("begin", "match"), [
    (b"\0\0\0\x18ftypmp42", "a video or a picture. Track points along the body in it first"),
    (b"RIFF\0\0\0\0AVI ", "a video or a picture"),
    (b"SQLite format 3\0", "a database of SQLite. Export its table as CSV"),
    (b"PAR1", "a table of Parquet. Save it as CSV"),
    (b"\x80\x04\x95", "a pickle of Python"),
])  # fmt: skip
def test_of_what_is_no_recording_of_points_it_is_said_what_it_is(tmp_path, begin, match):
    (tmp_path / "m.bin").write_bytes(begin + bytes(range(128, 256)))
    assert f"not a text file but {match}" in refusal(tmp_path / "m.bin")


ORDER = [7, 14, 0, *(k for k in range(15) if k not in (7, 14, 0))]  # center, nose, tail, and the rest of the worm


def test_the_order_of_points_is_told_on_the_command_line(tmp_path, capsys):
    film = tmp_path / "m.xlsx"
    recorders.ethovision(film, TIME, POINTS, NAMES, ORDER)
    asked = ["new", "campaign", str(tmp_path / "c"), "--film", str(film), "--yes", "--length-unit", "mm"]
    asked += ["--columns", "time=Trial time,x=X *,y=Y *"]
    assert main(asked) == 2
    assert "Say their order from tail to head, perhaps --markers tail,p7,p1,p2" in capsys.readouterr().err
    for markers, match in (
        (NAMES[::-1], f"begins with the head, got {','.join(NAMES[::-1])}. Give --markers {','.join(NAMES)}"),
        ([*NAMES[:-1], "haed"], "the film has no point `haed`; it has p7, head, tail, p1"),
        ([*NAMES, "tail"], "has `tail` twice"),
    ):
        assert main([*asked, "--markers", ",".join(markers)]) == 2
        assert match in capsys.readouterr().err
    assert main([*asked, "--markers", ",".join(NAMES), "--first-point", "head"]) == 2
    assert "from tail to head, and with --first-point head beside it" in capsys.readouterr().err
    assert main([*asked, "--markers", ", ".join(NAMES)]) == 0
    (trial,) = load_campaign(tmp_path / "c").trials
    assert trial.motion is not None
    same_shape = np.linalg.norm(np.diff(POINTS, axis=1), axis=2)
    assert load_campaign(tmp_path / "c").body.edges_m == pytest.approx(1e-3 * np.median(same_shape, axis=0), rel=0.05)
    assert main([*asked[:2], str(tmp_path / "part"), *asked[3:], "--markers", ",".join(NAMES[::2])]) == 0
    assert load_campaign(tmp_path / "part").body.vertices == 8


def test_text_of_other_files_is_their_own(tmp_path):
    (tmp_path / "m.csv").write_text("a,b\n")
    assert table_text(tmp_path / "m.csv") == "a,b\n"
    for path in (tmp_path, tmp_path / "none.xlsx"):
        with pytest.raises(InputError, match="is a folder|no such file"):
            table_text(path)


def test_text_in_two_bytes_a_letter_without_a_mark_is_told_so_and_a_mark_twice_is_none(tmp_path):
    text = "t_s,x_0,y_0\n0,1,2\n0.05,1,2\n"
    (tmp_path / "m.csv").write_bytes(text.encode("utf-16-le"))
    assert "Is it text in UTF-16 or UTF-32? Save it as UTF-8" in refusal(tmp_path / "m.csv", "tidy")
    (tmp_path / "m.csv").write_bytes(2 * b"\xef\xbb\xbf" + text.encode())
    assert read(tmp_path / "m.csv").floor.tolist() == [[[1, 2]], [[1, 2]]]
    (tmp_path / "m.csv").write_text(text.replace("x_0", "x" * 9000))
    assert len(refusal(tmp_path / "m.csv", "tidy")) < 600


@pytest.mark.slow
@pytest.mark.usefixtures("virtual_machine")
@pytest.mark.parametrize(("name", "write", "options"), [
    ("m.xml", lambda path: recorders.trackmate(path, TIME, POINTS), []),
    ("m.slp", lambda path: recorders.sleap_project(path, 1e3 * POINTS, NAMES), ["--frames-per-second", "20"]),
    ("m.mat", lambda path: recorders.qtm_mat(path, TIME, POINTS, NAMES), []),
    ("m.csv", lambda path: recorders.imagej_results(path, 1e3 * POINTS),
     ["--format", "long", "--columns", "frame=Slice,x=X,y=Y", "--length-unit", "px", "--frames-per-second", "20"]),
    ("m.txt", lambda path: recorders.tracker(path, TIME, POINTS, NAMES),
     ["--columns", "time=tail t,x=* x,y=* y", "--length-unit", "mm"]),
    ("m.xlsx", lambda path: recorders.ethovision(path, TIME, POINTS, NAMES, ORDER),
     ["--columns", "time=Trial time,x=X *,y=Y *", "--length-unit", "mm", "--markers", ",".join(NAMES)]),
])  # fmt: skip
def test_the_worm_that_was_written_has_its_ratio(tmp_path, name, write, options):
    write(tmp_path / name)
    assert main(["new", "campaign", str(tmp_path / "c"), "--film", str(tmp_path / name), "--yes", *options]) == 0
    campaign = load_campaign(tmp_path / "c")
    segments = trial_segments(campaign.trials[0])[:4]
    found = fit(neutral_model(campaign), segments, ("anisotropy_ratio",), np.array([0.5]))
    assert 1 / found.values[0] == pytest.approx(RATIO, rel=0.02)
