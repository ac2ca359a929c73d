"""Tables of tracked points: tidy CSV, long CSV with a column mapping, SLEAP CSV, C3D."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats, Rows, block, column_letter, increasing_times, place, read_rows
from serpenoid.measure.tracks import METRES, Tracks, floor_plane


def read_tidy(path: str | Path, length_unit: str = "m", frames_per_second: float | None = None) -> Tracks:
    """`t_s,x_0,y_0,x_1,y_1,...`, or `frame` for `t_s`; vertex 0 = tail; an empty cell is a hidden marker."""
    path = Path(path)
    rows = read_rows(path)
    header = [cell.strip() for cell in rows[0]]
    count = (len(header) - 1) // 2
    clock = "frame" if header[0] == "frame" else "t_s"
    if clock == "frame" and not frames_per_second:
        raise InputError(f"{path}: counts frames: give `frames_per_second` in [motion].")
    expected = [clock] + [f"{axis}_{k}" for k in range(count) for axis in "xy"]
    for column, (got, want) in enumerate(zip(header, expected, strict=False)):
        if got != want:
            raise InputError(f"{place(path, 0, column)}: a tidy file has `{want}` here, got {got!r}.")
    if count < 1 or len(header) != len(expected):
        raise InputError(f"{path}: row 1: a tidy file has `t_s,x_0,y_0,...` in pairs, got {len(header)} columns.")
    data = block(rows, 1, range(len(header)), header, path)
    times = increasing_times(data[:, 0], 1, 0, path, clock) / (float(frames_per_second or 1) if clock == "frame" else 1)
    floor = data[:, 1:].reshape(len(data), count, 2)
    return _tracks(times, [f"vertex_{k}" for k in range(count)], floor, length_unit, path)


def read_long(
    path: str | Path, columns: dict[str, str], length_unit: str, frames_per_second: float | None = None
) -> Tracks:
    """One row per frame and point. `columns` maps time, frame, point, x, y to the file's own names (time or frame)."""
    path = Path(path)
    rows = read_rows(path)
    header = [cell.strip() for cell in rows[0]]
    for role, name in columns.items():
        if name not in header:
            raise InputError(f"{path}: row 1: no column `{name}` (for `{role}`); it has {', '.join(header)}.")
    clock = "time" if "time" in columns else "frame"
    if clock == "frame" and not frames_per_second:
        raise InputError(f"{path}: has no time column: give `frames_per_second` in [motion].")
    roles = [clock, "point", "x", "y"]
    where = [header.index(columns[role]) for role in roles]
    data = block(rows, 1, where, [columns[role] for role in roles], path)
    _refuse_empty(data[:, :2], where, rows, path)
    stamps, frame = np.unique(data[:, 0], return_inverse=True)
    points, slot = np.unique(data[:, 1], return_inverse=True)
    taken, again = np.unique(frame * len(points) + slot, return_index=True)
    if len(taken) != len(data):
        row = int(np.setdiff1d(np.arange(len(data)), again)[0])
        raise InputError(f"{place(path, row + 1, where[1], columns['point'])}: this point is twice in one frame.")
    floor = np.full((len(stamps), len(points), 2), np.nan)
    floor[frame, slot] = data[:, 2:]
    times = stamps if clock == "time" else stamps / float(frames_per_second or 1)
    return _tracks(times, [f"point_{k:g}" for k in points], floor, length_unit, path)


def read_sleap(
    path: str | Path, frames_per_second: float | None, length_unit: str = "px", minimum_score: float = 0.0
) -> Tracks:
    """A SLEAP analysis CSV: `frame_idx`, then `NAME.x, NAME.y, NAME.score`. Image y points down: turned up."""
    path = Path(path)
    rows = read_rows(path)
    header = [cell.strip() for cell in rows[0]]
    if "frame_idx" not in header:
        raise InputError(f"{path}: row 1: a SLEAP export has a column `frame_idx`; it has {', '.join(header[:6])}...")
    if not frames_per_second:
        raise InputError(f"{path}: SLEAP files carry no time: give `frames_per_second` in [motion].")
    names = [cell[:-2] for cell in header if cell.endswith(".x")]
    if not names:
        raise InputError(f"{path}: row 1: no column ends in `.x`: not a SLEAP export.")
    _one_animal(rows, header, path)
    wanted = ["frame_idx"] + [f"{name}.{part}" for name in names for part in ("x", "y", "score")]
    for name in wanted:
        if name not in header:
            raise InputError(f"{path}: row 1: no column `{name}`.")
    where = [header.index(name) for name in wanted]
    data = block(rows, 1, where, wanted, path)
    times = increasing_times(data[:, 0], 1, where[0], path, "frame_idx") / frames_per_second
    points = data[:, 1:].reshape(len(data), len(names), 3)
    floor = np.where(points[..., 2:] >= minimum_score, points[..., :2], np.nan) * np.array([1.0, -1.0])
    return _tracks(times, names, floor, length_unit, path)


def read_c3d(path: str | Path, up_axis: str = "z") -> Tracks:
    """A C3D file's points (needs the extra `serpenoid[c3d]`); residual -1 or a triple zero is a hidden marker."""
    path = Path(path)
    try:
        import ezc3d
    except ImportError:
        raise InputError("reading C3D needs ezc3d: pip install 'serpenoid[c3d]'.") from None
    if not path.is_file():
        raise InputError(f"{path}: no such file.")
    try:
        content = ezc3d.c3d(str(path))
    except (OSError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: not a readable C3D file: {error}") from None
    group: dict[str, Any] = content["parameters"]["POINT"]
    unit = str((group["UNITS"]["value"] or ["mm"])[0]).strip()
    if unit not in ("m", "cm", "mm"):
        raise InputError(f"{path}: POINT:UNITS must be m, cm or mm, got {unit!r}.")
    points = np.array(content["data"]["points"][:3], dtype=float).transpose(2, 1, 0)  # (F, M, 3)
    residual = np.array(content["data"]["meta_points"]["residuals"])[0].T
    hidden = (residual < 0) | (points == 0).all(axis=2)
    points[hidden] = np.nan
    rate = float(group["RATE"]["value"][0])
    if not len(points) or rate <= 0:
        raise InputError(f"{path}: no frames, or POINT:RATE is not positive.")
    times = np.arange(len(points)) / rate
    names = list(group["LABELS"]["value"])[: points.shape[1]]
    tracks = _tracks(times, names, floor_plane(points, up_axis), unit, path)
    return replace(tracks, space=points * METRES[unit])


def _tracks(times: Floats, names: list[str], floor: Floats, length_unit: str, path: Path) -> Tracks:
    scaled = floor * METRES[length_unit]
    return Tracks(times, tuple(names), scaled, str(path), (False,) * len(names), length_unit != "px")


def _refuse_empty(data: Floats, where: list[int], rows: Rows, path: Path) -> None:
    empty = np.argwhere(~np.isfinite(data))
    if empty.size:
        row, column = (int(i) for i in empty[0])
        raise InputError(f"{place(path, row + 1, where[column], rows[0][where[column]])}: must not be empty.")


def _one_animal(rows: Rows, header: list[str], path: Path) -> None:
    if "track" not in header:
        return
    column = header.index("track")
    tracks = {row[column] for row in rows[1:] if len(row) > column}
    if len(tracks) > 1:
        raise InputError(
            f"{path}: column {column_letter(column)} (`track`): {len(tracks)} animals; export one file for each."
        )
