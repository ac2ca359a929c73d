"""What the extension is worth on gaits it was not fitted to, with bootstrap intervals over trials."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.paths import path_rms
from serpenoid.diagnose.data.windows.windows import Prediction
from serpenoid.group import accumulate

DRAWS = 400


@dataclass(frozen=True)
class Scores:
    """One number per trial each: path RMS and displacement error [m], heading error [rad], ln ratio, log-likelihood."""

    path: Floats
    displacement: Floats
    heading: Floats
    log_ratio: Floats
    log_likelihood: Floats


def scores(motion: Motion, predictions: Sequence[Prediction], mend: bool = False) -> Scores:
    """Per trial."""
    rows = []
    every = zip(motion.tracks, motion.white, predictions, residuals(motion.tracks, predictions), strict=True)
    for track, white, p, left in every:
        path = accumulate(np.nan_to_num(p.displacement), track.poses[0])
        true = track.poses[track.boundaries]
        moved, said = (np.hypot(*(x[-1] - x[0])[:2]) for x in (true, path))
        known = np.asarray(np.isfinite(left).all(axis=1))
        likelihood = -0.5 * (white.of(left, known) ** 2 + np.log(2 * np.pi * white.spreads(known) ** 2)).sum()
        ratio = np.log(max(said, 1e-9) / max(moved, 1e-9))
        rows.append([path_rms(track, p, mend), said - moved, path[-1, 2] - true[-1, 2], ratio, likelihood])
    return Scores(*np.array(rows).T)


def gain_record(before: Scores, after: Scores) -> dict[str, Any]:
    """Before and after, with 95 % bootstrap intervals over trials."""

    def rms(x: Floats) -> float:
        return float(np.sqrt(np.mean(x**2)))

    def spread(x: Floats) -> float:
        return float(np.std(x))

    def mean(x: Floats) -> float:
        return float(np.mean(x))

    kinds = {
        "path_rms_m": ("path", rms),
        "displacement_error_m": ("displacement", rms),
        "heading_error_rad": ("heading", rms),
        "s": ("log_ratio", spread), "log_likelihood": ("log_likelihood", mean),
    }  # fmt: skip
    record = {}
    for name, (field, statistic) in kinds.items():
        one, two = getattr(before, field), getattr(after, field)
        record[name] = {
            "before": statistic(one), "after": statistic(two),
            "before_interval": _bootstrap(one, statistic), "after_interval": _bootstrap(two, statistic),
        }  # fmt: skip
    return record


def _bootstrap(values: Floats, statistic: Any) -> list[float]:
    rng = np.random.default_rng(0)
    drawn = [statistic(values[rng.integers(len(values), size=len(values))]) for _ in range(DRAWS)]
    return [float(v) for v in np.percentile(drawn, [2.5, 97.5])]
