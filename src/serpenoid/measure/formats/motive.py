"""OptiTrack Motive CSV exports, format 1.21 to 1.25: measured markers only, solved rigid bodies left out.

Layout: a key/value line; label rows (`Type`, `Name`, `ID`, from 1.25 `Parent`); the quantity row (`Rotation`,
`Position`); the axis row starting `Frame`; one row per frame, an empty cell where a marker is hidden.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.measure.cells import Rows, place, read_rows
from serpenoid.measure.formats.mocap import Triples, in_space
from serpenoid.measure.tracks import Tracks
from serpenoid.wording import counted

UNITS = {"Meters": 1.0, "Centimeters": 0.01, "Millimeters": 0.001}
KNOWN_VERSIONS = ("1.21", "1.22", "1.23", "1.24", "1.25")
TYPES = {"Rigid Body", "Rigid Body Marker", "Marker", "Bone", "Bone Marker", "Force Plate", "Device"}


@dataclass(frozen=True)
class _Header:
    """Row numbers of the labels and what the first line says."""

    facts: dict[str, str]
    types: int
    names: int
    quantities: int
    axes: int


def read_motive(path: str | Path, up_axis: str = "y") -> Tracks:
    """Read the measured markers. Raises InputError with row and column for whatever is not as Motive writes it."""
    path = Path(path)
    rows = read_rows(path)
    header = _header(rows, path)
    scale = _scale(header, path)
    markers = _marker_columns(rows, header, path)
    tracks = in_space(path, rows, header.axes + 1, markers, scale, up_axis, (1, "Time"))
    _check_frame_count(header, len(tracks.time_s), path)
    return tracks


def _header(rows: Rows, path: Path) -> _Header:
    first = rows[0]
    if not first or first[0].strip() != "Format Version":
        raise InputError(
            f"{path}: row 1, column A: a Motive export starts with `Format Version`, "
            f"got {(first or [''])[0]!r}. "
            'Is `format = "motive"` right for this file?'
        )
    words = [cell.strip() for cell in first]
    facts = dict(zip(words, words[1:], strict=False))  # whatever commas a take's name has
    version = facts.get("Format Version", "")
    if version not in KNOWN_VERSIONS:
        raise InputError(
            f"{path}: row 1, column B: format version must be 1.21 to 1.25, got {version!r}. "
            'Export the take from Motive 2 or 3, or as C3D or TRC (`format = "c3d"`, "trc").'
        )
    axes = next((i for i, row in enumerate(rows[:12]) if row and row[0].strip() == "Frame"), None)
    if axes is None:
        raise InputError(f"{path}: no row starts with `Frame` among the first 12: the header is broken or cut off.")
    types = next((i for i in range(1, axes) if TYPES & {cell.strip() for cell in rows[i]}), None)
    if types is None or axes - types < 4:
        raise InputError(f"{path}: no row of column types (`Marker`, `Rigid Body`) above row {axes + 1}.")
    return _Header(facts, types, types + 1, axes - 1, axes)


def _scale(header: _Header, path: Path) -> float:
    unit = header.facts.get("Length Units", "")
    if unit not in UNITS:
        raise InputError(f"{path}: row 1: `Length Units` must be one of {', '.join(UNITS)}, got {unit!r}.")
    return UNITS[unit]


def _marker_columns(rows: Rows, header: _Header, path: Path) -> Triples:
    """Measured marker -> its X, Y, Z columns."""
    width = len(rows[header.axes])
    for row in (header.types, header.names, header.quantities):
        if len(rows[row]) != width:
            raise InputError(
                f"{path}: row {row + 1}: has {counted(len(rows[row]), 'cell')} where the axis row has {width}."
            )
    found: dict[str, dict[str, int]] = {}
    for column in range(2, width):
        kind, quantity = rows[header.types][column].strip(), rows[header.quantities][column].strip()
        axis = rows[header.axes][column].strip()
        if kind == "Marker" and quantity == "Position" and axis in {"X", "Y", "Z"}:
            axes = found.setdefault(rows[header.names][column].strip(), {})
            if axis in axes:
                name = rows[header.names][column]
                raise InputError(f"{place(path, header.names, column, name)}: two markers have this name.")
            axes[axis] = column
    if not found:
        raise InputError(
            f"{path}: no measured markers. Export with `Markers` on (rigid bodies alone are solved, not seen)."
        )
    for name, axes in found.items():
        if len(axes) != 3:
            raise InputError(
                f"{place(path, header.axes, min(axes.values()), name)}: X, Y and Z expected, got {sorted(axes)}."
            )
    return {name: (axes["X"], axes["Y"], axes["Z"]) for name, axes in found.items()}


def _check_frame_count(header: _Header, frames: int, path: Path) -> None:
    declared = header.facts.get("Total Exported Frames", "")
    if declared.isdigit() and int(declared) != frames:
        raise InputError(
            f"{path}: row {header.axes + 1 + frames}: the file ends after {counted(frames, 'frame')} and its first "
            f"line promises {declared}. The export or the copy was cut off: export it again."
        )
