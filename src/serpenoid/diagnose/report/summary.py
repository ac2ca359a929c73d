"""The summary on the screen: what decides first, then the details; one idea a line."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable

from serpenoid.body import WHOLE_LINKS
from serpenoid.diagnose.inference.fits.finding import alone
from serpenoid.diagnose.report.before import already_in_short, reference
from serpenoid.diagnose.report.drag import drag_ratio, ratio, ratio_change, rival_law
from serpenoid.diagnose.report.next_trial import experiment, held_out
from serpenoid.diagnose.report.sentences import (
    chance,
    changed_report,
    changed_trials,
    instead,
    left,
    rows,
    seconds,
    stage_line,
    undetected,
    untestable,
    within_chance,
)
from serpenoid.diagnose.report.together import in_common, titles, together
from serpenoid.diagnose.report.verdicts import inadequacy, meaning
from serpenoid.diagnose.report.words import (
    GONE,
    STAND_IN,
    Record,
    advice,
    few,
    foremost,
    gone,
    in_sample,
    own_place,
    parameter,
    times,
    title,
    unseen,
    what_to_do,
)
from serpenoid.effects.catalogue import find

LINKS = (
    f"{WHOLE_LINKS}: what is left may be that it does not resist its own turning; how much, and how to cut links: "
    "`remarks` in diagnosis.json"
)
LABEL, WIDTH = 18, 118  # characters: of the first column, of a line
IDEA = re.compile(r"(?<=[^\s.][;.?]) ")  # where an idea ends, but not in `0.1 .. 0.2`
DETAILS = "Details"


def lines(record: Record) -> list[str]:
    """The summary on the screen; what changed trials show by themselves stands before the details."""
    return [*_decides(record), *_changed(record), "", DETAILS, *_details(record)]


def _changed(record: Record) -> list[str]:
    """The answer of the trials in which something acts alone."""
    told = record.get("changed_trials")
    return (
        ["", f"Changed trials: {alone(told['trials'], told['others'])}", *_decides(told["diagnosis"])] if told else []
    )


def _decides(record: Record) -> list[str]:
    """Verdict, causes, what they are worth, what is left, what to do next."""
    verdict = "nothing found" if record["verdict"] == "nothing" else record["verdict"]
    held = "in sample" if in_sample(record) else f"held-out {unseen(record)}"
    return [
        *_rows("verdict", [f"{verdict}: {meaning(record)}"]),
        *_rows("changed trials", filter(None, [*changed_trials(record), changed_report(record)])),
        *_rows("since then", ratio_change(record)),
        *_rows("mend first", record.get("mend_first", [])),
        *_rows("caution", inadequacy(record)),
        *_rows("law", rival_law(record)),
        *_causes(record),
        *_rows("anisotropy ratio", [ratio(record)]),
        *_rows("K = 1 / eps", [drag_ratio(record)] if record["drag_ratio"] else []),
        *_rows(held, held_out(record)),
        *_rows("left", left(record)),
        *_rows("next experiment", experiment(record)),
    ]


def _details(record: Record) -> list[str]:
    """What the answer rests on."""
    stages = [text for s in record["ladder"] for text in _rows(s["stage"], [stage_line(s) + within_chance(s, record)])]
    skipped = record["skipped"] if record["drag_ratio"] is None else {}  # of an animal nobody expects servos
    remarks = [LINKS if text.startswith(WHOLE_LINKS) else text for text in record["remarks"]]
    weak = undetected(record)
    return [
        *stages,
        *_rows("skipped", [f"{stage}: {why}" for stage, why in skipped.items()]),
        *_rows("noise", chance(record)),
        *_rows("below detection", [few(weak)] if weak else []),
        *_rows("not tested", untestable(record)),
        *_rows("reference", [*reference(record), *already_in_short(record)]),
        *_rows("table rows", rows(record)),
        *_rows("seconds", [seconds(record)]),
        *_rows("note", remarks),
    ]


def _causes(record: Record) -> list[str]:
    """What is named, with its values, what to do, and what fits as well."""
    found, shown = list[str](), foremost(record)
    for group in together(record):
        e = group[0]
        if len(group) > 1:
            found += _alike(group, record)
            continue
        strength = f"{title(e)} ({times(e['strength_over_noise'])}){GONE if gone(e) else ''}"
        found += _rows("cause?", [strength + STAND_IN]) if e["stand_in"] else _rows("cause", [strength])
        found += _rows("  where", [where] if (where := own_place(e, record)) else [])
        found += [f"  {name:16} {parameter(p)}" for name, p in e["parameters"].items()]
        found += _rows("  or instead", instead(e, record))
        found += _rows("  what to do", what_to_do(e, record))
    more = len(record["effects"]) - len(shown)
    return found + _rows("", [f"and {more} more stand-ins in diagnosis.json"] if more else [])


def _alike(group: list[Record], record: Record) -> list[str]:
    """Causes of one name at several places."""
    values = [(f"  {find(e['name']).place} {e['place']}", p) for e in group for p in e["parameters"].values()]
    return [
        *_rows("cause", [titles(group)]),
        *(f"{label:{LABEL}} {parameter(p)}" for label, p in values),
        *_rows("  all alike", filter(None, [in_common(group)])),
        *_rows("  what to do", [advice(record, group[0]).what_to_do]),
    ]


def _rows(label: str, texts: Iterable[str]) -> list[str]:
    """Texts below each other beside their label, one idea a line."""
    short = [line for text in texts for line in _short(text)]
    return [f"{'' if i else label:{LABEL}}{line}" for i, line in enumerate(short)]


def _short(text: str) -> list[str]:
    """In one line, else one for each idea, else with lines that go on further in."""
    ideas = [text] if len(text) <= WIDTH - LABEL else [idea.rstrip(";.") for idea in _ideas(text)]
    wrapped = (textwrap.wrap(i, WIDTH - LABEL, subsequent_indent="  ", break_on_hyphens=False) for i in ideas)
    return [line for lines in wrapped for line in lines]


def _ideas(text: str) -> list[str]:
    """Cut where ideas end, outside of brackets."""
    ends = [m for m in IDEA.finditer(text) if text.count("(", 0, m.start()) <= text.count(")", 0, m.start())]
    begins, stops = [0, *(m.end() for m in ends)], [*(m.start() for m in ends), len(text)]
    return [text[begin:stop] for begin, stop in zip(begins, stops, strict=True)]
