"""An animal's mean beat as a gait: what its joints do on average at every phase, and a problem file that plays it.

    angles(t) = mean + sum over k of c_k cos(2 pi k phase(t)) + s_k sin(2 pi k phase(t)),    by least squares

phase: turns of all that bends (`beat`), so that beats may be longer and shorter.
Legend: R frames, m joints, T rows of the table.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Body
from serpenoid.files.writing import toml_string, write_text
from serpenoid.measure.animals.beat import Beat
from serpenoid.measure.cells import Floats
from serpenoid.measure.trial import Motion, Trial
from serpenoid.medium import OpenMedium
from serpenoid.table_file import write_table

ROWS = 50
HARMONICS = 3  # of a beat: more are of single beats
LEAST_FRAMES = 3  # of a harmonic, in a beat
USUAL_RATIO = 0.2  # where nobody says: it is no part of how a body bends


@dataclass(frozen=True)
class MeanBeat:
    """angles (T, m) [rad], one cycle; share: of the variance of all joint angles that it holds."""

    angles: Floats
    share: float


def mean_beat(motion: Motion, found: Beat) -> MeanBeat:
    """The mean over all beats, at even phases from wherever the film begins."""
    rows = np.concatenate([np.arange(run.start, run.stop) for run in motion.runs])
    time_s, angles = motion.time_s[rows], motion.smooth_angles[rows]
    a_beat = found.period_s / float(np.median(np.diff(time_s)))
    orders = range(1, 1 + int(np.clip(a_beat / LEAST_FRAMES, 1, HARMONICS)))
    basis = _waves(np.interp(time_s, found.centres_s, found.turns), orders)
    series = np.linalg.lstsq(basis, angles, rcond=None)[0]
    left = angles - basis @ series
    varied = ((angles - angles.mean(axis=0)) ** 2).sum()
    return MeanBeat(_waves(np.arange(ROWS) / ROWS, orders) @ series, float(1 - (left**2).sum() / varied))


def _waves(phase: Floats, orders: range) -> Floats:
    turns = [2 * np.pi * k * phase for k in orders]
    return np.column_stack([np.ones_like(phase), *(wave(turn) for turn in turns for wave in (np.cos, np.sin))])


def write_beat(folder: Path, trial: Trial, medium: OpenMedium | None) -> str | None:
    """Write `beat-NAME.toml`, a problem of an animal's body with its mean beat, and `beat-NAME.csv`, the table; returns
    a line that says so, None where nothing repeats or no animal is."""
    found = trial.motion.beat if trial.motion is not None and trial.body.is_animal else None
    if found is None or trial.motion is None:
        return None
    mean = mean_beat(trial.motion, found)
    table = folder / f"beat-{trial.name}.csv"
    write_table(table, mean.angles)
    write_text(table.with_suffix(".toml"), _problem(trial, medium, table.name, found.period_s))
    return f"  mean beat         {table.with_suffix('.toml').name} plays it: {mean.share:.1%} of the bending repeats"


def _problem(trial: Trial, medium: OpenMedium | None, table: str, period_s: float) -> str:
    body: Body = trial.body
    said = None if medium is None else medium.anisotropy_ratio
    source = (
        "of the campaign" if said is not None else "nobody says: --set medium.anisotropy_ratio=..., as `fit` finds it"
    )
    own = [] if body.weights is None else [float(f"{weight:.6g}") for weight in body.weights]
    weights = [f"weights = {json.dumps(own)}"] if own else []
    edges = body.edges_m if trial.metres else body.edges_m / body.edges_m.sum()  # of pixels in body lengths
    law = [] if medium is None else [f'law = "{medium.law}"']
    asked = f"How far does the mean beat of {trial.name} go, and the best of the same body?"
    lines = [
        f"# The mean beat of `{trial.name}`: `simulate` moves it, `sweep --set gait.family=ellipse` finds the best.",
        "[about]",
        f"question = {toml_string(asked)}",
        "",
        "[body]",
        f"vertices = {body.vertices}",
        *([] if body.kind is None else [f'kind = "{body.kind}"']),
        f"edge_lengths = {json.dumps([float(f'{edge:.6g}') for edge in edges])}   # tail to head",
        *weights,
        "",
        "[medium]",
        f"anisotropy_ratio = {USUAL_RATIO if said is None else said:g}   # {source}",
        *law,
        'dissipation = "edge"',
        "",
        "[gait]",
        'family = "table"',
        f"path = {json.dumps(table, ensure_ascii=False)}",
        "",
        "[task]",
        f"steps = {ROWS}",
        f"cycle_duration_s = {period_s:.6g}",
        "",
    ]
    return "\n".join(lines)
