"""Two clocks, laid over each other by the motion that both saw: servo time = zero + (1 + rate) camera time.

Joint angles of the markers against the servos' readings, with a constant per joint set free (marker_offset and
zero_offset do not move clocks). And when the motion began, by the log's labels: row i of cycle n is due at
(1 + rate) due, no later than its first log row and later than the last row before.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.measure.clock import find_offset
from serpenoid.measure.logs import ServoLog
from serpenoid.measure.schedule import Schedule

ITERATIONS = 5
COARSE = 4  # every so many frames in the search
OUTLYING = 5.0  # robust standard deviations


@dataclass(frozen=True)
class Clock:
    """Servo time of camera time t: zero + (1 + rate) t; standard deviations of the two."""

    zero: float
    rate: float
    zero_sd: float
    rate_sd: float

    def servo(self, camera: Floats) -> Floats:
        """Servo time of camera times."""
        return np.asarray(self.zero + (1 + self.rate) * camera)


def align(camera: Floats, angles: Floats, log: ServoLog) -> Clock:
    """The clock of a servo log against marker angles (F, m) at camera times (F,)."""
    some = slice(None, None, COARSE)
    known = np.isfinite(angles).all(axis=1)
    found = find_offset(camera[known][some], angles[known][some], log.time_s, log.position)
    if found is None or found.correlation < 0.5:
        raise InputError("the servo log and the cameras did not see the same motion.")
    middle = float(camera.mean())
    clock = Clock(-found.offset_s, 0.0, 0.0, 0.0)
    for _ in range(ITERATIONS):
        clock = _improved(clock, camera, middle, angles, log)
    return clock


def _improved(clock: Clock, camera: Floats, middle: float, angles: Floats, log: ServoLog) -> Clock:
    at = clock.servo(camera)
    inside = (at > log.time_s[0]) & (at < log.time_s[-1])
    reading = np.stack([np.interp(at, log.time_s, column) for column in log.position.T], axis=1)
    speed = np.gradient(reading, axis=0) / np.gradient(at)[:, None]
    width = 9
    speed = np.stack([np.convolve(c, np.ones(width) / width, mode="same") for c in speed.T], axis=1)
    miss = np.where(inside[:, None], angles - reading, np.nan)
    miss = miss - np.nanmedian(miss, axis=0)
    scatter = 1.4826 * np.nanmedian(np.abs(miss), axis=0)
    use = np.isfinite(miss) & (np.abs(miss) < np.maximum(OUTLYING * scatter, 0.05))
    weight = use / np.maximum(scatter, 1e-4) ** 2
    columns = np.stack([speed, speed * (camera - middle)[:, None]])
    mean = (weight * columns).sum(axis=1) / np.maximum(weight.sum(axis=0), 1e-12)
    columns = columns - mean[:, None]
    normal = np.einsum("afj,bfj,fj->ab", columns, columns, weight)
    step = np.linalg.solve(normal, np.einsum("afj,fj,fj->a", columns, np.where(use, miss, 0.0), weight))
    sd = np.sqrt(np.diag(np.linalg.inv(normal)))
    rate = clock.rate + step[1]
    zero = clock.zero + step[0] - step[1] * middle
    return Clock(float(zero), float(rate), float(sd[0]), float(sd[1]))


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
