"""Loads that wheels trade within a cycle: does statics predict them, and would a drag law that knew them do better?

    python benchmarks/load_transfer.py > results/benchmarks/load_transfer.md      # half a minute

The healthy arena robot plays the six gaits once, every contact force recorded. Windows are eighths of a cycle, as in a
diagnosis. Statics: links hinged by their vertical springs, on contacts of one stiffness, N >= 0 (it never binds), under
the true masses, with and without the measured friction at the floor. Drag: the turn and shift of the measured velocity
that a law needs to be in balance at every moment, added up over each window.
Legend: F frames, N wheel pairs, P = 2 N contacts, d = 3 + m: heave, roll, pitch of the tail link, and m hinges.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.arena import mujoco_module
from serpenoid.arena.floor import Mats
from serpenoid.arena.protocol import Protocol, load_protocol
from serpenoid.arena.trial import Plan, plans, schedule
from serpenoid.arena.world import World
from serpenoid.body import Floats

PROTOCOL = Path(__file__).parents[1] / "problems" / "protocols" / "six-gaits.toml"
CYCLES, PAUSE_S, PARTS, EVERY = 2, 1.5, 8, 3  # time steps a frame
GRAVITY = 9.81
CREEP = 2e-3  # m/s: over which the arena's soft contacts reach their full friction


@dataclass(frozen=True)
class Played:
    """windows (F,): of its cycles, -1 outside; places (F, P, 2) and loads (F, P) [N] of the tyres; of the body held
    level: lifts (F, P, d) of the contacts, weights (F, d) and friction (F, d) as generalised forces."""

    dt: float
    windows: Floats
    places: Floats
    loads: Floats
    lifts: Floats
    weights: Floats
    friction: Floats

    @property
    def pairs(self) -> Floats:
        """Loads (F, N) of wheel pairs, shares of their sum."""
        pairs = self.loads.reshape(len(self.loads), -1, 2).sum(axis=2)
        return pairs / pairs.sum(axis=1).mean()

    def means(self, values: Floats) -> Floats:
        """Window by window (PARTS * CYCLES, ...)."""
        return np.array([values[self.windows == n].mean(axis=0) for n in range(PARTS * CYCLES)])


class Statics:
    """Jacobians of the same shape with all hinges level."""

    def __init__(self, world: World) -> None:
        self.mujoco, self.model, self.world = mujoco_module(), world.model, world
        self.data = self.mujoco.MjData(self.model)
        joints = [self.model.joint(f"bend_{j}") for j in range(world.robot.servos)]
        self.hinges = np.array([joint.qposadr[0] for joint in joints])
        self.moved = np.array([2, 3, 4, *(joint.dofadr[0] for joint in joints)])

    def at(self, qpos: Floats, forces: Floats) -> tuple[Floats, Floats, Floats]:
        """lifts (P, d), weights (d,), friction (d,) for contact forces (P, 3) in the world."""
        w, x, y, z = qpos[3:7]
        yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        self.data.qpos[:] = qpos
        self.data.qpos[3:7] = [math.cos(yaw / 2), 0, 0, math.sin(yaw / 2)]
        self.data.qpos[self.hinges] = 0
        self.mujoco.mj_kinematics(self.model, self.data)
        self.mujoco.mj_comPos(self.model, self.data)
        down = np.array([0, 0, self.world.robot.wheel_diameter_m / 2])
        tyres, bodies = self.world._tyres, range(1, self.model.nbody)
        touch = np.array([self._slope(self.data.geom_xpos[g] - down, self.model.geom_bodyid[g]) for g in tyres])
        masses = [GRAVITY * self.model.body_mass[b] * self._slope(self.data.xipos[b], b)[2] for b in bodies]
        return touch[:, 2], -np.sum(masses, axis=0), np.einsum("pkd,pk->d", touch[:, :2], forces[:, :2])

    def _slope(self, place: Floats, body: int) -> Floats:
        slope = np.zeros((3, self.model.nv))
        self.mujoco.mj_jac(self.model, self.data, slope, None, place, body)
        return slope[:, self.moved]


def contact_forces(world: World) -> Floats:
    """On every tyre (P, 3) [N], in the world."""
    mujoco, force, found = mujoco_module(), np.zeros(6), np.zeros((2 * world.robot.wheels, 3))
    for i in range(world.data.ncon):
        contact: Any = world.data.contact[i]
        mujoco.mj_contactForce(world.model, world.data, i, force)
        push = contact.frame.reshape(3, 3).T @ force[:3]
        found[world._tyre_of[contact.geom].max()] += push if push[2] > 0 else -push
    return found


def play(protocol: Protocol, plan: Plan, table: Floats) -> Played:
    """One trial on even mats."""
    world = World(protocol.robot.assembled(), Mats.even())
    world.place(table[0], heading_rad=math.radians(plan.heading_deg))
    statics, step_s, sent, frames = Statics(world), world.robot.timestep_s, 0, []
    commands = schedule(len(table), plan.cycle_duration_s, CYCLES, PAUSE_S)
    for step in range(math.ceil(commands[-1].time_s / step_s)):
        while commands[sent + 1].time_s <= step * step_s:
            sent += 1
            world.command(table[commands[sent].row])
        world.step()
        if step % EVERY == 0:
            cycle, into = divmod(step * step_s, plan.cycle_duration_s + PAUSE_S)
            part = int(into / plan.cycle_duration_s * PARTS)
            forces = contact_forces(world)
            window = cycle * PARTS + part if part < PARTS else -1
            places = world.data.geom_xpos[world._tyres, :2].copy()
            frames.append((window, places, forces[:, 2], *statics.at(world.data.qpos.copy(), forces)))
    return Played(EVERY * step_s, *(np.array(column) for column in zip(*frames, strict=True)))


def statically(played: Played, stiffness: float, hinge: float, friction: float) -> Floats:
    """Shares (F, N) of the wheel pairs in balance, contacts and hinges being springs."""
    springs = np.diag([0.0] * 3 + [hinge] * (played.lifts.shape[2] - 3))
    matrix = springs + stiffness * np.einsum("fpd,fpe->fde", played.lifts, played.lifts)
    sunk = np.linalg.solve(matrix, (played.weights + friction * played.friction)[..., None])
    loads = -stiffness * (played.lifts @ sunk)[..., 0]
    return loads.reshape(len(loads), -1, 2).sum(axis=2) / loads.sum(axis=1, keepdims=True)


def explained(trials: list[Played], predicted: list[Floats]) -> tuple[float, float]:
    """R^2 of the windows' loads about each pair's mean, predictions as they are and scaled at best."""
    x, y = (np.concatenate([t.means(v) for t, v in zip(trials, values, strict=True)]) for values in
            (predicted, [t.pairs for t in trials]))  # fmt: skip
    x, y = x - x.mean(axis=0), y - y.mean(axis=0)
    return 1 - ((y - x) ** 2).sum() / (y**2).sum(), np.corrcoef(x.ravel(), y.ravel())[0, 1] ** 2


def astray(played: Played, loads: Floats, law: str, eps: float) -> Floats:
    """What each window's displacement [m] is off by (PARTS * CYCLES, 2), drag weighed by `loads` (F, N)."""
    tyres = played.places.reshape(len(loads), -1, 2, 2)
    middles, across = tyres.mean(axis=2), tyres[:, :, 0] - tyres[:, :, 1]
    track = np.linalg.norm(across, axis=2, keepdims=True)
    left = across / track
    ahead = np.stack([left[..., 1], -left[..., 0]], axis=2)
    arms = middles - middles.mean(axis=1, keepdims=True)
    angles = np.unwrap(np.arctan2(ahead[..., 1], ahead[..., 0]), axis=0)
    speeds = np.gradient(middles, played.dt, axis=0)
    rates = np.stack([(speeds * ahead).sum(2), (speeds * left).sum(2),
                      track[..., 0] / 2 * np.gradient(angles, played.dt, axis=0)])  # fmt: skip
    turns = [np.concatenate([n, (arms[..., 0] * n[..., 1] - arms[..., 1] * n[..., 0])[..., None]], 2)
             for n in (ahead, left)]  # fmt: skip
    by = np.stack([*turns, np.stack([0 * track[..., 0], 0 * track[..., 0], track[..., 0] / 2], 2)])
    shift = np.zeros((len(loads), 3))
    for _ in range(1 if law == "linear" else 80):
        along, aside, scrub = rates + np.einsum("rfnk,fk->rfn", by, shift)
        slip = np.sqrt(aside**2 + scrub**2 + CREEP**2)
        dry = np.stack([0.05 / np.sqrt(along**2 + CREEP**2 / 4) + 1.0, 0.6 / slip, 0.6 / slip])
        law_now = loads * (np.array([eps, 1.0, 0.0])[:, None, None] if law == "linear" else dry)
        matrix = np.einsum("rfn,rfnk,rfnl->fkl", law_now, by, by) + 1e-12 * np.eye(3)
        shift = -np.linalg.solve(matrix, np.einsum("rfn,rfnk->fk", law_now * rates, by)[..., None])[..., 0]
    return played.dt * np.array([shift[played.windows == n, :2].sum(axis=0) for n in range(PARTS * CYCLES)])


def known(kind: str, played: Played, weights: Floats, means: Floats) -> Floats:
    """Loads (F, N) that a law is told: fixed ones, or those measured."""
    if kind == "measured, every 8 ms":
        return np.maximum(played.pairs, 1e-4)
    fixed = {"equal": np.full(len(weights), 1 / len(weights)), "masses": weights}.get(kind, means)
    loads = np.tile(fixed, (len(played.loads), 1))
    other = PARTS if "other" in kind else 0
    if "window" in kind:
        by_window = played.means(played.pairs)
        for n in range(PARTS * CYCLES):
            loads[played.windows == n] = by_window[(n + other) % (PARTS * CYCLES)]
    return loads


def main() -> None:
    """Both tables."""
    protocol, tables = load_protocol(PROTOCOL)
    trials = [play(protocol, plan, tables[plan.gait]) for plan in plans(protocol) if plan.number == 0]
    masses = protocol.robot.vertex_masses_kg
    out = sys.stdout.write
    pairs = np.concatenate([t.pairs[t.windows >= 0] for t in trials])
    windows = np.array([t.means(t.pairs) for t in trials])
    spread = [100 * float(np.sqrt(np.mean(np.var(x, axis=0) / pairs.mean(0) ** 2))) for x in
              (pairs, windows.reshape(-1, windows.shape[2]))]  # fmt: skip
    about = (windows - windows.mean(axis=(0, 1))).reshape(len(trials), CYCLES, -1)
    again = np.corrcoef(about[:, 0].ravel(), about[:, 1].ravel())[0, 1]
    out("`python benchmarks/load_transfer.py`: six gaits of the healthy arena robot, two cycles each\n\n")
    out(f"A pair's load varies by {spread[0]:.0f} % of its mean (SD) from moment to moment, averaged over an eighth\n")
    out(f"of a cycle by {spread[1]:.0f} %; the windows of both cycles correlate by {again:.2f}.\n\n")
    out("| loads by statics of the shape | R^2 of windows | ... scaled at best |\n| --- | --- | --- |\n")
    for name, stiffness, hinge, friction in (
        ("rigid body on springs", 1e3, 1e6, 0.0),
        ("hinges of 20 N m/rad, contacts of 1 N/mm", 1e3, 20.0, 0.0),
        ("... contacts of 20 N/mm", 2e4, 20.0, 0.0),
        ("... 1 N/mm, friction at the floor as measured", 1e3, 20.0, 1.0),
        ("... 20 N/mm, the same", 2e4, 20.0, 1.0),
        ("... 100 N/mm, the same (the best of any stiffness)", 1e5, 20.0, 1.0),
    ):
        found = explained(trials, [statically(t, stiffness, hinge, friction) for t in trials])
        out(f"| {name} | {found[0]:.2f} | {found[1]:.2f} |\n")
    out("\n| loads that the law is told | linear drag, best eps [mm a window] | the arena's contact law |\n")
    out("| --- | --- | --- |\n")
    kinds = ("equal", "masses", "means", "window means", "window means of the other cycle", "measured, every 8 ms")
    for kind in kinds:
        loads = [known(kind, t, masses / masses.sum(), pairs.mean(0)) for t in trials]
        linear = min(_rms(trials, loads, "linear", eps) for eps in (0.08, 0.1, 0.12, 0.15))
        out(f"| {kind} | {linear:.1f} | {_rms(trials, loads, 'contact', 0.0):.1f} |\n")


def _rms(trials: list[Played], loads: list[Floats], law: str, eps: float) -> float:
    off = np.concatenate([astray(t, x, law, eps) for t, x in zip(trials, loads, strict=True)])
    return 1e3 * float(np.sqrt((off**2).sum(axis=1).mean()))


if __name__ == "__main__":
    main()
