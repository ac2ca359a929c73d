"""diagnosis.json, baseline-model.toml and extended-model.toml."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.diagnose.diagnose import Diagnosis, record
from serpenoid.diagnose.experiment import next_experiment
from serpenoid.diagnose.report import write_pages
from serpenoid.files import provenance, write_json
from serpenoid.gaits.table import write_table
from serpenoid.measure.campaign import CampaignFile
from serpenoid.model_file import write_model_file


def write(
    folder: Path, file: CampaignFile, d: Diagnosis, reference: dict[str, Any] | None = None, figures: bool = True
) -> dict[str, Any]:
    """Write everything; returns the record. reference: what the earlier campaign showed."""
    data = record(d) | {"campaign": file.name, "source": file.source, "provenance": provenance()}
    data["reference"] = reference
    comment = f"what the diagnosis of {file.name} found: {d.verdict}"
    write_model_file(folder / "extended-model.toml", d.model.medium, d.model.effects, comment=comment)
    before = d.motion.selection.null.model
    known = {(e.name, e.place): e for e in (*d.baseline.known, *before.effects)}
    comment = f"what the diagnosis of {file.name} began with, calibrated"
    write_model_file(folder / "baseline-model.toml", before.medium, tuple(known.values()), comment=comment)
    data["next_experiment"] = _next_experiment(folder, d)
    write_json(folder / "diagnosis.json", data)
    if figures:
        write_pages(folder, data)
    return data


def _next_experiment(folder: Path, d: Diagnosis) -> dict[str, Any] | None:
    """Where two explanations of the motion remain: the gait that tells them apart, written as a joint table."""
    found = d.motion.selection
    others = [s.fit.model for s in d.motion.swaps]
    if not others:
        return None
    recordings = [t.recording for t in found.motion.tracks]
    shortest = min(r.schedule.cycle_duration_s for r in recordings)
    heading = float(np.median([t.poses[0, 2] for t in found.motion.tracks if t.recording.gait == recordings[0].gait]))
    best = next_experiment(
        [found.best.model, *others[:2]], found.motion.noise, [shortest, 1.7 * shortest, 2.8 * shortest], heading
    )
    if best is None:
        return None
    write_table(folder / "next-experiment.csv", best.table)
    return {
        "joint_table": "next-experiment.csv", "cycle_duration_s": best.cycle_duration_s,
        "predictions_apart_sd": best.separation,
    }  # fmt: skip
