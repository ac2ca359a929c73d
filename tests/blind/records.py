"""Poses back from what was recorded, by one who knows the true shapes, the clocks and the hidden observation effects.

Shapes are no chance: a schedule and what its servos do determine them. With readings of a slow log, joined by a spline,
or angles of noisy markers the floor would hold what a better reader of the same files does not leave.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blind.cameras import displaced, resample, stretched
from blind.campaign import Trial
from blind.catalogue import World
from blind.motion import Drive
from blind.snake import Floats, shape

LEAST_SEEN = 3  # markers that a rigid fit asks for


@dataclass(frozen=True)
class Record:
    """time (F,) [s since t0], pose (F, 3) with NaN in gaps; drive: the true shapes, without slips, from the pose that
    was measured at the start."""

    time: Floats
    pose: Floats
    drive: Drive


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
    markers = stretched(cameras, (film.markers - film.jumps[:, None, :]) / (1 + cameras.scale_error), back=-1)
    markers = markers - np.maximum(film.time, 0)[:, None, None] * np.array(cameras.drift)
    return markers, displaced(cameras, r)


def record(world: World, trial: Trial) -> Record:
    """What a perfect observer makes of the files."""
    phi = resample(trial.film.time, trial.drive.time, trial.drive.phi)
    r = shape(phi, np.zeros_like(phi), world.ground.robot).r
    pose = fitted_pose(*_corrected(world, trial, r)[::-1])
    still = trial.film.time < 0
    good = pose[still & np.isfinite(pose[:, 0])]
    good[:, 2] = np.unwrap(good[:, 2])
    start, first = good.mean(axis=0), int(np.argmax(~still))
    time = np.concatenate([[0.0], trial.film.time[first:]])
    poses = np.concatenate([start[None], pose[first:]])
    return Record(time, poses, replace(trial.drive, start=start, slip=None))
