"""How large a body is in a film that has no scale, from the lengths that are stated: a number and its standard error.

    m_fe = s l_e + noise,  noise of frame f ~ N(0, v C_f),  C_f = tridiagonal (2, -cos of the bend between two edges)
    s^ = sum_f l' C_f^-1 m_f / sum_f l' C_f^-1 l

m: lengths in the film (distances, of an animal arcs), l: stated ones, v: variance of a point's coordinate. A point that
is off lengthens one edge and shortens the next, which is in C: s^ is the scale of the chain that fits the points best.
To first order its error is independent of those of bends and places (which change no length).

Noise lengthens every edge by v / m, too, and roughens the curve. What v adds to s^ is told by adding noise once more to
the points, and taken off. v itself is told by what lengths scatter by about their means: g(v) = v + a v^2, for arcs
scatter more than distances; with g = g(v) and a second one of g(v + g),

    g(v + g) / g = (1 + x) / x^2,    x = v / g

The standard error is a jackknife over blocks of frames; that of an animal has beside it how far two ways to draw the
curve between its points differ (`serpenoid.body_curve`). What lasts of lengths from frame to frame may be a body that
stretches, whose noise is less: of what is taken off, that share is in the standard error. What points that are beside
their places for good do is not. Legend: F frames, N vertices, E edges.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.body_curve import PLAIN, SMOOTH
from serpenoid.measure.blocks import blocks
from serpenoid.measure.cells import Floats
from serpenoid.measure.shapes.lengths import chord_shares, in_place, mean_of
from serpenoid.measure.shapes.own_noise import own_noise, share_of_scatter
from serpenoid.measure.trial_files import ever_seen, stated_between

BLOCKS = 20
DRAWS = 2  # of noise, each in four mirrors: what is odd in it does not hide what is even
TINY = np.finfo(float).tiny


@dataclass(frozen=True)
class FilmScale:
    """The film's unit over the body's, NaN where no two neighbours are seen together; its standard error, a share."""

    ratio: float
    sd: float

    @property
    def words(self) -> str:
        """What is said of a ratio in pixels a body length."""
        return (
            f"a body length is {self.ratio:.5g} pixels by its points, standard error {100 * self.sd:.2g} %: intervals "
            "of what is fitted have that in them, displacements and speeds in body lengths are off by as much. "
            "`metres_per_pixel` makes it known"
        )


def film_scale(body: Body, points: Floats) -> FilmScale:
    """Of a film's points (F, N, 2), NaN hidden, in its own unit."""
    found = _scaled(body, points, SMOOTH)
    unsure = abs(_scaled(body, points, PLAIN).ratio / found.ratio - 1) if body.is_animal else 0.0
    return FilmScale(found.ratio, float(np.hypot(found.sd, unsure)))


def _scaled(body: Body, points: Floats, degree: int) -> FilmScale:
    """The same, without what another way to draw the curve makes of it."""
    first, edges, slow = _told(body, points, degree)
    rows = first[:, 3] > 0
    if rows.sum() < 2:
        return FilmScale(np.nan, np.nan)
    told, noise = [first], np.sqrt(_variance(first.sum(axis=0), edges))
    for more in own_noise(points, DRAWS if noise > 0 else 0):
        told += [_told(body, points + noise * each, degree)[0] for each in more]
    parts = min(BLOCKS, int(rows.sum()))
    each = np.array([[part.sum(axis=0) for part in np.array_split(one[rows], parts)] for one in told])
    whole = each.sum(axis=1)
    ratio = _less_noise(whole, edges)
    others = np.array([_less_noise(whole - each[:, b], edges) for b in range(parts)]) / ratio
    by_frames = (parts - 1) / parts * ((others - others.mean()) ** 2).sum()
    longer = whole[0, 0] / whole[0, 1] / ratio - 1
    return FilmScale(ratio, float(np.hypot(np.sqrt(by_frames), slow * longer)))


def _less_noise(sums: Floats, edges: int) -> float:
    """s of sums (1 + 4 DRAWS, 4), the first row of the points as they are, less what noise lengthens it by."""
    scales = sums[:, 0] / sums[:, 1]
    variances = np.array([_variance(row, edges) for row in sums])
    if len(sums) == 1 or variances[0] <= 0:
        return float(scales[0])
    growth = variances[1:].mean() / variances[0]
    own = share_of_scatter(float(growth))
    return float(scales[0] - own * (scales[1:].mean() - scales[0]))


def _variance(sums: Floats, edges: int) -> float:
    """g: of a coordinate, by what lengths scatter by about their means."""
    return float(sums[2] / max(sums[3] - edges, 1.0))


def _told(body: Body, points: Floats, degree: int) -> tuple[Floats, int, float]:
    """Of every frame (F, 4): l' C^-1 m, l' C^-1 l, d' C^-1 d (d: from the means of m), and how many edges it shows; how
    many edges any frame shows; the share (0 .. 1) of d' d that lasts from frame to frame."""
    shown = ever_seen(points)
    steps = np.diff(points[:, shown], axis=1)
    lengths = np.asarray(np.linalg.norm(steps, axis=2))
    cosines = (steps[:, 1:] * steps[:, :-1]).sum(axis=2) / np.maximum(lengths[:, 1:] * lengths[:, :-1], TINY)
    if body.is_animal and len(shown) == body.vertices:
        lengths = lengths / chord_shares(body, points, degree=degree)
    stated = stated_between(shown.tolist(), body.edges_m, body)
    used = in_place(np.where(np.isfinite(stated), lengths, np.nan))
    away = np.where(used, lengths - mean_of(lengths, used), 0.0)
    told = np.where(used, np.nan_to_num(stated), 0.0)
    beside = np.where(used[:, 1:] & used[:, :-1], -np.nan_to_num(cosines), 0.0)
    found = np.zeros((len(points), 4))
    for b in blocks(len(points), told.shape[1] ** 2):
        solved = np.linalg.solve(_together(beside[b]), np.stack([told[b], away[b]], axis=2))
        found[b, 0] = (solved[..., 0] * np.where(used[b], lengths[b], 0.0)).sum(axis=1)
        found[b, 1] = (solved[..., 0] * told[b]).sum(axis=1)
        found[b, 2] = (solved[..., 1] * away[b]).sum(axis=1)
    found[:, 3] = used.sum(axis=1)
    return found, int(used.any(axis=0).sum()), _lasting(away, used)


def _lasting(away: Floats, used: NDArray[np.bool_]) -> float:
    """Share of the variance of lengths, from their means (F, E), that is not in differences of successive frames."""
    both = used[1:] & used[:-1]
    variance = (away**2).sum() / max(int(used.sum()), 1)
    quick = (np.diff(away, axis=0)[both] ** 2).sum() / 2 / max(int(both.sum()), 1)
    return float(np.clip(1 - quick / variance, 0, 1)) if variance > 0 and both.any() else 0.0


def _together(beside: Floats) -> Floats:
    """C (F, E, E) of what stands beside its diagonal (F, E - 1)."""
    frames, between = beside.shape
    made, at = np.zeros((frames, between + 1, between + 1)), np.arange(between + 1)
    made[:, at, at] = 2.0
    made[:, at[1:], at[:-1]] = made[:, at[:-1], at[1:]] = beside
    return made
