"""Tables of tracked points: long CSV with a column mapping, SLEAP CSV, C3D."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.files.inputs import RECORDING_BYTES, number, read_bytes
from serpenoid.measure.cells import (
    Floats,
    Rows,
    block,
    increasing_times,
    missing,
    place,
    read_rows,
    whole_frames,
    whole_points,
)
from serpenoid.measure.formats.child import read_in_child
from serpenoid.measure.formats.columns import SECONDS, find_column, refuse_other_unit
from serpenoid.measure.formats.header import first_row, header_row, names_of, refuse_nameless, width_of
from serpenoid.measure.formats.individuals import chosen
from serpenoid.measure.formats.mocap import metres, unlabelled
from serpenoid.measure.formats.point_order import along_body
from serpenoid.measure.formats.scores import sure
from serpenoid.measure.tracks import DOWN, METRES, Tracks, floor_plane, no_time, upright
from serpenoid.wording import counted

MOST_CELLS = 200_000_000
OTHER_NAMES = " Name them in `columns`."
TWICE = " Is a row there twice? Leave it out."
SEVERAL = " Of several animals? Then `columns` needs `individual`, and the trial names one: `individual`."


def read_long(
    path: str | Path,
    columns: dict[str, str],
    length_unit: str,
    frames_per_second: float | None = None,
    time_unit: str = "s",
    individual: str | None = None,
) -> Tracks:
    """One row per frame and point (and individual). `columns` maps time, frame, point, x, y, individual to the file's
    own names (time or frame). Points are numbers, or names (`point_order`); without a column of these, rows of a frame
    are its points in order, as many in each."""
    path = Path(path)
    rows = read_rows(path)
    at = header_row(rows, lambda row: set(columns.values()) <= set(row))
    header = names_of(rows, at)
    refuse_nameless(rows[at], path)
    found = {role: find_column(header, name, role, path, OTHER_NAMES) for role, name in columns.items()}
    clock = "time" if "time" in columns else "frame"
    if clock == "frame" and not frames_per_second:
        raise no_time(path, "has no time column")
    roles = [clock, "point", "x", "y"] if "point" in columns else [clock, "x", "y"]
    refuse_other_unit([columns[clock]], time_unit, SECONDS if clock == "time" else (), "time_unit", path)
    refuse_other_unit([columns["x"], columns["y"]], length_unit, METRES, "length_unit", path)
    where = [found[role] for role in roles]
    units = {found[role]: ("length_unit", length_unit) for role in "xy"}
    units |= {} if clock == "frame" else {found[clock]: ("time_unit", time_unit)}
    first = first_row(rows, at, [found[role] for role in (clock, "x", "y")], units, path)
    called = _numbered(rows[first:], found["point"]) if "point" in found else []
    data = block(rows, first, where, [columns[role] for role in roles], path, width_of(rows, first, header, where))
    _refuse_empty(data[:, :-2], first, where, roles, columns, path)
    whole_points(data[:, None, -2:], first, where[-2:-1], [columns["x"]], path)
    if clock == "frame":
        whole_frames(data[:, 0], first, where[0], path, columns[clock])
    own = _own(rows[first:], found.get("individual"), individual, path)
    data = data[own]
    stamps, frame = np.unique(data[:, 0], return_inverse=True)
    which = data[:, 1] if "point" in columns else _in_turn(stamps, frame, path)
    points, slot = np.unique(which, return_inverse=True)
    taken, again = np.unique(frame * len(points) + slot, return_index=True)
    if len(taken) != len(data):
        row = int(own[np.setdiff1d(np.arange(len(data)), again)[0]])
        cure = "" if "individual" in columns else SEVERAL
        raise InputError(
            f"{place(path, row + first, where[1], columns['point'])}: this point is twice in one frame.{cure}{TWICE}"
        )
    if len(stamps) * len(points) > MOST_CELLS:
        raise InputError(
            f"{path}: {counted(len(stamps), 'time')} of {counted(len(points), 'point')}: is "
            f"`{columns.get('point', columns[clock])}` their number?"
        )
    floor = np.full((len(stamps), len(points), 2), np.nan)
    floor[frame, slot] = upright(data[:, -2:], length_unit)
    times = stamps * SECONDS[time_unit] if clock == "time" else stamps / float(frames_per_second or 1)
    if not called:
        return _tracks(times, [f"point_{k:g}" for k in points], floor, length_unit, path)
    names = [called[int(k)] for k in points]
    order = along_body(names, frame, slot)
    along = order or list(range(len(names)))
    tracks = _tracks(times, [names[k] for k in along], floor[:, along], length_unit, path)
    return replace(tracks, in_order=order is not None)


def _in_turn(stamps: Floats, frame: NDArray[np.int64], path: Path) -> Floats:
    """Numbers of points (R,), from 1, of rows that follow each other within their frame. Raises InputError where frames
    have not as many each."""
    counts = np.bincount(frame)
    usual = int(np.median(counts))
    if usual == 1:
        raise InputError(
            f"{path}: most times have one row, which is one point of a body. Have rows of a frame not the same time, "
            "or does a column say which point each is of, `point` in `columns`? Of one point no K can be told."
        )
    odd = np.flatnonzero(counts != usual)
    if len(odd):
        raise InputError(
            f"{path}: has {counted(int(counts[odd[0]]), 'row')} of {stamps[odd[0]]:g}, and {usual} of most: which "
            "point is which? Name a column that says so, `point` in `columns`; or leave out frames that lack a point."
        )
    order = np.argsort(frame, kind="stable")
    turn = np.empty(len(frame))
    turn[order] = np.tile(np.arange(1.0, usual + 1), len(stamps))
    return turn


def _numbered(rows: Rows, column: int) -> list[str]:
    """Names of points, whose cells become their numbers (0, ...); none where any is a number already."""
    cells = [row[column].strip() for row in rows if len(row) > column]
    names = list(dict.fromkeys(cell for cell in cells if not missing(cell)))
    if any(number(name) is not None for name in names):
        return []
    place_of = {name: str(k) for k, name in enumerate(names)}
    for row in rows:
        if len(row) > column:
            row[column] = place_of.get(row[column].strip(), "")
    return names


def read_sleap(
    path: str | Path,
    frames_per_second: float | None,
    length_unit: str = "px",
    minimum_score: float = 0.0,
    individual: str | None = None,
) -> Tracks:
    """A SLEAP analysis CSV: `frame_idx`, then `NAME.x, NAME.y, NAME.score`. Image y points down: turned up."""
    path = Path(path)
    rows = read_rows(path)
    header = [cell.strip() for cell in rows[0]]
    if "frame_idx" not in header:
        raise InputError(f"{path}: row 1: a SLEAP export has a column `frame_idx`; it has {', '.join(header[:6])}...")
    if not frames_per_second:
        raise no_time(path, "SLEAP files carry no time")
    names = [cell[:-2] for cell in header if cell.endswith(".x")]
    if not names:
        raise InputError(f"{path}: row 1: no column ends in `.x`: not a SLEAP export.")
    own = _own(rows[1:], header.index("track") if "track" in header else None, individual, path)
    wanted = ["frame_idx"] + [f"{name}.{part}" for name in names for part in ("x", "y", "score")]
    for name in wanted:
        if name not in header:
            raise InputError(f"{path}: row 1: no column `{name}`.")
    where = [header.index(name) for name in wanted]
    data = block(rows, 1, where, wanted, path)
    points = data[:, 1:].reshape(len(data), len(names), 3)
    times = increasing_times(data[own, 0], own + 1, where[0], path, "frame_idx") / frames_per_second
    whole_points(points[..., :2], 1, where[1::3], names, path)
    floor = sure(points[own, :, :2], points[own, :, 2], minimum_score, path) * DOWN
    return _tracks(times, names, floor, length_unit, path)


def read_c3d(path: str | Path, up_axis: str = "z") -> Tracks:
    """A C3D file's points (needs the extra `serpenoid[c3d]`); residual -1 or a triple zero is a hidden marker."""
    path = Path(path)
    if importlib.util.find_spec("ezc3d") is None:
        raise InputError("reading C3D needs ezc3d: pip install ezc3d.")
    size = _check_c3d(read_bytes(path, RECORDING_BYTES), path)
    found = read_in_child("C3D", path, size)
    points, labels, unit, rate = found["points"].T, found["labels"].tolist(), str(found["unit"]), float(found["rate"])
    unit_m = metres(unit, path)
    hidden = (found["residuals"].T < 0) | (points == 0).all(axis=2)
    points[hidden] = np.nan
    if not points.size or not 0 < rate < 1e5:
        raise InputError(f"{path}: no frames, or POINT:RATE is not a number of frames per second, got {rate:g}.")
    if len(labels) < points.shape[1]:
        raise InputError(f"{path}: POINT:LABELS names {len(labels)} of {counted(points.shape[1], 'point')}.")
    whole_points(points, 0, range(len(labels)), labels, path)
    times = np.arange(len(points)) / rate
    tracks = _tracks(times, labels[: points.shape[1]], unit_m * floor_plane(points, up_axis), "m", path)
    return replace(tracks, space=points * unit_m, unlabelled=unlabelled(tracks.names))


def _check_c3d(data: bytes, path: Path) -> int:
    """Size of the file; InputError where its header promises more than that, or is none."""
    if len(data) < 1024 or data[1] != 0x50:
        raise InputError(f"{path}: not a C3D file: its second byte must be 0x50 and its header 512 bytes.")
    points, analog, first, last, start = (int(np.frombuffer(data[:512], "<u2")[k]) for k in (1, 2, 3, 4, 8))
    if data[(data[0] - 1) * 512 + 3 : (data[0] - 1) * 512 + 4] not in (b"\x54", b"\x00", b""):
        return len(data)  # another processor's byte order
    each = 4 if np.frombuffer(data[12:16], "<f4")[0] < 0 else 2  # bytes of a number: of floats the scale is negative
    needed = 512 * (start - 1) + each * (last - first + 1) * (4 * points + analog)
    if last < first or start < 2 or not points or needed > len(data):
        raise InputError(f"{path}: the C3D header promises more than the file holds. Was the copy cut off?")
    return len(data)


def _tracks(times: Floats, names: list[str], floor: Floats, length_unit: str, path: Path) -> Tracks:
    scaled = floor * METRES[length_unit]
    return Tracks(times, tuple(names), scaled, str(path), (False,) * len(names), length_unit != "px")


def _refuse_empty(
    data: Floats, first: int, where: list[int], roles: list[str], columns: dict[str, str], path: Path
) -> None:
    empty = np.argwhere(~np.isfinite(data))
    if empty.size:
        row, column = (int(i) for i in empty[0])
        raise InputError(f"{place(path, row + first, where[column], columns[roles[column]])}: must not be empty.")


def _own(rows: Rows, column: int | None, individual: str | None, path: Path) -> NDArray[np.int64]:
    """Which of these rows are of the individual that is wanted, whose name is in a column."""
    if column is None:
        chosen([], individual, path)
        return np.arange(len(rows))
    names = [row[column].strip() if len(row) > column else "" for row in rows]
    wanted = chosen(names, individual, path)
    return np.flatnonzero([name == wanted for name in names])
