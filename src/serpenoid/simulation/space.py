"""Forward simulation in space, SE(3): six equations a step.

The root sought is the minimum of the step energy nearest to the rigid alignment of the two chains. Newton's method from
that alignment finds it where the chain is bent; a nearly straight chain leaves its roll all but undetermined, and there
(or where the root is no minimum) the energy is descended first, by Newton steps whose curvature is made positive. The
chain is moved to every new estimate, so that the rotation sought is small, whatever frames the shapes came in.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.mechanics import functions
from serpenoid.model import Model, Structure
from serpenoid.status import Status

SPRING = 1e-9  # keeps Newton's matrix regular: as stiff as the roll of a chain that is straight to 1e-5 body lengths
TOLERANCE = 1e-12
DESCENT_STEPS = 200
POLISHING_STEPS = 5
LONGEST_TURN = 0.5  # rad, in one step of the descent


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
    if model.medium_effects:
        raise InputError(f"[[effects]] `{model.medium_effects[0].name}` acts on a floor; simulate in the plane.")
    shapes = np.asarray(vertices, float)
    rows = shapes.shape[0]
    rotations, translations = np.tile(np.eye(3), (rows, 1, 1)), np.zeros((rows, 3))
    energies, residuals = np.zeros(rows - 1), np.zeros(rows - 1)
    if not np.isfinite(shapes).all() or (np.linalg.norm(np.diff(shapes, axis=1), axis=2) <= 0).any():
        lost = [np.full_like(x, np.nan) for x in (rotations, translations, shapes, energies)]
        return SpatialTrajectory(Status.BAD_SHAPE, lost[0], lost[1], lost[2], lost[3], np.inf)
    for t in range(rows - 1):
        origin = shapes[t].mean(0)
        step = _Step(model, shapes[t] - origin, shapes[t + 1])
        energies[t], residuals[t] = step.solve()
        translations[t + 1] = translations[t] + rotations[t] @ (step.shift + origin)
        rotations[t + 1] = rotations[t] @ step.rotation
    status = Status.SOLVED if (residuals <= TOLERANCE).all() else Status.STEP_UNSOLVED
    placed = np.einsum("rij,rnj->rni", rotations, shapes) + translations[:, None]
    return SpatialTrajectory(status, rotations, translations, placed, energies, float(residuals.max(initial=0.0)))


class _Step:
    """Chain `after` on its way to its place against `before`: x -> rotation x + shift."""

    def __init__(self, model: Model, before: Floats, after: Floats) -> None:
        self.newton, self.energy, self.to_elements = _functions(model.structure)
        self.after, self.parameters = after, model.parameters
        self.before = self.to_elements(before.T)
        self.rotation, self.shift = _alignment(before, after)

    def solve(self) -> tuple[float, float]:
        """Move to the minimum; returns energy and residual."""
        start = self.rotation, self.shift
        if not np.isfinite(self._expansion()[1]).all():  # a chain folded back on itself has no tangent at the fold
            return np.nan, np.inf
        for _ in range(2):  # the second time takes the spring out
            self._move(self.newton(0, self.before, self._elements(), self.parameters).full()[:, 0])
        value, slope, curvature = self._expansion()
        sound = np.abs(slope).max() <= TOLERANCE and np.linalg.eigvalsh(curvature)[0] > -TOLERANCE
        if not sound:
            self.rotation, self.shift = start
            value, slope = self._descend()
        return value, float(np.abs(slope).max())

    def _descend(self) -> tuple[float, Floats]:
        value, slope, curvature = self._expansion()
        for _ in range(DESCENT_STEPS):
            if np.abs(slope).max() <= TOLERANCE / 100:
                break
            stiffness, axes = np.linalg.eigh(curvature)
            pose = -axes @ ((axes.T @ slope) / np.maximum(np.abs(stiffness), 1e-12))
            pose *= min(1.0, LONGEST_TURN / max(float(np.linalg.norm(pose[3:])), 1e-300))
            here = self.rotation, self.shift
            for _ in range(30):
                self._move(pose)
                there = self._expansion()
                if there[0] <= value:
                    break
                (self.rotation, self.shift), pose = here, pose / 2
            else:
                break  # no lower in floating point
            value, slope, curvature = there
        return self._polished(value, slope, curvature)

    def _polished(self, value: float, slope: Floats, curvature: Floats) -> tuple[float, Floats]:
        """Near the minimum the energy's last digits say nothing: Newton steps as long as they flatten the slope."""
        for _ in range(POLISHING_STEPS):
            here = self.rotation, self.shift
            self._move(np.asarray(-np.linalg.lstsq(curvature, slope, rcond=1e-14)[0], dtype=float))
            there = self._expansion()
            if np.abs(there[1]).max() >= np.abs(slope).max() or np.linalg.eigvalsh(there[2])[0] < -TOLERANCE:
                self.rotation, self.shift = here
                break
            value, slope, curvature = there
        return value, slope

    def _move(self, pose: Floats) -> None:
        turn = _cayley(pose[3:])
        self.rotation, self.shift = turn @ self.rotation, turn @ self.shift + pose[:3]

    def _elements(self) -> ca.DM:
        return self.to_elements((self.after @ self.rotation.T + self.shift).T)

    def _expansion(self) -> tuple[float, Floats, Floats]:
        value, slope, curvature = self.energy(self.before, self._elements(), self.parameters)
        return float(value), slope.full()[:, 0], curvature.full()


@lru_cache(maxsize=16)
def _functions(structure: Structure) -> tuple[ca.Function, ca.Function, ca.Function]:
    """Root finder (guess, before, after, parameters) -> pose; energy with slope and curvature; vertices to elements."""
    size = (6, structure.elements)
    pose, before, after = ca.SX.sym("pose", 6), ca.SX.sym("before", *size), ca.SX.sym("after", *size)
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    momentum = functions.step_momentum(structure, 3)(before, after, pose, parameters)
    spring = ca.vertcat(SPRING * pose[3:], ca.SX.zeros(3))
    equation = {"x": pose, "p": ca.vertcat(ca.vec(before), ca.vec(after), parameters), "g": momentum + spring}
    newton = ca.rootfinder("place", "newton", equation, {"abstol": 1e-15, "max_iter": 30, "error_on_fail": False})
    x, b, a = ca.MX.sym("x", 6), ca.MX.sym("b", *size), ca.MX.sym("a", *size)
    p = ca.MX.sym("p", parameters.numel())
    finder = ca.Function("step_in_space", [x, b, a, p], [newton(x, ca.vertcat(ca.vec(b), ca.vec(a), p))])
    value = functions.step_energy(structure, 3)(before, after, pose, parameters)
    curvature, slope = ca.hessian(value, pose)
    here = [ca.substitute(expression, pose, ca.SX.zeros(6)) for expression in (value, slope, ca.densify(curvature))]
    energy = ca.Function("energy_in_space", [before, after, parameters], here, functions.CSE)
    return finder, energy, functions.shape_elements(structure, 3)


def _alignment(before: Floats, after: Floats) -> tuple[Floats, Floats]:
    """Rotation and shift that lay chain `after` on `before` in the least-squares sense (Kabsch)."""
    b, a = before - before.mean(0), after - after.mean(0)
    u, _, vt = np.linalg.svd(b.T @ a)
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0])
    rotation = u @ flip @ vt
    return rotation, before.mean(0) - rotation @ after.mean(0)


def _cayley(vector: Floats) -> Floats:
    n = vector / 2
    cross = np.array([[0, -n[2], n[1]], [n[2], 0, -n[0]], [-n[1], n[0], 0]])
    return np.eye(3) + 2 / (1 + n @ n) * (cross + cross @ cross)
