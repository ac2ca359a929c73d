"""Single markers that are not where the rest of the body says: found before the whole body is said to have jumped.

A frame in which rigid links miss a marker by more than noise does (`quality.misfit_limit`), or from which the body
jumps back at once, is fitted beside what the frames about it show of its bends. If it does not fit, it is fitted
without each of its markers. Where all others then fit, the one that costs least to leave out is astray, and counts as
hidden; where none is enough, the best stays out and a second is looked for, as long as three are left.

Legend: F frames, N vertices, C suspect frames.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.film.quality import JUMP_SIGMA, Jump, between_jumps, misfit_limit
from serpenoid.measure.shapes.bends import Bends, bends_in_time
from serpenoid.measure.shapes.chain import ChainEstimate, fitted_beside

MOVED = 8  # frames: where the body jumps back before, it did not go there
LEAST_SEEN = 3  # two markers and the bends tell a pose; a third, whether they fit


def without_strays(
    body: Body, time_s: Floats, markers: Floats, found: ChainEstimate
) -> tuple[Floats, tuple[Jump, ...]]:
    """Markers (F, N, 2) with those that are astray as hidden, and which these are, each with how far it is off."""
    noise = noise_of_most(found)
    limit = misfit_limit(noise)
    there_and_back = between_jumps(found.poses, time_s, MOVED)
    clean = found.determined & (farthest(found.marker_residual) <= limit) & ~there_and_back
    if clean.all() or clean.sum() < 2:
        return markers, ()
    said = _about(body, time_s, markers, found, clean)
    suspects = np.flatnonzero(~clean & np.isfinite(said.angles).all(axis=1))
    _, missed, points = fitted_beside(body, markers[suspects], said.of_rows(suspects), noise)
    suspects = suspects[~_fits(markers[suspects] - points, missed, limit)]
    said = said.of_rows(suspects)
    mended, sizes = _searched(body, markers[suspects], said, noise, limit)
    kept = markers.copy()
    kept[suspects] = mended
    strays = [
        Jump(int(suspects[c]), float(time_s[suspects[c]]), int(k), float(sizes[c, k]))
        for c, k in np.argwhere(np.isfinite(sizes))
    ]
    return kept, tuple(strays)


def noise_of_most(found: ChainEstimate) -> float:
    """Marker SD by the median frame's misfit of markers alone: what up to half of all frames are is of no account."""
    seen = np.isfinite(found.marker_residual)
    freedom = seen.sum(axis=(1, 2)) - (2 + found.joint_angles.shape[1] + 1)
    usable = found.determined & (freedom > 0)
    if not usable.any():
        return float("nan")
    squares = np.where(seen, found.marker_residual**2, 0.0).sum(axis=(1, 2))[usable]
    middle = 2 * gammaincinv(freedom[usable] / 2, 0.5)  # median of chi squared
    return float(np.sqrt(np.median(squares / middle)))


def _about(body: Body, time_s: Floats, markers: Floats, found: ChainEstimate, clean: NDArray[np.bool_]) -> Bends:
    """What clean frames show of the bends in all others: whose own markers are not believed."""
    variance = np.diagonal(found.covariance[:, 3:, 3:], axis1=1, axis2=2)
    believed = np.where(clean[:, None, None], markers, np.nan)
    return bends_in_time(body, time_s, believed, found.joint_angles, variance, clean, beyond=True)


def _searched(body: Body, markers: Floats, said: Bends, marker_sd: float, limit: float) -> tuple[Floats, Floats]:
    """Suspect frames (C, N, 2) without what is astray, and how far each stray is off (C, N); NaN: it is not.

    A frame in which no choice is enough stays as it is.
    """
    tried, mended = markers.copy(), markers.copy()
    sizes = np.full(markers.shape[:2], np.nan)
    left = np.arange(len(markers))
    while len(left):
        seen = np.isfinite(tried[left, :, 0])
        left = left[seen.sum(axis=1) > LEAST_SEEN]
        worst, fits, off = _one_less(body, tried[left], said.of_rows(left), marker_sd, limit)
        tried[left, worst] = np.nan
        hidden = np.isfinite(markers[left, :, 0]) & ~np.isfinite(tried[left, :, 0])
        away = np.linalg.norm(markers[left] - off, axis=2)
        # one that is where the chain is without it was not astray: the fit had gone elsewhere
        done = fits & (away > limit).all(axis=1, where=hidden)
        mended[left[done]] = tried[left[done]]
        sizes[left[done]] = np.where(hidden, away, np.nan)[done]
        left = left[~fits]
    return mended, sizes


def _one_less(
    body: Body, markers: Floats, said: Bends, marker_sd: float, limit: float
) -> tuple[NDArray[np.int64], NDArray[np.bool_], Floats]:
    """Of each frame (C, N, 2) the marker that costs least to leave out (C,), whether all others fit then (C,), and
    where the chain is (C, N, 2)."""
    count, vertices = markers.shape[:2]
    without = np.repeat(markers[:, None], vertices, axis=1)
    without[:, np.arange(vertices), np.arange(vertices)] = np.nan
    rows = np.repeat(np.arange(count), vertices)
    cost, missed, points = fitted_beside(body, without.reshape(-1, vertices, 2), said.of_rows(rows), marker_sd)
    cost = np.where(np.isfinite(markers[..., 0]), cost.reshape(count, vertices), np.inf)
    best = cost.argmin(axis=1)
    each = np.arange(count)
    chain = points.reshape(count, vertices, vertices, 2)[each, best]
    missed = missed.reshape(count, vertices, missed.shape[1])[each, best]
    return best, _fits(without[each, best] - chain, missed, limit), chain


def _fits(residual: Floats, missed: Floats, limit: float) -> NDArray[np.bool_]:
    """Frames (F,) whose markers are not farther off than the limit, nor bends (F, m) than noise."""
    return np.asarray((farthest(residual) <= limit) & (np.abs(missed).max(axis=1) <= JUMP_SIGMA))


def farthest(residual: Floats) -> Floats:
    """Length (F,) of the longest of residuals (F, N, 2), NaN where hidden."""
    return np.asarray(np.nan_to_num(np.linalg.norm(residual, axis=2)).max(axis=1))
