"""Markers that are off in single frames: a reflection, a mistaken match. They count as hidden.

What rigid links and the frames about it say of each, `serpenoid.measure.shapes.strays` finds. A marker that stays where
the body does not put it is no accident of a frame: it fell or slipped, and is for the stages to judge.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import LEAST_MARKERS, register, shapes, turn
from serpenoid.measure.clock import ROBUST
from serpenoid.measure.film.quality import SHORT_GAP_S, misfit_limit, stretches
from serpenoid.measure.shapes.chain import estimate_chain, fits_within
from serpenoid.measure.shapes.strays import farthest, noise_of_most, without_strays

Strays = tuple[tuple[int, float], ...]  # vertex, and how far it is off [m]


def without_single(body: Body, time_s: Floats, markers: Floats) -> tuple[Floats, Strays]:
    """Markers (F, N, 2) [m] with those that are off for no longer than a short gap as hidden, and which these are."""
    seen = np.isfinite(markers[..., 0])
    ever = np.flatnonzero(seen.any(axis=0))
    if not {*body.joint_vertices} <= {*ever.tolist()}:  # the others' polygon fits as well bent to the other side
        return markers, ()
    length = body.total_length_m
    if fits_within(body, markers / length, misfit_limit(0.0)):  # whatever their noise is, none is off
        return markers, ()
    chain = estimate_chain(body, markers / length)
    missed = farthest(chain.marker_residual) > misfit_limit(noise_of_most(chain))  # a doubled frame is rigid
    if not missed.any():
        return markers, ()
    left, off = without_strays(body, time_s, markers / length, chain)
    flags = _short(time_s, seen & ~np.isfinite(left[..., 0]) & missed[:, None])
    kept = np.where(flags[..., None], np.nan, markers)
    return kept, tuple((j.vertex, j.size * length) for j in off if j.vertex is not None and flags[j.frame, j.vertex])


def beside_log(r: Recording) -> Recording:
    """The same of a recording in which some were found: where many frames in a row are off none about them shows the
    bends, but the servos say them. What a marker is off by in most frames is no accident."""
    if not r.strays:
        return r
    points, left = shapes(r.body, r.angles), r.markers.copy()
    rows, sizes = np.arange(len(left)), np.zeros(left.shape[:2])
    while True:
        poses, miss = register(points, left)
        miss = turn(-poses[:, None, 2], miss)
        ever = np.isfinite(miss[..., 0]).any(axis=0)
        about = miss[:, ever] - np.nanmedian(miss[:, ever], axis=0)
        length = np.zeros(left.shape[:2])
        length[:, ever] = np.nan_to_num(np.linalg.norm(about, axis=2))
        noise = ROBUST * float(np.nanmedian(np.abs(about))) / r.body.total_length_m
        worst, most = length.argmax(axis=1), length.max(axis=1)
        off = most > misfit_limit(noise) * r.body.total_length_m
        tried = off & (np.isfinite(left[..., 0]).sum(axis=1) > LEAST_MARKERS)
        if not tried.any():
            break
        sizes[rows[tried], worst[tried]] = most[tried]
        left[rows[tried], worst[tried]] = np.nan
    hidden = np.isfinite(r.markers[..., 0]) & ~np.isfinite(left[..., 0]) & ~off[:, None]  # where all others fit then
    flags = _short(r.time, hidden)
    strays = tuple((int(k), float(sizes[f, k])) for f, k in np.argwhere(flags))
    return replace(r, markers=np.where(flags[..., None], np.nan, r.markers), strays=(*r.strays, *strays))


def _short(time_s: Floats, flags: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Flags (F, N) of stretches that are no longer than a short gap."""
    found = flags.copy()
    for column in found.T:
        for first, stop in stretches(column):
            if time_s[stop - 1] - time_s[first] > SHORT_GAP_S:
                column[first:stop] = False
    return found


def told(strays: Sequence[tuple[int, float]], trials: int) -> str:
    """What is said of all that were found in so many trials."""
    vertices, sizes = (np.array(values) for values in zip(*strays, strict=True))
    often = np.bincount(vertices)
    most = f"vertex {often.argmax()} ({often.max()} times)"
    times, in_trials = "once" if len(strays) == 1 else f"{len(strays)} times", f"{trials} trial{'s' * (trials > 1)}"
    return (
        f"markers are off in single frames {times} in {in_trials}, by {np.median(sizes):.2g} m (median; up to "
        f"{sizes.max():.2g} m), most often that of {most}: taken for hidden there. Look for reflections or mistaken "
        "matches"
    )
