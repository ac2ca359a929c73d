"""Markers in space as systems of motion capture write them: a row per frame, three columns per marker."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats, Rows, block, increasing_times, whole_points
from serpenoid.measure.tracks import LENGTHS, METRES, Tracks, floor_plane

Triples = dict[str, tuple[int, int, int]]  # marker -> its X, Y, Z columns
# `Unlabeled:108` of Motive, `*108` of Vicon, `New 0108` of Qualisys
UNLABELLED = re.compile(r"(^|:)(Unlabel+ed[ :_-]?\d*|\*\d+|New \d+)$", re.IGNORECASE)


def in_succession(names: Sequence[str], first: int, path: Path) -> Triples:
    """Markers whose three columns follow each other, from column `first` on. Raises InputError for one named twice."""
    twice = next((name for k, name in enumerate(names) if name in names[:k]), None)
    if twice is not None:
        raise InputError(f"{path}: two markers are called `{twice}`.")
    return {name: (first + 3 * k, first + 3 * k + 1, first + 3 * k + 2) for k, name in enumerate(names)}


def metres(unit: str, path: Path) -> float:
    """One unit of a file that says which."""
    known = LENGTHS.get(unit.casefold())
    if known not in ("m", "cm", "mm"):
        raise InputError(f"{path}: the unit of its positions must be m, cm or mm, got {unit[:20]!r}.")
    return METRES[known]


def unlabelled(names: Sequence[str]) -> tuple[bool, ...]:
    """Which of these names stand for a marker that nobody has named."""
    return tuple(bool(UNLABELLED.search(name)) for name in names)


def in_space(
    path: Path,
    rows: Rows,
    first: int,
    markers: Mapping[str, tuple[int, int, int]],
    unit_m: float,
    up_axis: str,
    clock: tuple[int, str] | None,
    rate: float = 1.0,
    width: int | None = None,
) -> Tracks:
    """Rows `first`.. as tracks. clock: column of the time and its name, None where rows are counted; rate: of either, a
    second; width: of a row, in cells, where the one above the first is another's.

    An empty triple is a hidden marker, and so is one of zeros: no camera sees one exactly there.
    """
    counted = [] if clock is None else [clock]
    columns = [column for column, _ in counted] + [c for triple in markers.values() for c in triple]
    called = [name for _, name in counted] + [name for name in markers for _ in range(3)]
    data = block(rows, first, columns, called, path, width)
    times = np.arange(len(data), dtype=float)
    for column, name in counted:
        times = increasing_times(data[:, 0], first, column, path, name)
    positions = data[:, len(counted) :].reshape(len(data), len(markers), 3) * unit_m
    seen = without_zeros(positions)
    whole_points(seen, first, [triple[0] for triple in markers.values()], list(markers), path)
    return as_markers(path, times / rate, list(markers), seen, up_axis)


def without_zeros(positions: Floats) -> Floats:
    """Positions (F, M, 3) with those at exactly 0, 0, 0 hidden."""
    return np.where((positions == 0).all(axis=2, keepdims=True), np.nan, positions)


def as_markers(path: Path, times: Floats, names: Sequence[str], positions: Floats, up_axis: str) -> Tracks:
    """Markers in space (F, M, 3) [m] as tracks."""
    floor = floor_plane(positions, up_axis)
    return Tracks(times, tuple(names), floor, str(path), unlabelled(names), space=positions)


def fact(facts: Mapping[str, str], key: str, path: Path) -> float:
    """A number above zero of a file's header."""
    try:
        found = float(facts.get(key, ""))
    except ValueError:
        found = 0.0
    if not 0 < found < 1e9:
        raise InputError(f"{path}: its header must give `{key}`, a number above zero, got {facts.get(key, '')[:20]!r}.")
    return found


def refuse_fewer(promised: float, frames: int, path: Path) -> None:
    """Refuse a file with fewer frames than its header promises."""
    if frames < promised:
        raise InputError(
            f"{path}: holds {frames} frames, and its header promises {promised:g}. Was the export or the copy cut off? "
            "Export it again."
        )
