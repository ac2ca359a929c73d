"""Files of animal trackers: DeepLabCut (CSV, HDF5), SLEAP analysis and Tierpsy (HDF5).

All of them give points in the order of the file; image coordinates (pixels, y down) are turned up. HDF5 needs h5py
(`pip install 'serpenoid[hdf5]'`). Points whose score is below `minimum_score` count as hidden.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats, block, increasing_times, read_rows
from serpenoid.measure.formats.hdf5_files import hdf5, is_hdf5, require, texts, whole
from serpenoid.measure.formats.individuals import chosen
from serpenoid.measure.formats.pandas_table import read_pandas
from serpenoid.measure.formats.scores import sure
from serpenoid.measure.tracks import DOWN, METRES, End, Tracks, no_time
from serpenoid.wording import counted

LIKELY = 0.6  # DeepLabCut's own default of what it shows


@dataclass(frozen=True)
class Timing:
    """What [motion] says beside the file: frames a second, length unit, least score, whose points; None: the format's
    default."""

    frames_per_second: float | None = None
    length_unit: str | None = None
    minimum_score: float | None = None
    individual: str | None = None


def read_deeplabcut(path: str | Path, timing: Timing) -> Tracks:
    """Rows `scorer`, (`individuals`), `bodyparts`, `coords`, then frames; or the same table in HDF5."""
    path = Path(path)
    if is_hdf5(path):
        columns, frames, data = read_pandas(path)
    else:
        columns, frames, data = _deeplabcut_csv(path)
    individual = chosen([c[-3] for c in columns if len(c) == 4], timing.individual, path)
    own = [i for i, c in enumerate(columns) if len(c) < 4 or c[-3] == individual]
    columns, data = [columns[i] for i in own], data[:, own]
    names = list(dict.fromkeys(c[-2] for c in columns))
    slot = {c[-2:]: i for i, c in enumerate(columns)}
    missing = next((f"{n}, {part}" for n in names for part in ("x", "y") if (n, part) not in slot), None)
    if missing is not None:
        raise InputError(f"{path}: no column for {missing}: not a DeepLabCut table of points in the plane.")
    if any(part == "z" for _, part in slot):
        raise InputError(
            f"{path}: has points in space (`z`), whose unit and upward axis it does not say. Write x and y on "
            'the floor to a table of `format = "tidy"`.'
        )
    floor = np.stack([data[:, [slot[n, "x"], slot[n, "y"]]] for n in names], axis=1)
    if all((n, "likelihood") in slot for n in names):
        score = np.stack([data[:, slot[n, "likelihood"]] for n in names], axis=1)
        floor = sure(floor, score, LIKELY if timing.minimum_score is None else timing.minimum_score, path)
    return as_image(path, frames, names, floor, timing)


def _deeplabcut_csv(path: Path) -> tuple[list[tuple[str, ...]], Floats, Floats]:
    rows = read_rows(path)
    heads = next((i for i, row in enumerate(rows[:6]) if row and row[0].strip() == "coords"), None)
    if heads is None or rows[0][0].strip() != "scorer":
        raise InputError(f"{path}: row 1: a DeepLabCut CSV has rows `scorer`, `bodyparts`, `coords` first.")
    width = len(rows[heads])
    if any(len(row) != width for row in rows[:heads]):
        raise InputError(f"{path}: its header rows differ in length. Was the file edited?")
    columns = [tuple(rows[r][c].strip() for r in range(heads + 1)) for c in range(1, width)]
    data = block(rows, heads + 1, range(width), ["frame", *(", ".join(c[-2:]) for c in columns)], path)
    return columns, increasing_times(data[:, 0], heads + 1, 0, path, "frame"), data[:, 1:]


def read_sleap_analysis(path: str | Path, timing: Timing) -> Tracks:
    """`tracks` (instances, 2, nodes, frames), `node_names`, `point_scores`: SLEAP's analysis HDF5."""
    path = Path(path)
    with hdf5(path) as file:
        require(file, path, "SLEAP analysis", "tracks", "node_names")
        names = texts(file["node_names"], path)
        tracks = np.asarray(whole(file["tracks"], path), float)
        scores = np.asarray(whole(file["point_scores"], path), float) if "point_scores" in file else None
        tracked = texts(file["track_names"], path) if "track_names" in file else []
    if tracks.ndim != 4 or tracks.shape[1:3] != (2, len(names)):
        raise InputError(f"{path}: `tracks` must be (animals, 2, {len(names)}, frames), got {tracks.shape}.")
    tracked = tracked if len(tracked) == len(tracks) else [str(k) for k in range(len(tracks))]
    own = tracked.index(chosen(tracked, timing.individual, path)) if len(tracks) else 0
    floor = tracks[own].transpose(2, 1, 0).copy()
    if scores is not None and timing.minimum_score is not None:
        floor = sure(floor, scores[own].T, timing.minimum_score, path)
    return as_image(path, np.arange(len(floor), dtype=float), names, floor, timing)


def read_tierpsy(path: str | Path, timing: Timing) -> Tracks:
    """`coordinates/skeletons` (F, points, 2) [um] of a features file, head first; one worm."""
    path = Path(path)
    with hdf5(path) as file:
        require(file, path, "Tierpsy features", "coordinates/skeletons")
        skeletons = np.asarray(whole(file["coordinates/skeletons"], path), float)
        frames = np.arange(len(skeletons), dtype=float)
        rate = timing.frames_per_second
        if "timeseries_data" in file and file["timeseries_data"].dtype.names:
            table = file["timeseries_data"]
            said = (file[name].attrs.get("fps") for name in ("timeseries_data", "trajectories_data") if name in file)
            rate = rate or _number(next((each for each in said if each is not None), None))
            every = len(table) == len(frames)
            if "timestamp" in table.dtype.names and every:
                frames = np.asarray(table["timestamp"], float)
            if "worm_index" in table.dtype.names:
                worms = np.char.mod("%d", table["worm_index"])
                own = worms == chosen(worms.tolist(), timing.individual, path)
                if every:
                    skeletons, frames = skeletons[own], frames[own]
                elif not own.all():
                    raise InputError(
                        f"{path}: {counted(len(table), 'row')} of `timeseries_data` for {len(frames)} skeletons."
                    )
    if skeletons.ndim != 3 or skeletons.shape[2] != 2:
        raise InputError(f"{path}: `coordinates/skeletons` must be (frames, points, 2), got {skeletons.shape}.")
    if not rate:
        raise no_time(path, "does not say how many frames a second")
    return as_tracks(path, frames / rate, skeletons * DOWN, timing.length_unit or "um")


def as_image(path: Path, frames: Floats, names: Sequence[str], floor: Floats, timing: Timing) -> Tracks:
    """Pixels and frame numbers as tracks."""
    if not timing.frames_per_second:
        raise no_time(path, "carries no time")
    unit = timing.length_unit or "px"
    return as_named(path, frames / timing.frames_per_second, names, floor * DOWN, unit)


def as_tracks(path: Path, times: Floats, floor: Floats, unit: str, first: End | None = None) -> Tracks:
    """Points in the order of the file (F, N, 2), in `unit`, as Tracks; first: which end it says its first point is."""
    found = as_named(path, times, [f"point_{k}" for k in range(floor.shape[1])], floor, unit)
    return replace(found, first_point=first)


def as_named(path: Path, times: Floats, names: Sequence[str], floor: Floats, unit: str) -> Tracks:
    """Named points (F, N, 2) in `unit`, y up, as Tracks. Raises InputError where times (F,) do not increase."""
    if times.shape != (len(floor),):
        raise InputError(
            f"{path}: has {counted(times.size, 'time')} for {counted(len(floor), 'frame')} of {floor.shape[1]} points."
        )
    if not np.isfinite(times).all() or (np.diff(times) <= 0).any():
        raise InputError(f"{path}: times must increase, one for every frame.")
    if np.isinf(floor).any():
        raise InputError(f"{path}: positions must be finite or empty.")
    floor = np.where(np.isfinite(floor).all(axis=2, keepdims=True), floor, np.nan)
    return Tracks(times, tuple(names), floor * METRES[unit], str(path), (False,) * len(names), unit != "px")


def _number(value: Any) -> float | None:
    return None if value is None else float(value)
