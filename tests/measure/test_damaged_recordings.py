"""Recordings with damaged files, single points far astray, holes in time, and numbers that are no measurement."""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.measure.animals.beat import sines_about
from serpenoid.measure.clock import find_offset
from serpenoid.measure.formats.arrays import read_array
from serpenoid.measure.formats.trackers import Timing, read_sleap_analysis
from serpenoid.measure.formats.wcon import read_wcon
from serpenoid.measure.load import load_campaign
from serpenoid.measure.shapes.chain import estimate_chain
from serpenoid.measure.shapes.lengths import usual, without_noise
from serpenoid.measure.shapes.smooth import cross_validated, smooth, smoother
from serpenoid.measure.tracks import Tracks

WORM = Body(vertices=6, kind="crawler")
TIME = np.arange(160) / 20


def worm(noise: float = 1e-4) -> np.ndarray:
    """Points (F, 6, 2) of a body of five equal edges, a unit long together, that bends as it moves along x."""
    angle = 0.5 * np.sin(2 * np.pi * (TIME[:, None] / 2 + (np.arange(5) + 0.5) / 5))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2) / 5
    points = np.concatenate([np.zeros((len(TIME), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    points[..., 0] += 0.1 * TIME[:, None]
    return points + noise * np.random.default_rng(0).normal(size=points.shape)


@pytest.mark.parametrize("size", [1.0, 10.0, 1e4])
def test_points_far_astray_do_not_stretch_the_body(size: float) -> None:
    rng, points = np.random.default_rng(1), worm()
    whole = usual(without_noise(WORM, TIME, points))
    for frame in rng.choice(len(TIME), 16, replace=False):
        points[frame, rng.integers(6)] += size * rng.normal(size=2)
    found = usual(without_noise(WORM, TIME, points))
    assert found == pytest.approx(whole, rel=0.005)  # the scatter of a tenth fewer frames; before: up to thousands


def test_no_window_smooths_across_a_hole() -> None:
    time = np.where(TIME < 4, TIME, TIME + 1e6)
    values = np.sin(TIME)[:, None]
    beyond = np.where(TIME < 4, 0.0, 1e3)[:, None]  # elsewhere after the hole
    for window in (1, 9, 49):
        by = smoother(time, window)
        assert smooth(values + beyond, *by) - beyond == pytest.approx(smooth(values, *by), abs=1e-9)
        assert smooth(values, *by) == pytest.approx(values, abs=0.02)  # what a cubic misses in 49 rows
    best = cross_validated(time, values)
    assert best is not None
    assert cross_validated(np.array([0.0, 1, 1e5, 1e5 + 1, 2e5, 2e5 + 1, 3e5]), np.zeros((7, 1))) is not None


def test_a_window_in_a_hole_has_no_sines() -> None:
    found = sines_about(np.array([0.0, 1.0]), np.ones((2, 1)), np.array([500.0]), 10.0)
    assert not found.amplitudes.any()


def test_edges_that_differ_a_thousandfold_are_fitted() -> None:
    body = Body(vertices=6, kind="crawler", edge_lengths=(0.53, 0.46, 0.0007, 0.0007, 0.0007))
    points = worm()
    points[:, 1, 0] = -50.0
    assert estimate_chain(body, points).poses.shape == (len(TIME), 3)


def test_logs_whose_clock_leaps_by_days_are_not_laid_over_a_film() -> None:
    wave = np.sin(TIME)[:, None]
    assert find_offset(TIME, wave, np.where(TIME < 4, TIME, TIME + 1e6), wave) is None


@pytest.mark.parametrize(
    ("time", "points", "said"),
    [
        (TIME, 1e30 * worm(), "which is no measurement"),
        (TIME * 1e-12, worm(), "frames 1 and 2 are less than 1e-08 s apart, which no camera is"),
    ],
)
def test_what_no_camera_sees_is_refused(time: np.ndarray, points: np.ndarray, said: str) -> None:
    with pytest.raises(InputError, match=said):
        Tracks(time, tuple("abcdef"), points, "film", (False,) * 6)


def test_lengths_that_no_body_has_are_named_with_their_campaign(tmp_path: Path) -> None:
    rows = [
        ",".join(map(repr, [t, *p]))
        for t, p in zip(TIME.tolist(), (1e9 * worm()).reshape(160, -1).tolist(), strict=True)
    ]
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(6))
    (tmp_path / "film.csv").write_text("\n".join([header, *rows]) + "\n")
    (tmp_path / "campaign.toml").write_text(
        'format = 1\nname = "w"\n[body]\nvertices = 6\nkind = "crawler"\n[motion]\nformat = "tidy"\n'
        '[[trial]]\nname = "w"\nmotion = "film.csv"\n'
    )
    with pytest.raises(InputError, match=rf"{tmp_path.name}: \[body\] has no lengths, and by its points an edge is"):
        load_campaign(tmp_path)


def _header(shape: tuple[int, ...]) -> bytes:
    stream = io.BytesIO()
    np.lib.format.write_array_header_1_0(stream, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return stream.getvalue()


def _damaged(path: Path) -> None:
    """Packed, with bytes changed amid what is packed: what breaks is zlib."""
    np.savez_compressed(path, points=worm(), t_s=TIME)
    data = bytearray(path.read_bytes())
    data[500:508] = b"\xff" * 8
    path.write_bytes(data)


def _bomb(path: Path) -> None:
    with (
        zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file,
        file.open("points.npy", "w", force_zip64=True) as stream,
    ):
        stream.write(_header((10**9, 6, 2)) + bytes(1000))


def _words(path: Path) -> None:
    np.savez(path, points=worm(), t_s=TIME, author=np.array(["a word"]))


@pytest.mark.parametrize("make", [_damaged, _bomb, _words, lambda path: os.mkfifo(path), lambda path: path.mkdir()])
def test_broken_files_of_numbers_are_refused_by_name(make: Callable[[Path], None], tmp_path: Path) -> None:
    make(tmp_path / "film.npz")
    with pytest.raises(InputError, match=r"film\.npz: (not a readable NumPy file: |is a )"):
        read_array(tmp_path / "film.npz", Timing())


def test_an_array_may_have_any_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "film.npz", points=worm(), t_s=TIME)
    with zipfile.ZipFile(tmp_path / "film.npz", "a") as file:
        file.writestr("file.npy", _header((1,)) + bytes(8))
    assert read_array(tmp_path / "film.npz", Timing()).floor == pytest.approx(worm())


@pytest.mark.parametrize(
    ("tracks", "said"),
    [
        (None, "`/tracks` is a group"),
        ((1, 2, 6, 10**9), r"`/tracks` says that it holds 1\.2e\+10 numbers"),
        ("words", "not a readable HDF5 file"),
    ],
)
def test_data_sets_that_cannot_be_tracks_are_refused(tracks: object, said: str, tmp_path: Path) -> None:
    with h5py.File(tmp_path / "film.h5", "w") as file:
        file["node_names"] = np.array(list("abcdef"), dtype="S")
        if tracks is None:
            file.create_group("tracks")
        elif isinstance(tracks, tuple):
            file.create_dataset("tracks", shape=tracks, dtype="f8", chunks=(1, 2, 6, 1000), compression="gzip")
        else:
            file["tracks"] = np.array([b"x"])
    with pytest.raises(InputError, match=rf"film\.h5: {said}"):
        read_sleap_analysis(tmp_path / "film.h5", Timing(frames_per_second=20.0))


@pytest.mark.parametrize("make", ["pipe", "long"])
def test_a_midline_file_that_is_none_is_refused(make: str, tmp_path: Path) -> None:
    path = tmp_path / "film.wcon"
    if make == "pipe":
        os.mkfifo(path)
    else:  # an integer beyond all floating-point numbers
        entry = {"id": "1", "t": [10**400, 1], "x": [[0, 1]] * 2, "y": [[0, 1]] * 2}
        path.write_text(json.dumps({"units": {"t": "s", "x": "mm", "y": "mm"}, "data": [entry]}))
    with pytest.raises(InputError, match=r"film\.wcon: "):
        read_wcon(path, Timing())
