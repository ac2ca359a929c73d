"""Qualisys QTM exports of trajectories in 3D, in millimetres, as TSV or for MATLAB.

Layout: key/value rows, the last `MARKER_NAMES` (or, after it, `TRAJECTORY_TYPES`); perhaps a row of column names; a row
per frame, which begins with frame and time where these were exported, too. Of MATLAB's (`.mat`) one structure, with
`FrameRate` and `Trajectories.Labeled`: `Labels`, and `Data` (markers; X, Y, Z, residual; frames).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.inputs import RECORDING_BYTES, number, read_bytes
from serpenoid.measure.cells import missing, read_rows
from serpenoid.measure.formats.child import read_in_child
from serpenoid.measure.formats.mocap import as_markers, fact, in_space, in_succession, refuse_fewer, without_zeros
from serpenoid.measure.tracks import METRES, Tracks
from serpenoid.wording import counted

FIRST = ("NO_OF_FRAMES", "FILE_VERSION")  # the latter from its version 2 on


def read_qualisys(path: str | Path, up_axis: str = "z") -> Tracks:
    """Read the markers. Raises InputError with row and column for whatever is not as QTM writes it."""
    path = Path(path)
    if path.suffix.lower() == ".mat":
        return _of_matlab(path, up_axis)
    rows = read_rows(path)
    if rows[0][0].strip() not in FIRST:
        raise InputError(
            f"{path}: row 1, column A: a QTM export begins with `{FIRST[0]}` or `{FIRST[1]}`, got {rows[0][0]!r}. "
            'Export it as TSV with its header; is `format = "qualisys"` right?'
        )
    first = next((i for i, row in enumerate(rows) if row and _begins(row[0].strip())), len(rows))
    facts = {row[0].strip(): row[1].strip() for row in rows[:first] if len(row) > 1}
    if facts.get("DATA_INCLUDED", "3D") != "3D" or "MARKER_NAMES" not in facts:
        raise InputError(f"{path}: holds no trajectories of markers in 3D: export these (`DATA_INCLUDED` 3D).")
    named = next(row for row in rows[:first] if row and row[0].strip() == "MARKER_NAMES")
    names = [cell.strip() for cell in named[1:] if cell.strip()]
    wide = max((len(row) for row in rows[first:]), default=0)
    if wide - 3 * len(names) not in (0, 2):
        raise InputError(
            f"{path}: row {first + 1}: has {counted(wide, 'cell')}, where {counted(len(names), 'marker')} make "
            f"{3 * len(names)}, or two more with frame and time."
        )
    begin = wide - 3 * len(names)
    rate = fact(facts, "FREQUENCY", path) if not begin else 1.0
    markers = in_succession(names, begin, path)
    tracks = in_space(path, rows, first, markers, METRES["mm"], up_axis, (1, "Time") if begin else None, rate, wide)
    refuse_fewer(fact(facts, "NO_OF_FRAMES", path), len(tracks.time_s), path)
    return tracks


def _of_matlab(path: Path, up_axis: str) -> Tracks:
    found = read_in_child("QTM", path, len(read_bytes(path, RECORDING_BYTES)))
    names, data, rate = found["labels"].tolist(), found["data"], float(found["rate"])
    if data.ndim != 3 or data.shape[0] != len(names) or data.shape[1] not in (3, 4):
        raise InputError(
            f"{path}: `Trajectories.Labeled.Data` must be (markers, 4, frames) of {counted(len(names), 'label')}, got "
            f"{data.shape}."
        )
    in_succession(names, 0, path)
    if not 0 < rate < 1e6:
        raise InputError(f"{path}: `FrameRate` must be a number of frames a second, got {rate:g}.")
    positions = without_zeros(data[:, :3].transpose(2, 0, 1) * METRES["mm"])
    positions = np.where(np.isfinite(positions).all(axis=2, keepdims=True), positions, np.nan)
    tracks = as_markers(path, np.arange(len(positions)) / rate, names, positions, up_axis)
    refuse_fewer(float(found["frames"]), len(tracks.time_s), path)
    return tracks


def _begins(cell: str) -> bool:
    """Whether a row of numbers begins with it, the first of which may be hidden."""
    return missing(cell) or number(cell) is not None
