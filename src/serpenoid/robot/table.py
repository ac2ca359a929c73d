"""Joint tables: `joint_table.csv` of a results folder, or any CSV of its form, as a (T, m) array of radians.

Row `i` is the shape at step `i`; after the last row the first one is commanded again, unless it is a transient.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from serpenoid import table_file
from serpenoid.errors import InputError
from serpenoid.robot.stated import Stated, read_stated


@dataclass(frozen=True)
class JointTable:
    """T: steps, m: joints; `angles` (T, m) [rad], of a transient (T + 1, m); `stated`: what the results say of them."""

    angles: NDArray[np.float64]
    source: Path
    stated: Stated = Stated()

    @property
    def steps(self) -> int:
        return self.angles.shape[0] - (not self.closed)

    @property
    def closed(self) -> bool:
        return not self.stated.transient

    @property
    def joints(self) -> int:
        return self.angles.shape[1]


def read_table(path: str | Path) -> JointTable:
    """Read a results folder or a joint-table CSV; raise InputError naming line and column of the first bad cell."""
    path = Path(path)
    file = path / "joint_table.csv" if path.is_dir() else path
    if not file.exists():
        remedy = "Name a results folder (with joint_table.csv in it) or a joint-table CSV."
        raise InputError(f"{file}: no such file. {remedy}")
    return JointTable(table_file.read_table(file), file, read_stated(file))


def write_table(path: str | Path, angles: NDArray[np.float64]) -> None:
    """Write angles (T, m) [rad] with the header joint_1,...,joint_m."""
    table_file.write_table(path, angles)
