"""CSV cells as numbers: every fault is named with its file, row and column, and nothing is half-read."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from itertools import compress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.files import inputs
from serpenoid.files.inputs import RECORDING_BYTES, csv_rows
from serpenoid.files.workbook import table_text
from serpenoid.wording import counted

Floats = NDArray[np.float64]
Rows = list[list[str]]
PLAIN = re.compile(r"[0-9eE+., \t-]*", re.ASCII)  # cells that float() takes as everybody does
DATED = re.compile(
    r"([0-9]{4}-[0-9]{2}-[0-9]{2}|[0-9]{1,2}:[0-9]{2}"  # ISO 8601
    r"|[0-9]{1,2}[./-][0-9]{1,2}[./-]([0-9]{4}|[0-9]{2}\b)"  # 11.05.2023 and 5/11/23
    r"|[0-9]{1,2}[. /-]+[^\W\d_]{3,}|[^\W\d_]{3,}[. /-]+[0-9]{1,4}\b).*",  # 11. Mai and May-23
    re.DOTALL,
)
NO_DATES = (
    " Dates and times of day are not read: write seconds (or `time_unit`) since any moment, with their fractions, or "
    "count frames (`frames_per_second`). A position that is a date was made one by a spreadsheet: open the original "
    "there with its columns as text, or not at all."
)
FAILED = re.compile(r"#[^\W_]*[/0-9A-Z]*[!?]")  # #VALUE! and #DIV/0!, in any language
NO_FORMULAS = " A spreadsheet's formula failed there: mend it, or leave the cell empty."
HASHES = re.compile(r"##+")
NO_HASHES = " A spreadsheet's column was too narrow to show it: widen it and save again, or take the original."
MARKED = re.compile(r"[+-]?[0-9]{1,3}([,' \u00a0\u202f.][0-9]+)+", re.ASCII)  # 1,234.5 and 0,5
NO_MARKS = " Write a point before decimals, and nothing between thousands."
CURES = ((MARKED, NO_MARKS), (DATED, NO_DATES), (FAILED, NO_FORMULAS), (HASHES, NO_HASHES))
GROUPED = re.compile(r"[+-]?[1-9][0-9]{0,2}\.[0-9]{3}", re.ASCII)  # 1.234: perhaps a thousand
UNITS = {"s", "ms", "us", "ns", "m", "cm", "mm", "um", "px", "rad", "deg", "degrees"}
NO_UNITS = " Is that a row of units? Leave it out, and tell units in campaign.toml (docs/your-csv.md)."
MISSING = {"", "nan", "na", "n/a", "#n/a", "#nv", "null", "none", "-", "--"} | {  # of many programs; the rest: of C
    "-nan", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind"
}  # fmt: skip
UNEVEN = 0.5  # so much less unevenly do numbers run on whose marks divide thousands, read as that
LARGEST = 1e19  # a larger number is no measurement: nanoseconds since 1970 are 2e18


def read_rows(path: Path, live: bool = False) -> Rows:
    """All rows of a CSV but empty ones before and after, and those that begin with `#`; where the last of these names
    as many columns as the first row has numbers, it is the header. `live`: the file may end in the middle of a row
    (power loss): it is dropped."""
    text = table_text(path, RECORDING_BYTES)
    if not text.strip():
        raise InputError(f"{path}: is empty. Was the recording stopped before anything was written?")
    if live and not text.endswith("\n"):
        text = text[: text.rfind("\n") + 1]
    rows = csv_rows(_without_remarks(text), path)
    rows = rows[next((i for i, row in enumerate(rows) if any(map(str.strip, row))), len(rows)) :]
    if not rows:
        raise InputError(f"{path}: holds no complete row.")
    words = [len(row[0].split()) for row in rows[:2] if len(row) == 1]
    if len(words) == 2 and words[0] == words[1] > 1 and all(len(row) == 1 for row in rows):
        raise InputError(
            f"{path}: row 1: is one cell of {words[0]} words, as is the next: spaces separate nothing here. Write "
            "commas, semicolons or tabs between cells."
        )
    return rows


def _without_remarks(text: str) -> str:
    if "#" not in text:
        return text
    lines = text.splitlines()
    kept = [line for line in lines if not line.startswith("#")]
    first = next((i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), 0)
    if kept and first and lines[first - 1].startswith("#"):
        header, row = (inputs.csv_rows(line.lstrip("# "), "")[:1] for line in (lines[first - 1], lines[first]))
        numbers = [inputs.number(cell) is not None for cell in row[0]]
        if header and len(header[0]) == len(row[0]) and all(numbers) and numbers:
            kept.insert(0, lines[first - 1].lstrip("# "))
    return "\n".join(kept) + "\n" * text.endswith("\n")


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


def clock(time_s: float) -> str:
    """A moment [s] as it stands in a file, whenever its clock began."""
    return f"{time_s:.3f}".rstrip("0").rstrip(".")


def listed(words: Iterable[str]) -> str:
    """`a`, `a and b`, `a, b and c`: each once, as they come first."""
    different = list(dict.fromkeys(words))
    return " and ".join([", ".join(different[:-1])] * (len(different) > 1) + different[-1:])


def missing(cell: str) -> bool:
    """Whether a cell, without blanks about it, says that nothing was measured."""
    return cell.lower() in MISSING


def number(rows: Rows, row: int, column: int, path: Path, name: str = "") -> float:
    """One cell; empty, and what programs write for nothing, is NaN; infinities and other words are refused."""
    cell = rows[row][column].strip()
    if missing(cell):
        return math.nan
    value = inputs.number(cell)
    if value is None or abs(value) > LARGEST:
        cure = NO_UNITS if cell.strip("[]()") in UNITS else ""
        cure = next((words for form, words in CURES if form.fullmatch(cell)), cure)
        cure = f" Larger than {LARGEST:g} is no measurement." if value is not None else cure
        raise InputError(f"{place(path, row, column, name)}: must be a number or empty, got {cell[:40]!r}.{cure}")
    return value


def block(
    rows: Rows, first: int, columns: Sequence[int], names: Sequence[str], path: Path, width: int | None = None
) -> Floats:
    """Rows `first`.. as numbers, shape (rows, columns); short or long rows are refused. width: of each, default that of
    the row above."""
    width = len(rows[first - 1]) if width is None else width
    for row in range(first, len(rows)):
        if len(rows[row]) != width:
            twice = "Twice as many: are commas in its numbers? Write points there, or semicolons between cells."
            edited = "Is the file truncated, or were rows edited by hand?"
            if not rows[row]:
                edited = "Take empty lines out (Python's csv on Windows writes them without open(..., newline='')?)."
            raise InputError(
                f"{path}: row {row + 1}: has {counted(len(rows[row]), 'cell')} where the header has {width}. "
                f"{twice if len(rows[row]) == 2 * width else edited}"
            )
    if first >= len(rows):
        raise InputError(f"{path}: has a header and no data rows.")
    found = np.empty((len(rows) - first, len(columns)))  # a list of Python's numbers takes four times as much
    for row in range(first, len(rows)):
        cells = [rows[row][c] for c in columns]
        try:
            plain = PLAIN.fullmatch(",".join(cells))
            numbers = [float(cell or "nan") for cell in cells] if plain else []
        except ValueError:
            numbers = []
        cell = zip(columns, names, strict=True)
        found[row - first] = numbers or [number(rows, row, c, path, n) for c, n in cell]
    for row, column in np.argwhere(np.abs(found) > LARGEST)[:1].tolist():
        number(rows, first + row, columns[column], path, names[column])  # names the cell
    data = rows[first:]
    for column, values, name in zip(columns, found.T, names, strict=True):
        _refuse_thousands((row[column].strip() for row in data), values, place(path, first, column, name))
    return found


def _refuse_thousands(cells: Iterable[str], values: Floats, where: str) -> None:
    """Refuse a column whose marks divide thousands (998, 1.002): every number with a mark has three digits behind it
    and none before it is zero, others have none, and as thousands they run on far more evenly. Of most columns the
    first cell says that they do not."""
    every = []
    for cell in cells:
        if "." in cell and not GROUPED.fullmatch(cell):
            return
        every.append(cell)
    marked = np.array(["." in cell for cell in every])
    if not marked.any():
        return
    whole = ~marked & np.isfinite(values) & (values != 0)
    if whole.any() and np.abs(values[whole]).max() < 1000:
        seen = np.isfinite(values)
        as_thousands = np.where(marked, 1000 * values, values)
        if _unevenness(as_thousands[seen]) < UNEVEN * _unevenness(values[seen]):
            example = next(compress(every, marked))
            raise InputError(
                f"{where}: `{example}` and whole numbers below 1000 in one column: do marks divide thousands there, as "
                "spreadsheets write them? Save numbers without marks between thousands."
            )


def _unevenness(values: Floats) -> float:
    """Squared changes from row to row over the variance (von Neumann's ratio)."""
    return float(np.mean(np.diff(values) ** 2)) / max(float(np.var(values)), 1e-300)


def whole_points(floor: Floats, first: int, columns: Sequence[int], names: Sequence[str], path: Path) -> Floats:
    """Points (F, M, D), checked: all coordinates or none; columns, names (M,): where each begins."""
    seen = np.isfinite(floor)
    partly = np.argwhere(seen.any(axis=2) & ~seen.all(axis=2))
    if partly.size:
        row, point = (int(i) for i in partly[0])
        where = place(path, first + row, columns[point], names[point])
        raise InputError(f"{where}: a point has all its coordinates or none. Was the file edited?")
    return floor


def increasing_times(times: Floats, rows: int | NDArray[np.int64], column: int, path: Path, name: str) -> Floats:
    """The time column, checked: no empty cell, strictly increasing. rows: of the file, each or where they begin."""
    row_of = rows + np.arange(len(times)) if isinstance(rows, int) else rows
    missing = np.flatnonzero(~np.isfinite(times))
    if missing.size:
        raise InputError(f"{place(path, int(row_of[missing[0]]), column, name)}: time must not be empty.")
    back = np.flatnonzero(np.diff(times) <= 0)
    if back.size:
        row, again = int(row_of[back[0] + 1]), times[back[0] + 1] == times[back[0]]
        cure = "Two recordings in one file? Give each trial its own."
        if again:
            cure = "Is a row there twice, or has its time too few digits? Leave it out, or write more digits."
        elif len(times) > 2 and len(back) == len(times) - 1:
            cure = "All rows run backwards: sort them by their time."
        elif len(back) > 1:
            cure = "Rows in disorder? Sort them by their time. Several recordings in one file? Give each trial its own."
        raise InputError(
            f"{place(path, row, column, name)}: times must increase, got {times[back[0] + 1]:g} after "
            f"{times[back[0]]:g}. {cure}"
        )
    return times


def whole_frames(frames: Floats, first: int, column: int, path: Path, name: str) -> Floats:
    """A column that counts frames, checked: no fractions, which times have. first: row of the file where it begins."""
    broken = np.flatnonzero(np.isfinite(frames) & (frames != np.round(frames)))
    if broken.size:
        raise InputError(
            f"{place(path, first + int(broken[0]), column, name)}: frame numbers are whole, got {frames[broken[0]]:g}. "
            f'Are these times? Then `columns = {{ time = "{name}", ... }}` in [motion].'
        )
    return frames
