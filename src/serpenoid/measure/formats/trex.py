"""Files of TRex: midlines (`*_posture_*.npz`) and points of the body in tracking data (`*_id0.npz`, `.csv`).

Layout: TRex, docs/formats.rst, "Posture-data" and "Positional Data". A midline runs from head to tail in image
coordinates (pixels, y down), seen from `offset`; `midline_points` is (F, N, 2), or (sum of `midline_lengths`, 2) where
frames differ in length: those are spaced anew, evenly along the midline. `midline_centimeters` over the same length in
pixels is TRex's own scale, used only where `length_unit = "cm"` asks for it: without a calibration TRex assumes a width
of 30 cm. Tracking data hold `poseX0, poseY0, ...` [px] where a key-point model ran; `inf` is what was not found.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats, block, read_rows
from serpenoid.measure.formats.arrays import read_npz
from serpenoid.measure.formats.trackers import Timing, as_tracks
from serpenoid.measure.tracks import DOWN, Tracks, no_time

POSE = re.compile(r"poseX(\d+)$")
NOT_POINTS = (
    "holds neither midlines (`midline_points`) nor points of the body (`poseX0`, `poseY0`, ...). "
    "Export with `output_posture_data = true` and name the file `*_posture_*.npz`?"
)


def read_trex(path: str | Path, timing: Timing) -> Tracks:
    """Midlines of a posture file, head first, or the key points of tracking data in the order of their numbers."""
    path = Path(path)
    arrays = _csv(path) if path.suffix.lower() == ".csv" else read_npz(path)
    if "midline_points" in arrays:
        return _midlines(path, arrays, timing)
    points = _key_points(path, arrays)
    times = arrays["time"] if "time" in arrays else _frames(path, arrays, "frame") / _rate(path, timing)
    there = np.isfinite(times)
    return as_tracks(path, times[there], points[there] * DOWN, timing.length_unit or "px")


def _midlines(path: Path, arrays: dict[str, Floats], timing: Timing) -> Tracks:
    frames, points = _frames(path, arrays, "frames"), arrays["midline_points"]
    if points.ndim == 2:
        points = _evenly(path, points, arrays.get("midline_lengths"), len(frames))
    offset = arrays.get("offset")
    if points.ndim != 3 or points.shape[::2] != (len(frames), 2) or offset is None or offset.shape != (len(frames), 2):
        raise InputError(
            f"{path}: `midline_points` must be (frames, points, 2) and `offset` (frames, 2), "
            f"got {points.shape} and {None if offset is None else offset.shape} for {len(frames)} frames."
        )
    points = (points + offset[:, None]) * DOWN
    unit = timing.length_unit or "px"
    if unit == "cm":
        points = points * _centimetres(path, points, arrays)
    return as_tracks(path, frames / _rate(path, timing), points, unit)


def _evenly(path: Path, points: Floats, lengths: Floats | None, frames: int) -> Floats:
    """Midlines of several lengths, laid end to end, as (F, N, 2): N is the commonest length."""
    counts = np.zeros(0, int) if lengths is None else lengths.ravel().astype(int)
    if len(counts) != frames or counts.sum() != len(points) or (counts < 2).any():
        raise InputError(f"{path}: `midline_lengths` must give every frame's share of {len(points)} midline points.")
    count = int(np.bincount(counts).argmax())
    return np.stack([_spaced(line, count) for line in np.split(points, np.cumsum(counts)[:-1])])


def _spaced(line: Floats, count: int) -> Floats:
    """(n, 2) -> (count, 2), evenly along the line."""
    if len(line) == count:
        return line
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    return np.stack([np.interp(np.linspace(0, along[-1], count), along, axis) for axis in line.T], axis=1)


def _centimetres(path: Path, points: Floats, arrays: dict[str, Floats]) -> float:
    """Centimetres a pixel: the median over frames of the stated length over the length in pixels."""
    stated = arrays.get("midline_centimeters")
    if stated is None or stated.size != len(points):
        raise InputError(f"{path}: holds no `midline_centimeters`; give another `length_unit`, or leave it out for px.")
    length = np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        scales = stated.ravel() / length
    scales = scales[np.isfinite(scales) & (scales > 0)]
    if not scales.size:
        raise InputError(f"{path}: `midline_centimeters` tells no scale: no midline has a length.")
    return float(np.median(scales))


def _key_points(path: Path, arrays: dict[str, Floats]) -> Floats:
    numbers = sorted(int(found[1]) for name in arrays if (found := POSE.match(name)))
    pairs = [(arrays[f"poseX{k}"], arrays.get(f"poseY{k}")) for k in numbers]
    if not pairs or any(y is None or x.shape != y.shape or x.ndim != 1 for x, y in pairs):
        raise InputError(f"{path}: {NOT_POINTS}")
    points = np.stack([np.stack([x, y], axis=-1) for x, y in pairs if y is not None], axis=1)
    return np.where(np.isfinite(points), points, np.nan)


def _csv(path: Path) -> dict[str, Floats]:
    """Columns by name; text (`inf`) and empty cells are what was not found."""
    rows = read_rows(path)
    header = [cell.strip() for cell in rows[0]]
    wanted = [i for i, name in enumerate(header) if name in ("frame", "time") or re.match(r"pose[XY]\d+$", name)]
    plain = [[cell if cell.strip().lower() not in ("inf", "-inf", "nan") else "" for cell in row] for row in rows]
    data = block(plain, 1, wanted, [header[i] for i in wanted], path)
    return {header[i]: column for i, column in zip(wanted, data.T, strict=True)}


def _frames(path: Path, arrays: dict[str, Floats], name: str) -> Floats:
    if name not in arrays:
        raise InputError(f"{path}: holds no `{name}`: not an export of TRex. It has {', '.join(list(arrays)[:8])}.")
    return arrays[name].ravel()


def _rate(path: Path, timing: Timing) -> float:
    if not timing.frames_per_second:
        raise no_time(path, "counts frames")
    return timing.frames_per_second
