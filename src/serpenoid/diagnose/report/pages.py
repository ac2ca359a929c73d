"""The HTML report: three cards, the trials in motion, paths before and after, then what it rests on.

Every table is a function of the record (diagnosis.json); figures that were not drawn are left out. The markup is in
report/templates/diagnosis.html.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from serpenoid.diagnose.data.used import parameter_unit
from serpenoid.diagnose.report.before import already, reference
from serpenoid.diagnose.report.cards import GAINS, cards, times_noise, unit_of
from serpenoid.diagnose.report.next_trial import no_experiment, start
from serpenoid.diagnose.report.sentences import (
    SETTLED,
    changed_report,
    changed_trials,
    left,
    seconds,
    undetected,
    untestable,
)
from serpenoid.diagnose.report.words import Record, ends, in_sample, sentence, shown, title, unseen
from serpenoid.effects.catalogue import find
from serpenoid.report.animated import Animated, animation_data
from serpenoid.report.pages import Picture, Table, prepare, write_page

TEMPLATE = "diagnosis.html"
CAPTIONS = {
    "paths": "Centroid from the measured first pose, which heads along x; one curve for each repeat, later ones paler, "
    "large dots mark the ends. Small dots: where windows end (an eighth of a cycle, or half a pause); a prediction is "
    "known there alone, and dotted strokes only show the order. Each prediction comes from a fit to the other gaits. "
    "Ink: measured, orange: baseline, blue: extended model.",
    "ladder": "Error of each stage before and after the named effects, with its ratio to the noise level (dashed).",
    "joints": "Commanded minus realised angle, joint by joint.",
    "markers": "Distance of each marker from where the realised shape puts it, per coordinate.",
    "residuals": "Residual body velocity of every window (an eighth of a cycle, or half a pause), seen from the body: "
    "measured minus predicted. Lines: means. Grey: where 95 % of windows lie if only noise is left.",
    "residuals-left": "The same for the extended model alone, on a scale of its own: what is left.",
    "residuals-in-time": "The same window by window, over what noise makes of it: a line for each trial, repeats of a "
    "setting between two strokes. Grey: no usable window.",
    "along-body": "Left and middle: the residual motion as each vertex makes it. Right: chi squared that an effect at "
    "that vertex would gain, to first order (0: nothing).",
    "on-floor": "Residual velocity of the vertices where they stood on the floor, before and after on one scale of "
    "colours and of arrows. Colour: RMS over what noise makes of it (1: noise alone). Arrows: mean.",
    "ranking": "Candidates in the stage of motion, beside the anisotropy ratio alone; dark: chosen by the search, "
    "dashed: what is needed. Wrong candidates can gain much by standing in for the right one, so the best are fitted "
    "in full and compared again; where one was chosen for a while and is not named, the reason is written there.",
    "since-reference": "Without any model: by how much joint angles and paths of the same gaits differ from the "
    "reference's, each path from its own first pose. Dashed: what repeats differ by, the reference's where it has any. "
    "Dotted: noise level of the stage.",
    "next-experiment": "Its joint angles.",
}
FIGURES = {
    "paths": ("paths",), "ladder": ("ladder",), "since": ("since-reference",), "ranking": ("ranking",),
    "shape": ("joints", "markers"),
    "motion": ("residuals", "residuals-left", "residuals-in-time", "along-body", "on-floor"),
    "experiment": ("next-experiment",),
}  # fmt: skip


def write_pages(
    folder: Path, record: Record, trials: Sequence[Animated] = (), drawn: Callable[[], object] = lambda: None
) -> None:
    """report.html, from the record, the figures that are in the folder and the trials to be shown in motion.

    drawn: waits until the figures are there; all else is made before.
    """
    made = {
        "title": f"{record['campaign']}: {record['verdict']}",
        "lead": [],
        "cards": cards(record),
        "animation": animation_data(trials),
        "changed": [*map(sentence, changed_trials(record))],
        "changed_report": changed_report(record),
        "changed_parameters": _parameters(record["changed_trials"]["diagnosis"]) if record["changed_trials"] else None,
        "left": [*map(sentence, left(record))],
        "reference": [*map(sentence, (*reference(record), *already(record)))],
        "beside": _beside(record),
        "named": bool(record["effects"]),
        "settled": record["verdict"] in SETTLED,
        "gain": _gain(record),
        "ladder": _ladder(record),
        "parameters": _parameters(record),
        "alternatives": _alternatives(record),
        "undetected": [f"Below detection: {', '.join(weak)}."] if (weak := undetected(record)) else [],
        **_experiment(record["next_experiment"]),
        "no_experiment": sentence(no_experiment(record)),
    }
    prepare(TEMPLATE)
    drawn()
    pictures = {place: _pictures(folder, names, unseen(record)) for place, names in FIGURES.items()}
    write_page(folder / "report.html", TEMPLATE, pictures=pictures, **made)


def _beside(record: Record) -> list[str]:
    """What was skipped, not tested, used, and what is to be known of it."""
    found = []
    if record["drag_ratio"] is None:
        found += [f"the stage of {stage} was skipped: {why}" for stage, why in record["skipped"].items()]
    found += [f"not tested: {text}" for text in untestable(record)]
    found += [f"made from the recordings: {seconds(record)}", *record["remarks"]]
    return [*map(sentence, found)]


def _pictures(folder: Path, names: Sequence[str], unseen: str) -> list[Picture]:
    there = [n for n in names if (folder / f"{n}.svg").exists()]
    return [Picture.of(folder / f"{n}.svg", CAPTIONS[n].replace("gaits", unseen)) for n in there]


def _gain(record: Record) -> Table:
    rows = []
    for key, (name, _) in GAINS.items():
        g = record["gain"][key]
        rows.append([name, *(_with_interval(g, side, unit_of(key, record)) for side in ("before", "after"))])
    where = "in sample" if in_sample(record) else f"on held-out {unseen(record)}"
    return Table([where, "before (95 %)", "after (95 %)"], rows)


def _with_interval(g: Record, side: str, unit: str) -> str:
    low, high = g[f"{side}_interval"]
    return f"{shown(g[side], unit)} ({shown(low, unit)} .. {shown(high, unit)})"


def _ladder(record: Record) -> Table:
    rows = [
        [s["stage"], s["compares"], *(shown(s[k], s["unit"]) for k in ("before", "after", "noise_level"))]
        + [times_noise(s[side], s["noise_level"]) for side in ("before", "after")]
        for s in record["ladder"]
    ]
    head = ["stage", "compares", "RMS before", "RMS after", "noise level", "before", "after"]
    return Table(head, rows)


def _parameters(record: Record) -> Table:
    rows = []
    for e in record["effects"]:
        for name, p in e["parameters"].items():
            rows.append([title(e), name, *ends(p)])
    eps = record["anisotropy_ratio"]
    rows.append(
        ["calibration (no diagnosis)", "anisotropy_ratio", f"{eps['after']:.4g}", f"baseline: {eps['before']:.4g}", ""]
    )
    return Table(["effect", "parameter", "value", "95 % from", "to"], rows)


def _alternatives(record: Record) -> Table:
    rows = [[title(e), _instead(e), _values(e, record), _apart(e)] for e in record["alternatives"]]
    return Table(["effect", "instead of", "fits as well with", "predictions apart"], rows)


def _instead(e: Record) -> str:
    return title(e["instead_of"]) if e.get("instead_of") else ""


def _values(e: Record, record: Record) -> str:
    law, length = record["law"]["name"], record["length_unit"]
    units = {p.name: parameter_unit(p, law, length) for p in find(e["name"]).parameters}
    return ", ".join(f"{name} {shown(value, units[name])}" for name, value in e["parameters"].items())


def _apart(e: Record) -> str:
    return f"{e['separation_over_noise']:.1f} times the noise" if e.get("separation_over_noise") is not None else ""


def _experiment(plan: Record | None) -> dict[str, Any]:
    if plan is None:
        return {"experiment": None}
    apart = ", ".join(f"{title(rival)}: {rival['expected_chi2']:.0f}" for rival in plan["tells_apart"])
    return {"experiment": plan, "start": start(plan["start_pose"]), "apart": apart}
