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
from serpenoid.robot.stated import Stated, read_stated, record_of


@dataclass(frozen=True)
class JointTable:
    """T: steps, m: joints; `angles` (T, m) [rad], of a transient (T + 1, m); `stated`: what the results say of them.

    in_space: a joint has yaw and pitch, `angles` 2 m columns; such a table is written, not played. doubts: what is to
    be known of the file before a robot plays it.
    """

    angles: NDArray[np.float64]
    source: Path
    stated: Stated = Stated()
    in_space: bool = False
    doubts: tuple[str, ...] = ()

    @property
    def steps(self) -> int:
        return self.angles.shape[0] - (not self.closed)

    @property
    def closed(self) -> bool:
        return not self.stated.transient

    @property
    def joints(self) -> int:
        return self.angles.shape[1] // (2 if self.in_space else 1)

    @property
    def columns(self) -> list[str]:
        """What each column of `angles` is called."""
        return table_file.header(self.angles.shape[1], self.in_space)


def read_table(path: str | Path, any_table: bool = False) -> JointTable:
    """Read a results folder or a joint-table CSV; raise InputError naming line and column of the first bad cell.

    any_table: also one of yaw and pitch, which no robot file maps to servos.
    """
    path = Path(path)
    file = path / "joint_table.csv" if path.is_dir() else path
    if not file.exists():
        remedy = "Name a results folder (with joint_table.csv in it) or a joint-table CSV."
        raise InputError(f"{file}: no such file. {remedy}")
    table = table_file.read_any_table(file)
    if not any_table:
        table_file.plane(file, table)
    doubts: tuple[str, ...] = ()
    if not table.ended:
        doubts = (f"{file}: the last line has no end. Was the file cut short within its last number?",)
        if record_of(file) is not None:  # written here, where every line has one
            raise InputError(f"{doubts[0]} Write the results again; if a program of your own wrote it, end the line.")
    return JointTable(table.angles, file, read_stated(file), table.in_space, doubts)


def write_table(path: str | Path, angles: NDArray[np.float64], in_space: bool = False) -> None:
    """Write angles (T, m) [rad] with the header joint_1,...,joint_m; in space (T, 2 m), all yaws, then all pitches."""
    table_file.write_table(path, angles, in_space)
