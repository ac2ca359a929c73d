"""A gait given as a joint table: T rows of m joint angles, the row after the last is the first again."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.files import write_csv
from serpenoid.schema import Record


class TableGait(Record):
    """Joint angles from a CSV file (header joint_1,...,joint_m; radians)."""

    family: Literal["table"]
    path: str = Field(description="CSV file, relative to the problem file")


def header(joint_count: int) -> list[str]:
    """Column names of a joint table."""
    return [f"joint_{j + 1}" for j in range(joint_count)]


def write_table(path: str | Path, angles: Floats) -> None:
    """Write a joint table, shape (T, m) [rad]."""
    write_csv(path, header(angles.shape[1]), angles.tolist())


def read_table(path: str | Path, joint_count: int | None = None) -> Floats:
    """Read a joint table, shape (T, m) [rad]; raise InputError naming row and column of the first fault."""
    try:
        with Path(path).open(newline="", encoding="utf-8") as stream:
            rows = [row for row in csv.reader(stream) if row]
    except FileNotFoundError:
        raise InputError(f"{path}: no such joint table.") from None
    except (UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: not a CSV text file ({error}).") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}).") from None
    m = joint_count or (len(rows[0]) if rows else 2)
    if not rows or rows[0] != header(m):
        names = ",".join(header(min(m, 3))) + (",..." if m > 3 else "")
        raise InputError(f"{path}: the header must be {names} with {m} joints.")
    if len(rows) < 4:
        raise InputError(f"{path}: a gait needs at least 3 rows, got {len(rows) - 1}.")
    return np.array([_numbers(path, number, row, m) for number, row in enumerate(rows[1:], start=2)])


def _numbers(path: str | Path, line: int, row: list[str], m: int) -> list[float]:
    if len(row) != m:
        raise InputError(f"{path}:{line}: needs {m} numbers, got {len(row)}. Was the file cut short?")
    values = []
    for column, cell in enumerate(row, start=1):
        try:
            value = float(cell)
        except ValueError:
            raise InputError(f"{path}:{line}: joint_{column} is {cell!r}, not a number.") from None
        if not np.isfinite(value) or abs(value) > np.pi:
            raise InputError(f"{path}:{line}: joint_{column} must be within +-pi rad, got {cell}. Are these degrees?")
        values.append(value)
    return values
