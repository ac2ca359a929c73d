"""Forward simulation in space, SE(3): six equations a step.

The root sought is the minimum of the step energy nearest to the rigid alignment of the two chains. Newton's method from
that alignment finds it where the chain is bent; a nearly straight chain leaves its roll all but undetermined, and there
(or where the root is no minimum) the energy is descended first, by Newton steps whose curvature is made positive. The
chain is moved to every new estimate, so that the rotation sought is small, whatever frames the shapes came in.

Legend: R rows, S = R - 1 steps, N vertices, M elements.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.mechanics import functions
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.model import Model, Structure
from serpenoid.simulation.given import apart, model_of, shaped
from serpenoid.simulation.newton import TOLERANCE, State, newton
from serpenoid.status import Status

SPRING = 1e-9  # keeps Newton's matrix regular: as stiff as the roll of a chain that is straight to 1e-5 body lengths
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
    if model_of(model).medium_effects:
        raise InputError(f"[[effects]] `{model.medium_effects[0].name}` acts on a floor; simulate in the plane.")
    shapes = apart("vertices", shaped("vertices", vertices, (-1, model.body.vertices, 3)))
    rows = shapes.shape[0]
    rotations, translations = np.tile(np.eye(3), (rows, 1, 1)), np.zeros((rows, 3))
    if not np.isfinite(shapes).all():
        lost = [np.full_like(x, np.nan) for x in (rotations, translations, shapes, np.zeros(rows - 1))]
        return SpatialTrajectory(Status.BAD_SHAPE, lost[0], lost[1], lost[2], lost[3], np.inf)
    if rows == 1:
        return SpatialTrajectory(Status.SOLVED, rotations, translations, shapes, np.zeros(0), 0.0)
    origins = shapes[:-1].mean(1)
    placement = _Placement.of(model, shapes[:-1] - origins[:, None], shapes[1:])
    energies, residuals = placement.solve()
    for t in range(rows - 1):
        translations[t + 1] = translations[t] + rotations[t] @ (placement.shift[t] + origins[t])
        rotations[t + 1] = rotations[t] @ placement.rotation[t]
    status = Status.SOLVED if (residuals <= TOLERANCE).all() else Status.STEP_UNSOLVED
    placed = np.einsum("rij,rnj->rni", rotations, shapes) + translations[:, None]
    return SpatialTrajectory(status, rotations, translations, placed, energies, float(residuals.max(initial=0.0)))


@dataclass
class _Placement:
    """Chains `after` on their way to their places against `before`: x -> rotation x + shift, step by step.

    before: elements (S, M, 6); after (S, N, 3); rotation (S, 3, 3); shift (S, 3).
    """

    model: Model
    before: Floats
    after: Floats
    rotation: Floats
    shift: Floats

    @classmethod
    def of(cls, model: Model, before: Floats, after: Floats) -> _Placement:
        """Laid on each other."""
        pairs = [_alignment(b, a) for b, a in zip(before, after, strict=True)]
        rotation, shift = (np.array(found) for found in zip(*pairs, strict=True))
        return cls(model, _elements(model.structure, before), after, rotation, shift)

    def part(self, steps: np.ndarray) -> _Placement:
        """Some of the steps."""
        arrays = (a[steps] for a in (self.before, self.after, self.rotation, self.shift))
        return _Placement(self.model, *arrays)

    def put(self, steps: np.ndarray, other: _Placement) -> None:
        """Take over the places of some steps."""
        self.rotation[steps], self.shift[steps] = other.rotation, other.shift

    def solve(self) -> tuple[Floats, Floats]:
        """Move to the minima; energies and residuals (S,)."""
        start = self.part(np.arange(len(self.after)))
        for _ in range(2):  # the second time takes the spring out
            self._move(self._newton())
        value, slope, curvature = self._expansion()
        finite = np.asarray(np.isfinite(slope).all(1))  # a chain folded back on itself has no tangent at the fold
        stiffness = np.linalg.eigvalsh(np.where(finite[:, None, None], curvature, 0.0))[:, 0]
        residual = np.where(finite, np.abs(slope).max(1), np.inf)
        for s in np.flatnonzero(finite & ~((residual <= TOLERANCE) & (stiffness > -TOLERANCE))):
            one = start.part(np.array([s]))
            value[s], residual[s] = one._descend()
            self.put(np.array([s]), one)
        value[~finite] = np.nan
        return value, residual

    def _newton(self) -> Floats:
        """Poses (S, 6) that lead to the minima, against a weak spring."""
        after, spring = self._placed(), SPRING * np.array([0.0, 0, 0, 1, 1, 1])

        def equations(pose: Floats, steps: np.ndarray) -> State:
            _, slope, curvature = _expand(self.model, self.before[steps], after[steps], pose)
            return State(slope + spring * pose, (curvature + np.diag(spring))[None])

        return newton(equations, np.zeros((len(after), 6)), tolerance=TOLERANCE / 1000)[0]

    def _descend(self) -> tuple[float, float]:
        """Of one step: energy and residual where its energy is least."""
        value, slope, curvature = self._here()
        for _ in range(DESCENT_STEPS):
            if np.abs(slope).max() <= TOLERANCE / 100:
                break
            stiffness, axes = np.linalg.eigh(curvature)
            pose = -axes @ ((axes.T @ slope) / np.maximum(np.abs(stiffness), 1e-12))
            pose *= min(1.0, LONGEST_TURN / max(float(np.linalg.norm(pose[3:])), 1e-300))
            here = self.rotation, self.shift
            for _ in range(30):
                self._move(pose[None])
                there = self._here()
                if there[0] <= value:
                    break
                (self.rotation, self.shift), pose = here, pose / 2
            else:
                break  # no lower in floating point
            value, slope, curvature = there
        return self._polished(value, slope, curvature)

    def _polished(self, value: float, slope: Floats, curvature: Floats) -> tuple[float, float]:
        """Near the minimum the energy's last digits say nothing: Newton steps as long as they flatten the slope."""
        for _ in range(POLISHING_STEPS):
            here = self.rotation, self.shift
            self._move(np.asarray(-np.linalg.lstsq(curvature, slope, rcond=1e-14)[0], dtype=float)[None])
            there = self._here()
            if np.abs(there[1]).max() >= np.abs(slope).max() or np.linalg.eigvalsh(there[2])[0] < -TOLERANCE:
                self.rotation, self.shift = here
                break
            value, slope, curvature = there
        return value, float(np.abs(slope).max())

    def _move(self, poses: Floats) -> None:
        turns = np.array([_cayley(pose[3:]) for pose in poses])
        self.shift = np.einsum("sij,sj->si", turns, self.shift) + poses[:, :3]
        self.rotation = turns @ self.rotation

    def _placed(self) -> Floats:
        """Elements (S, M, 6) of the chains where they are."""
        chains = np.einsum("sij,snj->sni", self.rotation, self.after) + self.shift[:, None]
        return _elements(self.model.structure, chains)

    def _expansion(self) -> tuple[Floats, Floats, Floats]:
        after = self._placed()
        return _expand(self.model, self.before, after, np.zeros((len(after), 6)))

    def _here(self) -> tuple[float, Floats, Floats]:
        value, slope, curvature = self._expansion()
        return float(value[0]), slope[0], curvature[0]


def _elements(structure: Structure, chains: Floats) -> Floats:
    """Elements (S, M, 6) of chains (S, N, 3)."""
    function = _mapped(functions.shape_elements(structure, 3), len(chains))
    (found,) = evaluate(function, chains)
    return np.ascontiguousarray(found.T).reshape(len(chains), -1, 6)


def _expand(model: Model, before: Floats, after: Floats, poses: Floats) -> tuple[Floats, Floats, Floats]:
    """Energy (S,), its gradient (S, 6) and Hessian (S, 6, 6) by the poses (S, 6) of elements `after` (S, M, 6)."""
    function = _mapped(_energy(model.structure), len(poses))
    value, slope, curvature = evaluate(function, before, after, poses, model.parameters)
    return value[0], slope.T, np.ascontiguousarray(curvature.T).reshape(-1, 6, 6)


@lru_cache(maxsize=16)
def _energy(structure: Structure) -> ca.Function:
    size = (6, structure.elements)
    pose, before, after = ca.SX.sym("pose", 6), ca.SX.sym("before", *size), ca.SX.sym("after", *size)
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    value = functions.step_energy(structure, 3)(before, after, pose, parameters)
    curvature, slope = ca.hessian(value, pose)
    outputs = [value, slope, ca.densify(curvature)]
    return ca.Function("energy_in_space", [before, after, pose, parameters], outputs, functions.CSE)


@lru_cache(maxsize=128)
def _mapped(function: ca.Function, count: int) -> ca.Function:
    shared = [3] if function.n_in() == 4 else []
    return function.map(f"map{count}_{function.name()}", "serial", count, shared, [])


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
