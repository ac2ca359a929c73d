"""Joint tables as CSV files: header joint_1,...,joint_m; T rows of angles [rad]; after the last row the first again.

In space a joint has two angles: header joint_1_yaw,...,joint_m_yaw,joint_1_pitch,...,joint_m_pitch.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.files.inputs import csv_rows, number
from serpenoid.files.workbook import table_text
from serpenoid.files.writing import write_csv
from serpenoid.wording import counted

EMPTY = " \t,;"  # a last line of nothing else: what is above it has its end
ALL_DIGITS = 17  # characters, of 0.123456789012345: spreadsheets write no more
SHORT = 6  # characters, of 0.1234: shorter ones are written by hand, with as many digits as they need


class ReadTable(NamedTuple):
    """angles: (T, m) [rad], in space (T, 2 m); ended: whether the last line is; of a file cut off it may not be."""

    angles: Floats
    in_space: bool
    ended: bool


def header(columns: int, in_space: bool = False) -> list[str]:
    """Column names of a joint table: one of each joint, in space two."""
    if in_space:
        return [f"{name}_{way}" for way in ("yaw", "pitch") for name in header(columns // 2)]
    return [f"joint_{j + 1}" for j in range(columns)]


def write_table(path: str | Path, angles: Floats, in_space: bool = False) -> None:
    """Write a joint table, shape (T, m) [rad]; in space (T, 2 m), `joint_1_yaw,...,joint_m_yaw,joint_1_pitch,...`."""
    write_csv(path, header(angles.shape[1], in_space), angles.tolist())


def read_table(path: str | Path, joint_count: int | None = None) -> Floats:
    """Read a joint table, shape (T, m) [rad]; raise InputError naming line and column of the first fault."""
    return plane(path, read_any_table(path, joint_count))


def plane(path: str | Path, table: ReadTable) -> Floats:
    """Its angles; InputError about one of a gait in space."""
    if table.in_space:
        raise InputError(
            f"{path}: has yaw and pitch of a gait in space, and one angle a joint is played here. For a robot of your "
            "own with both, `serpenoid export RESULTS --format csv` without --robot checks and writes them."
        )
    return table.angles


def read_any_table(path: str | Path, joint_count: int | None = None) -> ReadTable:
    """The same, also of a gait in space."""
    text = table_text(path)
    lines = [(line, row) for line, row in enumerate(csv_rows(text, path), start=1) if row]
    head = [cell.strip() for cell in lines[0][1]] if lines else []
    m = joint_count or len(head) or 2
    if Path(path).suffix.lower() == ".toml":
        raise InputError(f"{path}: is no joint table. Name a results folder (`serpenoid solve` writes one) or a CSV.")
    if not lines:
        raise InputError(
            f"{path}: is empty. A joint table has a header joint_1,joint_2,... and a row of radians a step."
        )
    in_space = head[0] == "joint_1_yaw"
    m = len(head) if in_space else m
    wanted = header(m, in_space)
    if head != wanted:
        names = ",".join(wanted[:3]) + (",..." if len(wanted) > 3 else "")
        joints = counted(m // 2 if in_space else m, "joint")
        raise InputError(f"{path}: the header must be {names} with {joints}, got {','.join(head)[:60]!r}.")
    if len(lines) < 4:
        raise InputError(f"{path}: a gait needs at least 3 rows, got {len(lines) - 1}.")
    angles = np.array([_numbers(path, line, row, head) for line, row in lines[1:]])
    ended = text.rstrip(EMPTY).endswith(("\n", "\r"))
    if not ended:
        _refuse_cut(path, lines[1:])
    return ReadTable(angles, in_space, ended)


def _refuse_cut(path: str | Path, lines: list[tuple[int, list[str]]]) -> None:
    """InputError where the last line has no end, and either the last number is shorter than all others, and these are
    not short, or all digits are there, as programs write them that end their lines: rows may be missing, too."""
    *others, last = (cell.strip().lstrip("+-") for _, row in lines for cell in row)
    if len(last) < min(map(len, others)) >= SHORT:
        said = f"the last number, {last}, is shorter than any other, and its line has no end"
    elif max(map(len, others)) >= ALL_DIGITS:
        said = "the last line has no end, and programs that write so many digits end their lines"
    else:
        return
    raise InputError(f"{path}:{lines[-1][0]}: {said}. Was the file cut short? If not, end the line.")


def _numbers(path: str | Path, line: int, row: list[str], names: list[str]) -> list[float]:
    if len(row) != len(names):
        wanted = counted(len(names), "number")
        raise InputError(f"{path}:{line}: needs {wanted}, got {len(row)}. Was the file cut short?")
    values = []
    for name, cell in zip(names, row, strict=True):
        value = number(cell)
        if value is None:
            raise InputError(f"{path}:{line}: {name} is {cell[:40]!r}, not a number.")
        if abs(value) > math.pi:
            raise InputError(f"{path}:{line}: {name} must be within +-pi rad, got {cell}. Are these degrees?")
        values.append(value)
    return values
