"""First stage: what was commanded against what the servos read, joint by joint.

The set-point runs linearly from row to row, or jumps to each when it is due, whichever the readings follow better
(with a lag or without); every actuation effect that the reading shows is a law from set-point to angle, played by the
same code that simulates it. Joints do not touch each other here, so one evaluation fits an effect at every joint at
once. Where no log says when a trial began, what a shift in time explains is taken out of what is left.

Legend: R log rows of all trials, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recording import Recording
from serpenoid.effects.active import ActiveEffect, joined
from serpenoid.effects.catalogue import actuation_effects, find
from serpenoid.files.store import remembered
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.servos import realise_all

TICK = 2 * np.pi / 4096
STEPS = 7
SMOOTHED_ROWS = 9
STARTS = {"servo_lag": (0.03,), "backlash": (0.02,)}
SATURATED = (0.9, 0.7, 0.5)  # of the quickest set-point: above it a saturation changes nothing
JUMP_S = 1e-6  # before a row is due: a jump takes no time
REACH = 3.0  # largest change of a positive scale in one step


@dataclass(frozen=True)
class Plays:
    """The servos' readings (R, m) [rad], trial numbers (R,), and set-points on meshes that meet every row.

    noise (m,) [rad]: of a reading. known: effects that are no news; habit (R, m) [rad]: what readings are known to
    differ by from what these make of the set-points. without: effects that are no candidates.
    """

    recordings: tuple[Recording, ...]
    readings: Floats
    trials: np.ndarray
    times: tuple[Floats, ...]
    meshes: tuple[Floats, ...]
    where: tuple[np.ndarray, ...]
    noise: Floats
    known: tuple[ActiveEffect, ...] = ()
    habit: Floats | float = 0.0
    without: frozenset[str] = frozenset()

    @property
    def held(self) -> bool:
        """Whether the rows of the tables jump."""
        return self.recordings[0].schedule.held

    @cached_property
    def setpoints(self) -> tuple[Floats, ...]:
        """On the meshes [rad]."""
        return tuple(r.schedule.commanded(t) for r, t in zip(self.recordings, self.meshes, strict=True))

    @property
    def quickest(self) -> float:
        """Largest speed of a set-point [rad/s]."""
        pairs = zip(self.setpoints, self.meshes, strict=True)
        return max(float((np.abs(np.diff(s, axis=0)).max(axis=1) / np.diff(t)).max()) for s, t in pairs)

    def left(self, played: Floats) -> Floats:
        """Readings minus what is played (R, m), each trial shifted in time as far as nothing says when it began."""
        found, speed = self.readings - played, self.speed(played)
        for number, r in enumerate(self.recordings):
            mine = self.trials == number
            top, bottom = ((x[mine] * speed[mine] / self.noise**2).sum() for x in (found, speed))
            found[mine] -= np.clip(top / max(bottom, 1e-12), -r.adrift, r.adrift) * speed[mine]
        return found

    def speed(self, played: Floats) -> Floats:
        """Rates (R, m) [rad/s] of what is played."""
        parts = zip(range(len(self.recordings)), self.times, strict=True)
        return np.concatenate([np.gradient(played[self.trials == n], time, axis=0) for n, time in parts])

    def slope(self, played: Floats, moved: Floats, step: float) -> Floats:
        """By which `left` (R, m) falls with a parameter whose `step` moves what is played."""
        return np.asarray((self.left(played) - self.left(moved)) / step)

    def realised(self, effects: Sequence[ActiveEffect]) -> Floats:
        """What the servos would read (R, m) with these effects, in place of or after the known ones."""
        body = self.recordings[0].body
        model = Model(body, Medium(anisotropy_ratio=0.2), joined(self.known, effects))
        played = realise_all(model, self.setpoints, self.meshes)
        return np.concatenate([p.readings[where] for p, where in zip(played, self.where, strict=True)]) + self.habit


def plays(recordings: Sequence[Recording]) -> Plays:
    """Readings between t0 and the end, at the log's own times, beside the set-points that they follow best."""
    recordings = list({r.setting: r for r in recordings}.values())  # one of each kind tells what there is to tell
    found = [_plays([_commanded(r, held) for r in recordings]) for held in (False, True)]
    return min(found, key=_misfit)


def _commanded(r: Recording, held: bool) -> Recording:
    return replace(r, schedule=replace(r.schedule, held=held))


def _misfit(data: Plays) -> float:
    """Chi squared with a lag or without."""
    lagging = fit_everywhere(data, "servo_lag", (), STARTS["servo_lag"][0])[0]
    plain = (data.left(data.realised([])) ** 2 / data.noise**2).sum()
    return float(min(plain, lagging.chi2.sum()))


def _plays(recordings: Sequence[Recording]) -> Plays:
    readings, labels, times, meshes, where, noises = [], [], [], [], [], []
    for number, r in enumerate(recordings):
        time = r.log_time / (1 + r.clock.rate)
        inside = (time > 0) & (time < r.schedule.cycles * r.schedule.period_s)
        own = r.position[inside]
        noises.append(_scatter(own, r.by_servos))
        rows = len(r.schedule.table)
        corners = [
            n * r.schedule.period_s + np.arange(rows + 1) / rows * r.schedule.cycle_duration_s
            for n in range(r.schedule.cycles)
        ]
        jumps = [c - JUMP_S for c in corners] if r.schedule.held else []
        mesh = np.unique(np.concatenate([[0.0], *corners, *jumps, time[inside]]))
        mesh = mesh[mesh >= 0]
        times.append(time[inside])
        meshes.append(mesh)
        where.append(np.searchsorted(mesh, time[inside]))
        readings.append(own)
        labels.append(np.full(len(own), number))
    noise = np.percentile(noises, 25, axis=0)
    if recordings[0].by_servos:
        noise = np.maximum(noise, TICK / np.sqrt(12))
    return Plays(
        tuple(recordings), np.concatenate(readings), np.concatenate(labels), tuple(times), tuple(meshes), tuple(where),
        np.broadcast_to(noise, recordings[0].body.joint_count).copy(),
    )  # fmt: skip


def _scatter(readings: Floats, pooled: bool) -> Floats:
    """RMS about local parabolas [rad], corrected for what they swallow: of each joint (m,), or pooled: the median's."""
    if len(readings) < SMOOTHED_ROWS:
        return np.asarray(TICK if pooled else np.full(readings.shape[1], TICK))
    left = readings - local_parabolas(readings, SMOOTHED_ROWS)
    squares = (left**2).mean(axis=0) / (1 - 2.25 / SMOOTHED_ROWS)
    return np.asarray(np.sqrt(np.median(squares) if pooled else squares))


def local_parabolas(values: Floats, rows: int) -> Floats:
    """Each of `values` (R, m) by the parabola through the `rows` about it (Savitzky and Golay, 1964), R >= rows.

    SciPy's, without its package for signals, whose import takes as long as all others together.
    """
    powers, middle = np.vander(np.arange(rows) - rows // 2, 3), rows // 2
    smoother = powers @ np.linalg.pinv(powers)
    inside = np.lib.stride_tricks.sliding_window_view(values, rows, axis=0) @ smoother[middle]
    return np.concatenate([smoother[:middle] @ values[:rows], inside, smoother[middle + 1 :] @ values[-rows:]])


@dataclass(frozen=True)
class Attempt:
    """An effect fitted at one joint or at all: the effect, chi squared per joint (m,) with it."""

    effect: ActiveEffect
    chi2: Floats


def channels(data: Plays, effects: Sequence[ActiveEffect]) -> Floats:
    """RMS of reading minus prediction in units of noise, per joint (m,)."""
    return np.sqrt((data.left(data.realised(effects)) ** 2).mean(axis=0)) / data.noise


def attempts(data: Plays, base: Sequence[ActiveEffect]) -> list[Attempt]:
    """Every actuation effect that readings show, at every joint, beside those in `base`."""
    found = []
    for kind in actuation_effects():
        if (
            not kind.shown
            or kind.name in data.without
            or (kind.place is None and any(e.name == kind.name for e in base))
        ):
            continue
        starts: tuple[float, ...] = STARTS.get(kind.name, (0.0,))
        if kind.name == "speed_saturation":
            starts = tuple(share * data.quickest for share in SATURATED)
        fits = [fit_everywhere(data, kind.name, base, start) for start in starts]
        found += min(fits, key=lambda tries: float(sum(t.chi2.sum() for t in tries)))
    return found


@remembered
def fit_everywhere(data: Plays, name: str, base: Sequence[ActiveEffect], start: float) -> list[Attempt]:
    """Gauss-Newton for one parameter per joint, all joints side by side (one for all where there is no place)."""
    kind = find(name)
    joints = data.readings.shape[1]
    parameter = kind.parameters[0]
    taken = {e.place for e in base if e.name == name}
    places = [None] if kind.place is None else [j for j in range(1, joints + 1) if j not in taken]
    values = np.full(len(places), parameter.coordinate(start) if start else parameter.resting)
    if name == "stuck_joint":
        values = np.array([float(np.median(data.readings[:, j - 1])) for j in places if j is not None])

    def play(x: Floats) -> Floats:
        effects = [ActiveEffect.neutral(name, place).with_coordinates([v]) for place, v in zip(places, x, strict=True)]
        return data.realised([*base, *effects])

    def chi2(y: Floats) -> Floats:
        return (data.left(y) ** 2).sum(axis=0) / data.noise**2

    columns = slice(None) if kind.place is None else [j - 1 for j in places if j is not None]
    best = play(values)
    damping = np.ones(len(values))
    for _ in range(STEPS):
        step_size = 1e-4 * max(abs(parameter.coordinate(parameter.typical)), 1e-3)
        slope = data.slope(best, play(values + step_size), step_size)
        left = data.left(best)
        top, bottom = ((left * slope).sum(axis=0), (slope**2).sum(axis=0)) / data.noise**2
        if kind.place is None:
            top, bottom = top.sum(keepdims=True), bottom.sum(keepdims=True)
        else:
            top, bottom = top[columns], bottom[columns]
        change = damping * top / np.maximum(bottom, 1e-12)
        if start:
            change = np.clip(change, -0.7 * np.abs(values), REACH * np.abs(values))
        trial = np.array([_inside(parameter, v) for v in values + change])
        new = play(trial)
        old_cost, new_cost = chi2(best), chi2(new)
        if kind.place is None:
            better = np.array([new_cost.sum() < old_cost.sum()])
        else:
            better = new_cost[columns] < old_cost[columns]
        values = np.where(better, trial, values)
        damping = np.where(better, np.minimum(1.0, 2 * damping), damping / 4)
        best = new if better.all() else play(values)
        if np.abs(change).max() < 1e-4 * abs(parameter.typical):
            break
    cost = chi2(best)
    empty = chi2(data.realised(base))
    result = []
    for i, place in enumerate(places):
        total = cost if place is None else np.where(np.arange(joints) == place - 1, cost, empty)
        result.append(Attempt(ActiveEffect.neutral(name, place).with_coordinates([values[i]]), total))
    return result


def _inside(parameter: object, coordinate: float) -> float:
    p = parameter
    value = min(max(p.value(coordinate), p.lower), p.upper)  # type: ignore[attr-defined]
    return float(p.coordinate(value)) if np.isfinite(value) else float(coordinate)  # type: ignore[attr-defined]
