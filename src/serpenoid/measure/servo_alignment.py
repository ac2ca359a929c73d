"""A servo log laid over what the cameras saw: clock offset, zero of each joint, scatter.

Legend: F frames, N vertices, m joints, R rows of the log.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import Offset, find_offset, interpolate_smoothly
from serpenoid.measure.logs import TICK, ServoLog
from serpenoid.measure.schedule import Schedule, start_by_shape
from serpenoid.measure.servo_zeros import BELIEVED, lasting, told_zeros
from serpenoid.measure.shapes.chain import ChainEstimate
from serpenoid.measure.shapes.links import bends, chain_vertices, marker_angles

QUANTISATION_SD = TICK / np.sqrt(12)  # a servo cannot be better than its ticks
MIN_CORRELATION = 0.5  # below, the servo log and the cameras did not see the same motion: other joints' have less
STILL_S = 1.0  # of rest before the first command and after the last
OFTEN = 0.5  # share of the frames that a marker must be seen in to be a corner of the polygon


@dataclass(frozen=True)
class ServoAlignment:
    """Servo log laid over the cameras: clock offset, per-joint zero (markers minus servo) and scatter [rad].

    frame_sd: the scatter that errors of single frames would need to tell as little together, as errors that last do.
    """

    offset: Offset
    joint_zero: Floats  # (m,); 0 for joints that no marker tells
    sd: float
    frame_sd: float
    angles: Floats  # (F, m) on the frames, zero taken out; NaN outside the log


def align_servo(
    body: Body, estimate: ChainEstimate, markers: Floats, time_s: Floats, log: ServoLog
) -> tuple[ServoAlignment | None, list[str]]:
    """Clock offset, joint zeros and scatter of a servo log against what markers (F, N, 2) alone show.

    Where they do not show the whole chain, the clock is found by the bends of the polygon of those that are seen, on
    joints or between them (a vertex guessed from its neighbours has two mirror positions), and so are the zeros of
    joints that no frame shows, as far as markers tell them.
    """
    ends = seen_corners(body, markers)
    whole = ends == list(body.corners) and estimate.determined.mean() >= OFTEN
    offset = (
        find_offset(time_s, estimate.joint_angles, log.time_s, log.position)
        if whole
        else _offset_by_corners(body, ends, markers, time_s, log)
    )
    if offset is None or offset.correlation < MIN_CORRELATION:
        seen = "no common motion" if offset is None else f"correlation {offset.correlation:.2f}"
        return None, [f"servo log does not match the cameras ({seen}): not used"]
    angles = interpolate_smoothly(log.time_s + offset.offset_s, log.position, time_s)
    shown = estimate.joint_angles if whole else marker_angles(body, markers)
    zero, unseen = _zeros(shown - angles)
    told: list[int] = []
    if unseen:
        zero[unseen], known = told_zeros(body, ends, markers, angles + zero, unseen)
        told = [joint for joint, sd in zip(unseen, known.tolist(), strict=True) if sd < BELIEVED / 2]
    variance = np.diagonal(estimate.covariance[:, 3:, 3:], axis1=1, axis2=2) if whole else None
    sd = offset.rms if len(unseen) == body.joint_count else _servo_sd(shown - angles - zero, variance)
    lasts = lasting(shown - angles - zero)
    return ServoAlignment(offset, zero, sd, float(np.sqrt(sd**2 + lasts)), angles + zero), _remarks(unseen, told)


def align_commands(
    body: Body, estimate: ChainEstimate, markers: Floats, time_s: Floats, schedule: Schedule
) -> tuple[ServoAlignment | None, list[str]]:
    """The same of what servos were told, where nobody recorded what they did: for joints that no marker shows.

    What it misses of the joints that are seen (lag, play) is its scatter, and how long that lasts.
    """
    told = np.arange(-schedule.pause_s - STILL_S, schedule.whole_s + STILL_S, np.diff(time_s).min())
    angles = schedule.commanded(told + schedule.start_s)
    log = ServoLog(told, angles, None, None, None, None, "joint table")
    found, complaints = align_servo(body, estimate, markers, time_s, log)
    if found is None:
        return None, [said.replace("servo log", "joint table") for said in complaints]
    return found, []


def joints_unseen(body: Body, markers: Floats) -> list[int]:
    """Joints, from 0, that no frame of markers (F, N, 2) shows: a corner beside them is never seen."""
    return _zeros(marker_angles(body, markers))[1]


def assumed(joints: Sequence[int]) -> str:
    """What is said where their markers are never seen, and no servo log says what they did."""
    one = len(joints) == 1
    names = f"joint{'' if one else 's'} {', '.join(str(k + 1) for k in joints)}"
    return (
        f"no frame shows {names}, and no servo log says what {'it' if one else 'they'} did: assumed to do as the joint "
        "table says, to the side that it says; a fault there is not seen, and goes into every number"
    )


def seen_share(markers: Floats) -> Floats:
    """Of the frames, how many show each marker (N,)."""
    return np.asarray(np.isfinite(markers[..., 0]).mean(axis=0))


def seen_corners(body: Body, markers: Floats) -> list[int]:
    """Corners of the polygon through the markers that are seen often enough, wherever they are: the first and the last
    of each link, for between these it cannot bend. Where all ends and joints are seen, it is these."""
    often = np.flatnonzero(seen_share(markers) > OFTEN)
    links = [often[(often >= a) & (often <= b)] for a, b in pairwise(body.corners)]
    return sorted({int(k) for own in links if len(own) for k in (own[0], own[-1])})


def start_by_corners(body: Body, schedule: Schedule, markers: Floats, time_s: Floats) -> Offset | None:
    """t0 on the cameras' clock, by the bends of the polygon of markers (F, N, 2) that are seen."""
    ends = seen_corners(body, markers)
    if len(ends) < 3:
        return None
    return start_by_shape(schedule, time_s, bends(markers[:, ends]), lambda told: _bends_of(body, told, ends))


def _offset_by_corners(body: Body, ends: list[int], markers: Floats, time_s: Floats, log: ServoLog) -> Offset | None:
    if len(ends) < 3:
        return None
    return find_offset(time_s, bends(markers[:, ends]), log.time_s, _bends_of(body, log.position, ends))


def _bends_of(body: Body, angles: Floats, corners: list[int]) -> Floats:
    """Of the polygon through some vertices of joint angles (R, m)."""
    return bends(chain_vertices(body, np.zeros((len(angles), 3)), angles)[:, corners])


def _zeros(difference: Floats) -> tuple[Floats, list[int]]:
    """Medians of the columns (F, m), 0 where a column is never known, and which those are."""
    known = np.asarray(np.isfinite(difference).any(axis=0))
    zero = np.zeros(len(known))
    zero[known] = np.nanmedian(difference[:, known], axis=0)
    return zero, [int(k) for k in np.flatnonzero(~known)]


def _remarks(unseen: Sequence[int], told: Sequence[int]) -> list[str]:
    ends = {True: "its zero what all markers together say", False: "and whether its zero is right is not known"}
    found = []
    for known, words in ends.items():
        joints = ", ".join(str(k + 1) for k in unseen if (k in told) is known)
        if joints:
            found.append(f"no frame shows joint {joints}: its angle is the servo log's, {words}")
    return found


def _servo_sd(difference: Floats, variance: Floats | None) -> float:
    """Scatter of the servos' angles beyond the markers' own noise, no smaller than these data can tell.

    One standard error is added: servos that agree with the markers within their noise are not thereby exact, and their
    errors (rounding, interpolation between log rows, the zero itself) last longer than a frame. With the markers' own
    noise unknown (variance None) it stays in.
    """
    variance = np.full_like(difference, QUANTISATION_SD**2) if variance is None else variance
    both = np.isfinite(difference) & np.isfinite(variance)
    weight = np.where(both, 1 / np.where(both, variance, 1.0) ** 2, 0.0)
    excess = np.where(both, difference, 0.0) ** 2 - np.where(both, variance, 0.0)
    scatter = (weight * excess).sum() / weight.sum()
    unsure = np.sqrt(2 / both.sum()) / np.sqrt(weight.sum() / both.sum())
    return float(np.sqrt(max(scatter, QUANTISATION_SD**2) + unsure))
