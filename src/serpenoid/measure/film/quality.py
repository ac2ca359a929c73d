"""Gaps and jumps: found and reported, never smoothed away."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import ROBUST

SHORT_GAP_S = 0.1  # a body moves little in this time; longer gaps split the track
ONE_MISSING = 2.5  # times the usual way from frame to frame: less is one frame, whose time stamps are uneven
JUMP_SIGMA = 8.0  # robust standard deviations: no jump in a million frames of clean data
RUN = 7  # steps, about each
TINY = 1e-300
SMALLEST_JUMP = 0.004  # body lengths: a third of a centimetre on a metre; smaller ones drown in marker noise anyway


@dataclass(frozen=True)
class Gap:
    """Frames first..last (inclusive) in which the chain is not determined; short: for so little that it is bridged."""

    first: int
    last: int
    duration_s: float
    short: bool


@dataclass(frozen=True)
class Jump:
    """Between frame - 1 and frame the whole body (vertex None) or one marker moved by `size` [body lengths]."""

    frame: int
    time_s: float
    vertex: int | None
    size: float


def find_gaps(determined: NDArray[np.bool_], time_s: Floats, seen: NDArray[np.bool_]) -> tuple[Gap, ...]:
    """Every run of undetermined frames (F,); seen (F,): frames that show any point. One that shows none is lost, as one
    that is not in the file; where points are seen, and the chain is not known, something is wrong with them."""
    usual, found = bridged_s(time_s), []
    for first, stop in stretches(~determined):
        lasts = _span(first, stop - 1, time_s)
        found.append(Gap(first, stop - 1, lasts, lasts <= (SHORT_GAP_S if seen[first:stop].any() else usual)))
    return tuple(found)


def bridged_s(time_s: Floats) -> float:
    """How long frames may be lost [s] and be bridged: a frame alone at any rate, for film that is too slow to be
    without one of its frames is too slow to be used."""
    return max(SHORT_GAP_S, ONE_MISSING * float(np.median(np.diff(time_s))))


def stretches(flags: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First row of each stretch of true flags (R,), and the row after its last."""
    edges = np.flatnonzero(np.diff(flags.astype(int), prepend=0, append=0))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))


def find_holes(time_s: Floats) -> NDArray[np.int64]:
    """Frames before which more are missing from the file than are bridged."""
    return np.asarray(1 + np.flatnonzero(np.diff(time_s) > bridged_s(time_s)))


def _span(first: int, last: int, time_s: Floats) -> float:
    before, after = max(first - 1, 0), min(last + 1, len(time_s) - 1)
    return float(time_s[after] - time_s[before])


def between_jumps(poses: Floats, time_s: Floats, fewest: int) -> NDArray[np.bool_]:
    """Frames (F,) between two jumps of the body, or one and the film's beginning or end, that are fewer than
    `fewest` frames apart."""
    found = np.zeros(len(poses), dtype=bool)
    frames = [0, *(jump.frame for jump in _body_jumps(poses, time_s)), len(poses)]
    for first, stop in zip(frames, frames[1:], strict=False):
        found[first:stop] = stop - first < fewest
    return found


def find_jumps(
    poses: Floats, covariance: Floats, marker_residual: Floats, marker_sd: float, time_s: Floats
) -> tuple[Jump, ...]:
    """Whole-body jumps from the poses (F, 3) of such covariance (F, 3 or more, .), single-marker jumps from the misfit
    (F, N, 2) to the rigid chain."""
    variance = covariance[:, 0, 0] + covariance[:, 1, 1]
    return (*_body_jumps(poses, time_s, variance), *_marker_jumps(marker_residual, marker_sd, time_s))


def _body_jumps(poses: Floats, time_s: Floats, variance: Floats | None = None) -> list[Jump]:
    """A step of the centroid that neither its neighbours in time nor the run of the record explain, nor how well its
    ends are known (F,): where points are hidden, that is not alike."""
    known = np.flatnonzero(np.isfinite(poses[:, 0]))
    if len(known) < 8:
        return []
    spacing = np.diff(time_s[known])
    step = np.diff(poses[known, :2], axis=0) / spacing[:, None] * np.median(spacing)
    odd = _off_the_run(step)
    limit = max(SMALLEST_JUMP, JUMP_SIGMA * ROBUST * float(np.median(odd)))
    vague = np.zeros(len(odd)) if variance is None else JUMP_SIGMA * np.sqrt(variance[known][1:] + variance[known][:-1])
    jumps = np.flatnonzero(odd > np.maximum(limit, vague))
    return [Jump(int(known[i + 1]), float(time_s[known[i + 1]]), None, float(odd[i])) for i in jumps]


def _off_the_run(steps: Floats) -> Floats:
    """How far each step (S, 2) is from the median of the RUN about it. Where the record begins and ends, from the line
    through the nearest medians, in units of how far as many steps amid it are from theirs: a leap there is one step,
    and a motion that is smooth is none."""
    if len(steps) < RUN:
        return np.asarray(np.linalg.norm(steps - np.median(steps, axis=0), axis=1))
    half, whole = RUN // 2, np.median(np.lib.stride_tricks.sliding_window_view(steps, RUN, axis=0), axis=2)
    odd = np.zeros(len(steps))
    odd[half : half + len(whole)] = np.linalg.norm(steps[half : half + len(whole)] - whole, axis=1)
    usual, far = float(np.median(odd[half : half + len(whole)])), min(half, len(whole) - 1)
    for values, medians, ends in ((steps, whole, odd), (steps[::-1], whole[::-1], odd[::-1])):
        nearest, farther = medians[: len(medians) - far], medians[far:]
        for j in range(1, half + 1):
            line = nearest + (nearest - farther) * (j / max(far, 1))
            off = np.linalg.norm(values[half - j : half - j + len(line)] - line, axis=1)
            ends[half - j] = off[0] * min(1.0, usual / max(float(np.median(off)), TINY))
    return odd


def misfit_limit(marker_sd: float) -> float:
    """How far links may miss a marker and it be noise [body lengths]; infinite where noise is not known."""
    return max(SMALLEST_JUMP / 2, JUMP_SIGMA * marker_sd) if np.isfinite(marker_sd) else np.inf


def _marker_jumps(residual: Floats, marker_sd: float, time_s: Floats) -> list[Jump]:
    size = np.linalg.norm(residual, axis=2)
    limit = misfit_limit(marker_sd)
    with np.errstate(invalid="ignore"):
        odd = size > limit
    worst = np.where(odd, size, 0.0)
    jumps = []
    for vertex in range(size.shape[1]):
        starts = np.flatnonzero(odd[:, vertex] & ~np.concatenate([[False], odd[:-1, vertex]]))
        leading = [f for f in starts if worst[f].argmax() == vertex]  # its neighbours are dragged along
        jumps += [Jump(int(f), float(time_s[f]), vertex, float(size[f, vertex])) for f in leading]
    return sorted(jumps, key=lambda jump: jump.frame)
