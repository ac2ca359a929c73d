"""Files as programs write them that are not run here: the same worm of all, or what to do; never another one."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Sequence
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.measure.campaign import MotionKeys
from serpenoid.measure.formats.own_names import advice
from serpenoid.measure.formats.readers import READERS
from serpenoid.measure.tracks import Tracks
from serpenoid.scaffold.film_format import format_of

RATE, FRAMES, NAMES = 20.0, 30, ["tail", "a", "b", "c", "d", "head"]
DOWN = np.array([1.0, -1.0])
TIME = np.arange(FRAMES) / RATE
_ANGLE = 0.6 * np.sin(2 * np.pi * (TIME[:, None] + (np.arange(5) + 0.5) / 5))
POINTS = np.zeros((FRAMES, 6, 2))  # tail first
POINTS[:, 1:] = np.cumsum(np.stack([np.cos(_ANGLE), np.sin(_ANGLE)], axis=2), axis=1)
POINTS[..., 0] += 0.3 * TIME[:, None]


def read(path: Path, form: str | None = None, **keys: object) -> Tracks:
    kind = form or format_of(path)
    assert kind is not None
    return READERS[kind].read(path, MotionKeys.model_validate({"format": kind} | keys))


def refusal(path: Path, form: str | None = None, **keys: object) -> str:
    with pytest.raises(InputError) as told:
        read(path, form, **keys)
    return str(told.value)


def c3d(path: Path, unit: str = "mm", labels: tuple[str, ...] = tuple(NAMES), scale: float = 1000.0) -> bytes:
    ezc3d = pytest.importorskip("ezc3d")
    written = ezc3d.c3d()
    points = np.ones((4, len(labels), FRAMES))
    points[:2, :6], points[2, :6] = POINTS.transpose(2, 1, 0) * scale, 0.1
    written["parameters"]["POINT"]["UNITS"]["value"] = [unit]
    written["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
    written["parameters"]["POINT"]["RATE"]["value"] = [RATE]
    written["data"]["points"] = points
    written.write(str(path))
    return path.read_bytes()


def test_a_c3d_file_of_floats_that_was_cut_off_is_refused_however_much_is_left(tmp_path):
    data = c3d(tmp_path / "m.c3d")
    assert len(read(tmp_path / "m.c3d").time_s) == FRAMES
    for cut in (512, 1500, 2500):  # of 2880 bytes of points, and what fills the last block
        (tmp_path / "m.c3d").write_bytes(data[:-cut])
        assert "promises more than the file holds" in refusal(tmp_path / "m.c3d")


@pytest.mark.parametrize(("unit", "scale"), [("mm", 1e3), ("Meters", 1.0), ("millimetres", 1e3), ("cm", 100.0)])
def test_units_of_markers_may_be_spelt_out_and_markers_without_a_name_are_none_of_the_body(tmp_path, unit, scale):
    c3d(tmp_path / "m.c3d", unit, (*NAMES, "*7", "Unlabeled_12"), scale)
    found = read(tmp_path / "m.c3d")
    np.testing.assert_allclose(found.floor[:, :6], POINTS, atol=1e-6)
    assert found.unlabelled == (False,) * 6 + (True,) * 2


def test_an_unknown_unit_of_markers_is_refused(tmp_path):
    c3d(tmp_path / "m.c3d", "inches")
    assert "the unit of its positions must be m, cm or mm, got 'inches'" in refusal(tmp_path / "m.c3d")


def test_a_table_that_pandas_wrote_in_its_own_layout_is_read(tmp_path):
    """`DataFrame.to_hdf` without `format="table"`, as movement writes files of DeepLabCut."""
    parts = ["x", "y", "likelihood"]
    with h5py.File(tmp_path / "m.h5", "w") as file:
        group = file.create_group("any_key")
        group.attrs["nblocks"], group.attrs["block0_items_nlevels"] = 1, 3
        for level, words in enumerate((["net"], NAMES, parts)):
            group[f"block0_items_level{level}"] = np.array(words, dtype="S")
        group["block0_items_label0"] = np.zeros(18, dtype="i1")
        group["block0_items_label1"] = np.repeat(np.arange(6), 3).astype("i1")
        group["block0_items_label2"] = np.tile(np.arange(3), 6).astype("i1")
        group["axis1"] = np.arange(FRAMES)
        score = np.full((FRAMES, 6, 1), 0.9)
        score[3, 2] = 0.1
        group["block0_values"] = np.concatenate([POINTS * DOWN, score], axis=2).reshape(FRAMES, 18)
    found = read(tmp_path / "m.h5", frames_per_second=RATE)
    assert list(found.names) == NAMES
    assert np.argwhere(~found.seen).tolist() == [[3, 2]]
    np.testing.assert_array_equal(found.floor[found.seen], POINTS[found.seen])


def movement(path: Path, order: tuple[str, ...], seconds: bool = True, axes: str = "xy") -> None:
    """netCDF, which is HDF5 whose axes are named by scales."""
    scales = {"time": TIME if seconds else np.arange(FRAMES), "space": list(axes), "keypoints": NAMES}
    position = np.zeros((FRAMES, len(axes), 6, 2))
    position[..., 0], position[:, :2, :, 1] = 5.0, (POINTS * DOWN).transpose(0, 2, 1)
    standing = ("time", "space", "keypoints", "individuals")
    with h5py.File(path, "w") as file:
        for name, values in (scales | {"individuals": ["other", "worm"]}).items():
            file[name] = np.asarray(values) if name == "time" else np.array(values, dtype=object)
            file[name].make_scale(name)
        for name, data in (("position", position), ("confidence", np.full((FRAMES, 6, 2), 0.9))):
            mine = [axis for axis in order if name == "position" or axis != "space"]
            theirs = [axis for axis in standing if axis in mine]
            file[name] = data.transpose([theirs.index(axis) for axis in mine])
            for k, axis in enumerate(mine):
                file[name].dims[k].attach_scale(file[axis])
        file.attrs["time_unit"], file.attrs["source_software"] = "seconds" if seconds else "frames", "SLEAP"


@pytest.mark.parametrize("seconds", [True, False])
@pytest.mark.parametrize(
    "order", [("time", "space", "keypoints", "individuals"), ("time", "individuals", "keypoints", "space")]
)
def test_poses_of_movement_are_read_by_the_names_of_their_axes(tmp_path, order, seconds):
    movement(tmp_path / "m.nc", order, seconds)
    assert format_of(tmp_path / "m.nc") == "movement"
    rate = {} if seconds else {"frames_per_second": RATE}
    found = read(tmp_path / "m.nc", individual="worm", **rate)
    np.testing.assert_array_equal(found.floor, POINTS)
    np.testing.assert_allclose(found.time_s, TIME)
    assert (list(found.names), found.scale_known) == (NAMES, False)
    assert "shows 2 individuals: `other`, `worm`" in refusal(tmp_path / "m.nc", **rate)
    if not seconds:
        assert "give `frames_per_second`" in refusal(tmp_path / "m.nc", individual="worm")
    assert "no point has a score" in refusal(tmp_path / "m.nc", individual="worm", minimum_score=0.95, **rate)


def test_poses_of_movement_in_space_are_refused(tmp_path):
    movement(tmp_path / "m.nc", ("time", "space", "keypoints", "individuals"), axes="xyz")
    assert "has points in x, y, z" in refusal(tmp_path / "m.nc", individual="worm")


def by_hdf5(path: Path, **arrays: np.ndarray) -> None:
    """As MATLAB saves with -v7.3: 512 bytes of its own, then HDF5 with axes in opposite order."""
    with h5py.File(path, "w", userblock_size=512) as file:
        for name, array in arrays.items():
            file[name] = np.atleast_2d(array).T
        file.create_group("#refs#")
        file.create_group("worm")["x"] = np.zeros(3)
    data = path.read_bytes()
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(512, b"\0") + data[512:])


def test_what_matlab_saves_in_its_format_7_3_is_read(tmp_path):
    by_hdf5(tmp_path / "m.mat", points=POINTS, t_s=TIME)
    found = read(tmp_path / "m.mat")
    np.testing.assert_array_equal(found.floor, POINTS)
    np.testing.assert_array_equal(found.time_s, TIME)
    by_hdf5(tmp_path / "m.mat", t_s=TIME)
    said = refusal(tmp_path / "m.mat")
    assert "it has `t_s` (1, 30), `worm` (struct: x). Arrays within a structure are not read" in said


def test_cells_and_complex_numbers_of_matlab_are_told_with_the_line_that_makes_arrays_of_them(tmp_path):
    cells = np.empty((FRAMES, 1), dtype=object)
    for k, row in enumerate(POINTS):
        cells[k, 0] = row
    for name in ("points", "midlines"):
        savemat(tmp_path / "m.mat", {name: cells, "t_s": TIME})
        assert f"points = permute(cat(3, {name}{{:}}), [3 1 2]);" in refusal(tmp_path / "m.mat")
    savemat(tmp_path / "m.mat", {"points": POINTS @ [1, 1j], "t_s": TIME})
    assert "x = real(points); y = imag(points);" in refusal(tmp_path / "m.mat")
    savemat(tmp_path / "m.mat", {"take": {"FrameRate": 40.0, "Trajectories": {"Labeled": {"Data": POINTS}}}})
    assert 'an export of QTM? Then `format = "qualisys"`' in refusal(tmp_path / "m.mat", "array")


def test_frames_in_columns_are_told_without_times_too_and_frames_in_rows_never(tmp_path):
    for noise in (0.0, 0.03):
        points = POINTS + noise * np.random.default_rng(0).normal(size=POINTS.shape)
        savemat(tmp_path / "m.mat", {"x": points[..., 0].T, "y": points[..., 1].T})
        assert "frames of 30 points, whose distances" in refusal(tmp_path / "m.mat", frames_per_second=RATE)
        savemat(tmp_path / "m.mat", {"x": points[:5, :, 0], "y": points[:5, :, 1]})  # fewer frames than points
        assert read(tmp_path / "m.mat", frames_per_second=RATE).floor.shape == (5, 6, 2)
    savemat(tmp_path / "m.mat", {"points": POINTS[[0] * FRAMES]})  # at rest
    assert read(tmp_path / "m.mat", frames_per_second=RATE).floor.shape == POINTS.shape


def test_the_frame_rate_of_tierpsy_is_found_beside_its_trajectories(tmp_path):
    """As in its `featuresN` files."""
    table = np.zeros(FRAMES, dtype=[("worm_index", "<i4"), ("timestamp", "<i4")])
    table["timestamp"] = np.arange(FRAMES)
    with h5py.File(tmp_path / "m.hdf5", "w") as file:
        file["coordinates/skeletons"], file["timeseries_data"], file["trajectories_data"] = POINTS, table, table
        file["trajectories_data"].attrs["fps"] = RATE
    np.testing.assert_allclose(read(tmp_path / "m.hdf5").time_s, TIME)


@pytest.mark.parametrize(("name", "match"), [
    ("trajectories", "one point an animal"),
    ("skeleton", "its file of features"), ("voltage", "holds `voltage`, of none that are read"),
])  # fmt: skip
def test_an_hdf5_file_that_no_reader_is_for_is_told_by_what_it_holds(tmp_path, name, match):
    with h5py.File(tmp_path / "m.slp", "w") as file:
        file[name] = np.zeros(3)
    assert match in refusal(tmp_path / "m.slp")
    data = (tmp_path / "m.slp").read_bytes()
    (tmp_path / "m.h5").write_bytes(data[: len(data) // 2])
    assert "not a readable HDF5 file" in refusal(tmp_path / "m.h5")


def table(
    path: Path, above: str, header: Sequence[str], below: Sequence[str], separator: str = ",", end: str = ""
) -> None:
    """Times and points [mm] of all frames below rows of facts, a header and rows of labels; one point is hidden."""
    rows = [separator.join(header), *below]
    for frame, row in enumerate(POINTS):
        cells = [f"{value:.5f}" for value in row.ravel()]
        cells[6:8] = ["-", "-"] if frame == 3 else cells[6:8]
        cells = [f"{TIME[frame]:.3f}", *cells]
        rows.append(separator.join(cell.replace(".", ",") if separator == ";" else cell for cell in cells) + end)
    path.write_text(above + "\n".join(rows) + "\n")


IN_PAIRS = ["Trial time", *(f"{axis} {name}" for name in NAMES for axis in "XY")]
NAMED = {"time": "Trial time", "x": "X *", "y": "Y *"}
FACTS = '"Number of header lines:";"38";\n"Subject";"Worm 1";\n"Start";"01.05.2024 12:00";\n"";"";\n'


def same(found: Tracks) -> None:
    hidden = np.argwhere(~found.seen).tolist()
    assert hidden == [[3, 3]]
    np.testing.assert_allclose(1e3 * found.floor[found.seen], POINTS[found.seen], atol=1e-5)
    np.testing.assert_allclose(found.time_s, TIME, atol=1e-9)


@pytest.mark.parametrize(("above", "below", "separator", "end"), [
    ("", [], ",", ""), (FACTS, [";".join(["s"] + ["mm"] * 12) + ";"], ";", ";"),
    ("a: b\nc: d\n\n", [",".join(["time"] + ["X", "Y"] * 6), ",".join(["(sec)"] + ["(mm)"] * 12)], ",", ""),
], ids=["bare", "facts and units", "labels and units"])  # fmt: skip
def test_facts_above_a_header_and_labels_and_units_below_it_are_passed_over(tmp_path, above, below, separator, end):
    table(tmp_path / "m.csv", above, IN_PAIRS, below, separator, end)
    found = read(tmp_path / "m.csv", "tidy", columns=NAMED, length_unit="mm")
    same(found)
    assert list(found.names) == NAMES
    said = refusal(tmp_path / "m.csv", "tidy", length_unit="mm")
    assert f"row {above.count(chr(10)) + 1}, column A" in said
    assert '`columns = { time = "Trial time", x = "X *", y = "Y *" }`' in said


def test_a_row_of_units_that_says_another_than_it_is_read_in_is_refused_by_its_cell(tmp_path):
    table(tmp_path / "m.csv", FACTS, IN_PAIRS, [";".join(["s"] + ["mm"] * 12) + ";"], ";", ";")
    said = refusal(tmp_path / "m.csv", "tidy", columns=NAMED, length_unit="cm")
    assert 'row 6, column B: says mm, and the column is read in cm: `length_unit = "mm"`' in said
    said = refusal(tmp_path / "m.csv", "tidy", columns=NAMED, length_unit="mm", time_unit="ms")
    assert 'row 6, column A: says s, and the column is read in ms: `time_unit = "s"`' in said


def test_a_fault_below_facts_is_named_by_its_row_in_the_file(tmp_path):
    table(tmp_path / "m.csv", "a: b\nc: d\n", IN_PAIRS, ["s" + ",mm" * 12])
    lines = (tmp_path / "m.csv").read_text().splitlines()
    lines[9] = lines[9].replace(",", ",lost", 1)
    (tmp_path / "m.csv").write_text("\n".join(lines) + "\n")
    assert "row 10, column B (`X tail`): must be a number" in refusal(
        tmp_path / "m.csv", "tidy", columns=NAMED, length_unit="mm"
    )
    lines[9] = lines[9].rsplit(",", 1)[0]
    (tmp_path / "m.csv").write_text("\n".join(lines) + "\n")
    assert "row 10: has 12 cells" in refusal(tmp_path / "m.csv", "tidy", columns=NAMED, length_unit="mm")


def test_a_header_may_go_on_beyond_the_numbers_and_never_the_other_way_round(tmp_path):
    """As LabVIEW's, with `Comment`; a row more than its header may be shifted by a column."""
    table(tmp_path / "m.csv", "", [*IN_PAIRS, "Comment"], [])
    same(read(tmp_path / "m.csv", "tidy", columns=NAMED, length_unit="mm"))
    table(tmp_path / "m.csv", "", [*IN_PAIRS[:1], *IN_PAIRS[1:-2]], [])
    assert "has 13 cells where the header has 11" in refusal(tmp_path / "m.csv", "tidy", columns=NAMED)


@pytest.mark.parametrize("labels", [0, 3])
def test_rows_of_spots_below_several_rows_of_labels_are_read(tmp_path, labels):
    rows = ["LABEL,TRACK_ID,POSITION_X,POSITION_Y,POSITION_T", *(
        "Label,Track ID,X,Y,T", "Label,Track ID,X,Y,T", ",,(micron),(micron),(sec)")[:labels]]  # fmt: skip
    rows += [
        f"ID{9 * frame + k},{k},{x:.5f},{y:.5f},{TIME[frame]}"
        for k in reversed(range(6))
        for frame, (x, y) in enumerate(POINTS[:, k])
        if (frame, k) != (3, 3)
    ]
    (tmp_path / "m.csv").write_text("\n".join(rows) + "\n")
    columns = {"time": "POSITION_T", "point": "TRACK_ID", "x": "POSITION_X", "y": "POSITION_Y"}
    found = read(tmp_path / "m.csv", "long", columns=columns, length_unit="um")
    assert np.argwhere(~found.seen).tolist() == [[3, 3]]
    np.testing.assert_allclose(1e6 * found.floor[found.seen], POINTS[found.seen], atol=1e-5)
    assert 'x = "POSITION_X", y = "POSITION_Y" }` and `length_unit`' in advice(rows[0].split(","))
    if labels:
        said = refusal(tmp_path / "m.csv", "long", columns=columns, length_unit="mm")
        assert "row 4, column C: says um, and the column is read in mm" in said


def test_a_star_stands_for_words_of_one_kind_that_have_both_columns(tmp_path):
    header = ["t", *(f"{name}/{axis}" for name in NAMES for axis in "xy")]
    table(tmp_path / "m.csv", "", header, [])
    keys = {"columns": {"time": "t", "x": "*/x", "y": "*/y"}, "length_unit": "mm"}
    same(read(tmp_path / "m.csv", "tidy", **keys))
    table(tmp_path / "m.csv", "", [*header[:-1], "nose/y"], [])
    assert "in place of `*` has a column of x or of y alone" in refusal(tmp_path / "m.csv", "tidy", **keys)
    poses = [f"pose{k}.{what}.{axis}" for what in ("at", "turn") for k in range(3) for axis in "xy"]
    table(tmp_path / "m.csv", "", ["t", *poses], [])
    said = refusal(tmp_path / "m.csv", "tidy", columns={"time": "t", "x": "*.x", "y": "*.y"})
    assert "stands for several kinds of points: pose*.at, pose*.turn" in said


@pytest.mark.parametrize(("header", "columns"), [
    ("time,tail_x,tail_y,b1_x,b1_y,b2_x,b2_y,head_x,head_y", 'time = "time", x = "*_x", y = "*_y"'),
    ("frame,p0_x,p0_y,p0_conf,p1_x,p1_y,p1_conf", 'frame = "frame", x = "p*_x", y = "p*_y"'),
    ("pt1_cam1_X,pt1_cam1_Y,pt2_cam1_X,pt2_cam1_Y", 'x = "pt*_cam1_X", y = "pt*_cam1_Y"'),
    ("%time,seq,p0.at.x,p0.at.y,p0.turn.x,p0.turn.y,p1.at.x,p1.at.y,p1.turn.x,p1.turn.y",
     'time = "%time", x = "p*.at.x", y = "p*.at.y"'),
    ("time,child_frame_id,x,y,qx,qy", 'time = "time", point = "child_frame_id", x = "x", y = "y"'),
    ("frame,id,x,y,yaw", 'frame = "frame", point = "id", x = "x", y = "y"'),
    ("t,x,y,t,x,y", 'time = "Time (s)", x = "M*_x", y = "M*_y"'),
])  # fmt: skip
def test_advice_names_the_columns_of_a_file(header, columns):
    said = advice(header.split(","))
    found = re.search(r"`columns = {(.*?)}`", said)
    assert found is not None
    assert found[1].strip() == columns


@pytest.mark.parametrize("named", [{}, {"columns": {"time": "t_s", "x": "x_*", "y": "y_*"}}])
def test_one_point_whose_columns_are_there_twice_is_told_with_columns_that_can_be_read(tmp_path, named):
    order = [0, 1, 2, 3, 4, 5, 0]
    values = np.column_stack([TIME, POINTS[:, order].reshape(FRAMES, -1)])
    header = ["t_s", *(f"{axis}_{k}" for k in order for axis in "xy")]
    lines = [",".join(map(repr, row)) for row in values.tolist()]
    (tmp_path / "m.csv").write_text("\n".join([",".join(header), *lines]) + "\n")
    said = refusal(tmp_path / "m.csv", "tidy", **named)
    assert "`x_0` is the name of columns B and N. Take out what is not meant" in said
    proposed = re.search(r"`columns = ({.*?})`", said)
    assert proposed is not None
    columns = tomllib.loads(f"columns = {proposed[1]}")["columns"]
    assert columns["x"] == ["x_0 1", "x_1", "x_2", "x_3", "x_4", "x_5"]
    np.testing.assert_allclose(read(tmp_path / "m.csv", "tidy", columns=columns).floor, POINTS, atol=1e-12)


def test_a_film_whose_names_say_that_an_end_stands_between_others_makes_no_campaign(tmp_path, capsys):
    header = ["t", *(f"{name}_{axis}" for name in ("center", "nose", "b", "c", "d", "tail") for axis in "xy")]
    table(tmp_path / "m.csv", "", header, [])
    asked = ["new", "campaign", str(tmp_path / "c"), "--film", str(tmp_path / "m.csv"), "--yes"]
    assert main([*asked, "--columns", "time=t,x=*_x,y=*_y", "--length-unit", "mm"]) == 2
    assert "has `nose` between other points, in the order center, nose, b, c, d, tail" in capsys.readouterr().err
