"""From shapes to motion in the plane: relative poses of all steps, then their composition.

Legend: B gaits, T steps per cycle, R rows, N vertices, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.joint_limits import odd_angles
from serpenoid.model import Model
from serpenoid.shown import Shown
from serpenoid.simulation.extended import solve_extended, solve_independent
from serpenoid.simulation.given import apart, cycles_of, first_poses, model_of, odd_lengths, shaped, times_of
from serpenoid.simulation.poses import body_frame, body_poses
from serpenoid.simulation.servos import realise, realise_gait
from serpenoid.simulation.steps import Steps, elements_of_vertices, shape_rows, solve_cycles, solve_steps
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory
from serpenoid.wording import counted, warned

__all__ = [
    "Batch",
    "body_frame",
    "body_poses",
    "simulate_batch",
    "simulate_joint_angles",
    "simulate_realised",
    "simulate_vertices",
]


def simulate_joint_angles(
    model: Model, table: Floats, cycles: int = 1, start: Floats | None = None, closed: bool = True
) -> Trajectory:
    """Simulate a joint table, shape (T, m) [rad], for whole cycles; `closed=False` plays the rows as they are, once.

    `start` is the first pose (x, y, heading), default the origin. Source: Even et al., Alg. 1. Actuation effects turn
    the table into the periodic motion on which the servos settle (not closed: beginning at rest on the first row).
    """
    joints = model_of(model).body.joint_count
    table, cycles = shaped("table", table, (-1, joints)), cycles_of(cycles, closed)
    start = first_poses(start)
    return replace(_simulate_table(model, table, cycles, start, closed), odd_units=odd_angles(table))


def _simulate_table(model: Model, table: Floats, cycles: int, start: Floats | None, closed: bool) -> Trajectory:
    if not _baseline(model) and np.isfinite(table).all():
        return _simulate_extended(model, table, cycles, start, closed)
    rows = np.concatenate([table, table[:1]]) if closed else table
    if not np.isfinite(rows).all():
        return _failed(Status.BAD_SHAPE, rows.shape[0], model)
    vertices, elements = shape_rows(model, rows)
    m = model.structure.elements
    steps = solve_steps(model, elements[:, :-m], elements[:, m:])
    return _assemble(model, vertices, steps, cycles if closed else 1, start)


def simulate_realised(model: Model, joint_angles: Floats, times: Floats, start: Floats | None = None) -> Trajectory:
    """Simulate joint angles that the body really had, shape (R, m) [rad] at `times` (R,) [s since the motion began].

    Actuation effects do not act on them; `simulation.servos.realise` makes such angles from commanded ones.
    """
    angles = shaped("joint_angles", joint_angles, (-1, model_of(model).body.joint_count))
    clock, start = times_of(times, len(angles)), first_poses(start)
    if not np.isfinite(angles).all():
        return _failed(Status.BAD_SHAPE, angles.shape[0], model)
    vertices, elements = shape_rows(model, angles)
    found = _assemble(model, vertices, _solve_rows(model, elements, clock, start), 1, start)
    return replace(found, odd_units=odd_angles(angles))


def simulate_vertices(
    model: Model, vertices: Floats, start: Floats | None = None, times: Floats | None = None
) -> Trajectory:
    """Simulate shapes given as vertices, shape (R, N, 2) [body lengths], in any frame.

    `times` (R,) [s since the start of the motion], for effects that know speed. These shapes are realised ones:
    actuation effects do not act on them. `start` (3,), or the first poses (K + 1, 3) of a body that is moving.
    """
    given = apart("vertices", shaped("vertices", vertices, (-1, model_of(model).body.vertices, 2)))
    shapes = body_frame(model, given)
    times, start = times_of(times, len(shapes)), first_poses(start)
    if not np.isfinite(shapes).all():
        return _failed(Status.BAD_SHAPE, shapes.shape[0], model)
    elements = elements_of_vertices(model, shapes)
    found = _assemble(model, shapes, _solve_rows(model, elements, times, start), 1, start)
    return replace(found, odd_units=odd_lengths(given))


@dataclass(frozen=True, repr=False, eq=False)
class Batch(Shown):
    """Many gaits simulated for one cycle: poses (B, T + 1, 3), dissipation (B,), residual (B,), sound (B,).

    odd_units: what of the tables looks to be told in another unit, as sentences.
    """

    poses: Floats
    dissipation: Floats
    residual: Floats
    sound: np.ndarray
    odd_units: tuple[str, ...] = ()

    def summary(self) -> str:
        """How many could be simulated, how far they went; what looks to be told in another unit."""
        far = self.displacement[self.sound]
        went = f", {far.min():.6f} to {far.max():.6f} body lengths" if len(far) else ""
        return warned(f"{len(far)} of {counted(len(self.sound), 'gait')} simulated{went}", self.odd_units)

    @property
    def displacement(self) -> Floats:
        """Distance of the centroid over the cycle, shape (B,) [body lengths]."""
        return np.hypot(self.poses[:, -1, 0], self.poses[:, -1, 1])


def simulate_batch(model: Model, tables: Floats, closed: bool = True) -> Batch:
    """Simulate B joint tables, shape (B, R, m) [rad], for one cycle each; closed ones in one compiled call."""
    tables = shaped("tables", tables, (-1, -1, model_of(model).body.joint_count))
    return replace(_simulate_tables(model, tables, closed), odd_units=_odd_tables(tables))


def _odd_tables(tables: Floats) -> tuple[str, ...]:
    """Of the one whose angles are largest, and its place."""
    known = np.where(np.isfinite(tables), tables, 0.0)
    most = int(np.abs(known).max(axis=(1, 2)).argmax())
    return tuple(f"tables[{most}]: {said}" for said in odd_angles(known[most]))


def _simulate_tables(model: Model, tables: Floats, closed: bool) -> Batch:
    b, t, _ = tables.shape
    if not closed:
        return _one_by_one(model, tables, closed)
    if not _baseline(model):
        return _extended_batch(model, tables)
    steps = solve_cycles(model, tables)
    relative = steps.relative.reshape(b, t, 3)
    dissipation = t * steps.energy.reshape(b, t).sum(1)
    residual = steps.residual.reshape(b, t).max(1)
    sound = np.asarray(steps.sound.reshape(b, t).all(1))
    poses = group.accumulate(relative)
    for i in np.flatnonzero(~sound):
        single = simulate_joint_angles(model, tables[i])
        poses[i], dissipation[i], residual[i] = single.poses, single.dissipation, single.residual
        sound[i] = single.status.ok
    return Batch(poses, dissipation, residual, sound)


def _baseline(model: Model) -> bool:
    return model.is_plain and not model.effects


def _one_by_one(model: Model, tables: Floats, closed: bool) -> Batch:
    motions = [simulate_joint_angles(model, table, closed=closed) for table in tables]
    poses = np.array([motion.poses for motion in motions])
    dissipation = np.array([motion.dissipation for motion in motions])
    residual = np.array([motion.residual for motion in motions])
    return Batch(poses, dissipation, residual, np.array([motion.status.ok for motion in motions]))


def _extended_batch(model: Model, tables: Floats) -> Batch:
    """All steps of all gaits at once where they are independent, else gait by gait."""
    b, t, m = tables.shape
    if model.knows("place") or model.knows("history") or not np.isfinite(tables).all():
        return _one_by_one(model, tables, closed=True)
    realised = np.array([realise_gait(model, table) for table in tables])
    closed = np.concatenate([realised, realised[:, :1]], axis=1)
    _, elements = shape_rows(model, closed.reshape(-1, m))
    rows = elements.reshape(4, b, t + 1, -1)
    before, after = rows[:, :, :-1].reshape(4, -1), rows[:, :, 1:].reshape(4, -1)
    times = np.tile(_clock(model.step_duration(t), t + 1), (b, 1))
    steps = solve_independent(model, before, after, times)
    energy, residual = steps.energy.reshape(b, t).sum(1), steps.residual.reshape(b, t).max(1)
    poses = group.accumulate(steps.relative.reshape(b, t, 3))
    return Batch(poses, t ** (model.law.degree - 1) * energy, residual, np.asarray(steps.sound.reshape(b, t).all(1)))


def _simulate_extended(model: Model, table: Floats, cycles: int, start: Floats | None, closed: bool) -> Trajectory:
    """Whole cycles at once where later ones differ from the first (place, time, history), else one and its repeats."""
    duration = model.step_duration(len(table) if closed else len(table) - 1)
    angles = realise_gait(model, table) if closed else realise(model, table, _clock(duration, len(table))).angles
    alike = not any(model.knows(what) for what in ("place", "clock", "history"))
    played = cycles if closed and not alike else 1
    rows = np.concatenate([np.tile(angles, (played, 1)), angles[:1]]) if closed else angles
    vertices, elements = shape_rows(model, rows)
    steps = _solve_rows(model, elements, _clock(duration, len(rows)), start)
    trajectory = _assemble(model, vertices, steps, cycles if closed and alike else 1, start)
    return replace(trajectory, steps_per_cycle=len(table)) if closed else trajectory


def _solve_rows(model: Model, elements: Floats, times: Floats | None, start: Floats | None) -> Steps:
    """Steps of consecutive rows, elements (4, M R): the baseline's, or with effects."""
    m = model.structure.elements
    if not model.is_plain:
        rows = elements.shape[1] // m
        clock = _clock(model.step_duration(rows - 1), rows) if times is None else times
        return solve_extended(model, elements, clock, start)
    return solve_steps(model, elements[:, :-m], elements[:, m:])


def _clock(duration: float, rows: int) -> Floats:
    return duration * np.arange(rows, dtype=float)


def _assemble(model: Model, shapes: Floats, steps: Steps, cycles: int, start: Floats | None) -> Trajectory:
    per_cycle = steps.relative.shape[0]
    first = None if start is None else np.atleast_2d(start)[0]
    poses = group.accumulate(np.tile(steps.relative, (cycles, 1)), first)
    rows = np.concatenate([np.tile(shapes[:-1], (cycles, 1, 1)), shapes[-1:]])
    status = Status.SOLVED if steps.sound.all() else Status.STEP_UNSOLVED
    residual = float(np.max(steps.residual, initial=0.0))
    energy = np.tile(steps.energy, cycles)
    return Trajectory(status, poses, group.place(poses, rows), energy, residual, per_cycle, model.law.degree)


def _failed(status: Status, rows: int, model: Model) -> Trajectory:
    n = model.body.vertices
    unknown = np.full((rows, 3), np.nan)
    return Trajectory(status, unknown, np.full((rows, n, 2), np.nan), np.full(rows - 1, np.nan), np.inf, rows - 1)
