"""Shapes and paths back from what was recorded, by one who knows the clocks and the hidden observation effects.

Shapes: servo readings on the camera's time, plus a hidden zero offset where there is one; without a log, the angles
that the markers show. Poses: rigid fit of that shape to the visible markers of a frame.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import savgol_filter

from blind.cameras import resample
from blind.campaign import Trial
from blind.catalogue import World
from blind.motion import Drive
from blind.schedule import Plan
from blind.snake import Floats, shape

SMOOTHED_S, SMOOTHED_CYCLE = 0.18, 0.08  # window of local parabolas: seconds, at most this part of a cycle
LEAST_SEEN = 3  # markers that a rigid fit asks for


@dataclass(frozen=True)
class Record:
    """time (F,) [s since t0], phi (F, m), phase (F,) [cycles], pose (F, 3) with NaN in gaps, start pose (3,)."""

    time: Floats
    phi: Floats
    phase: Floats
    pose: Floats
    start: Floats

    @property
    def drive(self) -> Drive:
        return Drive(self.time, self.phi, self.phase, self.start)


def fitted_pose(r: Floats, markers: Floats) -> Floats:
    """Pose (F, 3) that carries the shapes r (F, N, 2) to the visible markers by least squares; NaN below 3."""
    seen = np.isfinite(markers[..., 0])
    count = seen.sum(axis=1)
    share = seen / np.maximum(count, 1)[:, None]
    there = np.where(seen[..., None], markers, 0.0)
    mid_r, mid_p = np.einsum("fk,fkd->fd", share, r), np.einsum("fk,fkd->fd", share, there)
    a, b = (r - mid_r[:, None]) * seen[..., None], (there - mid_p[:, None]) * seen[..., None]
    dot = (a * b).sum(axis=(1, 2))
    cross = (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]).sum(axis=1)
    heading = np.arctan2(cross, dot)
    c, s = np.cos(heading), np.sin(heading)
    x = mid_p[:, 0] - (c * mid_r[:, 0] - s * mid_r[:, 1])
    y = mid_p[:, 1] - (s * mid_r[:, 0] + c * mid_r[:, 1])
    pose = np.column_stack([x, y, heading])
    pose[count < LEAST_SEEN] = np.nan
    return pose


def _corrected(world: World, trial: Trial, r: Floats) -> tuple[Floats, Floats]:
    """Markers with the frame's errors taken out, and shapes with the displaced markers put where they are seen."""
    cameras, film = world.cameras, trial.film
    markers = (film.markers - film.jumps[:, None, :]) / (1 + cameras.scale_error)
    markers = markers - np.maximum(film.time, 0)[:, None, None] * np.array(cameras.drift)
    seen = r.copy()
    for vertex, (along, left) in cameras.moved_marker.items():
        edge = max(vertex - 1, 0)
        e = r[:, edge + 1] - r[:, edge]
        e = e / np.linalg.norm(e, axis=-1, keepdims=True)
        seen[:, vertex] += along * e + left * np.stack([-e[:, 1], e[:, 0]], axis=-1)
    return markers, seen


def _smoothed(phi: Floats, plan: Plan, time: Floats) -> Floats:
    """Local parabolas, each stretch of playing or pause by itself: rates of raw ticks would drown a non-linear law."""
    period = plan.cycle_s + plan.pause_s
    cycle = np.floor(time / period)
    stretch = np.where(time < 0, -1, 2 * cycle + (time - cycle * period >= plan.cycle_s))
    smooth = phi.copy()
    window = 2 * int(min(SMOOTHED_S, SMOOTHED_CYCLE * plan.cycle_s) / np.median(np.diff(time)) / 2) + 1
    for label in np.unique(stretch):
        mine = stretch == label
        if mine.sum() > window > 2:
            smooth[mine] = savgol_filter(phi[mine], window, 2, axis=0)
    return smooth


def _shown_by_markers(world: World, trial: Trial) -> Floats:
    """Joint angles (F, m) of the markers, holes bridged."""
    robot, film = world.ground.robot, trial.film
    seen = film.markers.copy()
    for vertex, (along, left) in world.cameras.moved_marker.items():
        edge = max(vertex - 1, 0)
        e = seen[:, edge + 1] - seen[:, edge]
        e /= np.linalg.norm(e, axis=-1, keepdims=True)
        seen[:, vertex] -= along * e + left * np.stack([-e[:, 1], e[:, 0]], axis=-1)
    links = np.diff(seen, axis=1)
    a, b = links[:, :-1], links[:, 1:]
    angle = np.arctan2(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(axis=-1))
    for j in range(robot.joints):
        known = np.isfinite(angle[:, j])
        angle[:, j] = np.interp(film.time, film.time[known], angle[known, j])
    return angle


def record(world: World, trial: Trial) -> Record:
    """What a perfect observer makes of the files."""
    if len(trial.log.time):
        log_time = (trial.log.time - trial.clocks.servo_t0) / (1 + world.cameras.clock_rate)
        phi = CubicSpline(log_time, trial.log.position)(np.clip(trial.film.time, log_time[0], log_time[-1]))
    else:
        phi = _shown_by_markers(world, trial)
    phi = _smoothed(phi, trial.setting.plan, trial.film.time)
    for joint, offset in world.servos.offset.items() if len(trial.log.time) else ():
        phi[:, joint - 1] += offset
    r = shape(phi, np.zeros_like(phi), world.ground.robot).r
    pose = fitted_pose(*_corrected(world, trial, r)[::-1])
    phase = np.interp(trial.film.time, trial.drive.time, trial.drive.phase)
    still = trial.film.time < 0
    good = pose[still & np.isfinite(pose[:, 0])]
    good[:, 2] = np.unwrap(good[:, 2])
    first = int(np.argmax(~still))
    time = trial.film.time[first:]
    at_zero = resample(np.zeros(1), trial.film.time, phi)
    return Record(
        np.concatenate([[0.0], time]),
        np.concatenate([at_zero, phi[first:]]),
        np.concatenate([[0.0], phase[first:]]),
        np.concatenate([good.mean(axis=0)[None], pose[first:]]),
        good.mean(axis=0),
    )
