"""Vicon Nexus exports as CSV: the section `Trajectories`, whatever others (devices, joints) stand beside it.

Layout of a section: its title; frames a second; names, each over the first of its columns; `Frame`, `Sub Frame` and
axes (`X'` and `X''` where velocities and accelerations were exported, too); units; a row per frame; an empty row.
"""

from __future__ import annotations

from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.files.inputs import without_empty_ends
from serpenoid.measure.cells import place, read_rows
from serpenoid.measure.formats.mocap import Triples, fact, in_space, metres
from serpenoid.measure.tracks import Tracks

TITLE = "trajectories"
AXES = ("X", "Y", "Z")


def read_vicon(path: str | Path, up_axis: str = "z") -> Tracks:
    """Read the markers. Raises InputError with row and column for whatever is not as Nexus writes it."""
    path = Path(path)
    rows = read_rows(path)
    title = next((i for i, row in enumerate(rows) if row and row[0].strip().lower() == TITLE), None)
    if title is None or len(rows) < title + 6:
        raise InputError(
            f'{path}: has no section `Trajectories`: export these from Nexus as ASCII. Is `format = "vicon"` right?'
        )
    after = range(title + 5, len(rows))
    end = next((i for i in after if not any(cell.strip() for cell in rows[i])), len(rows))
    rows = rows[: title + 2] + without_empty_ends(rows[title + 2 : end])
    names, axes, units = ([cell.strip() for cell in rows[title + k]] for k in (2, 3, 4))
    if axes[:1] != ["Frame"] or len(units) != len(axes):
        raise InputError(f"{path}: row {title + 4}: `Frame`, `Sub Frame` and axes, then as many units, belong here.")
    markers = _markers(names, axes, path, title + 2)
    said = sorted({units[column] for triple in markers.values() for column in triple})
    if len(said) != 1:
        raise InputError(f"{path}: row {title + 5}: one unit of all positions expected, got {', '.join(said)}.")
    rate = fact({"frames a second": rows[title + 1][0].strip() if rows[title + 1] else ""}, "frames a second", path)
    return in_space(path, rows, title + 5, markers, metres(said[0], path), up_axis, (0, "Frame"), rate)


def _markers(names: list[str], axes: list[str], path: Path, row: int) -> Triples:
    """Marker -> its columns; a name holds until the next one."""
    found: dict[str, dict[str, int]] = {}
    name = ""
    for column, axis in enumerate(axes):
        name = (names[column] if column < len(names) else "") or name
        if name and axis in AXES:
            if axis in found.setdefault(name, {}):
                raise InputError(f"{place(path, row, column, name)}: two markers have this name.")
            found[name][axis] = column
    whole = {name: tuple(axes[axis] for axis in AXES) for name, axes in found.items() if len(axes) == len(AXES)}
    if not whole or len(whole) != len(found):
        raise InputError(f"{path}: row {row + 2}: X, Y and Z of every marker expected below the names.")
    return {name: (x, y, z) for name, (x, y, z) in whole.items()}
