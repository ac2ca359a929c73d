"""Forward simulation in space, SE(3): six equations a step.

A straight chain leaves its roll undetermined. A proximal term (a weak spring to the last estimate, in the rotation)
keeps the Jacobian regular; repeating the solve from its own answer takes the spring out again.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics import functions
from serpenoid.model import Model, Structure
from serpenoid.status import Status

SPRING = 1e-5
REPEATS = 4
TOLERANCE = 1e-12


@dataclass(frozen=True)
class SpatialTrajectory:
    """rotations (R, 3, 3) and translations (R, 3) of each row's shape, vertices (R, N, 3), energies (R - 1,)."""

    status: Status
    rotations: Floats
    translations: Floats
    vertices: Floats
    step_energy: Floats
    residual: float


def simulate_in_space(model: Model, vertices: Floats) -> SpatialTrajectory:
    """Place shapes (R, N, 3) [body lengths] one after the other; the first stays where it is."""
    shapes = np.asarray(vertices, float)
    finder, energy, momentum, to_elements = _functions(model.structure)
    rows = shapes.shape[0]
    rotations, translations = np.tile(np.eye(3), (rows, 1, 1)), np.zeros((rows, 3))
    energies, worst = np.zeros(rows - 1), 0.0
    for t in range(rows - 1):
        before, after = to_elements(shapes[t].T), to_elements(shapes[t + 1].T)
        guess = _first_guess(shapes[t], shapes[t + 1])
        for _ in range(REPEATS):
            guess = finder(guess, before, after, guess[3:], model.parameters)
        worst = max(worst, float(ca.norm_inf(momentum(before, after, guess, model.parameters))))
        energies[t] = float(energy(before, after, guess, model.parameters))
        rotation = _cayley(guess.full()[3:, 0])
        translations[t + 1] = translations[t] + rotations[t] @ guess.full()[:3, 0]
        rotations[t + 1] = rotations[t] @ rotation
    status = Status.SOLVED if worst <= TOLERANCE else Status.STEP_UNSOLVED
    placed = np.einsum("rij,rnj->rni", rotations, shapes) + translations[:, None]
    return SpatialTrajectory(status, rotations, translations, placed, energies, worst)


@lru_cache(maxsize=16)
def _functions(structure: Structure) -> tuple[ca.Function, ca.Function, ca.Function, ca.Function]:
    size = (6, structure.elements)
    pose, before, after = ca.SX.sym("pose", 6), ca.SX.sym("before", *size), ca.SX.sym("after", *size)
    rest, parameters = ca.SX.sym("rest", 3), ca.SX.sym("parameters", 2 * structure.vertices)
    momentum = functions.step_momentum(structure, 3)
    spring = ca.vertcat(SPRING * (pose[3:] - rest), ca.SX.zeros(3))
    inputs = ca.vertcat(ca.vec(before), ca.vec(after), rest, parameters)
    equation = {"x": pose, "p": inputs, "g": momentum(before, after, pose, parameters) + spring}
    options = {"abstol": 1e-15, "max_iter": 30, "error_on_fail": False}
    newton = ca.rootfinder("place", "newton", equation, options)
    b, a, r, p = ca.MX.sym("b", *size), ca.MX.sym("a", *size), ca.MX.sym("r", 3), ca.MX.sym("p", parameters.numel())
    x = ca.MX.sym("x", 6)
    finder = ca.Function("step_in_space", [x, b, a, r, p], [newton(x, ca.vertcat(ca.vec(b), ca.vec(a), r, p))])
    return finder, functions.step_energy(structure, 3), momentum, functions.shape_elements(structure, 3)


def _first_guess(before: Floats, after: Floats) -> ca.DM:
    """Rigid alignment of the two chains (Kabsch), as (translation, Cayley vector)."""
    b, a = before - before.mean(0), after - after.mean(0)
    u, _, vt = np.linalg.svd(b.T @ a)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0])
    rotation = u @ flip @ vt
    skew = 2 * np.linalg.solve((np.eye(3) + rotation).T, (rotation - np.eye(3)).T).T
    vector = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    return ca.DM([*(before.mean(0) - rotation @ after.mean(0)), *vector])


def _cayley(vector: Floats) -> Floats:
    n = vector / 2
    cross = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + 2 / (1 + n @ n) * (cross + cross @ cross)
