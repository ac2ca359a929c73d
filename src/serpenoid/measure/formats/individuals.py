"""Whose points are read of a recording that shows several animals or robots."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from serpenoid.errors import InputError

MOST_LISTED = 8


def chosen(names: Sequence[str], wanted: str | None, path: Path) -> str:
    """The one of a file's individuals (each named once or more) that is wanted, or the only one.

    Raises InputError where there are several and none is wanted, or another than those that are there.
    """
    there = list(dict.fromkeys(names))
    listed = ", ".join(f"`{name}`" for name in there[:MOST_LISTED]) + ", ..." * (len(there) > MOST_LISTED)
    if wanted is not None and wanted not in there:
        raise InputError(f'{path}: `individual = "{wanted}"`: the file has {listed or "no names of individuals"}.')
    if wanted is None and len(there) > 1:
        raise InputError(
            f'{path}: shows {len(there)} individuals: {listed}. Name one in the trial: `individual = "{there[0]}"`; '
            "each may be a trial of its own."
        )
    return wanted or (there[0] if there else "")
