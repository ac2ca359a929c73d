"""What a track file begins like: the format that its reader is for, where nobody says it."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

from serpenoid.errors import InputError
from serpenoid.files.inputs import MATLAB, begins
from serpenoid.measure.cells import read_rows
from serpenoid.measure.formats.hdf5_files import hdf5, inside, is_hdf5
from serpenoid.measure.formats.matlab import OF_IDTRACKER, TRAJECTORIES, read_mat
from serpenoid.measure.formats.own_names import FIRST_CELLS
from serpenoid.measure.formats.pandas_table import is_pandas

BY_SUFFIX = {".c3d": "c3d", ".npy": "array", ".trc": "trc", ".wcon": "wcon", ".json": "wcon", ".xml": "trackmate"}
PACKED = (".gz", ".zip")
BY_CELL = (("frame_idx", "sleap"), ("poseX0", "trex"), ("point", "long"), ("bodypart", "long"))  # of a header
BY_GROUP = (
    ("node_names", "sleap"),
    ("coordinates", "tierpsy"),
    ("keypoints", "movement"),
    ("instances", "sleap"),
)  # of HDF5
UNREAD = {
    TRAJECTORIES: OF_IDTRACKER,
    "skeleton": "Of Tierpsy its file of features is read.",
}  # of HDF5
POSTURE = re.compile(rb"midline_points|poseX0")


def format_of(film: Path) -> str:
    """A name of `READERS`. Raises InputError of a film that is broken, or that no reader is for."""
    end = next((end for end in reversed(film.suffixes) if end.lower() not in PACKED), "").lower()
    if end in BY_SUFFIX:
        return BY_SUFFIX[end]
    if end == ".mat" or begins(film, MATLAB):
        return "qualisys" if any("Trajectories" in said for said in read_mat(film)[1]) else "array"
    if end == ".npz":
        return "trex" if POSTURE.search(film.read_bytes()) else "array"
    if is_hdf5(film):
        with hdf5(film) as file:
            return _of_groups(file, film)
    return _of_table(film)


def _of_groups(file: Any, film: Path) -> str:
    kind = next((kind for name, kind in BY_GROUP if name in file), None)
    if kind is None and any(is_pandas(file[name]) for name in file):
        kind = "deeplabcut"
    if kind is None:
        known = ", ".join(dict.fromkeys([*(kind for _, kind in BY_GROUP), "deeplabcut"]))
        cure = "".join(f" {words}" for name, words in UNREAD.items() if name in file)
        raise InputError(f"{film}: an HDF5 file that holds {inside(file)}, of none that are read ({known}).{cure}")
    return kind


def _of_table(film: Path) -> str:
    """Tables that none of their first cells tells are tidy ones, with names of their own."""
    header = [cell.strip() for cell in read_rows(film)[0]]
    if header[0] in FIRST_CELLS:
        return FIRST_CELLS[header[0]]
    return next((kind for name, kind in BY_CELL if name in header), "tidy")
