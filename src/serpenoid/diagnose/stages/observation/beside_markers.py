"""Names of the floor beside what markers show and nothing explains.

Where a joint is bent otherwise than its servo reads, or a marker stands elsewhere, the shapes and poses of windows are
off, too. A fit is a projection: of an error e beside noise, a name takes away no more than

    (|e| + |n|)^2        (in units of noise; |n|^2: what the best of all candidates takes of noise alone)

Names that take away no more may be there for what is left of the markers.

Legend: F frames, B boundaries, N vertices, m joints, C = m + N - 1 channels: joint angles, then edges.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.windows.readings_noise import by_bends
from serpenoid.diagnose.data.windows.tracks import half_average
from serpenoid.diagnose.inference.fits.medium import candidates_of
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.stages.observation.marker_evidence import shown_otherwise
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.model import Model


def no_larger(found: Selection, seen: Observation, news: Sequence[float]) -> frozenset[tuple[str, int | None]]:
    """Which names take away no more than shapes and poses that are off; seen: what markers are known to show; news
    (C,): see `Stage`."""
    if not any(news):
        return frozenset()
    error, best = np.sqrt(chi2_of_markers(found, seen, news)), found.best
    tries = len(candidates_of(best)) + len(best.effects)
    by_noise = {e.key: np.sqrt(most_gained(len(e.parameters), tries)) for e in best.effects}
    bases = zip(best.effects, found.bases, strict=True)
    return frozenset(e.key for e, base in bases if base.chi2 - best.chi2 <= (error + by_noise[e.key]) ** 2)


def chi2_of_markers(found: Selection, seen: Observation, news: Sequence[float]) -> float:
    """Chi squared of what windows are off by."""
    total = 0.0
    for t, white in zip(found.motion.tracks, found.motion.white, strict=True):
        if isinstance(t.recording, Recording):  # with servos: markers are held against them
            off = off_in_windows(t.recording, found.best.model, t.time[t.boundaries], seen, np.array(news))
            total += float((white.of(off, t.usable) ** 2).sum())
    return total


def off_in_windows(r: Recording, model: Model, times: Floats, seen: Observation, news: Floats) -> Floats:
    """What windows between times (B,) are off by (B - 1, 3) if joints are bent as markers show, which poses that are
    laid over them follow, whatever is true. An edge that is off moves one end of the body by as much."""
    off = _about(r, seen, times) * news
    joints = r.body.joint_count
    moved = (by_bends(r, model, times) * off[:, :joints, None]).sum(axis=1)
    moved[:, 0] += off[:, joints:].sum(axis=1)
    return np.diff(moved, axis=0)


def _about(r: Recording, seen: Observation, times: Floats) -> Floats:
    """By how much markers show channels otherwise about times (B, C), on average; 0 where they are hidden."""
    angles = seen.angles(r.angles, seen.begun(r.angles, marker_angles(r.body, seen.unstretched(r.markers))))
    left = shown_otherwise(r.body, r.markers, angles, seen)
    known = np.isfinite(left)
    sums, counts = (np.cumsum(np.pad(x, ((1, 0), (0, 0))), axis=0) for x in (np.where(known, left, 0.0), known))
    first, last = (np.searchsorted(r.time, times + side * half_average(r)) for side in (-1, 1))
    return np.asarray((sums[last] - sums[first]) / np.maximum(counts[last] - counts[first], 1))
