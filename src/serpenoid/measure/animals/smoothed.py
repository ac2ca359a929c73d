"""Smoothed before it was exported: of a film that was, no frame has noise of its own.

What points do in the directions in which they vary least (the least principal components of their places about the
body's centre and heading, of one half of a film's frames taken for the other half) is noise, however large that is. Its
correlation after k frames, the median over these directions, is 0 of points that were seen frame by frame, and of a
moving mean over n frames

    rho_k = 1 - k / n                     so that n = 1 / (1 - rho_1)

and of other filters alike: at first rho falls no faster than later, and it is gone after 2 n frames. Where a part of
the noise is each frame's own (a tracker whose other errors last), rho falls at once, and slowly from there. What a body
does stays or comes again: it is not gone. Where the file's rounding is as large as this noise nothing is told: points
that hardly move are rounded alike for many frames.

Legend: F frames, N points, c directions.
"""

from __future__ import annotations

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.film.filled_in import rounded_by
from serpenoid.measure.trial import Motion

FEWEST = 100  # frames that show all points: of fewer, what a body does is not told from noise well enough
MOST, LEAST = 12, 5  # points: of more, so many that are evenly spaced
FRAMES = 12  # for every point: of fewer, directions are those of noise alone by chance
SHARE = 1 / 3  # of the directions: of the others a body may make more than noise does
LASTS = 0.35  # of its variance that noise shares with the next frame: more is told
OWN = 1.5  # times what is lost from the first frame to the second, and more, lost at once: noise of each frame's own
GONE = 0.4  # of what is shared with the next frame: more after 2 n frames is a body's motion
LAGS = 100  # frames
PIECE = 6  # frames of one half of a film, in Thue and Morse's order, which no beat follows


def smoothed_over(motion: Motion) -> float:
    """Over how many frames a moving mean makes noise last as it does in this film; 1: it lasts not, or none is seen."""
    noise, rho = _noise(motion), np.zeros(0)
    if noise.shape[1]:
        rho = _correlation(noise, min(len(noise) // 4, LAGS))
    if len(rho) < 3 or rho[0] <= LASTS or 1 - rho[0] >= OWN * (rho[0] - rho[1]):
        return 1.0
    frames = 1 / (1 - rho[0])
    later = np.abs(rho[int(np.ceil(2 * frames)) - 1 :])
    return float(frames) if len(later) > 3 and later.max() < GONE * rho[0] else 1.0


def said_of_smoothing(motion: Motion) -> list[str]:
    """With what it does to K as a rule, and what to do."""
    frames = int(np.ceil(smoothed_over(motion)))
    if frames == 1:
        return []
    said = (
        f"noise of its points lasts for about {frames} frames, and hardly any is a frame's own: were they smoothed "
        "before they were exported, as by a moving mean or a median? Give them as they were before that (if they are, "
        "its tracker's errors last)"
    )
    if motion.beat is None:
        return [said]
    turn = np.pi * float(np.median(np.diff(motion.time_s))) / motion.beat.period_s
    share = 1 - np.sin(frames * turn) / (frames * np.sin(turn))
    return [
        f"{said}. A moving mean over {frames} frames takes {share:.1%} off how far points swing, and makes K too large "
        "by as much to twice as much; filters that keep peaks (Savitzky and Golay's) do so far less"
    ]


def _noise(motion: Motion) -> Floats:
    """What points do in the directions in which they vary least (F, c), NaN in frames that do not show all of them; no
    directions: nothing can be told."""
    count = int(np.clip(len(motion.markers) // FRAMES, LEAST, MOST))
    which = np.unique(np.linspace(0, motion.markers.shape[1] - 1, count).round().astype(int))
    places = motion.markers[:, which, 0] + 1j * motion.markers[:, which, 1]
    turned = (places - places.mean(axis=1, keepdims=True)) * np.exp(-1j * motion.smooth_poses[:, 2:])
    both = np.concatenate([turned.real, turned.imag], axis=1)
    seen = np.isfinite(both).all(axis=1)
    if seen.sum() < FEWEST:
        return np.zeros((len(both), 0))
    if np.sqrt(_ways(both[seen])[0][0]) <= rounded_by(motion.markers) / 4:
        return np.zeros((len(both), 0))
    noise = np.full((len(both), _ways(both[seen])[1].shape[1]), np.nan)
    halves = np.array([(f // PIECE).bit_count() % 2 for f in range(len(both))])
    for half in (0, 1):
        own, other = seen & (halves == half), seen & (halves != half)
        noise[own] = (both[own] - both[other].mean(axis=0)) @ _ways(both[other])[1]
    return noise


def _ways(places: Floats) -> tuple[Floats, Floats]:
    """Variances (2 N - 2,), the least first, of places (F, 2 N) about their centre, and the principal directions (2 N,
    c) of the least SHARE of them."""
    away = places - places.mean(axis=0)
    variance, ways = np.linalg.eigh(away.T @ away / len(away))
    return variance[2:], ways[:, 2 : 2 + max(2, round(SHARE * (len(ways) - 2)))]  # of the centre there is none


def _correlation(noise: Floats, lags: int) -> Floats:
    """After 1, 2, .. frames, the median over directions."""
    seen = np.isfinite(noise[:, 0])
    there = np.where(seen[:, None], noise, 0.0)
    variance = (there**2).sum(axis=0) / seen.sum()
    pairs = [max(int((seen[k:] & seen[:-k]).sum()), 1) for k in range(1, lags + 1)]
    products = [(there[k:] * there[:-k]).sum(axis=0) for k in range(1, lags + 1)]
    return np.array([np.median(p / n / variance) for p, n in zip(products, pairs, strict=True)])
