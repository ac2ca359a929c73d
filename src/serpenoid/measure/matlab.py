"""Arrays that MATLAB saved (`save m.mat t_s points`), formats 4 to 7; vectors are matrices of one row or column."""

from __future__ import annotations

from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.files.inputs import RECORDING_BYTES, read_bytes
from serpenoid.measure.cells import Floats
from serpenoid.measure.child import OTHERS, read_in_child

TRAJECTORIES = "trajectories"  # what files of idtracker and idtracker.ai hold
OF_IDTRACKER = (
    "Trajectories of idtracker and idtracker.ai are one point an animal: where it is, and not how it bends. That takes "
    "points along its body."
)


def read_mat(path: Path) -> tuple[dict[str, Floats], list[str]]:
    """The arrays of a .mat that are read, which must be numbers; what else is in it, in words."""
    data = read_bytes(path, RECORDING_BYTES)
    if data.startswith((b"MATLAB 7.3", b"\x89HDF")):
        group = f" {OF_IDTRACKER}" if TRAJECTORIES.encode() in data else ""
        raise InputError(
            f"{path}: is saved in MATLAB's format 7.3 (HDF5). In MATLAB: `load {path.name}`, then "
            f"`save('{path.name}', 't_s', 'points', '-v7')`.{group}"
        )
    found = read_in_child("MATLAB", path, len(data))
    return found, [str(said) for said in found.pop(OTHERS)]
