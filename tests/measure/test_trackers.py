"""Files of animal trackers: the same swimmer in every format gives the same points; what is broken is named."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from scipy.io import savemat

from serpenoid.compare.records import trial_record
from serpenoid.errors import InputError
from serpenoid.files.writing import write_csv
from serpenoid.measure.animals.animal import bends_run, edges_per_wave, leading, remarks
from serpenoid.measure.animals.beat import beat
from serpenoid.measure.campaign import MotionKeys
from serpenoid.measure.formats import readers
from serpenoid.measure.formats.arrays import read_array
from serpenoid.measure.formats.points import read_long, read_sleap
from serpenoid.measure.formats.tidy import read_tidy
from serpenoid.measure.formats.trackers import Timing, read_deeplabcut, read_sleap_analysis, read_tierpsy
from serpenoid.measure.formats.trex import read_trex
from serpenoid.measure.formats.wcon import read_wcon
from serpenoid.measure.load import load_campaign

RATE = 25.0
NAMES = ["tail", "a", "b", "c", "d", "head"]
DOWN = np.array([1.0, -1.0])
ONE_POINT = "Trajectories of idtracker and idtracker.ai are one point an animal"


def swimmer(seconds: float = 4.0, waves: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) and points (F, 6, 2), tail first; bends run from head to tail, and it moves head first along x."""
    time, s = np.arange(round(seconds * RATE)) / RATE, (np.arange(5) + 0.5) / 5
    angle = 0.5 * np.sin(2 * np.pi * (time[:, None] + waves * s))
    edge = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    points = np.concatenate([np.zeros((len(time), 1, 2)), np.cumsum(edge, axis=1)], axis=1)
    points[..., 0] += 0.5 * time[:, None]
    return time, points


def deeplabcut_csv(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    head = [["scorer"] + ["net"] * 18, ["bodyparts"] + [n for n in NAMES for _ in range(3)],
            ["coords"] + ["x", "y", "likelihood"] * 6]  # fmt: skip
    cells = np.concatenate([points * DOWN, np.full((*points.shape[:2], 1), 0.99)], axis=2).reshape(len(time), -1)
    rows = [[str(f), *map(repr, row.tolist())] for f, row in enumerate(cells)]
    path.write_text("\n".join(",".join(row) for row in head + rows) + "\n")


def deeplabcut_hdf5(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    """As pandas writes it: a compound table, and the column names as a pickle of protocol 0."""
    import pickle

    cells = np.concatenate([points * DOWN, np.full((*points.shape[:2], 1), 0.99)], axis=2).reshape(len(time), -1)
    table = np.zeros(len(time), dtype=[("index", "<i8"), ("values_block_0", "<f8", (18,))])
    table["index"], table["values_block_0"] = np.arange(len(time)), cells
    columns = [("net", name, part) for name in NAMES for part in ("x", "y", "likelihood")]
    with h5py.File(path, "w") as file:
        group = file.create_group("df_with_missing")
        group.create_dataset("table", data=table)
        group.attrs["non_index_axes"] = np.bytes_(pickle.dumps([(1, columns)], protocol=0))


def sleap_hdf5(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    with h5py.File(path, "w") as file:
        file["tracks"] = (points * DOWN).transpose(2, 1, 0)[None]
        file["node_names"] = np.array(NAMES, dtype="S")
        file["point_scores"] = np.full((1, len(NAMES), len(time)), 0.99)


def sleap_csv(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    cells = np.concatenate([points * DOWN, np.full((*points.shape[:2], 1), 0.99)], axis=2).reshape(len(time), -1)
    rows = [["track", str(f), *map(repr, row.tolist())] for f, row in enumerate(cells)]
    head = ["track", "frame_idx", *(f"{name}.{part}" for name in NAMES for part in ("x", "y", "score"))]
    path.write_text("\n".join(",".join(row) for row in [head, *rows]) + "\n")


def tierpsy(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    table = np.zeros(len(time), dtype=[("worm_index", "<i4"), ("timestamp", "<i4")])
    table["timestamp"] = np.arange(len(time))
    with h5py.File(path, "w") as file:
        file["coordinates/skeletons"] = points * DOWN
        file["timeseries_data"] = table
        file["timeseries_data"].attrs["fps"] = RATE


def wcon(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    worm = {"id": "1", "t": time.tolist(), "x": points[..., 0].tolist(), "y": points[..., 1].tolist()}
    path.write_text(json.dumps({"units": {"t": "s", "x": "um", "y": "um"}, "data": [worm]}))


def array(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    np.savez(path, t_s=time, points=points)


def trex_posture(path: Path, time: np.ndarray, points: np.ndarray, several_lengths: bool = False) -> None:
    """As TRex writes it: midlines from the head on, in pixels below and right of `offset`, with its own types."""
    there = np.isfinite(points).all(axis=(1, 2))
    image = (points * DOWN)[there, ::-1]
    offset = np.floor(image.min(axis=1))
    midlines = (image - offset[:, None]).astype(np.float64)
    lengths = np.full(len(image), 6)
    arrays = {"midline_points": midlines}
    if several_lengths:
        lengths[1] = 11  # one frame sampled twice as finely
        fine = [np.interp(np.arange(11) / 2, np.arange(6), column) for column in midlines[1].T]
        lines = [*midlines[:1], np.stack(fine, axis=1), *midlines[2:]]
        arrays = {"midline_points": np.concatenate(lines)}
    span = np.linalg.norm(np.diff(image, axis=1), axis=2).sum(axis=1)
    np.savez(
        path, frames=np.flatnonzero(there), offset=offset.astype(np.float32), midline_lengths=lengths.astype(np.uint64),
        midline_centimeters=(0.02 * span).astype(np.float32), midline_offsets=np.zeros(len(image), np.float32),
        midline_angle=np.zeros(len(image), np.float32), posture_area=np.ones(len(image), np.float32),
        hole_points=np.zeros((0, 2), np.float32), hole_counts=np.zeros(len(image), np.uint64),
        midline_points_raw=arrays["midline_points"], outline_lengths=np.full(len(image), 3, np.uint64),
        outline_points=np.zeros((3 * len(image), 2), np.float32), **arrays,
    )  # fmt: skip


def trex_columns(time: np.ndarray, points: np.ndarray) -> dict[str, np.ndarray]:
    """Tracking data with key points: what was not found is infinite."""
    shown = np.where(np.isfinite(points), points * DOWN, np.inf)
    columns = {"frame": np.arange(len(time)), "missing": np.zeros(len(time)), "time": time, "X#wcentroid": time}
    return columns | {f"pose{axis}{k}": shown[:, k, i] for k in range(6) for i, axis in enumerate("XY")}


def trex_npz(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    np.savez(path, **trex_columns(time, points))


def trex_csv(path: Path, time: np.ndarray, points: np.ndarray) -> None:
    columns = trex_columns(time, points)
    rows = [",".join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)]
    path.write_text("\n".join([",".join(columns), *rows]) + "\n")


Writer = Callable[[Path, np.ndarray, np.ndarray], None]
FORMATS: dict[str, tuple[Writer, Callable, str, float]] = {
    "deeplabcut.csv": (deeplabcut_csv, read_deeplabcut, "px", 1.0),
    "deeplabcut.h5": (deeplabcut_hdf5, read_deeplabcut, "px", 1.0),
    "sleap.h5": (sleap_hdf5, read_sleap_analysis, "px", 1.0),
    "tierpsy.hdf5": (tierpsy, read_tierpsy, "um", 1e-6),
    "worm.wcon": (wcon, read_wcon, "um", 1e-6),
    "points.npz": (array, read_array, "m", 1.0),
    "fish_id0.npz": (trex_npz, read_trex, "px", 1.0),
    "fish_id0.csv": (trex_csv, read_trex, "px", 1.0),
}


@pytest.mark.parametrize("unit", ["micrometers", "micrometres", "microns", "um"])
def test_units_of_a_wcon_file_may_be_spelt_out(tmp_path, unit):
    time, points = swimmer()
    wcon(tmp_path / "w.wcon", time, points)
    text = (tmp_path / "w.wcon").read_text().replace('"s"', '"seconds"')
    (tmp_path / "w.wcon").write_text(text.replace('"um"', f'"{unit}"'))
    np.testing.assert_allclose(read_wcon(tmp_path / "w.wcon", Timing()).floor, points * 1e-6)


@pytest.mark.parametrize("name", FORMATS)
def test_every_format_gives_back_the_points(tmp_path, name):
    time, points = swimmer()
    points[3, 2] = np.nan
    write, read, _, metres = FORMATS[name]
    write(tmp_path / name, time, points)
    found = read(tmp_path / name, Timing(RATE))
    np.testing.assert_allclose(found.time_s, time, atol=1e-12)
    np.testing.assert_allclose(found.floor, points * metres, rtol=1e-12, atol=1e-18)
    assert found.scale_known == (FORMATS[name][2] != "px")


@pytest.mark.parametrize("several", [False, True], ids=["one length", "several lengths"])
def test_midlines_of_trex_are_read_head_first_with_its_own_scale(tmp_path, several):
    """A frame without a midline is absent from the file; 0.02 cm a pixel stands in `midline_centimeters` alone."""
    time, points = swimmer()
    points[3] = np.nan
    trex_posture(tmp_path / "fish_posture_fish0.npz", time, points, several)
    found = read_trex(tmp_path / "fish_posture_fish0.npz", Timing(RATE))
    there = np.arange(len(time)) != 3
    np.testing.assert_allclose(found.time_s, time[there], atol=1e-12)
    np.testing.assert_allclose(found.floor, points[there, ::-1], atol=1e-6)
    assert not found.scale_known
    scaled = read_trex(tmp_path / "fish_posture_fish0.npz", Timing(RATE, "cm"))
    np.testing.assert_allclose(scaled.floor, 2e-4 * points[there, ::-1], rtol=1e-5, atol=1e-9)  # stored as float32
    assert scaled.scale_known


def test_tracking_data_of_trex_without_points_on_the_body_say_what_to_export(tmp_path):
    np.savez(tmp_path / "a.npz", **{"X#wcentroid": np.arange(4.0), "time": np.arange(4.0)})
    with pytest.raises(InputError, match=r"output_posture_data = true"):
        read_trex(tmp_path / "a.npz", Timing(RATE))


def test_every_format_a_campaign_may_name_has_its_reader():
    assert tuple(readers.READERS) == readers.NAMES
    for name, form in readers.READERS.items():
        with pytest.raises(InputError, match=r"nothing\.csv|ezc3d|h5py"):
            form.read(
                Path("nothing.csv"),
                MotionKeys(
                    format=name,
                    columns={"time": "t", "point": "p", "x": "x", "y": "y"},
                    length_unit="mm",
                    frames_per_second=25.0,
                ),
            )


@pytest.mark.parametrize("name", FORMATS)
def test_rubbish_in_every_format_is_named_with_its_file(tmp_path, name):
    read, path = FORMATS[name][1], tmp_path / name
    for content in (b"", b"nothing of the kind", b"\x89HDF\r\n\x1a\n" + bytes(80), b'{"units": 3}', b"PK\x03\x04"):
        path.write_bytes(content)
        with pytest.raises(InputError, match=name):
            read(path, Timing(RATE))
    path.unlink()
    with pytest.raises(InputError, match="no such file"):
        read(path, Timing(RATE))


def test_a_pickle_that_would_run_something_is_refused(tmp_path):
    time, points = swimmer()
    deeplabcut_hdf5(tmp_path / "a.h5", time, points)
    with h5py.File(tmp_path / "a.h5", "a") as file:
        file["df_with_missing"].attrs["non_index_axes"] = np.bytes_(b"cos\nsystem\n(S'true'\ntR.")
    with pytest.raises(InputError, match=r"column names cannot be read \(os.system\)"):
        read_deeplabcut(tmp_path / "a.h5", Timing(RATE))


def test_points_the_tracker_is_unsure_of_are_hidden(tmp_path):
    time, points = swimmer()
    deeplabcut_csv(tmp_path / "a.csv", time, points)
    text = (tmp_path / "a.csv").read_text().replace("0.99", "0.5")
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError, match="no point has a score of 0.6 or more, the highest is 0.5"):
        read_deeplabcut(tmp_path / "a.csv", Timing(RATE))
    assert read_deeplabcut(tmp_path / "a.csv", Timing(RATE, None, 0.4)).seen.all()


def campaign(folder: Path, keys: str) -> Path:
    (folder / "campaign.toml").write_text(
        'format = 1\nname = "w"\n[body]\nvertices = 6\nkind = "crawler"\n[motion]\n'
        f'{keys}\n[[trial]]\nname = "one"\nmotion = "m.csv"\n'
    )
    return folder


def tidy(folder: Path, seconds: float, clock: str = "t_s", reverse: bool = False, waves: float = 1.0) -> Path:
    time, points = swimmer(seconds, waves)
    first = time if clock == "t_s" else np.arange(len(time))
    header = f"{clock}," + ",".join(f"x_{k},y_{k}" for k in range(6))
    table = np.column_stack([first, (points[:, ::-1] if reverse else points).reshape(len(time), -1)])
    np.savetxt(folder / "m.csv", table, delimiter=",", header=header, comments="")
    return campaign(folder, 'format = "tidy"\nlength_unit = "um"\nframes_per_second = 25.0')


def test_frame_numbers_and_micrometres(tmp_path):
    trial = load_campaign(tidy(tmp_path, 4.0, "frame")).trials[0]
    np.testing.assert_allclose(np.diff(trial.motion.time_s), 1 / RATE, atol=1e-12)
    assert trial.metres == pytest.approx(5e-6, rel=0.015)  # five chords of 1 um; arcs are longer
    weights = trial.body.vertex_weights
    np.testing.assert_allclose(weights, np.array([0.5, 1, 1, 1, 1, 0.5]) / 5, rtol=5e-3)  # in proportion to length


def test_head_first_and_tail_first_are_found_out_and_said(tmp_path):
    trial = load_campaign(tidy(tmp_path, 4.0)).trials[0]
    motion = trial.motion
    assert leading(motion) > 0.9
    assert bends_run(motion) > 0.9
    assert remarks(trial.body, motion)[0].startswith("moves head first")
    assert remarks(trial.body.changed(kind=None), motion)[0].startswith(
        "its points are taken for joints of rigid links"
    )
    reverse = tmp_path / "reverse"
    reverse.mkdir()
    notes = load_campaign(tidy(reverse, 4.0, reverse=True)).trials[0].notes
    assert any("moves tail first" in note for note in notes)
    assert any("set `first_point`" in note for note in notes)


def test_points_too_few_for_the_waves_of_a_body_are_said_before_any_fit(tmp_path):
    for waves in (0.8, 2.0):
        (folder := tmp_path / str(waves)).mkdir()
        trial = load_campaign(tidy(folder, 6.0, waves=waves)).trials[0]
        assert edges_per_wave(trial.motion) == pytest.approx(5 / waves, rel=0.02 if waves < 1 else 0.2)
        assert any("track more points" in note for note in trial.notes) == (waves == 2.0)


def test_a_recording_too_short_says_so(tmp_path):
    notes = load_campaign(tidy(tmp_path, 1.6)).trials[0].notes
    assert any("too short: 1.56 s are 1.6 periods" in note or "nothing repeats" in note for note in notes)


def test_pixels_with_a_scale_are_metres_and_a_length_takes_no_scale(tmp_path):
    tidy(tmp_path, 4.0)
    keys = 'format = "tidy"\nlength_unit = "px"\nmetres_per_pixel = 2e-5'
    trial = load_campaign(campaign(tmp_path, keys)).trials[0]
    assert trial.metres == pytest.approx(5 * 2e-5, rel=0.015)  # five chords of 1 px; arcs are longer
    with pytest.raises(InputError, match=r"`metres_per_pixel` is given, and these points are in a length already"):
        load_campaign(campaign(tmp_path, keys.replace("px", "mm")))


@pytest.mark.parametrize("unit", ["px", "mm"])
def test_pixels_count_downwards_in_every_format_and_lengths_upwards(tmp_path, unit):
    points = np.arange(12.0).reshape(2, 3, 2)
    np.savez(tmp_path / "a.npz", points=points, t_s=np.arange(2.0))
    rows = [[t, *frame.ravel()] for t, frame in enumerate(points)]
    write_csv(tmp_path / "t.csv", ["t_s", *(f"{axis}_{k}" for k in range(3) for axis in "xy")], rows)
    each = [[t, k, *point] for t, frame in enumerate(points) for k, point in enumerate(frame)]
    write_csv(tmp_path / "l.csv", ["t", "k", "u", "v"], each)
    found = [
        read_array(tmp_path / "a.npz", Timing(length_unit=unit)),
        read_tidy(tmp_path / "t.csv", unit),
        read_long(tmp_path / "l.csv", {"time": "t", "point": "k", "x": "u", "y": "v"}, unit),
    ]
    for tracks in found:
        np.testing.assert_allclose(tracks.floor, points * ((1, -1) if unit == "px" else (1e-3, 1e-3)))


def test_a_mirrored_film_bends_the_other_way(tmp_path):
    tidy(tmp_path, 4.0)
    keys = 'format = "tidy"\nlength_unit = "px"'
    plain, mirrored = (
        load_campaign(campaign(tmp_path, keys + more)).trials[0].motion.joint_angles
        for more in ("", "\nmirrored = true")
    )
    assert np.abs(plain).max() > 0.1
    np.testing.assert_allclose(mirrored, -plain, atol=1e-9)


@pytest.mark.parametrize(("waves", "reverse"), [(1.0, False), (0.6, False), (1.0, True)])
def test_the_gait_of_a_worm_is_its_frequency_amplitudes_and_waves(tmp_path, waves, reverse):
    """Made with 1 Hz, 0.5 rad of each edge, and so many waves on the body, which run from head to tail."""
    trial = load_campaign(tidy(tmp_path, 6.0, reverse=reverse, waves=waves)).trials[0]
    found = beat(trial.motion)
    assert 1 / found.period_s == pytest.approx(1.0, rel=0.02)
    assert found.waves == pytest.approx(-waves if reverse else waves, rel=0.03)
    bent = 2 * 0.5 * np.sin(np.pi * waves / 5)  # of the difference of two neighbouring edges' sines
    np.testing.assert_allclose(found.amplitude_rad, bent, rtol=0.03)
    assert trial_record(trial)["gait"]["frequency_hz"] == pytest.approx(1 / found.period_s)


@pytest.mark.parametrize(("write", "name"), [(deeplabcut_csv, "m.csv"), (sleap_hdf5, "m.h5"), (sleap_csv, "m.csv")])
def test_a_score_that_no_point_reaches_is_told_with_the_highest_there_is(tmp_path, write, name):
    time, points = swimmer()
    write(tmp_path / name, time, points)
    reader = readers.READERS["deeplabcut" if write is deeplabcut_csv else "sleap"].read
    keys = MotionKeys(frames_per_second=RATE, minimum_score=0.99)
    assert reader(tmp_path / name, keys).seen.all()
    keys = MotionKeys(frames_per_second=RATE, minimum_score=0.995)
    with pytest.raises(
        InputError, match=r"no point has a score of 0.995 or more, the highest is 0.99: .*`minimum_score`"
    ):
        reader(tmp_path / name, keys)


def test_a_point_without_a_score_is_no_doubtful_one(tmp_path):
    """As a person sets it in SLEAP."""
    time, points = swimmer()
    sleap_csv(tmp_path / "m.csv", time, points)
    text = (tmp_path / "m.csv").read_text().splitlines()
    row = text[3].split(",")
    row[4] = ""
    (tmp_path / "m.csv").write_text("\n".join([*text[:3], ",".join(row), *text[4:]]) + "\n")
    assert read_sleap(tmp_path / "m.csv", RATE, minimum_score=0.6).seen.all()


@pytest.mark.parametrize("version", [pytest.param("4", marks=pytest.mark.slow), "5"])
def test_what_matlab_saved_is_the_same_and_what_is_damaged_is_refused(tmp_path, version):
    time, points = swimmer()
    both = {"x": points[..., 0], "y": points[..., 1]} if version == "4" else {"points": points}
    savemat(tmp_path / "m.mat", {"t_s": time, **both}, format=version)
    found = read_array(tmp_path / "m.mat", Timing())
    np.testing.assert_array_equal(found.floor, points)
    np.testing.assert_array_equal(found.time_s, time)
    whole = (tmp_path / "m.mat").read_bytes()
    for broken in (whole[:200], whole[:-900], b"MATLAB" + bytes(500), b""):
        (tmp_path / "m.mat").write_bytes(broken)
        with pytest.raises(InputError, match="m.mat: (not a readable MATLAB file|needs `points`|has [0-9]+ times)"):
            read_array(tmp_path / "m.mat", Timing())
    for hdf5 in (b"MATLAB 7.3 MAT-file", b"\x89HDF\r\n"):
        (tmp_path / "m.mat").write_bytes(hdf5 + bytes(500))
        with pytest.raises(InputError, match="m.mat: not a readable HDF5 file"):
            read_array(tmp_path / "m.mat", Timing())
    (tmp_path / "m.mat").write_bytes(b"MATLAB 7.3 MAT-file" + bytes(500))
    with pytest.raises(InputError, match='but one of MATLAB.*`format = "array"`'):
        read_tidy(tmp_path / "m.mat")


def test_trajectories_of_one_point_an_animal_are_told_as_that(tmp_path):
    np.save(tmp_path / "m.npy", {"trajectories": np.zeros((9, 3, 2))})
    savemat(tmp_path / "m.mat", {"trajectories": np.zeros((9, 3, 2))})
    for name in ("m.npy", "m.mat"):
        with pytest.raises(InputError, match=f"m{name[1:]}.*{ONE_POINT}"):
            read_array(tmp_path / name, Timing(RATE))
    table = "\n".join(["seconds,x1,y1,x2,y2,x3,y3", *(f"{f / 10},{f},0,1,{f},2,2" for f in range(9))])
    (tmp_path / "m.csv").write_text(table)
    with pytest.raises(InputError, match=f"Are these points along one body.*{ONE_POINT}"):
        read_tidy(tmp_path / "m.csv")


def refusal(path: Path, **arrays: np.ndarray) -> str:
    """What is said of a file of these arrays."""
    if path.suffix == ".mat":
        savemat(path, arrays)
    else:
        np.savez(path, **arrays)
    with pytest.raises(InputError) as told:
        read_array(path, Timing())
    assert "idtracker" not in str(told.value)
    return str(told.value)


@pytest.mark.parametrize("order", [(1, 2, 0), (2, 1, 0), (2, 0, 1), (0, 2, 1)])
def test_arrays_in_another_order_are_refused_with_the_one_line_that_turns_them(tmp_path, order):
    time, points = swimmer()
    turned = points.transpose(order)
    said = refusal(tmp_path / "m.npz", t_s=time, points=turned)
    assert f"`points` {turned.shape}" in said
    cure = said.partition("Save `points.transpose(")[2].partition(")")[0]
    np.savez(tmp_path / "m.npz", t_s=time, points=turned.transpose([int(axis) for axis in cure.split(", ")]))
    np.testing.assert_array_equal(read_array(tmp_path / "m.npz", Timing()).floor, points)
    said = refusal(tmp_path / "m.mat", t_s=time, points=turned)
    assert f"permute(points, [{' '.join(str(int(axis) + 1) for axis in cure.split(', '))}])" in said


def test_frames_in_columns_points_in_space_and_structures_are_told_as_what_they_are(tmp_path):
    time, points = swimmer()
    across = refusal(tmp_path / "m.mat", t_s=time, x=points[..., 0].T, y=points[..., 1].T)
    assert "has 100 times for 6 frames of 100 points" in across
    assert "Save `x` and `y`, transposed." in across
    assert "Save `points.transpose(1, 0, 2)`." in refusal(tmp_path / "m.npz", t_s=time, points=points.swapaxes(0, 1))
    space = np.concatenate([points, points[..., :1]], axis=2)
    assert "`points[:, :, :2]`" in refusal(tmp_path / "m.npz", t_s=time, points=space)
    within = refusal(tmp_path / "m.mat", worm={"t_s": time, "x": points[..., 0], "y": points[..., 1]}, rate=RATE)
    assert "it has `worm` (struct: t_s, x, y), `rate` (1, 1)" in within
    assert "t_s = worm.t_s; x = worm.x; y = worm.y; save('m.mat', 't_s', 'x', 'y', '-v7')" in within


def test_points_that_numpy_saved_alone_need_a_frame_rate(tmp_path):
    time, points = swimmer()
    np.save(tmp_path / "m.npy", points)
    np.testing.assert_array_equal(read_array(tmp_path / "m.npy", Timing(RATE)).floor, points)
    with pytest.raises(InputError, match="give `frames_per_second`"):
        read_array(tmp_path / "m.npy", Timing())
    np.savez(tmp_path / "m.npz", t_s=time, points=points.transpose(1, 0, 2))
    with pytest.raises(InputError, match="has 100 times for 6 frames of 100 points"):
        read_array(tmp_path / "m.npz", Timing())


def test_points_of_deeplabcut_in_space_are_no_pixels(tmp_path):
    time, points = swimmer()
    deeplabcut_csv(tmp_path / "m.csv", time, points)
    (tmp_path / "m.csv").write_text((tmp_path / "m.csv").read_text().replace("likelihood", "z"))
    with pytest.raises(InputError, match=r"has points in space \(`z`\)"):
        read_deeplabcut(tmp_path / "m.csv", Timing(RATE))
