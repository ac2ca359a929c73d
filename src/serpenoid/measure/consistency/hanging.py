"""A film that hangs until its end: from some frame on no point moves in any digit, and no leap tells of lost time.

A robot at rest stands in all digits, too, where its film has no noise or is rounded coarsely. So the film hangs where

    its points jittered before by more than the file's rounding, as white noise does: of fourth differences d, in which
    little is left of motion, sum d_i d_(i+1) = -4/5 sum d_i^2; of steps, or of a walk at random, it is -3/4; or
    the servo log moves on meanwhile, and what the film shows before is far likelier by it than the whole film is by any
    shift of clocks (`measure.clock`), nor did the log's clock step or the film lose frames.

Where the servo log, else the joint table, says that joints move meanwhile, it is a contradiction; else it is said.

Legend: F frames, N points, R rows, m joints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.clock import far_likelier, find_offset
from serpenoid.measure.consistency.claim import Claim
from serpenoid.measure.consistency.clock_steps import far_steps
from serpenoid.measure.consistency.lost_frames import lost_frames
from serpenoid.measure.consistency.signals import AWAY, LEAST_ROWS, Signal
from serpenoid.measure.schedule import start_by_shape
from serpenoid.measure.servo_alignment import MIN_CORRELATION

WHITE = -0.775  # half-way from a walk at random to white noise
ORDER = 4  # of differences
PER_NOISE = 70.0  # their variance over that of white noise: the sum of squares of 1, 4, 6, 4, 1
JITTER = 1.0  # steps of rounding: with less, a point at rest may stand for as long
CURE = "did the camera hang? End the trial there: `to_s = {}`"
Shown = Callable[[Floats], Floats]  # what would be filmed of joint angles (R, m)


@dataclass(frozen=True)
class Hanging:
    """From when to when [s]; mover: who says that joints move meanwhile, "" nobody."""

    since_s: float
    end_s: float
    mover: str

    @property
    def words(self) -> str:
        """What is seen."""
        when = (
            f"from {clock(self.since_s)} s to its end at {clock(self.end_s)} s no point of its film moves in any digit"
        )
        return f"{when}, while {self.mover}" if self.mover else f"{when}, and before all jitter"

    @property
    def said(self) -> str:
        """Both, as a remark."""
        return f"{self.words}: {self.cure}"

    @property
    def cure(self) -> str:
        """What to do."""
        return CURE.format(clock(self.since_s))


def stands_from(points: Floats) -> int | None:
    """The frame from which no point (F, N, 2), NaN hidden, moves in any digit until the last in which two are seen;
    None: for fewer than LEAST_ROWS frames, or from the first."""
    shown = np.flatnonzero(np.isfinite(points[..., 0]).sum(axis=1) > 1)
    seen = points[: shown[-1] + 1] if len(shown) else points[:0]
    moves = np.flatnonzero((np.abs(np.diff(seen, axis=0)) > 0).any(axis=(1, 2)))
    first = int(moves[-1]) + 1 if len(moves) else 0
    return first if 0 < first <= len(seen) - LEAST_ROWS else None


def jitters(points: Floats) -> bool:
    """Whether points (F, N, 2), NaN hidden, have white noise beyond their file's rounding."""
    changes = np.abs(np.diff(points, axis=0))
    rough = np.diff(points, n=ORDER, axis=0)
    both = np.isfinite(rough[1:]) & np.isfinite(rough[:-1])
    stands = np.isfinite(changes).any(axis=(1, 2)) & ~(changes > 0).any(axis=(1, 2))
    if both.sum() < LEAST_ROWS or stands.any():
        return False  # it stands before, too
    after, before = rough[1:][both], rough[:-1][both]
    squares = float((after**2 + before**2).mean()) / 2
    shared = float((after * before).mean()) / max(squares, np.finfo(float).tiny)
    return shared < WHITE and np.sqrt(squares / PER_NOISE) > JITTER * float(changes[changes > 0].min())


def hanging_unmoved(points: Floats, time_s: Floats) -> Hanging | None:
    """When the film of points (F, N, 2) is sure to hang until its end, whatever moves meanwhile."""
    first = stands_from(points)
    if first is None or not jitters(points[: first + 1]):
        return None
    return Hanging(float(time_s[first]), float(time_s[-1]), "")


def hanging(claim: Claim, points: Floats) -> Hanging | None:
    """The same, and who says that joints move meanwhile; None: nobody does."""
    first, film = stands_from(points), claim.film
    if first is None or film is None:
        return None
    since_s, end_s = float(film.time_s[first]), float(film.time_s[-1])
    shown: Shown = claim.outline.of if claim.outline is not None and film is claim.outline.shown else np.asarray
    before = Signal(film.time_s[: first + 1], film.values[: first + 1])
    sure, mover = jitters(points[: first + 1]), ""
    if before.enough and claim.servos is not None and claim.servos.enough:
        mover = _log_moves(film, before, claim.servos, shown, end_s, sure)
    elif before.enough and claim.schedule is not None and sure:
        mover = _table_moves(before, claim, shown, end_s)
    return Hanging(since_s, end_s, mover) if mover else None


def _log_moves(film: Signal, before: Signal, log: Signal, shown: Shown, end_s: float, sure: bool) -> str:
    """Whether a log, laid over what was filmed before, moves meanwhile; unless it is sure that the film hangs, no shift
    of clocks may explain the whole film as well."""
    log_s, read = log.time_s[log.known], shown(log.values[log.known])
    part = find_offset(before.time_s, before.values, log_s, read)
    if part is None or part.correlation < MIN_CORRELATION:
        return ""
    inside = (log_s + part.offset_s >= before.time_s[-1]) & (log_s + part.offset_s <= end_s)
    if not _moves(read[inside], read):
        return ""
    if not sure:
        whole = find_offset(film.time_s, film.values, log_s, read)
        if whole is None or not far_likelier(part.rms**2, whole.rms**2):
            return ""
        if far_steps(log_s) or lost_frames(film, Signal(log_s, read)):
            return ""  # it rests when the clocks say that it moves
    return "the servo log goes on to move"


def _table_moves(before: Signal, claim: Claim, shown: Shown, end_s: float) -> str:
    """Whether a joint table, laid over what was filmed before, moves meanwhile."""
    if claim.schedule is None:
        return ""
    told = start_by_shape(claim.schedule, before.time_s, before.values, shown)
    if told is None or told.correlation < MIN_CORRELATION:
        return ""
    meanwhile = np.arange(before.time_s[-1], end_s, np.median(np.diff(before.time_s))) - told.offset_s
    whole = np.linspace(0.0, claim.schedule.period_s, 1 + len(claim.schedule.table))
    angles = [shown(claim.schedule.commanded(at)) for at in (meanwhile, whole)]
    return "by the joint table its joints move on" if _moves(*angles) else ""


def _moves(part: Floats, whole: Floats) -> bool:
    """Whether a part of joint angles (R, m) moves as far as counts as motion in the whole."""
    return bool(len(part) and np.ptp(part, axis=0).max() > AWAY * np.ptp(whole, axis=0).max())
