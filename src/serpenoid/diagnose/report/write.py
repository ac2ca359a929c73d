"""diagnosis.json, baseline-model.toml and extended-model.toml."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from typing import Any

from serpenoid.body import Body
from serpenoid.diagnose.changed_trials import ChangedTrials
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.design.experiment import Laboratory, next_experiment
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.record import plain, record
from serpenoid.diagnose.reference import summary
from serpenoid.diagnose.since_reference import since_reference
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import of_laws
from serpenoid.files.writing import provenance, write_json
from serpenoid.measure.campaign import CampaignFile
from serpenoid.model_file import write_model_file
from serpenoid.table_file import write_table

PLACES = (
    "drag sits in the middles of edges, which are vertices here: 2 k is vertex k of the campaign's body, 2 k + 1 the "
    "middle of edge k"
)
ALONG = (
    "drag sits all along the links, in {pieces} pieces of each edge, whose middles are vertices here: {each} k is "
    "vertex k of the campaign's body, what follows are the pieces of edge k"
)
ELSEWHERE = "drag-elsewhere.toml"
CHANGED = "changed-trials"  # the folder of their answer, in that of the whole campaign's
LONG = ("residual_maps", "scores", "provenance")  # of an answer that stands in another: its own file has them
PREDICTION = "only to predict: not named as a cause"
PREDICTS = (
    "\nIt predicts the recorded motion. What is marked as not named is no cause that was found; the anisotropy ratio"
    "\nwas fitted together with it, and holds only beside it."
)


def write(folder: Path, file: CampaignFile, d: Diagnosis, reference: dict[str, Any] | None = None) -> dict[str, Any]:
    """Write everything but the figures and the report that shows them; returns the record.

    reference: what the earlier campaign showed.
    """
    data = record(d) | {"campaign": file.name, "source": file.source, "provenance": provenance()}
    data |= {"kind": file.body.kind, "reference": reference, "since_reference": since_reference(d)}
    before = d.motion.selection.null.model
    known = {e.key: e for e in (*d.baseline.known, *before.effects)}
    notes = [role(e, data["effects"], known) for e in d.model.effects]
    data["only_predicts"] = [plain(e) for e, note in zip(d.model.effects, notes, strict=True) if note == PREDICTION]
    pieces = 0 if file.tracked_only else d.model.body.pieces
    body, said = (d.model.body, _places(pieces)) if pieces else (None, "")
    places = f"\n{said}" if pieces else ""
    data["remarks"] += [said] if pieces else []
    data["middles"] = pieces
    data["remarks"][:0] = about_links(file.body, d.motion.stage.settled) if pieces == 1 else []
    comment = f"what the diagnosis of {file.name} found: {d.verdict}" + PREDICTS * (PREDICTION in notes) + places
    write_model_file(folder / "extended-model.toml", d.model.medium, d.model.effects, body, comment, notes)
    comment = f"what the diagnosis of {file.name} began with, calibrated" + places
    write_model_file(folder / "baseline-model.toml", before.medium, tuple(known.values()), body, comment)
    data["law"]["drag_at_model"] = _elsewhere(folder, file, d)
    data["next_experiment"] = _next_experiment(folder, d)
    data["changed_trials"] = None if d.changed is None else _changed(folder, file, d.changed, reference)
    write_json(folder / "diagnosis.json", data)
    return data


def _changed(folder: Path, file: CampaignFile, of: ChangedTrials, reference: dict[str, Any] | None) -> dict[str, Any]:
    """The answer of the trials in which something acts, written into a folder of its own."""
    others = {"campaign": f"{file.name}, the other trials"}
    before = reference if of.before is None else summary(of.before) | others
    named = file.model_copy(update={"name": f"{file.name}, changed trials"})
    answer = write(folder / CHANGED, named, of.found, before)
    told = {key: value for key, value in answer.items() if key not in LONG}
    trials, rest = list(of.divided.changed), list(of.divided.others)
    return {"trials": trials, "others": rest, "folder": CHANGED, "diagnosis": told}


def _places(pieces: int) -> str:
    """Which vertices those of a body are whose drag acts amid so many pieces of each edge."""
    return PLACES if pieces == 1 else ALONG.format(pieces=pieces, each=pieces + 1)


def _elsewhere(folder: Path, file: CampaignFile, d: Diagnosis) -> str | None:
    """The file of the model whose drag acts elsewhere on the body, where that leaves less."""
    other = d.motion.elsewhere
    if other is None:
        return None
    comment = f"of {file.name}: {d.motion.stage.drag_at}\n{_places(other.body.pieces)}"
    every = (*d.baseline.known, *other.effects)
    write_model_file(folder / ELSEWHERE, other.medium, every, other.body, comment)
    return ELSEWHERE


def about_links(body: Body, settled: bool) -> list[str]:
    """What drag in the middles of edges leaves out; where chance is all that is left, only if it is much."""
    said = body.sparse_edges or (None if settled else body.whole_links)
    return [said] if said else []


def role(effect: ActiveEffect, named: Sequence[Mapping[str, Any]], known: Container[Any]) -> str:
    """Whether an effect of the extended model is a cause that was named, known before, or there to predict."""
    for one in named:
        if (one["name"], one["place"]) == (effect.name, effect.place):
            return "named, perhaps a stand-in" if one["stand_in"] else "named"
    if effect.effect in of_laws():
        return "a number of the law, calibrated with the anisotropy ratio"
    return "known before" if effect.key in known else PREDICTION


def _next_experiment(folder: Path, d: Diagnosis) -> dict[str, Any] | None:
    """Where two explanations of the motion remain: the trial that tells them apart, its gait as a joint table."""
    swaps = d.motion.swaps
    found = d.motion.selection
    if not swaps or not all(isinstance(t.recording, Recording) for t in found.motion.tracks):  # animals play no tables
        return None
    best = next_experiment(Laboratory.of(found.best, [s.fit for s in swaps], found.motion))
    if best is None or best.chi2.max(initial=0.0) < best.band:  # expected to exclude none of them
        return None
    schedule = best.plan.schedule
    write_table(folder / "next-experiment.csv", schedule.table)
    apart = [
        {"name": s.rival.effect.name, "place": s.rival.effect.place, "expected_chi2": float(chi2)}
        for s, chi2 in zip(swaps, best.chi2, strict=False)
    ]
    return {
        "joint_table": "next-experiment.csv", "cycle_duration_s": schedule.cycle_duration_s,
        "cycles": schedule.cycles, "pause_s": schedule.pause_s, "repeats": best.plan.repeats,
        "start_pose": {"x_m": best.plan.start[0], "y_m": best.plan.start[1], "heading_rad": best.plan.start[2]},
        "tells_apart": apart,
    }  # fmt: skip
