"""Gaits of a lifted body: the roots of all steps side by side by Newton's method from rest, then frame after frame.

A step's equation is that of `mechanics.spatial`, as in the NLP. Legend: B gaits, T steps, R rows, N vertices, M
elements.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.gaits.lifted import LiftedFamily
from serpenoid.mechanics import functions, spatial
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.mechanics.wide import Columns, over_columns
from serpenoid.model import Model, Structure
from serpenoid.simulation.newton import Equations, State, newton
from serpenoid.simulation.rollout import Batch
from serpenoid.status import Status
from serpenoid.trajectory import LiftedTrajectory

POSE = spatial.POSE
TURNS = 16  # of a step whose root is not near rest


@dataclass(frozen=True)
class _Played:
    """Of steps (B, T): relative poses (B, T, 6), energies, residuals, soundness; of rows points (B, R, N, 3) and shares
    (B, R, N)."""

    relative: Floats
    energies: Floats
    residuals: Floats
    sound: np.ndarray
    points: Floats
    shares: Floats


def simulate_lifted(model: Model, family: LiftedFamily, q: Floats, cycles: int = 1) -> LiftedTrajectory:
    """The motion of gait q (n,) from the origin, over some cycles; a transient is played once."""
    played = _play(model, family, q[None])
    times, steps, weights = cycles if family.closed else 1, len(played.energies[0]), model.body.vertex_weights
    points, shares = (np.concatenate([np.tile(x[0, :-1], (times, *[1] * (x.ndim - 2))), x[0, -1:]])
                      for x in (played.points, played.shares))  # fmt: skip
    rotations, places = _frames(np.tile(played.relative[0], (times, 1))[None])
    vertices = np.einsum("rij,rnj->rni", rotations[0], points) + places[0][:, None]
    return LiftedTrajectory(
        Status.SOLVED if played.sound.all() else Status.STEP_UNSOLVED, group.spatial_poses(rotations, places)[0],
        vertices, np.tile(played.energies[0], times), float(played.residuals.max()), steps,
        contact=shares / weights, weights=weights,
    )  # fmt: skip


def simulate_lifted_gaits(model: Model, family: LiftedFamily, gaits: Floats) -> Batch:
    """The motions of gaits (B, n), over a cycle."""
    played = _play(model, family, gaits)
    dissipation, poses = (
        played.energies.shape[1] * played.energies.sum(1),
        group.spatial_poses(*_frames(played.relative)),
    )
    return Batch(poses, dissipation, played.residuals.max(1), np.asarray(played.sound.all(1)))


def _play(model: Model, family: LiftedFamily, gaits: Floats) -> _Played:
    points, shares, elements = _rows(model, family, gaits)
    count, steps = len(gaits), points.shape[1] - 1
    before, after = (e.reshape(count * steps, -1, 7) for e in (elements[:, :-1], elements[:, 1:]))
    weights, eps = (
        np.asarray(x.full()).ravel() for x in functions.element_parameters(model.structure)(model.parameters)
    )

    def equations(poses: Floats, which: np.ndarray) -> State:
        return _step(poses, before[which], after[which], weights, float(eps[0]))

    relative, state = newton(equations, np.zeros((count * steps, POSE)))
    sound = _sound(state)
    for step in np.flatnonzero(~sound):
        found = _anywhere(equations, int(step))
        if found is not None:
            relative[step], sound[step] = found[0], True
            state.put(np.array([step]), found[1], np.array([0]))
    by_gait = (count, steps)
    relative = np.where(sound[:, None], relative, np.nan).reshape(*by_gait, POSE)
    energies = np.where(sound, state.more[0], np.nan)
    energies, residuals, good = (x.reshape(by_gait) for x in (energies, state.size, sound))
    return _Played(relative, energies, residuals, good, points, shares)


def _sound(state: State) -> np.ndarray:
    """Which steps are roots, and minima."""
    finite = np.isfinite(state.slopes[0]).all((1, 2))
    stiffness = np.linalg.eigvalsh(np.where(finite[:, None, None], state.slopes[0], 0.0))[:, 0]
    return np.asarray(state.found & (stiffness > 0))


def _anywhere(equations: Equations, step: int) -> tuple[Floats, State] | None:
    """Of one step that is no small one: of the minima that Newton's method finds from turns all around the least."""
    guesses = np.zeros((TURNS, POSE))
    guesses[:, 2] = 2 * np.pi * np.arange(TURNS) / TURNS
    poses, state = newton(lambda poses, _: equations(poses, np.full(len(poses), step)), guesses)
    good = np.flatnonzero(_sound(state))
    if good.size == 0:
        return None
    least = good[state.more[0][good].argmin()]
    return poses[least], State(state.residual[[least]], state.slopes[:, [least]], (state.more[0][[least]],))


def _rows(model: Model, family: LiftedFamily, gaits: Floats) -> tuple[Floats, Floats, Floats]:
    """Points (B, R, N, 3), shares (B, R, N), elements (B, R, M, 7) of all rows; closed: the first is the last, too."""
    data = np.concatenate([family.data, family.data[:1]]) if family.closed else family.data
    count, rows = len(gaits), len(data)
    function = _row(model.structure, family, count * rows)
    each = np.repeat(gaits, rows, 0), np.tile(data, (count, 1)), model.parameters
    points, shares, elements = evaluate(function, *each)
    n = model.structure.vertices
    return (
        points.T.reshape(count, rows, n, 3),
        shares.T.reshape(count, rows, n),
        elements.T.reshape(count, rows, -1, 7),
    )


@lru_cache(maxsize=32)
def _row(structure: Structure, family: LiftedFamily, count: int) -> ca.Function:
    """(gaits, rows' data, parameters) -> points, shares, elements of `count` rows, each in one column."""
    p, data = ca.SX.sym("p", family.size), ca.SX.sym("data", family.data.shape[1])
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    found = functions.lifted_row(structure, family.lift)(family.at(p, data), parameters)
    made = ca.Function("lifted_rows", [p, data, parameters], [ca.vec(x) for x in found], functions.CSE)
    return made.map("all_lifted_rows", "serial", count, [2], [])


def _step(poses: Floats, before: Floats, after: Floats, weights: Floats, eps: float) -> State:
    """Residuals, slopes and energies of steps with relative poses (n, 6) and elements (n, M, 7)."""
    n, m = before.shape[:2]
    size = max(8, 1 << (n * m - 1).bit_length())  # of a few lengths only, each with its map
    columns = [np.repeat(poses, m, 0), before.reshape(-1, 7), after.reshape(-1, 7), np.tile(weights, n)[:, None]]
    filled = [np.concatenate([c, np.broadcast_to(c[-1], (size - n * m, c.shape[1]))]) for c in columns]
    slope, energy, curvature = evaluate(_over(size), *filled, np.full(1, eps))

    by_step = slope.T[: n * m].reshape(n, m, POSE).sum(1)
    bends = np.ascontiguousarray(curvature.T).reshape(-1, POSE, POSE)[: n * m].reshape(n, m, POSE, POSE).sum(1)
    return State(by_step, bends[None], (energy[0, : n * m].reshape(n, m).sum(1),))


@lru_cache(maxsize=24)
def _over(count: int) -> ca.Function:
    """Over a number of elements that registers divide; what is the same for all comes last."""
    element = _element()
    function = element.block or element.function
    return function.map("spatial_steps", "serial", count // element.width, [element.shared], [])


@lru_cache(maxsize=1)
def _element() -> Columns:
    return over_columns(spatial.element_functions(1)[:1])[0]


def _frames(relative: Floats) -> tuple[Floats, Floats]:
    """Rotations (B, R, 3, 3) and places (B, R, 3) reached by relative poses (B, T, 6), from the origin."""
    count, steps = relative.shape[:2]
    rotations, places = np.zeros((count, steps + 1, 3, 3)), np.zeros((count, steps + 1, 3))
    rotations[:, 0] = np.eye(3)
    turns, moves = group.spatial_rotation(relative), relative[..., [0, 1, 3]]
    for t in range(steps):
        places[:, t + 1] = places[:, t] + np.einsum("bij,bj->bi", rotations[:, t], moves[:, t])
        rotations[:, t + 1] = rotations[:, t] @ turns[:, t]
    return rotations, places
