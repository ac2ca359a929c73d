"""A study as one CSV table: command, commit and key in `# name: value` lines above it, one row a campaign.

A cell that is no plain text is JSON. The table is rewritten whole with every row; an interrupted study goes on from it.
"""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

Row = dict[str, Any]


def read(path: Path) -> tuple[dict[str, str], list[Row]]:
    """What stands above the table, and its rows; nothing of a file that is not there."""
    if not path.exists():
        return {}, []
    lines = path.read_text().splitlines()
    above = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# "))
    rows = csv.DictReader(line for line in lines if not line.startswith("# "))
    return above, [{name: _value(cell) for name, cell in row.items() if cell != ""} for row in rows]


def write(path: Path, above: Mapping[str, str], rows: Sequence[Row]) -> None:
    """All of it, in one go."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    text = io.StringIO()
    text.writelines(f"# {name}: {value}\n" for name, value in above.items())
    table = csv.DictWriter(text, names, lineterminator="\n")
    table.writeheader()
    table.writerows({name: _cell(value) for name, value in row.items()} for row in rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(f".{os.getpid()}.part")
    temporary.write_text(text.getvalue())
    temporary.replace(path)


def _cell(value: Any) -> str:
    if not isinstance(value, str):
        return json.dumps(_short(value))
    text = value.replace("\n", " | ").replace("\r", "")
    return text if _value(text) == text else json.dumps(text)  # "null" is a word here


def _short(value: Any) -> Any:
    """Floats with five digits: a table is to be read."""
    if isinstance(value, float):
        return float(f"{value:.5g}")
    if isinstance(value, Mapping):
        return {k: _short(v) for k, v in value.items()}
    return [_short(v) for v in value] if isinstance(value, (list, tuple)) else value


def _value(cell: str) -> Any:
    try:
        return json.loads(cell)
    except json.JSONDecodeError:
        return cell
