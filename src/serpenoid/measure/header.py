"""Where a table begins: rows of facts above its header, and of labels and units below it, are passed over."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.files.inputs import number
from serpenoid.measure.cells import CURES, Rows, missing, place
from serpenoid.measure.columns import SPELT
from serpenoid.measure.tracks import LENGTHS

HIGHEST = 200  # rows above a header, at most
LABELS = 4  # rows between it and its numbers, at most
TIMES = {"sec": "s", "second": "s", "seconds": "s", "msec": "ms", "millisecond": "ms", "milliseconds": "ms"}


def header_row(rows: Rows, has: Callable[[list[str]], bool]) -> int:
    """The first row that has what is looked for; 0 where none has."""
    stripped = ([cell.strip() for cell in row] for row in rows[:HIGHEST])
    return next((i for i, row in enumerate(stripped) if has(row)), 0)


def likely_header(rows: Rows) -> int:
    """The first of the rows of words that stand above numbers and are as wide; 0 where there are none."""
    first = next((i for i, row in enumerate(rows[:HIGHEST]) if _numbers(row)), 0)
    begin = first
    while begin and _named(rows[begin - 1]) and len(rows[begin - 1]) == len(rows[first]):
        begin -= 1
    return begin if begin < first else 0


def _numbers(row: Sequence[str]) -> bool:
    cells = [cell.strip() for cell in row if not missing(cell.strip())]
    return len(cells) > 1 and sum(number(cell) is not None for cell in cells) > len(cells) / 2


def _named(row: Sequence[str]) -> bool:
    words = [cell for cell in row if cell.strip()]
    return len(words) > 2 and all(number(cell) is None for cell in words)  # a fact is one word, or a word and another


def first_row(rows: Rows, header: int, columns: Sequence[int], units: Mapping[int, tuple[str, str]], path: Path) -> int:
    """The first row of numbers below a header: rows of labels and units, in which none of these columns has a number
    and some have words, are passed over. units: of columns that have one, its key and what they are read in; raises
    InputError where such a row says another."""
    row = header + 1
    while row <= header + LABELS and row < len(rows) - 1 and _labels(rows[row], columns):
        for column, (key, unit) in units.items():
            said = _unit(rows[row][column].strip()) if column < len(rows[row]) else None
            if said not in (None, unit) and (said in LENGTHS) == (unit in LENGTHS):
                raise InputError(
                    f"{place(path, row, column)}: says {said}, and the column is read in {unit}: "
                    f'`{key} = "{said}"` in campaign.toml, or correct the row.'
                )
        row += 1
    return row


def width_of(rows: Rows, first: int, header: Sequence[str], columns: Collection[int]) -> int:
    """Cells of a row of numbers: as many as the header has, or less where it goes on beyond all these columns, as it
    does where remarks may stand behind them."""
    there = len(rows[first]) if first < len(rows) else len(header)
    return there if max(columns) < there < len(header) else len(header)


def _labels(row: Sequence[str], columns: Collection[int]) -> bool:
    cells = [row[column].strip() for column in columns if column < len(row)]
    words = [cell for cell in cells if not missing(cell)]
    broken = any(form.fullmatch(word) for word in words for form, _ in CURES)
    return bool(words) and not broken and all(number(word) is None for word in words)


def _unit(word: str) -> str | None:
    bare = word.strip("[]() ").translate(SPELT).casefold()
    return LENGTHS.get(bare) or TIMES.get(bare) or (bare if bare in ("s", "ms", "us", "ns") else None)
