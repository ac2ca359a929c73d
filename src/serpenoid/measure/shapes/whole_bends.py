"""Bends of an animal where a frame hides points, by what the same frame shows: a body bends as a whole.

    z ~ N(c, S),      a frame shows  y = z_s + n,      n ~ N(0, N): of the points' noise
    E[z | y] = c + S_:s (S_ss + N_ss)^-1 (y - c_s),      Cov[z | y] = S - S_:s (S_ss + N_ss)^-1 S_s:

c and S are those that make all that is shown likeliest (expectation and maximisation), hidden or not: no frame need
show the whole body. Where a wave runs along the body this knows a hidden bend however long it is hidden, while a
straight line in time cuts its corners.

Legend: F frames, m joints; s: joints that a frame shows.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import bridged, unwrapped
from serpenoid.measure.shapes.bends import Bends
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.measure.shapes.principal_bends import noise_pattern

ROUNDS = 40  # of expectation and maximisation; what they still move then is far below how well a bend is known
MOST_FRAMES = 400  # evenly through the recording, from which the bends' covariance is learned
ROUNDING = 1e-10  # of the joints' mean variance


def whole_bends(body: Body, markers: Floats, marker_sd: float, otherwise: Bends) -> Bends:
    """Joint angles of animals at points (F, N, 2) that are hidden, by the others of their frame, or `otherwise`
    (straight lines in time, say): whichever is known better."""
    shown = unwrapped(marker_angles(body, markers))
    seen = np.isfinite(shown)
    wanted = np.flatnonzero(~seen.all(axis=1) & seen.any(axis=1))
    if not len(wanted) or not seen.any(axis=0).all():
        return otherwise
    noise = marker_sd**2 * noise_pattern(body)
    mean, spread = _learned(shown, seen, noise)
    angles, variance = _given(shown[wanted], seen[wanted], mean, spread, noise)
    sd = np.sqrt(np.maximum(np.diagonal(variance, axis1=1, axis2=2), ROUNDING * np.trace(spread)))
    found = Bends(otherwise.angles.copy(), otherwise.sd.copy())
    better = ~seen[wanted] & ~(otherwise.sd[wanted] <= sd)
    found.angles[wanted] = np.where(better, angles, found.angles[wanted])
    found.sd[wanted] = np.where(better, sd, found.sd[wanted])
    return found


def _learned(shown: Floats, seen: NDArray[np.bool_], noise: Floats) -> tuple[Floats, Floats]:
    """Mean (m,) and covariance (m, m) of the bends that angles (F, m) show."""
    useful = np.flatnonzero(seen.any(axis=1))
    rows = useful[np.unique(np.linspace(0, len(useful) - 1, MOST_FRAMES).astype(int))]
    shown, seen = shown[rows], seen[rows]
    start = bridged(rows.astype(float), shown)
    mean, spread = start.mean(axis=0), np.cov(start.T, bias=True).reshape(len(noise), len(noise))
    for _ in range(ROUNDS):
        angles, variance = _given(shown, seen, mean, spread, noise)
        mean = angles.mean(axis=0)
        spread = (angles - mean).T @ (angles - mean) / len(angles) + variance.mean(axis=0)
    return mean, spread


def _given(
    shown: Floats, seen: NDArray[np.bool_], mean: Floats, spread: Floats, noise: Floats
) -> tuple[Floats, Floats]:
    """Bends (F, m) given what each frame shows, and their covariance (F, m, m)."""
    both = spread + noise + ROUNDING * np.trace(spread) / len(spread) * np.eye(len(spread))
    pairs = seen[:, :, None] & seen[:, None]
    own = np.where(pairs, both, np.where(seen[:, :, None], 0.0, np.eye(len(both))))
    across = np.where(seen[:, :, None], spread, 0.0)
    gain = np.linalg.solve(own, across)
    away = np.where(seen, shown - mean, 0.0)
    angles = mean + np.einsum("fsj,fs->fj", gain, away)
    return angles, spread - np.swapaxes(across, 1, 2) @ gain
