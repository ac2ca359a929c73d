"""Two clocks, laid over each other by the motion that both saw: servo time = zero + (1 + rate) camera time.

The bends of the polygon through the markers seen, wherever on the links they are, against those of the same polygon on
the servos' chain, a constant per bend set free (marker_offset and zero_offset do not move clocks); where no marker is
missing they are the joint angles.
When the motion began, the log's labels say: row i of cycle n is due at (1 + rate) due, no later than its first log row
and later than the last row before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.chance import ERROR, SYSTEMATIC
from serpenoid.diagnose.data.recordings.laid import Laid, Plan
from serpenoid.diagnose.data.shapes.geometry import LEAST_MARKERS, shapes
from serpenoid.errors import InputError
from serpenoid.measure.clock import bridged, find_offset
from serpenoid.measure.consistency.signals import LEAST_ROWS, Signal
from serpenoid.measure.logs import ServoLog
from serpenoid.measure.schedule import Schedule
from serpenoid.measure.servo_alignment import MIN_CORRELATION, OFTEN, seen_corners, seen_share
from serpenoid.measure.shapes.links import bends
from serpenoid.wording import counted

ITERATIONS = 5
MOSTLY = 0.9  # of frames: where more tell the angles, it is not for hidden markers that they are too few
HALF = 0.5  # of all angles: frames that show less do not tell where a log lies
SEARCHED_HZ = 30.0  # frames a second in the search: a gait has no motion beyond


@dataclass(frozen=True)
class Clock:
    """Servo time of camera time t: zero + (1 + rate) t; standard deviations of the two."""

    zero: float
    rate: float
    zero_sd: float
    rate_sd: float
    apart: tuple[float, float] | None = None  # the rate, told apart from displaced markers, and its deviation

    @property
    def told_apart(self) -> Clock:
        """With the rate as it is told apart from displaced markers, where it is."""
        return self if self.apart is None else replace(self, rate=self.apart[0], rate_sd=self.apart[1])

    def servo(self, camera: Floats) -> Floats:
        """Servo time of camera times."""
        return np.asarray(self.zero + (1 + self.rate) * camera)


def pooled(clocks: Sequence[Clock]) -> tuple[float, float]:
    """The rate between two devices' clocks that is one in all trials, and its standard deviation."""
    weight = np.array([1 / c.rate_sd**2 for c in clocks])
    return float(weight @ [c.rate for c in clocks] / weight.sum()), float(1 / np.sqrt(weight.sum()))


def run_apart(clocks: Sequence[Clock], settings: Sequence[tuple[str, float]]) -> bool:
    """Whether the rate differs from trial to trial, in their order, by more than chance makes, at the stated error;
    also as it is told apart from displaced markers, which draw it aside as far as gaits bend beside them.

    What all trials of a setting share, though others were played between them, is the gait's and no clock's: servos
    that fall behind in the course of a trial do so whenever it is played."""
    alike, apart = _of_one_gait(settings), [c.told_apart for c in clocks]
    return all(_differ([[some[i] for i in same] for same in alike]) for some in (clocks, apart))


def _of_one_gait(settings: Sequence[tuple[str, float]]) -> list[list[int]]:
    """Trials of each setting that has others between its trials, and all that are left."""
    by = {s: [i for i, other in enumerate(settings) if other == s] for s in settings}
    between = [same for same in by.values() if same[-1] - same[0] >= len(same)]
    return [*between, [i for i in range(len(settings)) if all(i not in same for same in between)]]


def _differ(alike: Sequence[Sequence[Clock]]) -> bool:
    """About a rate of each group."""
    squares = [((c.rate - pooled(same)[0]) / (SYSTEMATIC * c.rate_sd)) ** 2 for same in alike for c in same]
    degrees = len(squares) - sum(bool(same) for same in alike)
    return degrees > 0 and bool(sum(squares) > chdtri(degrees, ERROR))


def _too_little(cameras: Signal) -> str:
    """What of a recording is too short to be found in a log."""
    seen = float(cameras.known.mean())
    if seen > MOSTLY:
        return "one of them is too short"
    return f"in {seen:.0%} of its frames enough markers are seen to tell the joint angles, and that is too little"


def align(body: Body, camera: Floats, markers: Floats, log: ServoLog) -> Clock:
    """The clock of a servo log against markers (F, N, 2), NaN hidden, at camera times (F,)."""
    corners = _corners(body, markers)
    angles, read = bends(markers[:, corners]), _bends_of(body, log.position, corners)
    cameras = Signal(camera, mostly_seen(camera, angles))
    _refuse_still(cameras, Signal(log.time_s, log.position))
    some = np.flatnonzero(cameras.known)[:: max(1, round(1 / SEARCHED_HZ / np.median(np.diff(camera))))]
    found = find_offset(camera[some], cameras.values[some], log.time_s, read)
    if found is None:
        raise InputError(
            f"the servo log ({np.ptp(log.time_s):.3g} s) and the recording ({np.ptp(camera):.3g} s) cannot be laid "
            f"over each other: {_too_little(cameras)}."
        )
    if found.correlation < MIN_CORRELATION:
        raise InputError(
            f"the servo log and the cameras did not see the same motion (correlation {found.correlation:.2f}). "
            "A log of another trial, joints in another order or with another sign, or markers not tail first?"
        )
    clock = Clock(-found.offset_s, 0.0, 0.0, 0.0)
    for _ in range(ITERATIONS):
        clock = _improved(clock, camera, Laid.by(camera, clock.servo(camera), angles, log.time_s, read, None))
    return clock


def mostly_seen(camera: Floats, angles: Floats) -> Floats:
    """Angles (F, m) in frames that show half of them or more, those that are hidden there bridged: of many markers one
    may be hidden in every frame in which the robot moves."""
    shown = np.isfinite(angles).mean(axis=1) >= HALF
    return np.where(shown[:, None], bridged(camera, angles), np.nan)


def beside_plan(clock: Clock, body: Body, camera: Floats, markers: Floats, log: ServoLog, plan: Plan | None) -> Clock:
    """The same by what servos do beside a plan of joint angles that their commands keep to: between the rows of a slow
    log nobody sees where motion begins and ends, and it would seem longer than it was. None: as it is, its rate told
    apart from what displaced markers make."""
    corners = _corners(body, markers)
    angles, read = bends(markers[:, corners]), _bends_of(body, log.position, corners)
    planned = (lambda time: _bends_of(body, plan(time), corners)) if plan else None

    def laid() -> Laid:
        return Laid.by(camera, clock.servo(camera), angles, log.time_s, read, planned)

    for _ in range(ITERATIONS if plan else 0):
        clock = _improved(clock, camera, laid())
    more, sd = laid().rate_apart()
    return replace(clock, apart=(clock.rate + more, sd))


def _refuse_still(cameras: Signal, servos: Signal) -> None:
    """Two clocks are laid over each other by motion: each of the two witnesses must show some."""
    seen, read = int(cameras.known.sum()), len(servos.time_s)
    if seen < LEAST_ROWS:
        raise InputError(
            f"in {seen} of {len(cameras.time_s)} frames the same markers are seen together, and {LEAST_ROWS} are "
            "needed. Was the recording cut short, or its markers never labelled?"
        )
    if read < LEAST_ROWS:
        raise InputError(
            f"the servo log has {counted(read, 'row')} of readings, and {LEAST_ROWS} are needed. Leave it out?"
        )
    for signal, who in ((cameras, "markers"), (servos, "servos' readings")):
        if not signal.moves:
            raise InputError(
                f"the {who} show no motion beyond their noise from row to row in the {np.ptp(signal.time_s):.3g} s "
                "that were recorded. Did the recording end before the robot began, did the robot not move, or are "
                "rows in disorder? Leave this trial out."
            )


def _corners(body: Body, markers: Floats) -> NDArray[np.int64]:
    often = seen_corners(body, markers)
    if len(often) < LEAST_MARKERS:
        never = ", ".join(str(k) for k in np.flatnonzero(seen_share(markers) <= OFTEN))
        raise InputError(
            f"the markers of vertices {never} are hidden most of the time, and no joint lies between those that are "
            "seen, or fewer than three are: no shape can be known. Leave this trial out?"
        )
    return np.array(often)


def _bends_of(body: Body, angles: Floats, corners: NDArray[np.int64]) -> Floats:
    """Of the polygon through some vertices of joint angles (R, m)."""
    return bends(shapes(body, angles)[:, corners])


def _improved(clock: Clock, camera: Floats, laid: Laid) -> Clock:
    step, sd = laid.step()
    zero = clock.zero + step[0] - step[1] * float(camera.mean())
    return Clock(float(zero), float(clock.rate + step[1]), float(sd[0]), float(sd[1]))


def as_played(log: ServoLog, schedule: Schedule) -> Schedule:
    """With no more cycles than the log's labels say were begun, if the log goes on when the next one was due; as it is
    where there are no labels, or the log ends."""
    if log.phase is None or log.cycle is None or not (playing := np.array(log.phase) == "play").any():
        return schedule
    if log.time_s[-1] - log.time_s[playing][-1] <= schedule.pause_s + schedule.row_s:
        return schedule
    return replace(schedule, cycles=min(schedule.cycles, int(log.cycle[playing].max()) + 1))


def start_on_log(log: ServoLog, schedule: Schedule, rate: float) -> tuple[float, float] | None:
    """Servo time of t0 and half the interval that the log's labels leave for it; None where it has no labels."""
    if log.phase is None or log.cycle is None or log.step is None:
        return None
    phase = np.array(log.phase)
    playing, resting = phase == "play", phase == "pause"
    if not playing.any():
        return None
    rows = len(schedule.table)
    begun = log.cycle * schedule.period_s + np.minimum(log.step, rows) * schedule.cycle_duration_s / rows
    ends = log.cycle * schedule.period_s + (log.step + 1) * schedule.cycle_duration_s / rows
    ends = np.where(resting, (log.cycle + 1) * schedule.period_s, ends)
    found = []
    for assumed in (rate, 0.0):
        late = (log.time_s - (1 + assumed) * begun)[playing | resting].min()
        early = (log.time_s - (1 + assumed) * ends)[playing].max()
        found.append((late - early, (late + early) / 2))
    width, middle = max(found)
    return float(middle), float(abs(width) / 2)
