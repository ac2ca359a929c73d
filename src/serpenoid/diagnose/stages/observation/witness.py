"""Is a log wrong at a joint? Markers are the second witness of what a servo reads.

A servo that does not do as it is told is read so and seen so: markers follow the reading, whatever its law. Where they
show that a joint does as it is told, and exclude that it does what its log says, the log is wrong there (a reading that
is written down late looks like a servo that lags); the joint is then taken to do as it was told.

Legend: F frames, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.course import Course
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Stage, excludable
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.diagnose.stages.actuation.choose_actuation import choose_actuation
from serpenoid.diagnose.stages.actuation.expected import carried, expected
from serpenoid.diagnose.stages.actuation.gone import without_gone
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.observation.marker_evidence import angle_leverage
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.wording import listed

LONGEST = 0.25  # of a cycle: a later reading looks like an earlier one


@dataclass(frozen=True)
class WrongLog:
    """The joint (1 .. m), and how late its readings are [s]; None: what is wrong with them is no delay.

    trials: in which alone they are wrong; none if they are in all.
    """

    joint: int
    late_s: float | None
    trials: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """As a sentence's beginning."""
        how = "is wrong" if self.late_s is None else f"is {self.late_s:.2g} s late"
        alone = f" in {listed([f'`{name}`' for name in self.trials])} alone" if self.trials else ""
        return f"the log of joint {self.joint} {how}{alone}: markers show that it does as it is told"


def of_servos(recordings: Sequence[Recording], baseline: Baseline) -> tuple[tuple[Recording, ...], Plays, Stage]:
    """The stage of actuation; where a log is wrong at a joint, judged again as it was told there."""
    every: tuple[WrongLog, ...] = ()
    while True:
        servos, gone = without_gone(baseline.plays(recordings))
        stage = choose_actuation(servos)
        wrong = wrong_log(recordings, servos, stage, [w.joint for w in every])
        if wrong is None:
            words = (*_said(every, servos), *stage.words)
            return tuple(recordings), servos, replace(stage, named=(*gone, *stage.named), words=words)
        every += (wrong,)
        recordings = mended(recordings, servos, stage, wrong)


def _said(wrong: Sequence[WrongLog], servos: Plays) -> tuple[str, ...]:
    """Of each joint whose log is wrong; of all together where there is no other."""
    if len(wrong) > 1 and len(wrong) == servos.readings.shape[1]:
        return ("the log is wrong at every joint, or too slow: markers show that servos do as they are told",)
    return tuple(w.words for w in wrong)


def wrong_log(
    recordings: Sequence[Recording], servos: Plays, found: Stage, mended: Sequence[int] = ()
) -> WrongLog | None:
    """The joint whose readings markers contradict most, of those that do not read as they are told; but for joints
    (1 .. m) that are mended already."""
    effects, shared = _effects(found), _effects(found, of_one=False)
    astray = unlike_told(servos, effects, shared)
    astray[[joint - 1 for joint in mended]] = False
    if not astray.any() or not all(r.by_servos for r in recordings):
        return None
    read = carried(recordings, servos, effects)
    told = expected(read, servos, shared)
    each = np.array([_misfits(r, course) for r, course in zip(read, told, strict=True)])
    by_log, by_order, count = each.sum(axis=0)
    worst = int(np.where(astray, by_log - by_order, -np.inf).argmax())
    band = most_gained(1, len(astray))
    if not excludable(by_log[worst], by_order[worst], max(count[worst], 1.0), band):
        return None
    return WrongLog(worst + 1, _late(read, told, worst), _in_some(read, each[:, 0, worst] - each[:, 1, worst]))


def _in_some(recordings: Sequence[Recording], excess: Floats) -> tuple[str, ...]:
    """Trials in which markers contradict the log by most of an excess (T,), where in others they hardly do."""
    most = excess > LAW_ERROR**2 * excess.max()
    return () if most.all() else tuple(r.name for r, is_wrong in zip(recordings, most, strict=True) if is_wrong)


def mended(recordings: Sequence[Recording], servos: Plays, found: Stage, wrong: WrongLog) -> tuple[Recording, ...]:
    """Recordings in which the joint whose log is wrong reads what it was told."""
    column = wrong.joint - 1

    def as_told(r: Recording, course: Course) -> Recording:
        position = r.position.copy()
        position[:, column] = course.at(r.read_at)[:, column]
        return replace(r, position=position)

    pairs = zip(recordings, expected(recordings, servos, _effects(found, of_one=False)), strict=True)
    return tuple(as_told(r, course) for r, course in pairs)


def unlike_told(servos: Plays, effects: Sequence[ActiveEffect], shared: Sequence[ActiveEffect]) -> NDArray[np.bool_]:
    """Which joints (m,) do not read as they are told with the effects that all `shared`, beside what was found of the
    others: a trial begins when the others say that do as is found, not where one that is late makes it seem to."""
    every, told = servos.realised(effects), servos.realised(shared)
    alone = np.eye(every.shape[1], dtype=bool)
    follows = np.array([servos.missed(every, own)[own].item() for own in alone]) < VISIBLE**2

    def missed(own: NDArray[np.bool_]) -> float:
        others = follows & ~own
        return float(servos.missed(np.where(own, told, every), others if others.any() else own)[own].item())

    return np.array([missed(own) for own in alone]) > VISIBLE**2


def _effects(found: Stage, of_one: bool = True) -> list[ActiveEffect]:
    """What a stage found, that of single joints, too."""
    every = (n.effect for n in (*found.named, *found.undetected))
    return [e for e in every if of_one or e.place is None]


def _misfits(read: Recording, told: Course) -> Floats:
    """Chi squared of the angles that markers show, each joint's zero free, as read and as told; their number (3, m)."""
    inside = (read.time > 0) & (read.time < read.end)
    shown = marker_angles(read.body, read.markers[inside])
    noise = read.marker_noise * angle_leverage(read.body)

    def misfit(angles: Floats) -> Floats:
        miss = shown - angles
        known = np.isfinite(miss)
        zero = np.where(known, miss, 0.0).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        return np.asarray(np.where(known, (miss - zero) ** 2, 0.0).sum(axis=0) / noise**2)

    number = np.isfinite(shown).sum(axis=0).astype(float)
    return np.stack([misfit(read.angles[inside]), misfit(told.at(read.time[inside])), number])


def _late(recordings: Sequence[Recording], told: Sequence[Course], joint: int) -> float | None:
    """By what delay [s] readings follow what was told, if that is nearly all that is wrong with them."""

    def missed(delay: float) -> float:
        pairs = zip(recordings, told, strict=True)
        miss = [r.position[:, joint] - course.at(r.read_at - delay)[:, joint] for r, course in pairs]
        return float((np.concatenate(miss) ** 2).sum())

    longest = LONGEST * min(r.schedule.cycle_duration_s for r in recordings)
    best = minimize_scalar(missed, bounds=(-longest, longest), method="bounded")
    return float(best.x) if best.fun < LAW_ERROR**2 * missed(0.0) else None
