"""Tidy CSV: one row per time, two columns per point, under its own names or the file's."""

from __future__ import annotations

import re
from os.path import commonprefix
from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.inputs import number
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
from serpenoid.measure.formats.columns import (
    IN_BRACKETS,
    LONGEST_SHOWN,
    SECONDS,
    SPELT,
    MotionColumns,
    by_words,
    find_column,
    has_columns,
    numbered,
    refuse_other_unit,
    shown,
)
from serpenoid.measure.formats.header import (
    first_row,
    header_row,
    likely_header,
    names_of,
    refuse_nameless,
    same_names,
    width_of,
)
from serpenoid.measure.formats.own_names import FIRST_CELLS, advice, doubled
from serpenoid.measure.tracks import METRES, Tracks, in_places, no_time, upright

OF_FRAME = re.compile(r".*[^\W\d_].*\([0-9]+\)")  # `head_x(0)`
SAME_TIME = 1e-4  # relatively: Tracker writes times with five digits


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
    _refuse_turned(rows, path)
    known = rows[0][0].strip() in FIRST_CELLS
    at = (
        (0 if known else likely_header(rows))
        if columns is None
        else header_row(rows, lambda row: has_columns(row, columns))
    )
    header = names_of(rows, at)
    refuse_nameless(rows[at], path)
    clock, points, stems = (
        (0, _tidy_points(rows, at, path), ()) if columns is None else _own_places(rows, at, columns, path)
    )
    counts = header[0] == "frame" if columns is None else columns.time is None
    if counts and not frames_per_second:
        raise no_time(path, "has no column of times" if clock is None else "counts frames")
    clocks, called = [] if clock is None else [clock], [header[c] for c in points]
    refuse_other_unit([header[c] for c in clocks], time_unit, () if counts else SECONDS, "time_unit", path)
    refuse_other_unit(called, length_unit, METRES, "length_unit", path)
    units = dict.fromkeys(points, ("length_unit", length_unit))
    units |= {} if counts else dict.fromkeys(clocks, ("time_unit", time_unit))
    first = first_row(rows, at, [*clocks, *points], units, path)
    width = width_of(rows, first, header, [*clocks, *points])
    data = block(rows, first, [*clocks, *points], [header[c] for c in clocks] + called, path, width)
    times = np.arange(len(data), dtype=float)
    if clock is not None:
        times = increasing_times(data[:, 0], first, clock, path, header[clock])
        if counts:
            whole_frames(times, first, clock, path, header[clock])
        _refuse_other_clocks(rows, at, first, clock, times, path)
    times = times * (1 / float(frames_per_second or 1) if counts else SECONDS[time_unit])
    floor = whole_points(data[:, len(clocks) :].reshape(len(data), -1, 2), first, points[::2], called[::2], path)
    names = in_places(floor.shape[1]) if columns is None else stems or _stems(called[::2], called[1::2])
    floor = upright(floor, length_unit) * METRES[length_unit]
    return Tracks(times, names, floor, str(path), (False,) * len(names), length_unit != "px")


def _refuse_turned(rows: Rows, path: Path) -> None:
    """Refuse a table whose columns are animals, with a row for each quantity in each frame."""
    names = [row[0].strip() if row else "" for row in rows[1:]]
    if len(names) < 2 or not all(OF_FRAME.fullmatch(name) for name in names):
        return
    raise InputError(
        f"{path}: row 2, column A: `{names[0][:LONGEST_SHOWN]}` is a quantity in one frame, and every row is one, with "
        "animals beside one another, as FIMTrack writes them. Turn the table round, a file for each animal: a row for "
        "each frame, with the columns `frame,x_0,y_0,...` from tail to head."
    )


def _refuse_other_clocks(rows: Rows, at: int, first: int, clock: int, times: Floats, path: Path) -> None:
    """Refuse tables beside one another, each with a clock of its own, whose rows are not of the same times."""
    own = [cell.strip() for cell in rows[at]]
    header = names_of(rows, at)
    for column in (c for c, name in enumerate(own) if c != clock and name == own[clock]):
        for k, row in enumerate(rows[first:]):
            cell = row[column].strip() if column < len(row) else ""
            value = None if missing(cell) else number(cell)
            if value is not None and abs(value - times[k]) > SAME_TIME * max(1.0, abs(times[k])):
                raise InputError(
                    f"{place(path, first + k, column, header[column])}: is {value:g} where `{header[clock]}` is "
                    f"{times[k]:g}: these tables have not the same times in their rows. Export them for the same "
                    "frames, with empty cells where a point is not marked."
                )


def _stems(across: list[str], up: list[str]) -> tuple[str, ...]:
    """What each point is called in its own columns: how both begin (`M4` of `M4_x` and `M4_y`), else the first."""
    stems = tuple(commonprefix(both).rstrip(" _-.:") for both in zip(across, up, strict=True))
    return stems if all(stems) and len(set(stems)) == len(stems) else tuple(across)


def _tidy_points(rows: Rows, row: int, path: Path) -> list[int]:
    """Columns of x_0, y_0, x_1, ..., which stand behind the clock's."""
    header = names_of(rows, row)
    count = (len(header) - 1) // 2
    expected = ["frame" if header[0] == "frame" else "t_s"] + [f"{axis}_{k}" for k in range(count) for axis in "xy"]
    for column, (got, want) in enumerate(zip(header, expected, strict=False)):
        if _without_unit(got) != want:
            there = f"a tidy file has `{want}` here, got {got[:LONGEST_SHOWN]!r}"
            cure = doubled(header, same_names(rows, row)) or advice(header)
            raise InputError(f"{place(path, row, column)}: {there}. {cure}")
    if count < 1 or len(header) != len(expected):
        raise InputError(
            f"{path}: row {row + 1}: a tidy file has `t_s,x_0,y_0,...` in pairs, got {len(header)} columns. Where "
            'others stand beside: `columns = { time = "t_s", x = "x_*", y = "y_*" }` in [motion] names those that are '
            "read."
        )
    return list(range(1, len(header)))


def _without_unit(name: str) -> str:
    """`x_0` of `x_0 [mm]`: what can be held against the campaign's own unit."""
    found = IN_BRACKETS.search(name)
    known = found is not None and found[1].translate(SPELT) in {*METRES, *SECONDS}
    return IN_BRACKETS.sub("", name).strip() if known else name


def _own_places(
    rows: Rows, row: int, columns: MotionColumns, path: Path
) -> tuple[int | None, list[int], tuple[str, ...]]:
    """Column of the clock, if one is named; those of x of vertex 0, y of vertex 0, x of vertex 1, ...; what stands in
    place of `*` in their names, if that is no number."""
    header, same = names_of(rows, row), same_names(rows, row)
    if columns.x is None or columns.y is None:
        raise InputError(
            f"{path}: `columns` needs `x` and `y` for a tidy file, and `time` or `frame` where it has one."
        )
    stars = ["[0-9]+".join(map(re.escape, name.split("*"))) for name in (columns.x, columns.y) if isinstance(name, str)]
    if any(re.fullmatch(form, name) for form in stars for name in same) and (cure := doubled(header, same)):
        raise InputError(f"{path}: row {row + 1}: {cure}")
    pairs = [numbered(header, named, axis, path) for axis, named in (("x", columns.x), ("y", columns.y))]
    stems: tuple[str, ...] = ()
    if not pairs[0] and not pairs[1]:
        stems, pairs = by_words(header, str(columns.x), str(columns.y), path)
    if not pairs[0] or len(pairs[0]) != len(pairs[1]):
        raise InputError(
            f"{path}: row 1: `columns` names {len(pairs[0])} for x and {len(pairs[1])} for y; "
            f"the file has {shown(header)}."
        )
    inside = [find_column(header, name, "x or y", path) for both in zip(*pairs, strict=True) for name in both]
    named = columns.time or columns.frame
    clock = None if named is None else find_column(header, named, "time" if columns.time else "frame", path)
    return clock, inside, stems
