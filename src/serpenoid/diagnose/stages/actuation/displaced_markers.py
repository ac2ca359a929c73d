"""Is it a marker beside its place that makes a joint seem not to follow, where no servo log is another witness?

A marker at joint k that sits beside it, fixed to the link before (or after, from the head's side), is at a constant
distance D of the joint before, and seen from there at a constant angle phi from where its joint is:

    joint k = marker k-1 + e_k u(angle(marker k - marker k-1) - phi)

phi is where the next link is as long as stated, e_k+1. What stated lengths miss so, of all links together, is compared
with what they miss as they are, and with links of other lengths, each its median. A scale that all share is taken off.

Legend: F frames, K corners of the chain (its ends, and its joints), m = K - 2 joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.measure.trial_files import stated_between

MOST_FRAMES = 4000
LEAST_FRAMES = 40
LEAST_LINKS = 4  # two meet at the marker, and two say what is usual
WIDEST = 0.5  # rad
PARTS = 10  # of its range, in each of which phi is sought


@dataclass(frozen=True)
class DisplacedMarker:
    """At which joint (1 .. m), by how much [m], and whether links of other lengths explain less."""

    joint: int
    distance_m: float
    sure: bool

    @property
    def words(self) -> str:
        """As the second half of a sentence."""
        lengths = "" if self.sure else ", or links that meet there are of other lengths than `edge_lengths`"
        return f"by the lengths of links the marker at joint {self.joint} is {self._far} beside its place{lengths}"

    @property
    def remedy(self) -> str:
        """What to do first."""
        lengths = "" if self.sure else ", or see whether `edge_lengths` are right there"
        put = f"put it right, or log the servos{lengths}; then diagnose again"
        return f"the marker at joint {self.joint} is {self._far} beside its place: {put}"

    def beside(self, joint: int) -> bool:
        """Whether it bends what markers show of a joint (1 .. m)."""
        return abs(joint - self.joint) <= 1

    @property
    def _far(self) -> str:
        return f"{1e3 * self.distance_m:.2g} mm"


def displaced_marker(recordings: Sequence[Recording], joint: int) -> DisplacedMarker | None:
    """The marker at a joint (1 .. m) or at a neighbour of it that is beside its place by more than its noise."""
    body = recordings[0].body
    points = np.concatenate([r.markers[:, body.corners] for r in recordings])
    points = points[np.isfinite(points).all(axis=(1, 2))]
    points = points[:: 1 + len(points) // MOST_FRAMES]
    lengths = stated_between(body.corners, body.edges_m, body)
    if len(points) < LEAST_FRAMES or len(lengths) < LEAST_LINKS:
        return None
    shown = np.linalg.norm(np.diff(points, axis=1), axis=2)
    lengths = lengths * np.median(np.median(shown, axis=0) / lengths)
    stated = ((shown - lengths) ** 2).mean(axis=0)
    other = float(((shown - np.median(shown, axis=0)) ** 2).mean(axis=0).sum())
    tried = []
    for k in range(max(joint - 1, 1), min(joint + 1, len(lengths) - 1) + 1):
        rest = float(np.delete(stated, [k - 1, k]).sum())
        forth, back = points[:, k - 1 : k + 2], points[:, k - 1 : k + 2][:, ::-1]
        for three, two in ((forth, lengths[k - 1 : k + 1]), (back, lengths[k - 1 : k + 1][::-1])):
            distance, left = _beside(three, two)
            tried.append((rest + left, left, distance, k))
    left, own, distance, k = min(tried)
    noise = np.sqrt(own) / 2  # of a coordinate: a distance has twice its variance
    most = stated.sum() - left > (1 - LAW_ERROR**2) * (stated.sum() - min(left, other))
    return DisplacedMarker(k, distance, left <= other) if most and distance > noise else None


def _beside(points: Floats, lengths: Floats) -> tuple[float, float]:
    """How far [m] the middle one of three markers (F, 3, 2) is from its joint, fixed to the first link, and what two
    links miss so [m^2]."""
    first, apart = points[:, 0], points[:, 1] - points[:, 0]
    distance, angle = np.linalg.norm(apart, axis=1), np.arctan2(apart[:, 1], apart[:, 0])
    usual = float(np.median(distance))

    def missed(phi: float) -> float:
        along = np.stack([np.cos(angle - phi), np.sin(angle - phi)], axis=1)
        left = np.linalg.norm(points[:, 2] - first - lengths[0] * along, axis=1) - lengths[1]
        return float((left**2).mean())

    bounds = np.linspace(-WIDEST, WIDEST, PARTS + 1)
    fits = [minimize_scalar(missed, bounds=part, method="bounded") for part in zip(bounds, bounds[1:], strict=False)]
    best = min(fits, key=lambda fit: float(fit.fun))
    away = np.hypot(usual * np.cos(best.x) - lengths[0], usual * np.sin(best.x))
    return float(away), float(best.fun) + float(((distance - usual) ** 2).mean())
