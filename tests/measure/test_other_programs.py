"""Files as programs write them that are not run here: the same worm of all, or what to do; never another one."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from serpenoid.errors import InputError
from serpenoid.measure.campaign import MotionKeys
from serpenoid.measure.readers import READERS
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
    assert 'an export of QTM? Take that as TSV or C3D: `format = "qualisys"`' in refusal(tmp_path / "m.mat")


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
    ("trajectories", "one point an animal"), ("pred_points", "a project of SLEAP: export its analysis HDF5"),
    ("skeleton", "its file of features"), ("voltage", "holds `voltage`, of none that are read"),
])  # fmt: skip
def test_an_hdf5_file_that_no_reader_is_for_is_told_by_what_it_holds(tmp_path, name, match):
    with h5py.File(tmp_path / "m.slp", "w") as file:
        file[name] = np.zeros(3)
    assert match in refusal(tmp_path / "m.slp")
    data = (tmp_path / "m.slp").read_bytes()
    (tmp_path / "m.h5").write_bytes(data[: len(data) // 2])
    assert "not a readable HDF5 file" in refusal(tmp_path / "m.h5")
