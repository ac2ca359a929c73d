"""Reading files that others wrote: regular files of a bounded size, UTF-8 text, JSON without surprises.

Everything the package reads comes through here, so that no pipe, device or endless file can hold it up and every
fault is an InputError that begins with the file's name.
"""

from __future__ import annotations

import codecs
import csv
import gzip
import io
import json
import math
import os
import re
import stat
import zipfile
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

from serpenoid.errors import InputError

SETTINGS_BYTES = 20_000_000  # problem, model, robot, campaign and result files, joint tables
RECORDING_BYTES = 1_000_000_000  # an hour of a hundred markers at 100 frames/s as text
DENSEST = 100  # times what it is packed to: recordings as text are packed to a fifth or a twentieth
DEEPEST = 32  # sections within sections; what the package writes has 7
CELL_CHARACTERS = 100_000
GZIP, ZIP = b"\x1f\x8b", b"PK\x03\x04"
MATLAB = b"MATLAB "  # whatever its files are called
SHEETS = ("[Content_Types].xml", "mimetype")  # what archives hold that are spreadsheets: xlsx, ods
BESIDE = re.compile(r"(.*/)?(__MACOSX/.*|\..*|.*/)")  # what archives hold beside their files
SPREADSHEET = "a spreadsheet (xlsx, ods) or another zip archive"
MOST_NAMED = 4
PICTURES = "a video or a picture. Track points along the body in it first, and name the table of these"
FTYP = slice(4, 8)  # where MP4 and QuickTime have that word
NO_TEXT = {
    ZIP: f"{SPREADSHEET}. Save the sheet as CSV in UTF-8, or unpack it",
    b"\xd0\xcf\x11\xe0": "an old spreadsheet (xls), or one with a password. Save the sheet as CSV in UTF-8",
    MATLAB: 'one of MATLAB\'s: is `format = "array"` meant?',
    b"\x02P": 'a C3D file: is `format = "c3d"` meant?',
    b"<?xml": 'one of XML: of TrackMate, `format = "trackmate"`. Of others export a table of points as CSV',
    b"PAR1": "a table of Parquet. Save it as CSV",
    b"ARROW1": "a table of Feather. Save it as CSV",
    b"SQLite format 3": "a database of SQLite. Export its table as CSV",
    **dict.fromkeys((b"\x80\x04", b"\x80\x05"), "a pickle of Python. Save a table as CSV, or an array with np.savez"),
    **dict.fromkeys((b"RIFF", b"\x1aE\xdf\xa3", b"II*\0", b"MM\0*", b"\x89PNG", b"GIF8"), PICTURES),
    b"\x89HDF": "an HDF5 file. Is `format` that of another program, or the file to be exported as CSV?",
}  # what files begin with that are often taken for text
DECIMAL_COMMA = re.compile(r"\s*[+-]?[0-9]*,[0-9]+([eE][+-]?[0-9]+)?\s*", re.ASCII)
SEPARATORS = ",;\t|"
QUOTED = re.compile(r'"[^"]*"')
DIRECTIVE = re.compile(r'"?sep=(.)"?', re.IGNORECASE)  # the first line that some spreadsheets write and take
BROKEN_ARCHIVE = (OSError, EOFError, zlib.error, zipfile.BadZipFile, RuntimeError, ValueError)  # encrypted: the fifth
NUMBER = re.compile(r"\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*", re.ASCII)


def read_bytes(path: str | Path, most: int = SETTINGS_BYTES) -> bytes:
    """The file's bytes; refuse what is no regular file or larger than `most` bytes."""
    try:
        # without O_NONBLOCK opening a pipe waits for somebody to write into it
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0))
        with open(descriptor, "rb") as stream:
            kind = os.fstat(descriptor).st_mode
            if not stat.S_ISREG(kind):
                what = "is a folder; name a file in it" if stat.S_ISDIR(kind) else "is a pipe or a device, not a file"
                raise InputError(f"{path}: {what}.")
            data = stream.read(most + 1)
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: no such file.") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder; name a file in it.") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror}).") from None
    except ValueError:  # a zero byte in the name
        raise InputError(f"{str(path)!r}: no file can have such a name.") from None
    if len(data) > most:
        raise InputError(f"{path}: must be at most {most / 1e6:g} MB. Is it the right file?")
    return data


def read_unpacked(path: str | Path, most: int = SETTINGS_BYTES) -> bytes:
    """The file's bytes, or those of the one file that gzip or a zip archive packed into it."""
    data = read_bytes(path, most)
    if data.startswith(GZIP):
        return _bounded(lambda size: _of_gzip(data, size), len(data), "gzip", path, most)
    if data.startswith(ZIP) and not any(name.encode() in data for name in SHEETS):
        return _bounded(lambda size: _of_archive(data, path, size), len(data), "zip", path, most)
    return data


def read_text(path: str | Path, most: int = SETTINGS_BYTES) -> str:
    """UTF-8 text, with or without a byte-order mark, UTF-16 with one, or such text packed by gzip or zip."""
    data = read_unpacked(path, most)
    what = next((words for begin, words in NO_TEXT.items() if data.startswith(begin)), None)
    if what is not None or data[FTYP] == b"ftyp":
        what = what or PICTURES
        raise InputError(f"{path}: not a text file but {what}{'' if what.endswith('?') else '.'}")
    wide = data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE))
    try:
        text = data.decode("utf-16" if wide else "utf-8-sig")
    except UnicodeDecodeError as error:
        sheet = "" if str(path).endswith(".toml") else ' (spreadsheets call that "CSV UTF-8")'
        cure = "" if b"\0" in data else f" Save it as UTF-8{sheet}."
        raise InputError(f"{path}: not a text file in UTF-8 ({error.reason} at byte {error.start}).{cure}") from None
    if "\0" in text:
        cure = " Is it text in UTF-16 or UTF-32? Save it as UTF-8." if text.count("\0") >= len(text) // 3 else ""
        raise InputError(f"{path}: not a text file (a zero byte at character {text.index(chr(0))}).{cure}")
    # two ends of a line: of a program that ends lines itself, in a file that ends them once more
    return text.lstrip("\ufeff").replace("\r\r\n", "\n")


def begins(path: str | Path, mark: bytes) -> bool:
    """Whether a regular file begins with these bytes; not, where it cannot be read."""
    try:
        if not Path(path).is_file():
            return False
        with open(path, "rb") as stream:
            return stream.read(len(mark)) == mark
    except (OSError, ValueError):
        return False


def first_line(path: Path) -> str:
    """Its first 200 characters at most; empty of what is no text."""
    try:
        with path.open(encoding="utf-8") as file:
            return file.readline(200)
    except (OSError, UnicodeDecodeError):
        return ""


def _bounded(unpack: Callable[[int], bytes], size: int, packer: str, path: str | Path, most: int) -> bytes:
    """What `unpack` gives of at most so many bytes; InputError where there are more than a recording has."""
    likely = max(SETTINGS_BYTES, DENSEST * size)
    try:
        found = unpack(min(most, likely) + 1)
    except InputError:
        raise
    except BROKEN_ARCHIVE as error:
        what = f"not a text file but {SPREADSHEET}" if packer == "zip" else f"packed by {packer}"
        cure = " Save the sheet as CSV in UTF-8, or unpack it." if packer == "zip" else ""
        raise InputError(f"{path}: {what}, and cannot be unpacked ({error}). Was the copy cut off?{cure}") from None
    if len(found) > most:
        raise InputError(f"{path}: must be at most {most / 1e6:g} MB when unpacked. Is it the right file?")
    if len(found) > likely:
        raise InputError(
            f"{path}: packed by {packer} to less than a part in {DENSEST}, which no recording is. Is it the right file?"
        )
    return found


def _of_gzip(data: bytes, size: int) -> bytes:
    with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
        return stream.read(size)


def _of_archive(data: bytes, path: str | Path, size: int) -> bytes:
    """Of the one file in a zip archive."""
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        names = [name for name in archive.namelist() if not BESIDE.fullmatch(name)]
        if len(names) != 1:
            there = ", ".join(f"`{name}`" for name in names[:MOST_NAMED]) + ", ..." * (len(names) > MOST_NAMED)
            raise InputError(
                f"{path}: a zip archive of {len(names)} files{f' ({there})' if names else ''}, where one is read. "
                "Unpack it, and name one of them."
            )
        with archive.open(names[0]) as stream:
            return stream.read(size)


def csv_rows(text: str, path: str | Path) -> list[list[str]]:
    """All rows of a CSV's text, without empty cells at its ends.

    A first line `sep=;`, which is no row, says what separates cells, else the mark does that the first line with any
    has most of. Where that is no comma, numbers may have decimal commas, as spreadsheets of many languages write them,
    unless any below the first row has a point.
    """
    csv.field_size_limit(CELL_CHARACTERS)
    lines = text.splitlines()
    separator = _separator(lines)
    if lines and DIRECTIVE.fullmatch(lines[0]):
        lines = lines[1:]
    try:
        rows = list(csv.reader(lines, delimiter=separator))
    except csv.Error as error:
        raise InputError(f"{path}: not a CSV file: {error}.") from None
    rows = without_empty_ends(rows)
    if separator == ",":
        return rows
    if "." in text and any("." in cell and NUMBER.fullmatch(cell) for row in rows[1:] for cell in row):
        return rows
    return [[cell.replace(",", ".") if DECIMAL_COMMA.fullmatch(cell) else cell for cell in row] for row in rows]


def without_empty_ends(rows: list[list[str]]) -> list[list[str]]:
    """Rows without what is at the end of a sheet but says nothing: columns and rows of empty cells."""
    end = next((i for i in range(len(rows), 0, -1) if any(map(str.strip, rows[i - 1]))), 0)
    width = widest = max(map(len, rows), default=0)
    while width and not any(len(row) >= width and row[width - 1].strip() for row in rows):
        width -= 1
    return rows[:end] if width == widest else [row[:width] for row in rows[:end]]


def _separator(lines: Sequence[str]) -> str:
    if lines and (said := DIRECTIVE.fullmatch(lines[0])):
        return said[1]
    bare = (QUOTED.sub("", line) for line in lines)
    header = next((line for line in bare if any(mark in line for mark in SEPARATORS)), "")
    return max(SEPARATORS, key=header.count)


def number(cell: str) -> float | None:
    """A cell as a finite number; None for words, `1_000`, infinities and digits of other scripts."""
    value = float(cell) if NUMBER.fullmatch(cell) else math.inf
    return value if math.isfinite(value) else None


def read_json(path: str | Path) -> Any:
    """JSON values; refuse numbers that are not finite and nesting beyond DEEPEST."""

    def finite(number: str) -> float:
        value = float(number)
        if not math.isfinite(value):
            raise InputError(f"{path}: {number} is too large for a number.")
        return value

    def refuse(word: str) -> NoReturn:
        raise InputError(f"{path}: {word} is not a JSON number; null stands for an unknown one.")

    try:
        data = json.loads(read_text(path), parse_float=finite, parse_constant=refuse)
    except InputError:
        raise
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid JSON: {_reason(error)}.") from None
    refuse_depth(data, path)
    return data


def refuse_depth(data: Any, path: str | Path) -> None:
    """Refuse values nested deeper than DEEPEST; without recursion, which is what they would break."""
    level = [data]
    for _ in range(DEEPEST):
        below = (v.values() if isinstance(v, dict) else v for v in level if isinstance(v, dict | list))
        level = [item for values in below for item in values]
        if not level:
            return
    raise InputError(f"{path}: is nested more than {DEEPEST} levels deep.")


def _reason(error: Exception) -> str:
    return "nested too deeply" if isinstance(error, RecursionError) else str(error)
