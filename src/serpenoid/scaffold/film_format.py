"""What a track file begins like: the format that its reader is for, where nobody says it."""

from __future__ import annotations

import re
from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.measure.cells import read_rows
from serpenoid.measure.tidy import FIRST_CELLS
from serpenoid.measure.trackers import hdf5

BY_SUFFIX = {".c3d": "c3d", ".mat": "array", ".npy": "array", ".trc": "trc", ".wcon": "wcon"}
BY_CELL = (("frame_idx", "sleap"), ("poseX0", "trex"), ("point", "long"), ("bodypart", "long"))  # of a header
BY_GROUP = (("node_names", "sleap"), ("coordinates", "tierpsy"), ("df_with_missing", "deeplabcut"))  # of HDF5
POSTURE = re.compile(rb"midline_points|poseX0")


def format_of(film: Path) -> str | None:
    """A name of `READERS`; None where neither name nor content of the film tells."""
    end = film.suffix.lower()
    if end in BY_SUFFIX:
        return BY_SUFFIX[end]
    if end == ".npz":
        return "trex" if POSTURE.search(film.read_bytes()) else "array"
    try:
        return _of_groups(film) if end in (".h5", ".hdf5") else _of_table(film)
    except InputError:
        return None


def _of_groups(film: Path) -> str | None:
    with hdf5(film) as file:
        return next((kind for name, kind in BY_GROUP if name in file), None)


def _of_table(film: Path) -> str:
    """Tables that none of their first cells tells are tidy ones, with names of their own."""
    header = [cell.strip() for cell in read_rows(film)[0]]
    if header[0] in FIRST_CELLS:
        return FIRST_CELLS[header[0]]
    return next((kind for name, kind in BY_CELL if name in header), "tidy")
