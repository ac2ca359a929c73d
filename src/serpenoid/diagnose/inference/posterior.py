"""The posterior of an explanation: its log evidence, Laplace's approximation about a fit, and prior odds of its names.

    ln p(r | M) = -(r^T V^{-1} r + ln |V|) / 2 + ln p(x) + (P / 2) ln 2 pi - ln |X^T V^{-1} X + W| / 2

V: noise and discrepancy, the latter the likeliest given this explanation; p(x), W: prior density and its curvature.
Prior odds: one effect of the catalogue is expected, every name as likely as the others, and so every place of a name.
The odds of a campaign's many candidates are so taken into account, whatever their number.

Legend: P parameters, C candidates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.diagnose.inference.medium import Fit, blocks, fit_guided
from serpenoid.diagnose.inference.prior import WIDTHS, Prior
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import MediumEffect
from serpenoid.effects.catalogue import catalogue, places

TWICE = 2  # sizes of the discrepancy and parameters depend on each other


@dataclass(frozen=True)
class Explanation:
    """A fit under the discrepancy that is likeliest with it (`motion.sizes`), and its log posterior score."""

    motion: Motion
    fit: Fit
    score: float


def explained(motion: Motion, found: Fit, steps: int = 3, rounds: int = TWICE) -> Explanation:
    """Sizes of the discrepancy and parameters, in turn; the score. steps: of each fit, 0 leaves parameters alone."""
    for _ in range(rounds):
        motion = replace(motion, sizes=likeliest(motion, found))
        found = fit_guided(motion, found, steps)
    return Explanation(motion, found, score_of(motion, found))


def likeliest(motion: Motion, found: Fit) -> Floats:
    """Sizes of the discrepancy (K,) given a fit."""
    left, used = [], []
    for track, p in zip(motion.tracks, found.predictions, strict=True):
        white = (track.displacement - p.displacement) / motion.noise.of(track)
        used.append(track.usable & np.isfinite(white).all(axis=1))
        left.append(white[used[-1]].ravel())
    return blocks(motion, found.predictions, used).likeliest(np.concatenate(left), motion.sizes)


def score_of(motion: Motion, found: Fit) -> float:
    """Log evidence and log prior odds of a fit."""
    evidence, effects = found.evidence, found.effects
    prior, x = Prior.of(motion, effects), found.coordinates
    stretch = prior.stretch(x)
    matrix = (evidence.matrix.sum(axis=0) + np.diag(prior.pull(x)[1])) * np.outer(stretch, stretch)
    occam = 0.5 * (len(x) * np.log(2 * np.pi) - np.linalg.slogdet(matrix)[1])
    misfit = float(evidence.constant.sum()) + evidence.log_determinant
    return -0.5 * misfit + prior.log_density(x) + float(occam) + sum(log_odds(motion, e) for e in effects)


def log_odds(motion: Motion, effect: ActiveEffect) -> float:
    """ln of the prior odds that an effect is at its place."""
    names = {k.name for k in catalogue().values() if isinstance(k, MediumEffect) or k.name == "frame_drift"}
    body = motion.tracks[0].recording.body
    return -float(np.log(len(names - motion.untestable)) + np.log(len(places(effect.effect, body))))


def projected(evidence: Evidence, own: Sequence[int], new: Sequence[int], width: Floats) -> tuple[Floats, Floats]:
    """What the data say about new columns, own ones of prior width (own,) fitted again: matrix (C, C), vector (C,)."""
    matrix, vector = evidence.matrix.sum(axis=0), evidence.vector.sum(axis=0)
    o, n = list(own), list(new)
    inner = matrix[np.ix_(o, o)] + np.diag(1 / width**2)
    taken = np.linalg.solve(inner, np.column_stack([matrix[np.ix_(o, n)], vector[o]]))
    across = matrix[np.ix_(n, o)]
    return matrix[np.ix_(n, n)] - across @ taken[:, :-1], vector[n] - across @ taken[:, -1]


def linear_gain(matrix: Floats, vector: Floats, width: Floats) -> Floats:
    """Gain of log evidence to first order, of columns (P, P), (..., P) whose parameters have prior widths (P,)."""
    whole = []
    for w in WIDTHS:
        certainty = np.diag(1 / (w * width) ** 2)
        solved = np.linalg.solve(matrix + certainty, vector[..., None])[..., 0]
        occam = np.linalg.slogdet(np.eye(len(width)) + matrix * np.outer(w * width, w * width))[1]
        whole.append(0.5 * (vector * solved).sum(axis=-1) - 0.5 * occam)
    most = np.max(whole, axis=0)
    return np.asarray(most + np.log(np.exp(np.array(whole) - most).mean(axis=0)))
