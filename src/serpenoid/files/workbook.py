"""Tables that a spreadsheet holds (.xlsx), as the text of a CSV: whatever reads one reads the other.

Of a workbook the one sheet is read that holds anything. It takes openpyxl (`pip install 'serpenoid[excel]'`).
"""

from __future__ import annotations

import csv
import io
import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from serpenoid.errors import InputError
from serpenoid.files.inputs import DENSEST, SETTINGS_BYTES, SHEETS, SPREADSHEET, ZIP, begins, read_bytes, read_text

BOOK = "xl/workbook.xml"
# of archives, XML and what openpyxl makes of it
BROKEN = (OSError, EOFError, zlib.error, zipfile.BadZipFile, SyntaxError, LookupError, RuntimeError, ValueError,
          TypeError, AttributeError, OverflowError, MemoryError)  # fmt: skip
AS_CSV = "Save the sheet that holds the table as CSV in UTF-8."
MOST_CELLS = 50_000_000


def table_text(path: str | Path, most: int = SETTINGS_BYTES) -> str:
    """A table's file as text: of a workbook its sheet's rows, commas between cells and a line's end behind each; else
    the text itself. Raises InputError where there is no such thing, or more than `most` bytes of it."""
    if not begins(path, ZIP):
        return read_text(path, most)
    data = read_bytes(path, most)
    if not _is_book(data, path, most):
        return read_text(path, most)
    try:
        import openpyxl  # noqa: F401 - whether it is there
    except ImportError:
        raise InputError(
            f"{path}: reading Excel workbooks needs openpyxl: pip install openpyxl. Or: {AS_CSV}"
        ) from None
    try:
        return _as_csv(data, path)
    except InputError:
        raise
    except BROKEN as error:
        raise InputError(f"{path}: not a readable Excel workbook ({str(error)[:100]}). {AS_CSV}") from None


def _is_book(data: bytes, path: str | Path, most: int) -> bool:
    """Whether a zip archive is a workbook; InputError of one that is broken, or far larger than its file."""
    if not any(name.encode() in data for name in SHEETS):
        return False
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            size, names = sum(part.file_size for part in archive.infolist()), archive.namelist()
    except BROKEN as error:
        raise InputError(
            f"{path}: not a text file but {SPREADSHEET}, and cannot be unpacked ({error}). Was the copy cut off?"
        ) from None
    if size > min(most, max(SETTINGS_BYTES, DENSEST * len(data))):
        raise InputError(f"{path}: holds {size / 1e6:.0f} MB when unpacked, which no recording does. {AS_CSV}")
    return BOOK in names


def _as_csv(data: bytes, path: str | Path) -> str:
    from openpyxl import load_workbook

    book = load_workbook(io.BytesIO(data), read_only=True, data_only=True)
    filled = {sheet.title: rows for sheet in book.worksheets if (rows := _rows(sheet, path))}
    if len(filled) != 1:
        listed = ", ".join(f"`{name}`" for name in filled)
        raise InputError(
            f"{path}: has {len(filled)} sheets that hold anything, {listed}, where one is read. {AS_CSV}"
            if filled
            else f"{path}: is empty: no sheet of the workbook holds anything."
        )
    title, rows = filled.popitem()
    formulas = load_workbook(io.BytesIO(data), read_only=True)[title] if _has_formulas(data) else None
    if formulas is not None and _never_computed(rows, _rows(formulas, path)):
        raise InputError(
            f"{path}: its formulas were never computed: open it in a spreadsheet and save it again. Or: {AS_CSV}"
        )
    wide = max(map(len, rows))
    if wide * len(rows) > MOST_CELLS:
        raise InputError(f"{path}: has {len(rows)} rows of {wide} cells. Is it the right file?")
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(row + [""] * (wide - len(row)) for row in rows)
    return f"sep=,\n{text.getvalue()}"


def _rows(sheet: Any, path: str | Path) -> list[list[str]]:
    """Words of all cells, without empty ones at the ends of rows, and without empty rows at the end."""
    sheet.reset_dimensions()  # some programs write others than the sheet has
    rows: list[list[str]] = []
    filled = cells = 0
    for values in sheet.iter_rows(values_only=True):
        words = [_word(value) for value in values]
        while words and not words[-1]:
            words.pop()
        rows.append(words)
        filled, cells = (len(rows) if words else filled), cells + len(words)
        if cells > MOST_CELLS:
            raise InputError(f"{path}: sheet `{sheet.title}` has more than {MOST_CELLS} cells. Is it the right file?")
    return rows[:filled]


def _word(value: Any) -> str:
    """A cell's value, of numbers all digits, on one line."""
    if value is None:
        return ""
    return repr(value) if isinstance(value, float) else " ".join(str(value).splitlines()).strip()


def _has_formulas(data: bytes) -> bool:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        sheets = (name for name in archive.namelist() if name.startswith("xl/worksheets/") and name.endswith(".xml"))
        return any(b"<f>" in part or b"<f " in part for part in map(archive.read, sheets))


def _never_computed(rows: list[list[str]], formulas: list[list[str]]) -> bool:
    """Whether cells hold formulas, and none of these a value."""
    found = list(_values_of_formulas(rows, formulas))
    return bool(found) and not any(found)


def _values_of_formulas(rows: list[list[str]], formulas: list[list[str]]) -> Iterator[str]:
    for k, row in enumerate(formulas):
        there = rows[k] if k < len(rows) else []
        yield from (there[c] if c < len(there) else "" for c, word in enumerate(row) if word.startswith("="))
