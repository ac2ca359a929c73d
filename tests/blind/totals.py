"""All keys together: `python -m blind.totals results/blind README.md` writes totals.md, and its rows into the README.

Of each kind of campaign: how many answers are right where something is required of them, over the keys of the present
method (`FIRST` on). Each key's own table says with which commit it was made.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from arena.hidden import by_cause, required
from blind import table
from blind.pages import TITLES, markdown, parts_of

FIRST = 12  # gates-12: the first key with noise levels from true shapes
RANDOM, USUAL = ("random", "laid", "weather"), ("null", "one", "two", "outside")
CAUSES = {"null": "nothing", "one": "one effect", "two": "two effects", "outside": "outside"}
ROWS = {
    "random robots and protocols": RANDOM,
    "the ten-servo snake": USUAL,
    "healthy robots, beside a healthy reference": ("same", "days"),
    "floors of dry friction, half of them beside a reference": ("dry",),
    "floors whose law is not in the catalogue, half of them beside a reference": ("physics",),
    "nothing played twice, beside a reference": ("once",),
    "something begins amid the campaign": ("amid",),
}
ARENA = "the virtual laboratory, random robots, beside a reference"
HEAD = "campaigns of"
Count = tuple[int, int]


@dataclass(frozen=True)
class Sum:
    """Campaigns, how many keys they are of, right answers by cause, and intervals that hold the truth."""

    campaigns: int
    keys: tuple[str, ...]
    causes: Mapping[str, Count]
    intervals: Count


def keys_of(root: Path) -> list[Path]:
    """Folders of the keys, the oldest first."""
    found = [(int(m[1]), p) for p in root.iterdir() if (m := re.fullmatch(r"gates-(\d+)[a-z]?", p.name))]
    return [p for number, p in sorted(found) if number >= FIRST]


def summed(root: Path, kinds: Sequence[str]) -> Sum:
    """Over all keys; of effects those count whose strength S is 3 or more."""
    campaigns, keys = 0, []
    causes: dict[str, Count] = {}
    intervals = (0, 0)
    for folder in keys_of(root):
        for kind, above, rows in _tables(folder, kinds):
            campaigns += len(rows)
            keys += [folder.name] * (folder.name not in keys)
            for part in parts_of(kind, above, rows):
                share = part.summary["right_where_required" if part.kind in ("one", "two") else "right"]
                causes[part.kind] = _plus(causes.get(part.kind, (0, 0)), share)
                intervals = _plus(intervals, part.summary["intervals_cover"])
    return Sum(campaigns, tuple(keys), causes, intervals)


def _tables(folder: Path, kinds: Sequence[str]) -> Iterator[tuple[str, Mapping[str, str], Sequence[Mapping[str, Any]]]]:
    for kind in kinds:
        above, rows = table.read(folder / f"{kind}.csv")
        if rows:
            yield kind, above, rows


def _plus(count: Count, share: Mapping[str, Any]) -> Count:
    return count[0] + share["good"], count[1] + share["of"]


def in_the_arena(root: Path) -> Sum:
    """Robots drawn at random in the arena, two changes each, all keys; of those in the catalogue that are required."""
    tables = [(p.parent.name, table.read(p)[1]) for p in sorted(root.glob("any-*/any-robot.csv"))]
    judged = [r for _, rows in tables for r in rows if "outcome" in r]
    split = zip(("null", "one", "outside"), by_cause(required(judged)).values(), strict=True)
    causes = {k: (sum(r["outcome"] == "right" for r in rows), len(rows)) for k, rows in split}
    return Sum(len(judged), tuple(name for name, _ in tables), causes, (0, 0))


def page(root: Path) -> str:
    """The table, as the README holds it."""
    sums = {title: summed(root, kinds) for title, kinds in ROWS.items()}
    sums[ARENA] = in_the_arena(root)
    head = [HEAD, "count", *CAUSES.values(), "intervals"]
    rows = []
    for title, s in sums.items():
        shares = [s.causes.get(cause, (0, 0)) for cause in CAUSES]
        rows.append([title, str(s.campaigns), *map(_share, [*shares, s.intervals])])
    return markdown(head, rows)


def _share(count: Count) -> str:
    return f"{count[0]} of {count[1]}" if count[1] else ""


def main(root: Path, readme: Path) -> None:
    """totals.md beside the folders of the keys, and the table in the README."""
    found, keys = page(root), summed(root, tuple(TITLES)).keys
    head = [
        "# All keys",
        "",
        f"Written by `python -m blind.totals`: {keys[0]} to {keys[-1]}, and all of the arena.",
        "",
    ]
    (root / "totals.md").write_text("\n".join([*head, found]), encoding="utf-8")
    text = readme.read_text(encoding="utf-8").split("\n")
    begin = next(i for i, line in enumerate(text) if line.startswith(f"| {HEAD} |"))
    end = next(i for i in range(begin, len(text)) if not text[i].startswith("|"))
    readme.write_text("\n".join([*text[:begin], *found.splitlines(), *text[end:]]), encoding="utf-8")


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
