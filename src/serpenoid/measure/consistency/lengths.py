"""Is it one body in all trials? Where a campaign gives no lengths, each trial's own are laid beside the others'.

    a = median over frames of ( median over edges of log(distance / the campaign's edge) )        of every trial

Two trials whose a differ by more than a calibrated camera explains (`geometry.SCALE_SD`) and the scatter of their own
parts are two bodies: lengths estimated from both together are those of neither.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.geometry import SCALE_SD
from serpenoid.measure.consistency.rivals import ODDS

PARTS = 4  # of a recording, whose scales show how far postures and noise move one


@dataclass(frozen=True)
class Longer:
    """`trial` is `factor` times as long as `other`, the middle one; `gain`: by how much another body is likelier."""

    trial: str
    other: str
    factor: float
    gain: float


def other_bodies(vertices: Mapping[str, Floats], edges: Floats) -> list[Longer]:
    """Trials (F, N, 2) whose body is another than in the middle one's, by the campaign's edges (N - 1,)."""
    scales = {trial: found for trial, points in vertices.items() if (found := _scale(points, edges)) is not None}
    if len(scales) < 2:
        return []
    ordered = sorted(scales, key=lambda trial: scales[trial])
    middle = ordered[(len(ordered) - 1) // 2]
    longer = []
    for trial, (scale, scatter) in scales.items():
        apart = scale - scales[middle][0]
        gain = 0.5 * apart**2 / (SCALE_SD**2 + scatter**2 + scales[middle][1] ** 2) - float(np.log(len(scales)))
        if gain > ODDS:
            longer.append(Longer(trial, middle, float(np.exp(apart)), gain))
    return longer


def _scale(points: Floats, edges: Floats) -> tuple[float, float] | None:
    """Log scale of a trial against `edges`, and how far its parts scatter about it; None: no neighbours are seen."""
    distance = np.linalg.norm(np.diff(points, axis=1), axis=2)
    ratio = np.log(np.where(distance > 0, distance, np.nan) / edges)
    ratio = ratio[np.isfinite(ratio).any(axis=1)]
    if len(ratio) < PARTS:
        return None
    every = np.nanmedian(ratio, axis=1)
    return float(np.median(every)), float(np.std([np.median(part) for part in np.array_split(every, PARTS)]))
