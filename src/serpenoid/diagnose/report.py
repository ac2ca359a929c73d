"""The HTML report: the verdict with paths before and after on one page, then what it rests on.

Every table is a function of the record (diagnosis.json); figures that were not drawn are left out. The markup is in
templates/diagnosis.html.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from serpenoid.diagnose.words import MEANINGS, Record, ends, faint, parameter, reference, shown, title, untestable
from serpenoid.effects.catalogue import find
from serpenoid.pages import Picture, Table, write_page

CAPTIONS = {
    "paths": "Centroid from the measured first pose, which heads along x; dots mark the ends. Each prediction comes "
    "from a fit to the other gaits. Ink: measured, orange: baseline, blue: extended model.",
    "ladder": "Error on each rung before and after the named effects. Dashed: noise floor. Percentages: share of the "
    "mean square error that the floor does not explain.",
    "joints": "Commanded minus realised angle, joint by joint.",
    "markers": "Distance of each marker from where the realised shape puts it, per coordinate.",
    "residuals": "Residual body velocity of every window (an eighth of a cycle, or half a pause), seen from the body: "
    "measured minus predicted. Lines: means. Grey: where 95 % of windows lie if only chance is left.",
    "residuals-left": "The same for the extended model alone, on a scale of its own: what is left.",
    "along-body": "Left and middle: the residual motion as each vertex makes it. Right: how much better held-out gaits "
    "would be predicted with a load or a worn wheel at that vertex, to first order (0: not at all).",
    "on-floor": "Residual velocity of the vertices where they stood on the floor. Colour: RMS over what chance makes "
    "of it (1: chance alone). Arrows: mean. Each panel has a scale of its own.",
    "ranking": "Candidates on the rung of motion, beside eps alone; dark: named, dashed: what is needed. Wrong "
    "candidates can gain much by standing in for the right one, so the best are fitted in full and compared again.",
    "next-experiment": "Its joint angles.",
}
GAINS = {
    "path_rms_m": ("path RMS", "m"), "displacement_error_m": ("displacement error, RMS", "m"),
    "heading_error_rad": ("heading error, RMS", "rad"), "s": ("s (spread of ln ratio of displacements)", "1"),
    "log_likelihood": ("log-likelihood per trial", "1"),
}  # fmt: skip
WORSE = 1.02  # a path RMS that does not come closer
FIGURES = {
    "paths": ("paths",), "ladder": ("ladder",), "ranking": ("ranking",), "shape": ("joints", "markers"),
    "motion": ("residuals", "residuals-left", "along-body", "on-floor"), "experiment": ("next-experiment",),
}  # fmt: skip


def write_pages(folder: Path, record: Record) -> None:
    """report.html, from the record and the figures that are in the folder."""
    write_page(
        folder / "report.html",
        "diagnosis.html",
        title=f"{record['campaign']}: {record['verdict']}",
        lead=lead(record),
        named=bool(record["effects"]),
        gain=_gain(record),
        ladder=_ladder(record),
        parameters=_parameters(record),
        alternatives=_alternatives(record),
        faint=[text.capitalize() for text in faint(record)],
        pictures={place: _pictures(folder, names) for place, names in FIGURES.items()},
        **_experiment(record["next_experiment"]),
    )


def lead(record: Record) -> list[str]:
    """The verdict in sentences."""
    found = [f"Diagnosis: {MEANINGS[record['verdict']]}."]
    for e in record["effects"]:
        kind = find(e["name"])
        numbers = "; ".join(f"{name} {parameter(p)}" for name, p in e["parameters"].items())
        found.append(
            f"{title(e)}: {numbers}. Its trace is {e['strength_floors']:.1f} times the noise floor. "
            f"How it looks: {kind.looks_like}. What to do: {kind.what_to_do}."
        )
    found += [f"{text.capitalize()}: gaits not fitted are predicted better with it." for text in faint(record)]
    others = [title(e) for e in record["alternatives"]]
    if others:
        found.append(f"The data cannot tell this from: {', '.join(others)}.")
    rms = record["gain"]["path_rms_m"]
    found.append(
        f"Path RMS on gaits that were not fitted: {shown(rms['before'], 'm')} before, {shown(rms['after'], 'm')} "
        f"after; repeats alone would leave about {shown(record['noise_floor_m'], 'm')}."
    )
    if record["effects"] and rms["after"] > WORSE * rms["before"]:
        found.append("With the extension these paths are no closer: do not rely on the name without further trials.")
    found += [f"{text}." for text in reference(record)]
    found += [f"The rung of {rung} was skipped: {why}." for rung, why in record["skipped"].items()]
    found += [f"Not tested, {text}." for text in untestable(record)]
    return found + left_over(record["residual_pattern"])


def left_over(sentences: Sequence[str]) -> list[str]:
    """A sentence for every rung, of `rung: what is left there`."""
    rungs: dict[str, list[str]] = {}
    for text in sentences:
        rung, _, what = text.partition(": ")
        rungs.setdefault(rung, []).append(what)
    return [f"Not accounted for on the rung of {rung}: {'; '.join(what)}." for rung, what in rungs.items()]


def _pictures(folder: Path, names: Sequence[str]) -> list[Picture]:
    return [Picture.of(folder / f"{n}.svg", CAPTIONS[n]) for n in names if (folder / f"{n}.svg").exists()]


def _gain(record: Record) -> Table:
    rows = []
    for key, (name, unit) in GAINS.items():
        g = record["gain"][key]
        rows.append([name, *(_with_interval(g, side, unit) for side in ("before", "after"))])
    return Table(["on held-out gaits", "before (95 %)", "after (95 %)"], rows)


def _with_interval(g: Record, side: str, unit: str) -> str:
    low, high = g[f"{side}_interval"]
    return f"{shown(g[side], unit)} ({shown(low, unit)} .. {shown(high, unit)})"


def _ladder(record: Record) -> Table:
    rows = [
        [s["rung"], s["compares"], *(shown(s[k], s["unit"]) for k in ("before", "after", "floor"))]
        + [f"{s[f'share_above_floor_{side}']:.0%}" for side in ("before", "after")]
        for s in record["ladder"]
    ]
    head = ["rung", "compares", "RMS before", "RMS after", "noise floor", "above it before", "after"]
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
    rows = [[title(e), _instead(e), _values(e), _apart(e)] for e in record["alternatives"]]
    return Table(["effect", "instead of", "fits as well with", "predictions apart"], rows)


def _instead(e: Record) -> str:
    return title(e["instead_of"]) if e.get("instead_of") else ""


def _values(e: Record) -> str:
    units = {p.name: p.unit for p in find(e["name"]).parameters}
    return ", ".join(f"{name} {shown(value, units[name])}" for name, value in e["parameters"].items())


def _apart(e: Record) -> str:
    return f"{e['separation_floors']:.1f} floors" if e.get("separation_floors") is not None else ""


def _experiment(plan: Record | None) -> dict[str, Any]:
    if plan is None:
        return {"experiment": None}
    apart = ", ".join(f"{title(rival)}: {rival['expected_chi2']:.0f}" for rival in plan["tells_apart"])
    return {"experiment": plan, "start": _start(plan["start_pose"]), "apart": apart}


def _start(pose: Record) -> str:
    heading = shown(pose["heading_rad"], "rad")
    return f"beginning at x = {pose['x_m']:.2f} m, y = {pose['y_m']:.2f} m, heading {heading}"
