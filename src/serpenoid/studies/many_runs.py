"""Many results folders as one table: a line a run (of a campaign: a trial), the numbers of its record as columns.

Names of nested values are joined by dots (`gain.path_rms_m.before`); a pair (an interval) becomes two columns, `.0` and
`.1`; of named things (effects) the names are listed. Longer arrays stay in the record, which `folder` names.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

from serpenoid.errors import InputError
from serpenoid.files.inputs import first_line, read_json
from serpenoid.files.schema import read_toml
from serpenoid.files.writing import EARLIER, write_csv

Row = dict[str, Any]
# record -> the list within it that has a line an entry; None: one line for all
RECORDS: dict[str, str | None] = {
    "solution.json": None, "diagnosis.json": None, "fit.json": None, "campaign.json": "trials",
    "compare.json": "comparisons", "set.json": "gaits", "in-use.json": None, "play.json": None,
}  # fmt: skip
CAMPAIGN = "campaign.toml"
UNREADABLE = "unreadable"
FIRST = ("folder", "record", "campaign", "problem", "trial", "gait", "status", "verdict")


def table_of(folders: Iterable[Path]) -> list[Row]:
    """Rows of all results in and below the folders, in the order of their paths."""
    rows: list[Row] = []
    for folder in folders:
        if folder.is_file():
            raise InputError(f"{folder}: is a file, no folder. Name the folder it is in, or one above.")
        if not folder.is_dir():
            raise InputError(f"{folder}: no such folder. Name one that holds results, or folders of them.")
        for path in sorted(folder.rglob("*")):
            if path.name in {*RECORDS, CAMPAIGN} and not _set_aside(path.relative_to(folder)):
                rows += _rows_or_fault(path)
    if not rows:
        raise InputError(f"{', '.join(map(str, folders))}: no results there: none of {', '.join(RECORDS)}, {CAMPAIGN}.")
    return rows


def write_table(path: str | Path, rows: Sequence[Row]) -> None:
    """A CSV with every column that any row has; an empty cell where a row has no such value."""
    names = dict.fromkeys(name for row in rows for name in row)
    header = [n for n in FIRST if n in names] + [n for n in names if n not in FIRST]
    write_csv(path, header, [["" if row.get(n) is None else row[n] for n in header] for row in rows])


def is_table(path: Path) -> bool:
    """Whether a file begins as `write_table` begins one."""
    return first_line(path).split(",")[:2] == list(FIRST[:2])


def _set_aside(path: Path) -> bool:
    return any(part.startswith(EARLIER) for part in path.parts)


def _rows_or_fault(path: Path) -> list[Row]:
    """One damaged record, of a run that was killed, does not keep the others back: it is a line that says so."""
    try:
        return _rows(path)
    except InputError as error:
        return [{"folder": str(path.parent), "record": path.stem, "status": UNREADABLE, "message": str(error)}]


def _rows(path: Path) -> list[Row]:
    kept: Row
    each: str | None
    if path.name == CAMPAIGN:
        data, each = read_toml(path), "trial"
        kept = {"campaign": data.get("name")}
    else:
        data, each = read_json(path), RECORDS[path.name]
        if not isinstance(data, dict):
            raise InputError(f"{path}: is not a record of this package.")
        kept = dict(_flat({k: v for k, v in data.items() if k != each}))
    about: Row = {"folder": str(path.parent), "record": path.stem if path.name != CAMPAIGN else "trials"}
    about["problem"] = kept.pop("provenance.problem", None)
    own = {k: v for k, v in kept.items() if not k.startswith("provenance.versions.")}
    if each is None:
        return [about | own]
    entries = data.get(each, [])
    if not isinstance(entries, list):
        raise InputError(f"{path}: `{each}` must be a list. Was the file edited?")
    entries = [e for e in entries if isinstance(e, dict)]
    return [about | own | _named(dict(_flat(entry))) for entry in entries]


def _named(entry: Row) -> Row:
    """A trial's name stands under `trial`, whichever file it is from."""
    return {"trial": entry.pop("name"), **entry} if "name" in entry and "trial" not in entry else entry


def _flat(data: dict[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """Single values by their dotted names."""
    for key, value in data.items():
        name = f"{before}{key}"
        if isinstance(value, dict):
            yield from _flat(value, f"{name}.")
        elif not isinstance(value, list):
            yield name, value
        elif value and all(isinstance(item, dict) and "name" in item for item in value):
            yield name, "; ".join(str(item["name"]) for item in value)
        elif len(value) == 2 and not any(isinstance(item, dict | list) for item in value):
            yield from ((f"{name}.{i}", item) for i, item in enumerate(value))
