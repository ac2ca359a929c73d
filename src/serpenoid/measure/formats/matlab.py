"""Arrays that MATLAB saved (`save m.mat t_s points`), formats 4 to 7.3; vectors are matrices of one row or column."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.files.inputs import RECORDING_BYTES, read_bytes
from serpenoid.measure.cells import Floats
from serpenoid.measure.formats.child import MAT_ARRAYS, OTHERS, read_in_child
from serpenoid.measure.formats.hdf5_files import MAGIC, hdf5, whole

BY_HDF5 = b"MATLAB 7.3"
TRAJECTORIES = "trajectories"  # what files of idtracker and idtracker.ai hold
OF_IDTRACKER = (
    "Trajectories of idtracker and idtracker.ai are one point an animal: where it is, and not how it bends. That takes "
    "points along its body."
)


def read_mat(path: Path) -> tuple[dict[str, Floats], list[str]]:
    """The arrays of a .mat that are read, which must be numbers; what else is in it, in words."""
    data = read_bytes(path, RECORDING_BYTES)
    if data.startswith((BY_HDF5, MAGIC)):
        return _of_hdf5(path)
    found = read_in_child("MATLAB", path, len(data))
    return found, [str(said) for said in found.pop(OTHERS)]


def _of_hdf5(path: Path) -> tuple[dict[str, Floats], list[str]]:
    """The same of its format 7.3, whose arrays stand there with their axes in opposite order."""
    arrays, others = {}, []
    with hdf5(path) as file:
        for name, data in file.items():
            kind = getattr(getattr(data, "dtype", None), "kind", "")
            if name in MAT_ARRAYS and kind and kind in "biuf":
                arrays[name] = np.asarray(whole(data, path), float).T
            elif not name.startswith("#"):  # where it keeps what is in cells
                others.append(_told(name, data, kind))
    return arrays, others


def _told(name: str, data: Any, kind: str) -> str:
    if not kind:
        return f"`{name}` (struct: {', '.join(data)})"
    if data.attrs.get("MATLAB_class") == b"cell":
        return f"`{name}` (cell of {data.size})"
    return f"`{name}` ({', '.join(map(str, data.shape[::-1]))})"
