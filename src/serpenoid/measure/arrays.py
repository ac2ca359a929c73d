"""Plain arrays of points: .npz and .npy of NumPy, .mat of MATLAB. What is refused is told with its shape and a cure."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.inputs import RECORDING_BYTES, read_bytes
from serpenoid.measure.cells import Floats
from serpenoid.measure.child import MAT_ARRAYS, read_in_child
from serpenoid.measure.matlab import OF_IDTRACKER, TRAJECTORIES, read_mat
from serpenoid.measure.trackers import Timing, as_tracks
from serpenoid.measure.tracks import Tracks, no_time, upright

AXES = 3
STRUCTURE = re.compile(r"`(.*)` \(struct: (.*)\)")


def read_array(path: str | Path, timing: Timing) -> Tracks:
    """An .npz or .mat with `points` (F, N, 2), or `x` and `y` (F, N); `t_s` (F,), or `frame` and a frame rate; an .npy
    with points alone."""
    path = Path(path)
    by_matlab = path.suffix.lower() == ".mat"
    arrays, others = read_mat(path) if by_matlab else (read_npz(path), [])
    points, apart = arrays.get("points"), "points" not in arrays
    if apart and {"x", "y"} <= set(arrays) and arrays["x"].shape == arrays["y"].shape:
        points = np.stack([arrays["x"], arrays["y"]], axis=-1)
    clock = next((arrays[name].ravel() for name in ("t_s", "frame") if name in arrays), None)
    if points is None or points.ndim != AXES or points.shape[2] != 2:
        there = [f"`{name}` {_shape(array)}" for name, array in arrays.items()] + others
        cure = "" if points is None else _cure(points.shape, None if clock is None else clock.size, by_matlab)
        group = f" {OF_IDTRACKER}" if any(TRAJECTORIES in said for said in there) else ""
        raise InputError(
            f"{path}: needs `points` (F, N, 2), or `x` and `y` (F, N), of F frames and N points; it has "
            f"{', '.join(there) or 'neither'}.{cure}{_of_structures(others, path)}{group}"
        )
    if clock is not None and clock.size == points.shape[1] != len(points):
        turned = "`x` and `y`, transposed" if apart else f"`{_permuted((1, 0, 2), by_matlab)}`"
        raise InputError(
            f"{path}: has {clock.size} times for {len(points)} frames of {points.shape[1]} points. Are its points in "
            f"rows, and its frames in columns? Save {turned}."
        )
    if "t_s" in arrays:
        times = arrays["t_s"].ravel()
    elif timing.frames_per_second:
        times = (np.arange(len(points), dtype=float) if clock is None else clock) / timing.frames_per_second
    else:
        raise no_time(path, "has no `t_s`")
    unit = timing.length_unit or "m"
    return as_tracks(path, times, upright(points, unit), unit)


def read_npz(path: Path) -> dict[str, Floats]:
    """All arrays of an .npz, which must be numbers; the one of an .npy is `points`."""
    data = read_bytes(path, RECORDING_BYTES)
    try:
        return read_in_child("NumPy", path, len(data))
    except InputError as error:
        group = "pickle" in str(error) and TRAJECTORIES.encode() in data
        raise InputError(f"{error} {OF_IDTRACKER}" if group else str(error)) from None


def _shape(array: Floats) -> str:
    """As people write it: (401, 13, 2)."""
    return f"({', '.join(map(str, array.shape))})"


def _cure(shape: tuple[int, ...], frames: int | None, by_matlab: bool) -> str:
    """What makes points of such a shape (F, N, 2), where that can be told."""
    if len(shape) != AXES:
        return ""
    axes = [axis for axis in range(AXES) if shape[axis] == 2]
    if not axes and shape[2] == AXES:
        plane = "points(:, :, 1:2)" if by_matlab else "points[:, :, :2]"
        return f" Of points in space, save what is on the floor, two of three columns: `{plane}`, if z points up."
    if len(axes) != 1:
        return ""
    first, second = (axis for axis in range(AXES) if axis != axes[0])
    if shape[second] == frames or (frames is None and shape[second] > shape[first]):
        first, second = second, first
    return f" Save `{_permuted((first, second, axes[0]), by_matlab)}`."


def _permuted(order: tuple[int, ...], by_matlab: bool) -> str:
    """Points with their axes in another order, in the language of the file."""
    if by_matlab:
        return f"permute(points, [{' '.join(str(axis + 1) for axis in order)}])"
    return f"points.transpose({', '.join(map(str, order))})"


def _of_structures(others: list[str], path: Path) -> str:
    """How arrays come out of a structure of MATLAB, if one is there."""
    found = next(filter(None, map(STRUCTURE.fullmatch, others)), None)
    if found is None:
        return ""
    name, fields = found[1], found[2].split(", ")
    known = [field for field in MAT_ARRAYS if field in fields]
    taken = " ".join(f"{field} = {name}.{field};" for field in known) or f"points = {name}.FIELD; t_s = {name}.FIELD;"
    saved = ", ".join(f"'{field}'" for field in known or ("points", "t_s"))
    return f" Arrays within a structure are not read: in MATLAB `{taken} save('{path.name}', {saved}, '-v7')`."
