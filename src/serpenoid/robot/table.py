"""Joint tables: `joint_table.csv` of a results folder, or any CSV of its form, as a (T, m) array of radians.

Row `i` is the shape at step `i`; after the last row the first one is commanded again.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.files import write_csv
from serpenoid.robot.stated import Stated, read_stated


@dataclass(frozen=True)
class JointTable:
    """T: steps, m: joints; `angles` (T, m) [rad]; `stated`: what the results say of them."""

    angles: NDArray[np.float64]
    source: Path
    stated: Stated = Stated()

    @property
    def steps(self) -> int:
        return self.angles.shape[0]

    @property
    def joints(self) -> int:
        return self.angles.shape[1]


def read_table(path: str | Path) -> JointTable:
    """Read a results folder or a joint-table CSV; raise InputError naming line and column of the first bad cell."""
    path = Path(path)
    file = path / "joint_table.csv" if path.is_dir() else path
    if not file.is_file():
        remedy = "Name a results folder (with joint_table.csv in it) or a joint-table CSV."
        raise InputError(f"{file}: no such file. {remedy}")
    return JointTable(_read_angles(file), file, read_stated(file.parent / "solution.json"))


def write_table(path: str | Path, angles: NDArray[np.float64]) -> None:
    """Write angles (T, m) [rad] with the header joint_1,...,joint_m."""
    write_csv(path, [f"joint_{j + 1}" for j in range(angles.shape[1])], angles.tolist())


def _read_angles(file: Path) -> NDArray[np.float64]:
    try:
        rows = list(csv.reader(file.read_text(encoding="utf-8").splitlines()))
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{file}: not a CSV text file ({error}).") from None
    header = [cell.strip() for cell in rows[0]] if rows else []
    expected = [f"joint_{j + 1}" for j in range(len(header))]
    if not header or header != expected:
        raise InputError(f"{file}: line 1 must be the header joint_1,...,joint_m, got {','.join(header)[:60]!r}.")
    body = [(number, row) for number, row in enumerate(rows[1:], start=2) if row]
    if len(body) < 2:
        raise InputError(f"{file}: needs at least two rows of angles, got {len(body)}. A gait is a cycle of shapes.")
    return np.array([_read_row(file, number, row, len(header)) for number, row in body])


def _read_row(file: Path, number: int, row: list[str], joints: int) -> list[float]:
    if len(row) != joints:
        raise InputError(f"{file}: line {number} has {len(row)} cells, the header has {joints}. Is the file cut short?")
    try:
        return [float(cell) for cell in row]
    except ValueError as error:
        raise InputError(f"{file}: line {number}: {error}. Angles are numbers in radians.") from None
