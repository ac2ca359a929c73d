"""Tidy CSV: one row per time, two columns per point, under its own names or the file's."""

from __future__ import annotations

import re
from os.path import commonprefix
from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import block, increasing_times, place, read_rows, whole_frames, whole_points
from serpenoid.measure.columns import (
    IN_BRACKETS,
    SECONDS,
    SPELT,
    MotionColumns,
    find_column,
    numbered,
    refuse_other_unit,
    shown,
)
from serpenoid.measure.matlab import OF_IDTRACKER
from serpenoid.measure.tracks import METRES, Tracks, in_places, no_time, upright

OWN_NAMES = (
    'Own names: `columns = { time = "Time (s)", x = "M*_x", y = "M*_y" }` in [motion], `*` where the numbers of the '
    "points stand, tail first (docs/your-csv.md)."
)

OF_SEVERAL = f" Are these points along one body? {OF_IDTRACKER}"

FIRST_CELLS = {
    "scorer": "deeplabcut", "track": "sleap", "Format Version": "motive", "Trajectories": "vicon", "Devices": "vicon",
    "NO_OF_FRAMES": "qualisys", "FILE_VERSION": "qualisys", "PathFileType": "trc",
}  # fmt: skip


def read_tidy(
    path: str | Path,
    length_unit: str = "m",
    frames_per_second: float | None = None,
    columns: MotionColumns | None = None,
    time_unit: str = "s",
) -> Tracks:
    """`t_s,x_0,y_0,x_1,y_1,...`, or `frame` for `t_s`; vertex 0 = tail; an empty cell is a hidden marker.

    columns: names of the file's own; what they do not name is passed over. With neither `time` nor `frame` among them
    each row is the next frame.
    """
    path = Path(path)
    rows = read_rows(path)
    header = [cell.strip() for cell in rows[0]]
    clock, points = (0, _tidy_points(header, path)) if columns is None else _own_places(header, columns, path)
    counts = header[0] == "frame" if columns is None else columns.time is None
    if counts and not frames_per_second:
        raise no_time(path, "has no column of times" if clock is None else "counts frames")
    clocks, called = [] if clock is None else [clock], [header[c] for c in points]
    refuse_other_unit([header[c] for c in clocks], time_unit, () if counts else SECONDS, "time_unit", path)
    refuse_other_unit(called, length_unit, METRES, "length_unit", path)
    data = block(rows, 1, [*clocks, *points], [header[c] for c in clocks] + called, path)
    times = np.arange(len(data), dtype=float)
    if clock is not None:
        times = increasing_times(data[:, 0], 1, clock, path, header[clock])
        if counts:
            whole_frames(times, 1, clock, path, header[clock])
    times = times * (1 / float(frames_per_second or 1) if counts else SECONDS[time_unit])
    floor = whole_points(data[:, len(clocks) :].reshape(len(data), -1, 2), 1, points[::2], called[::2], path)
    names = in_places(floor.shape[1]) if columns is None else _stems(called[::2], called[1::2])
    floor = upright(floor, length_unit) * METRES[length_unit]
    return Tracks(times, names, floor, str(path), (False,) * len(names), length_unit != "px")


def _stems(across: list[str], up: list[str]) -> tuple[str, ...]:
    """What each point is called in its own columns: how both begin (`M4` of `M4_x` and `M4_y`), else the first."""
    stems = tuple(commonprefix(both).rstrip(" _-.:") for both in zip(across, up, strict=True))
    return stems if all(stems) and len(set(stems)) == len(stems) else tuple(across)


def _tidy_points(header: list[str], path: Path) -> list[int]:
    """Columns of x_0, y_0, x_1, ..., which stand behind the clock's."""
    count = (len(header) - 1) // 2
    expected = ["frame" if header[0] == "frame" else "t_s"] + [f"{axis}_{k}" for k in range(count) for axis in "xy"]
    for column, (got, want) in enumerate(zip(header, expected, strict=False)):
        if _without_unit(got) != want:
            raise InputError(f"{place(path, 0, column)}: a tidy file has `{want}` here, got {got!r}. {_own(header)}")
    if count < 1 or len(header) != len(expected):
        raise InputError(
            f"{path}: row 1: a tidy file has `t_s,x_0,y_0,...` in pairs, got {len(header)} columns. Where others stand "
            'beside: `columns = { time = "t_s", x = "x_*", y = "y_*" }` in [motion] names those that are read.'
        )
    return list(range(1, len(header)))


def _without_unit(name: str) -> str:
    """`x_0` of `x_0 [mm]`: what can be held against the campaign's own unit."""
    found = IN_BRACKETS.search(name)
    known = found is not None and found[1].translate(SPELT) in {*METRES, *SECONDS}
    return IN_BRACKETS.sub("", name).strip() if known else name


def _own(header: list[str]) -> str:
    """What to write for the names of a file, where two columns a point can be seen, or whose file it is."""
    if header[0] in FIRST_CELLS:
        return f'That is how another kind of file begins: `format = "{FIRST_CELLS[header[0]]}"` in [motion].'
    named = list(dict.fromkeys(re.sub(r"[0-9]+", "*", name) for name in header[1:]))
    if len(named) != 2 or any(name.count("*") != 1 for name in named) or '"' in "".join(header):
        return OWN_NAMES
    first = re.sub(r"[0-9]+", "*", header[0])
    x, y = named if first != named[1] else reversed(named)  # x_0,y_0,x_1,...: points begin in the first column
    several = OF_SEVERAL if {x.casefold(), y.casefold()} == {"x*", "y*"} else ""
    if first == x:  # points begin in the first column
        return (
            f'Own names: `columns = {{ x = "{x}", y = "{y}" }}` and `frames_per_second` in [motion], as the file '
            "has no column of times and each row is the next frame; points tail first, units as `length_unit` "
            f"(docs/your-csv.md).{several}"
        )
    return (
        f'Own names: `columns = {{ time = "{header[0]}", x = "{x}", y = "{y}" }}` in [motion], `frame` for `time` '
        "where frames are counted; points tail first, units as `length_unit` and `time_unit` "
        f"(docs/your-csv.md).{several}"
    )


def _own_places(header: list[str], columns: MotionColumns, path: Path) -> tuple[int | None, list[int]]:
    """Column of the clock, if one is named; those of x of vertex 0, y of vertex 0, x of vertex 1, ..."""
    if columns.x is None or columns.y is None:
        raise InputError(
            f"{path}: `columns` needs `x` and `y` for a tidy file, and `time` or `frame` where it has one."
        )
    pairs = [numbered(header, named, axis, path) for axis, named in (("x", columns.x), ("y", columns.y))]
    if not pairs[0] or len(pairs[0]) != len(pairs[1]):
        raise InputError(
            f"{path}: row 1: `columns` names {len(pairs[0])} for x and {len(pairs[1])} for y; "
            f"the file has {shown(header)}."
        )
    inside = [find_column(header, name, "x or y", path) for both in zip(*pairs, strict=True) for name in both]
    named = columns.time or columns.frame
    return None if named is None else find_column(header, named, "time" if columns.time else "frame", path), inside
