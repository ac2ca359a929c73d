"""A log whose own clock steps: between two of its rows passes far more time than between any others, and what it tells
goes on as if none had.

    evidence of a step = that of the log with the step taken off its later times, less that of the log as it is:
                         of the schedule laid over the log, and of the log laid over the film

Rows that were lost look alike in the log's times, but what it tells has gone on meanwhile; a player that stood still
looks alike in the log, but not in the film.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.consistency.claim import Claim, logged, same_joints
from serpenoid.measure.consistency.hypotheses import KINDS
from serpenoid.measure.consistency.match import PHYSICAL, Course, Match, Prior, course_of, match
from serpenoid.measure.consistency.rivals import Rival, leads, window
from serpenoid.measure.consistency.signals import Signal

FAR = 4.0  # usual intervals: what a busy computer makes now and then
UNTOLD = "; or did the robot stand still for so long? No film tells"
MOST = 4  # of the longest intervals that are looked at


@dataclass(frozen=True)
class Step:
    """The first time after it [s], by how much it is too late, and how far apart rows are else."""

    at_s: float
    seconds: float
    usual_s: float

    @property
    def words(self) -> str:
        """What is seen, without its witness."""
        return (
            f"times step by {self.seconds:.3g} s at {clock(round(self.at_s, 3))} s (its rows are {self.usual_s:.2g} s "
            "apart), and the motion goes on there as if no time had passed"
        )

    @property
    def cure(self) -> str:
        """What makes the log right."""
        at = clock(round(self.at_s, 3))
        return f"did the log's clock jump? Take {self.seconds:.3g} s off its times from {at} s on"


def far_steps(time_s: Floats) -> list[Step]:
    """The longest intervals between rows (R,), where they are far above the usual one."""
    apart = np.diff(time_s)
    usual = float(np.median(apart))
    longest = np.argsort(-apart)[:MOST]
    return [Step(float(time_s[k + 1]), float(apart[k]) - usual, usual) for k in longest if apart[k] > FAR * usual]


def without_step(claim: Claim) -> tuple[Claim, Rival] | None:
    """The trial with the likeliest step taken off its log's clock, and the step as a rival, if it is certain."""
    found = [] if claim.servos is None or not claim.servos.enough else far_steps(claim.servos.time_s)
    if not found:
        return None
    as_it_is = _laid(claim, claim)
    own = sum(one.evidence for one in as_it_is)
    pair = ("table" if claim.schedule is not None else "markers", "log")
    untold = "" if len(as_it_is) > (claim.schedule is not None) else UNTOLD
    share, tried = -float(np.log(KINDS * len(found))), list[tuple[Claim, Rival]]()
    for step in found:
        changed = replace(claim, servos=_set_back(claim.servos, step), commands=_set_back(claim.commands, step))
        laid = _laid(changed, claim)
        lead, explained = sum(one.evidence for one in laid) - own, min((one.explained for one in laid), default=0.0)
        rival = Rival(claim.trial, "the servo log", "clock", f"the servo log's {step.words}", step.cure + untold,
                      lead, share, False, explained, pair, {})  # fmt: skip
        tried.append((changed, rival))
    best = max(tried, key=lambda one: one[1].lead)
    return best if leads(best[1], best[1].lead) else None


def _laid(claim: Claim, promised: Claim) -> list[Match]:
    """The schedule over the log, and the log over the film; promised: the trial whose log says how long it is."""
    found = []
    signal, _, prior = next(one for one in claim.witnesses if one[0] is not None)
    if claim.schedule is not None and promised.servos is not None and signal is not None and signal.enough:
        shown = claim.schedule.seen_in(float(np.ptp(promised.servos.time_s)))
        found.append(_over(signal, course_of(shown), prior))
    if claim.cameras is not None and claim.servos is not None and same_joints(claim.cameras, claim.servos):
        period = None if claim.schedule is None else claim.schedule.period_s
        found.append(_over(claim.cameras, logged(claim.servos, period), PHYSICAL))
    return found


def _over(signal: Signal, course: Course, prior: Prior) -> Match:
    return match(window(signal, course.period_s, course.period_s), course, prior)


def _set_back(signal: Signal | None, step: Step) -> Signal | None:
    """The signal with a step taken off its later times."""
    if signal is None:
        return None
    return Signal(signal.time_s - np.where(signal.time_s >= step.at_s, step.seconds, 0.0), signal.values)
