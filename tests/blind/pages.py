"""The tables of all studies as one readable page: `python -m blind.pages results/blind` writes summary.md there.

A study whose campaigns have several causes is summed up cause by cause.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from blind import table
from blind.summary import summarise

Summary = Mapping[str, Any]
TITLES = {
    "one": "One effect",
    "null": "Nothing hidden",
    "two": "Two effects",
    "outside": "Outside the catalogue",
    "followup": "Next experiment, after a first campaign of one gait",
    "random": "Random protocols",
    "laid": "Random protocols, each trial laid anew",
    "weather": "Random protocols, a floor that differs a little from trial to trial",
    "physics": "Another physics",
    "dry": "Floors of dry friction",
    "same": "Healthy against healthy",
    "once": "Nothing played twice, beside a reference, a law left out",
    "days": "Healthy against healthy, floors that differ a little from trial to trial",
    "amid": "Random protocols, something begins amid the campaign",
}
TARGETS = {"one": "95 %", "null": "98 %", "two": "80 %", "outside": "95 %"}
CAUSES = ("null", "one", "two", "outside")


@dataclass(frozen=True)
class Part:
    """The campaigns of one table with one kind of cause."""

    title: str
    kind: str
    above: Mapping[str, str]
    summary: Summary


def parts_of(kind: str, above: Mapping[str, str], rows: Sequence[Mapping[str, Any]]) -> list[Part]:
    """One part, or one for each cause."""
    causes = [c for c in CAUSES if any(r.get("cause", kind) == c for r in rows)]
    if kind in CAUSES or len(causes) < 2:
        target = kind if kind in TARGETS else (causes[0] if causes else kind)
        return [Part(TITLES[kind], "followup" if kind == "followup" else target, above, summarise(kind, rows))]
    split = {c: [r for r in rows if r.get("cause") == c] for c in causes}
    return [Part(f"{TITLES[kind]}: {TITLES[c].lower()}", c, above, summarise(c, own)) for c, own in split.items()]


def page(parts: Sequence[Part]) -> str:
    """Markdown: all proportions beside their targets, then a section for each part."""
    rows = [row for part in parts for row in _proportions(part)]
    head = ["# Hidden-effect trials", "", "Written by `python -m blind.pages`; 95 % intervals after Wilson.", ""]
    overall = markdown(["", "good", "of", "share", "interval", "target"], rows)
    return "\n".join([*head, overall, *(_section(part) for part in parts)])


def _proportions(part: Part) -> list[list[str]]:
    rows, kind, title, s = [], part.kind, part.title, part.summary
    if kind == "followup":
        e = s["after_experiment"]
        rows += [_share("groups that contain the truth", e["truth_in_group"], "")]
        rows += [_share("proposed experiment: smaller, truth kept", e["proposed"], "80 %")]
        return [*rows, _share("random gait: smaller, truth kept", e["random"], "")]
    rows.append(_share(title, s["right"], TARGETS.get(kind, "")))
    if kind in ("one", "two"):
        rows.append(_share(f"{title}, each S >= 3", s["right_where_required"], TARGETS[kind]))
        rows.append(_share(f"{title}: intervals cover", s["intervals_cover"], "90-98 %"))
        named = f"{title}: rightly named, held out within 1.2 F"
        rows.append(_share(named, s["held_out_within_1.2_floors"], "all"))
        if s["held_out_as_far_as_told"]["of"]:
            rows.append(_share(f"{named} and what the other gaits leave open", s["held_out_as_far_as_told"], "95 %"))
    return rows


def _share(name: str, s: Summary, target: str) -> list[str]:
    if not s["of"]:
        return [name, "0", "0", "", "", target]
    low, high = s["interval"]
    share = f"{100 * s['share']:.0f} %"
    return [name, str(s["good"]), str(s["of"]), share, f"{100 * low:.0f} - {100 * high:.0f} %", target]


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def _section(part: Part) -> str:
    kind, s = part.kind, part.summary
    facts = [
        _line("Verdicts", s["verdicts"]),
        _line("Outcomes", s["outcomes"]),
        _line("Processor seconds (older tables: wall)", s["seconds"]),
    ]
    facts.append(_line("Held-out path RMS over F, where right", s["held_out_over_floor"]))
    facts.append(_line("Intervals that missed", s["intervals_cover"]["missed"]))
    if s["mean_group_size"] is not None:
        sizes = ", ".join(f"{n} of size {size}" for size, n in s["group_sizes"].items())
        facts.append(f"- Mean group size for each effect named: {s['mean_group_size']:.2f} ({sizes})\n")
    said = f"`{part.above.get('command', '')}`, commit {part.above.get('commit', 'unknown')}\n"
    parts = [f"## {part.title}\n", said, "".join(facts)]
    if kind in ("one", "two"):
        parts.append(_strengths(s))
    if kind == "followup":
        parts.append(_follow_up(s["after_experiment"]))
    if s["odds"]:
        parts.append(_calibration(s["odds"]))
    parts += ["### Hidden (rows) and chosen\n", _confusion(s["confusion"])]
    if s["misses"]:
        parts += ["### Misses\n", _misses(s["misses"])]
    return "\n".join(parts)


def _line(title: str, values: Mapping[str, Any] | None) -> str:
    if not values:
        return ""
    said = (f"{k} {v:.3g}" if isinstance(v, float) else f"{k} {v}" for k, v in values.items())
    return f"- {title}: {', '.join(said)}\n"


def _strengths(s: Summary) -> str:
    rows = []
    for b in s["by_strength"]:
        name = f"{b['from']:g} - {b['to']:g}" if b["to"] else f"{b['from']:g} and more"
        size = "" if b["mean_group_size"] is None else f"{b['mean_group_size']:.2f}"
        rows.append([*_share(name, b["right"], "")[:5], *_share(name, b["truth_in_group"], "")[1:2], size])
    return markdown(["weakest S", "right", "of", "share", "interval", "truth in group", "group size"], rows)


def _calibration(bins: Sequence[Summary]) -> str:
    rows = [[f"{b['stated']:.2f}", *_share("", b, "")[1:5]] for b in bins]
    return markdown(["stated odds", "true", "of", "share", "interval"], rows)


def _follow_up(e: Summary) -> str:
    rows = []
    for c in e["cases"]:
        after = [
            ", ".join(c[k]) or "nothing" if c[k] is not None else "-" for k in ("members_proposed", "members_random")
        ]
        rows.append([_truth(c), f"{min(c['strengths'], default=0):.1f}", ", ".join(c["group"]), *after])
    return markdown(["hidden", "S", "group", "after the proposed experiment", "after a random gait"], rows)


def _confusion(table: Mapping[str, Mapping[str, int]]) -> str:
    names = sorted({c for row in table.values() for c in row})
    rows = [[hidden, *(str(row.get(c, "")) for c in names)] for hidden, row in table.items()]
    return markdown(["", *names], rows)


def _misses(rows: Sequence[Summary]) -> str:
    said = []
    for r in rows:
        strengths = ", ".join(f"{x:.1f}" for x in r.get("strengths", []))
        apart = ", ".join(f"{k} {v:.1f}" for k, v in r.get("separations", {}).items())
        said.append([r["identity"], _truth(r), strengths, r["outcome"], ", ".join(r.get("group", [])), apart])
    return markdown(["trial", "hidden", "S", "outcome", "group", "separations"], said)


def _truth(row: Summary) -> str:
    found = []
    for e in row.get("truth") or []:
        place = "" if e["place"] is None else f"@{e['place']}"
        found.append(f"{e['name']}{place} ({', '.join(f'{k} {v:.3g}' for k, v in e['parameters'].items())})")
    return "; ".join(found) or "nothing"


def write_page(folder: Path) -> None:
    """summary.md from the tables that are in the folder."""
    found = {kind: table.read(folder / f"{kind}.csv") for kind in TITLES}
    parts = [part for kind, (above, rows) in found.items() if rows for part in parts_of(kind, above, rows)]
    (folder / "summary.md").write_text(page(parts))


if __name__ == "__main__":
    write_page(Path(sys.argv[1]))
