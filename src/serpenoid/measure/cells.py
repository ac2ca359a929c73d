"""CSV cells as numbers: every fault is named with its file, row and column, and nothing is half-read."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError

Floats = NDArray[np.float64]
Rows = list[list[str]]


def read_rows(path: Path, live: bool = False) -> Rows:
    """All rows of a CSV. `live`: the file may end in the middle of a row (power loss): it is dropped."""
    text = _read_text(path)
    if not text.strip():
        raise InputError(f"{path}: is empty. Was the recording stopped before anything was written?")
    if live and not text.endswith("\n"):
        text = text[: text.rfind("\n") + 1]
    try:
        rows = list(csv.reader(text.splitlines()))
    except csv.Error as error:
        raise InputError(f"{path}: not a CSV file: {error}.") from None
    while rows and not any(cell.strip() for cell in rows[-1]):
        rows.pop()
    if not rows:
        raise InputError(f"{path}: holds no complete row.")
    return rows


def _read_text(path: Path) -> str:
    try:
        text = path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(f"{path}: no such file.") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a CSV file.") from None
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file ({error.reason} at byte {error.start}); export it as CSV.") from None
    if "\0" in text:
        raise InputError(f"{path}: not a text file (a zero byte at {text.index(chr(0))}); export it as CSV.")
    return text


def column_letter(column: int) -> str:
    """0 -> A, 25 -> Z, 26 -> AA: as a spreadsheet shows it."""
    letters = ""
    column += 1
    while column:
        column, digit = divmod(column - 1, 26)
        letters = chr(65 + digit) + letters
    return letters


def place(path: Path, row: int, column: int, name: str = "") -> str:
    """`file: row 12, column C (`t_s`)`, rows counted from 1."""
    named = f" (`{name}`)" if name else ""
    return f"{path}: row {row + 1}, column {column_letter(column)}{named}"


def number(rows: Rows, row: int, column: int, path: Path, name: str = "") -> float:
    """One cell; empty is NaN; infinities and words are refused."""
    cell = rows[row][column].strip()
    if not cell or cell.lower() == "nan":
        return math.nan
    try:
        value = float(cell)
    except ValueError:
        raise InputError(f"{place(path, row, column, name)}: must be a number or empty, got {cell!r}.") from None
    if math.isinf(value):
        raise InputError(f"{place(path, row, column, name)}: must be finite, got {cell!r}.")
    return value


def block(rows: Rows, first: int, columns: Sequence[int], names: Sequence[str], path: Path) -> Floats:
    """Rows `first`.. as numbers, shape (rows, columns); short or long rows are refused."""
    width = len(rows[first - 1])
    for row in range(first, len(rows)):
        if len(rows[row]) != width:
            raise InputError(
                f"{path}: row {row + 1}: has {len(rows[row])} cells where the header has {width}. "
                "Is the file truncated, or were rows edited by hand?"
            )
    if first >= len(rows):
        raise InputError(f"{path}: has a header and no data rows.")
    try:
        return np.array([[float(rows[r][c] or "nan") for c in columns] for r in range(first, len(rows))]).reshape(
            len(rows) - first, len(columns)
        )
    except ValueError:
        cells = [
            [number(rows, r, c, path, n) for c, n in zip(columns, names, strict=True)] for r in range(first, len(rows))
        ]
        return np.array(cells)


def increasing_times(times: Floats, first: int, column: int, path: Path, name: str) -> Floats:
    """The time column, checked: no empty cell, strictly increasing."""
    missing = np.flatnonzero(~np.isfinite(times))
    if missing.size:
        raise InputError(f"{place(path, first + int(missing[0]), column, name)}: time must not be empty.")
    back = np.flatnonzero(np.diff(times) <= 0)
    if back.size:
        row = first + int(back[0]) + 1
        raise InputError(
            f"{place(path, row, column, name)}: times must increase, got {times[back[0] + 1]:g} after "
            f"{times[back[0]]:g}. "
            "Two recordings in one file?"
        )
    return times
