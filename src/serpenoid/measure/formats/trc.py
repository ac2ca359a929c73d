"""TRC files (OpenSim, Motion Analysis): marker trajectories as tab-separated text.

Layout: `PathFileType`, a row of keys, a row of their values, `Frame#`, `Time` and the markers' names, a row of axes
(`X1`, `Y1`, `Z1`, ...), perhaps an empty one, a row per frame.
"""

from __future__ import annotations

from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.files.inputs import number
from serpenoid.measure.cells import read_rows
from serpenoid.measure.formats.mocap import fact, in_space, in_succession, metres, refuse_fewer
from serpenoid.measure.tracks import Tracks


def read_trc(path: str | Path, up_axis: str = "y") -> Tracks:
    """Read the markers. Raises InputError with row and column for whatever is not as the format has it."""
    path = Path(path)
    rows = read_rows(path)
    cells = [[cell.strip() for cell in row] for row in rows[:5]]
    if len(cells) < 5 or cells[0][0] != "PathFileType" or "(X/Y/Z)" not in cells[0] or cells[3][:1] != ["Frame#"]:
        raise InputError(
            f"{path}: a TRC file begins with `PathFileType`, 4, `(X/Y/Z)`, and has `Frame#` in row 4. Is "
            '`format = "trc"` right?'
        )
    facts = dict(zip(cells[1], cells[2], strict=False))
    names = [cell for cell in cells[3][2:] if cell]
    wide = 2 + 3 * len(names)
    first = next((i for i, row in enumerate(rows[5:], 5) if row and number(row[0]) is not None), len(rows))
    markers, unit = in_succession(names, 2, path), metres(facts.get("Units", ""), path)
    tracks = in_space(path, rows, first, markers, unit, up_axis, (1, "Time"), width=wide)
    refuse_fewer(fact(facts, "NumFrames", path), len(tracks.time_s), path)
    return tracks
