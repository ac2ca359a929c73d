"""Where a table begins, and what its columns are called.

Rows of facts above a header, and of labels and units below it, are passed over. Names that a header has twice are told
apart by the row above it, where that has words over several columns each (`tail x` of `x` below `tail`), else by their
number (`x 2`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.files.inputs import number
from serpenoid.measure.cells import CURES, Rows, missing, place
from serpenoid.measure.formats.columns import SPELT
from serpenoid.measure.tracks import LENGTHS

HIGHEST = 200  # rows above a header, at most
LABELS = 4  # rows between it and its numbers, at most
TIMES = {"sec": "s", "second": "s", "seconds": "s", "msec": "ms", "millisecond": "ms", "milliseconds": "ms"}


def header_row(rows: Rows, has: Callable[[list[str]], bool]) -> int:
    """The first row whose names have what is looked for; 0 where none has."""
    return next((i for i in range(min(HIGHEST, len(rows))) if has(names_of(rows, i))), 0)


def names_of(rows: Rows, at: int) -> list[str]:
    """What columns are called by a row, each name once."""
    own = [cell.strip() for cell in rows[at]]
    twice = {name for name, count in Counter(own).items() if name and count > 1}
    if not twice:
        return own
    groups = _groups(rows[at - 1], len(own)) if at else []
    if groups:
        return [" ".join(filter(None, pair)) for pair in zip(groups, own, strict=True)]
    before: Counter[str] = Counter()
    names = []
    for name in own:
        before[name] += 1
        names.append(f"{name} {before[name]}" if name in twice else name)
    return names


def same_names(rows: Rows, at: int) -> dict[str, list[int]]:
    """The columns of every name that a row has more than once, where `names_of` tells them apart by their number."""
    own, names = [cell.strip() for cell in rows[at]], names_of(rows, at)
    numbered = [name for name, count in Counter(own).items() if count > 1 and f"{name} 1" in names]
    return {name: [c for c, cell in enumerate(own) if cell == name] for name in numbered}


def _groups(row: Sequence[str], width: int) -> list[str]:
    """The word over each of so many columns, if it stands over several, at the first or at each; else none."""
    words = [cell.strip() for cell in row[:width]] + [""] * (width - len(row))
    over: list[str] = []
    for word in words:
        over.append(word or (over[-1] if over else ""))
    named = [word for word in words if word]
    several = len(set(over) - {""}) > 1 and max(Counter(filter(None, over)).values()) > 1
    return over if several and all(number(word) is None for word in named) else []


def refuse_nameless(row: Sequence[str], path: Path) -> None:
    """Refuse a row of numbers where names of columns belong."""
    words = [cell.strip() for cell in row if cell.strip()]
    if len(words) > 1 and all(number(word) is not None for word in words):
        raise InputError(
            f"{path}: row 1: has numbers where names of columns belong. Write a line of names above it, one "
            f"for each of its {len(row)} columns, and say in `columns` which are which (docs/your-csv.md). Of one "
            "point for each animal, as ToxTrac writes it, none can be: it says where they are, and not how they bend."
        )


def likely_header(rows: Rows) -> int:
    """The first of the rows of words that stand above numbers and are as wide; 0 where there are none."""
    first = next((i for i, row in enumerate(rows[:HIGHEST]) if _numbers(row)), 0)
    begin = first
    while begin and _named(rows[begin - 1]) and len(rows[begin - 1]) == len(rows[first]):
        begin -= 1
    while begin + 1 < first and _groups(rows[begin], len(rows[begin + 1])):
        begin += 1
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
