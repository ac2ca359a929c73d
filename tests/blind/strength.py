"""Floor F and strength S of what is hidden in a campaign, as the issue on diagnosis words them.

F: start-aligned path RMS between the measurement and the true law, as trials have it in the mean, driven by the true
   shapes [m].
S: what the effect leaves of the true (noise-free, slip-free) path after eps and the start pose are refitted, over F.
Effects on shapes and on markers are judged on their own stage (`shape_signature`): the worst joint's or link's RMS,
over that stage's floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import minimize_scalar

from blind.cameras import Instruments, resample, seen_markers
from blind.campaign import Campaign, make
from blind.catalogue import KNOWN, MEDIUM, Effect, World, world
from blind.ground import Ground
from blind.motion import Drive, paths
from blind.records import record
from blind.schedule import Grid, Plan, grid, realise
from blind.snake import EDGES, TICK, Floats, Robot

COARSE_HERTZ = 60.0
GYRATION = 0.27 / EDGES.sum()  # of the stretched body, body lengths
READING_FLOOR = TICK * np.sqrt(1 / 12 + 0.4**2)  # rad, reading against set-point
SMOOTHED_S = 11 / 120  # markers are smoothed over this time
ON_THE_PATH = ("position_jumps", "frame_drift")  # observation effects that show in the path


def path_rms(differences: Sequence[Floats]) -> float:
    """Root mean square over trials of each trial's mean square distance [m]; frames in gaps do not count."""
    return float(np.sqrt(np.mean([np.nanmean((d**2).sum(axis=1)) for d in differences])))


def floor(c: Campaign) -> float:
    """F [m]."""
    records = [record(c.world, t) for t in c.trials]
    predicted = c.law.paths([r.drive for r in records])
    seen = [resample(r.time, r.drive.time, p) for p, r in zip(predicted, records, strict=True)]
    return path_rms([p[:, :2] - r.pose[:, :2] for p, r in zip(seen, records, strict=True)])


def registered(path: Floats, target: Floats, length: float) -> Floats:
    """Centroids (F, 2) of the poses `path` (F, 3) after the one rigid motion that brings the bodies closest.

    Whole bodies, because markers show the heading: a pose counts as two points, GYRATION lengths before and
    behind its centre.
    """

    def points(pose: Floats) -> Floats:
        arm = GYRATION * length * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
        return np.concatenate([pose[:, :2] + arm, pose[:, :2] - arm])

    p, q = points(path), points(target)
    a, b = p - p.mean(axis=0), q - q.mean(axis=0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return (path[:, :2] - p.mean(axis=0)) @ turn + q.mean(axis=0)


def clean_drives(c: Campaign, one_per_setting: bool = False) -> list[Drive]:
    """The true shapes and start poses without slips, on a coarse grid that keeps the schedule's corners."""
    trials = [t for t in c.trials if not one_per_setting or t.name.endswith("-1")]
    drives = []
    for t in trials:
        rows = len(t.setting.plan.table)
        steps = int(np.ceil(t.setting.plan.cycle_s * COARSE_HERTZ / rows) * rows)
        nodes = grid(t.setting.plan, steps)
        phi = resample(nodes.time, t.drive.time, t.drive.phi)
        drives.append(Drive(nodes.time, phi, nodes.phase, t.drive.start))
    return drives


def clean_paths(c: Campaign, drives: Sequence[Drive], trials: Sequence[int]) -> list[Floats]:
    """Noise-free poses (F, 3) as the cameras' frame shows them."""
    found = []
    for d, p, i in zip(drives, c.law.paths(drives, trials), trials, strict=True):
        film = c.trials[i].film
        moved = d.time[:, None] * np.array(c.world.cameras.drift) + resample(d.time, film.time, film.jumps)
        found.append(p + np.column_stack([moved, np.zeros(len(moved))]))
    return found


@dataclass(frozen=True)
class NullFit:
    """What the null law leaves of the clean paths after refitting eps and start poses."""

    eps: float
    rms: float


def null_fit(drives: Sequence[Drive], targets: Sequence[Floats], ground: Ground) -> NullFit:
    """Refit eps of a ground by a bounded scalar search."""

    def left(log_eps: float) -> float:
        predicted = paths(replace(ground, eps=float(np.exp(log_eps))), list(drives))
        return path_rms(
            [registered(p, t, ground.robot.length) - t[:, :2] for p, t in zip(predicted, targets, strict=True)]
        )

    best = minimize_scalar(left, bounds=(np.log(0.01), np.log(1.0)), method="bounded", options={"xatol": 1e-4})
    return NullFit(float(np.exp(best.x)), float(best.fun))


def path_strength(c: Campaign, noise_floor: float) -> float:
    """S on the stage of motion."""
    drives = clean_drives(c)
    return null_fit(drives, clean_paths(c, drives, range(len(drives))), null_ground(c)).rms / noise_floor


def null_ground(c: Campaign) -> Ground:
    """The ground as it was before anything was hidden."""
    return world(c.eps, c.base, c.world.ground.robot).ground


def effective_eps(c: Campaign) -> float:
    """eps of the plain law that comes closest to the clean paths."""
    drives = clean_drives(c)
    return null_fit(drives, clean_paths(c, drives, range(len(drives))), Ground(c.eps, c.world.ground.robot)).eps


def _coarse(c: Campaign) -> list[Grid]:
    return [grid(t.setting.plan, _whole(400, t.setting.plan)) for t in c.trials if t.name.endswith("-1")]


def _whole(steps: int, plan: Plan) -> int:
    """At least so many, a whole number a row."""
    return -(-steps // len(plan.table)) * len(plan.table)


def shape_signature(c: Campaign, w: World) -> Floats:
    """Noise-free residuals of the shape stage in units of their floors, shape (time, channels).

    Channels: reading - set-point per joint; marker joint angle - reading per joint (without a log: - set-point); link
    length - known length. A marker that is never seen has none.
    """
    robot, tools = w.ground.robot, c.protocol.instruments
    angle_floor, link_floor = marker_floors(robot, tools)
    blind = np.isin(np.arange(robot.vertices), tools.unseen)
    links_seen = ~(blind[1:] | blind[:-1])
    joints_seen = links_seen[1:] & links_seen[:-1]
    blocks = []
    for g in _coarse(c):
        phi, reading = realise(g, w.servos)
        pose = np.zeros((len(g.time), 3))
        seen = seen_markers(replace(w.cameras, drift=(0.0, 0.0)), phi, pose, g.time, np.zeros((len(g.time), 2)), robot)
        links = np.diff(seen, axis=1)
        angle = np.unwrap(np.arctan2(links[..., 1], links[..., 0]), axis=1)
        late = w.cameras.clock_rate * (g.time - g.time.mean())  # a constant offset is calibrated, not an effect
        heard = resample(g.time - late, g.time, reading) if tools.log_hertz else g.setpoint
        bent = ((np.diff(angle, axis=1) - heard) / angle_floor)[:, joints_seen]
        long = ((np.linalg.norm(links, axis=-1) - robot.edges) / link_floor)[:, links_seen]
        said = (reading - g.setpoint) / READING_FLOOR if tools.log_hertz else bent
        blocks.append(np.column_stack([said, bent, long]))
    return np.concatenate(blocks)


def marker_floors(robot: Robot, tools: Instruments) -> tuple[Floats, float]:
    """What marker noise, smoothed, leaves of joint angles (m,) [rad] and of a link's length [m]."""
    noise = tools.marker_noise / np.sqrt(max(SMOOTHED_S * tools.frames_per_second, 1.0))
    a, b = 1 / robot.edges[:-1], 1 / robot.edges[1:]
    return noise * np.sqrt(a**2 + b**2 + (a + b) ** 2), noise * np.sqrt(2)


def worst_channel(signature: Floats) -> float:
    """The largest RMS of a channel."""
    return float(np.sqrt((signature**2).mean(axis=0)).max())


def on_path_rung(effect: Effect) -> bool:
    """Is the effect judged by the path (True) or by shapes and markers (False)?"""
    return KNOWN[effect.name].site == MEDIUM or effect.name in ON_THE_PATH


def alone(c: Campaign, effect: Effect) -> Campaign:
    """The campaign with only this one of its effects, for the strength of each of two."""
    return c if len(c.effects) == 1 else make(c.seed, [effect], c.identity, protocol=c.protocol, base=c.base)


def strength(c: Campaign, effect: Effect, noise_floor: float) -> float:
    """S of one of the hidden effects, by itself."""
    if on_path_rung(effect):
        return path_strength(alone(c, effect), noise_floor)
    return worst_channel(shape_signature(c, world(c.eps, [effect], c.world.ground.robot)))
