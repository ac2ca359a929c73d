"""Plain arrays of points: .npz and .npy of NumPy, .mat of MATLAB. What is refused is told with its shape and a cure."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.inputs import MATLAB, RECORDING_BYTES, begins, read_bytes
from serpenoid.measure.cells import Floats
from serpenoid.measure.formats.child import MAT_ARRAYS, read_in_child
from serpenoid.measure.formats.matlab import OF_IDTRACKER, TRAJECTORIES, read_mat
from serpenoid.measure.formats.trackers import Timing, as_tracks
from serpenoid.measure.tracks import Tracks, no_time, upright

AXES = 3
LEAST = 4  # frames and points, from which they can be told apart
UNLIKE = 4.0  # times as much do distances vary that are no edges of a body
KEPT = ", whose distances stay the same from frame to frame far better if frames are points"
STRUCTURE = re.compile(r"`(.*)` \(struct: (.*)\)")
CELL = re.compile(r"`(.*)` \(cell of .*\)")
ARRAY = re.compile(r"`(\w+)` \((\d+(?:, \d+)*)\)")
COMPLEX = re.compile(r"`(.*)` \(complex, .*\)")


def read_array(path: str | Path, timing: Timing) -> Tracks:
    """An .npz or .mat with `points` (F, N, 2), or `x` and `y` (F, N); `t_s` (F,), or `frame` and a frame rate; an .npy
    with points alone."""
    path = Path(path)
    by_matlab = path.suffix.lower() == ".mat" or begins(path, MATLAB)
    arrays, others = read_mat(path) if by_matlab else (read_npz(path), [])
    points, apart = arrays.get("points"), "points" not in arrays
    if apart and {"x", "y"} <= set(arrays) and arrays["x"].shape == arrays["y"].shape:
        points = np.stack([arrays["x"], arrays["y"]], axis=-1)
    clock = next((arrays[name].ravel() for name in ("t_s", "frame") if name in arrays), None)
    if points is None or points.ndim != AXES or points.shape[2] != 2:
        there = [f"`{name}` {_shape(array)}" for name, array in arrays.items()] + others
        cure = (
            _renamed(there, path, by_matlab)
            if points is None
            else _cure(points.shape, None if clock is None else clock.size, by_matlab)
        )
        group = f" {OF_IDTRACKER}" if any(TRAJECTORIES in said for said in there) else ""
        raise InputError(
            f"{path}: needs `points` (F, N, 2), or `x` and `y` (F, N), of F frames and N points; it has "
            f"{', '.join(there) or 'neither'}.{cure}{_of_others(others, path)}{group}"
        )
    told = clock is not None and clock.size == points.shape[1] != len(points)
    if told or (clock is None and _turned(points)):
        turned = "`x` and `y`, transposed" if apart else f"`{_permuted((1, 0, 2), by_matlab)}`"
        raise InputError(
            f"{path}: has {f'{clock.size} times for ' if clock is not None else ''}{len(points)} frames of "
            f"{points.shape[1]} points{'' if told else KEPT}. Are its points in rows, and its frames in columns? Save "
            f"{turned}."
        )
    if "t_s" in arrays:
        times = arrays["t_s"].ravel()
    elif timing.frames_per_second:
        times = (np.arange(len(points), dtype=float) if clock is None else clock) / timing.frames_per_second
    else:
        raise no_time(path, "has no `t_s`")
    unit = timing.length_unit or "m"
    return as_tracks(path, times, upright(points, unit), unit)


def _turned(points: Floats) -> bool:
    """Whether steps from frame to frame of points (F, N, 2) are alike as the edges of a body are, and its edges not."""
    if min(points.shape[:2]) < LEAST:
        return False
    varied = []
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(points, axis=1 - axis), axis=2)
        steps = steps[:, np.isfinite(steps).all(axis=0)] if axis == 0 else steps[np.isfinite(steps).all(axis=1)].T
        varied.append(float(np.median(steps.std(axis=0) / np.maximum(steps.mean(axis=0), 1e-300))) if steps.size else 0)
    return 0 < varied[1] < varied[0] / UNLIKE


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


def _renamed(there: Sequence[str], path: Path, by_matlab: bool) -> str:
    """How the one array that may be points becomes `points`, where that can be told."""
    found = [(named[1], tuple(map(int, named[2].split(", ")))) for said in there if (named := ARRAY.fullmatch(said))]
    likely = [(name, shape) for name, shape in found if len(shape) == AXES and sum(n == 2 for n in shape) == 1]
    if len(likely) != 1:
        return ""
    name, shape = likely[0]
    pair = shape.index(2)
    fewer, more = sorted((axis for axis in range(AXES) if axis != pair), key=lambda axis: shape[axis])
    axes = _permuted((more, fewer, pair), by_matlab).replace("points", name)
    if by_matlab:
        return f" Is that `{name}`? In MATLAB `points = {axes}; {_saved(path, ('points', 't_s'))}`."
    return f" Is that `{name}`? Save `points={axes}`."


def _permuted(order: tuple[int, ...], by_matlab: bool) -> str:
    """Points with their axes in another order, in the language of the file."""
    if by_matlab:
        return f"permute(points, [{' '.join(str(axis + 1) for axis in order)}])"
    return f"points.transpose({', '.join(map(str, order))})"


def _of_others(others: list[str], path: Path) -> str:
    """How arrays come out of a structure, a cell or complex numbers of MATLAB, if there are such."""
    for said in others:
        if found := STRUCTURE.fullmatch(said):
            return _of_structure(found[1], found[2].split(", "), path)
        if found := CELL.fullmatch(said):
            made = f"points = permute(cat(3, {found[1]}{{:}}), [3 1 2]);"
            return f" Cells are not read; of one (N, 2) a frame, in MATLAB `{made} {_saved(path, ('points', 't_s'))}`."
        if found := COMPLEX.fullmatch(said):
            made = f"x = real({found[1]}); y = imag({found[1]});"
            return f" Complex numbers are not read: in MATLAB `{made} {_saved(path, ('x', 'y', 't_s'))}`."
    return ""


def _of_structure(name: str, fields: list[str], path: Path) -> str:
    if "Trajectories" in fields:
        return ' Is it an export of QTM? Then `format = "qualisys"`; of MATLAB\'s -v7.3 take TSV or C3D.'
    known = [field for field in MAT_ARRAYS if field in fields]
    taken = " ".join(f"{field} = {name}.{field};" for field in known) or f"points = {name}.FIELD; t_s = {name}.FIELD;"
    return f" Arrays within a structure are not read: in MATLAB `{taken} {_saved(path, known or ('points', 't_s'))}`."


def _saved(path: Path, names: Sequence[str]) -> str:
    quoted = ", ".join(f"'{name}'" for name in names)
    return f"save('{path.name}', {quoted}, '-v7')"
