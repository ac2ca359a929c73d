"""Gaits in space, solved and certified like those in the plane: re-simulation, KKT, polishing, finer meshes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.optimise.certify import GAIN_TOLERANCE, KKT_TOLERANCE, POSE_TOLERANCE
from serpenoid.optimise.interrupt import StopFlag, catch_interrupt
from serpenoid.optimise.ipopt import Bounds, Ipopt, Outcome, Residuals
from serpenoid.optimise.lifted import NAMES, LiftedBody, SpatialMotion, compose
from serpenoid.optimise.mesh import MeshStudy, study_mesh
from serpenoid.problem import Problem
from serpenoid.shown import Shown
from serpenoid.status import Status

TRIALS, DISTANCES = 8, (1.0, 0.1, 0.01)
WIDTHS = np.array([0.1, 0.02, 0.01, 0.02])  # a few per cent of the parameters' usual ranges
RESTING = 0.5  # of the contact: what rests more than this carries the body


class SpatialNLP:
    """variables: poses (6 T), frames (12 T), gait (4); see `lifted`. Derivatives are CasADi's own, step by step."""

    def __init__(self, body: LiftedBody, steps: int) -> None:
        self.body, self.steps = body, steps
        self.variables = ca.MX.sym("variables", 18 * steps + len(NAMES))
        self.parameters = ca.MX.sym("c")

    @property
    def constraint_counts(self) -> tuple[int, ...]:
        """Balance (6 T), frames (12 T), joints (2 m T)."""
        return 6 * self.steps, 12 * self.steps, 2 * self.body.model.body.joint_count * self.steps

    def functions(self) -> dict[str, ca.Function]:
        """As `GaitNLP.functions`."""
        steps, x, c = self.steps, self.variables, self.parameters
        poses, frames, gait = ca.vertsplit(x, [0, 6 * steps, 18 * steps, x.numel()])
        poses, frames = ca.reshape(poses, 6, steps), ca.reshape(frames, 12, steps)
        times = ca.DM(np.arange(steps) / steps).T
        slope, energies, _ = self.body.step.map("steps", "serial", steps, [1], [])(
            poses, gait, times, times + 1 / steps
        )
        origin = ca.DM([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0])
        after = compose().map(steps)(ca.horzcat(origin, frames[:, :-1]), poses)
        _, _, yaw, pitch = self.body.row.map("rows", "serial", steps, [0], [])(gait, times)
        g = ca.vertcat(steps * ca.vec(slope), ca.vec(frames - after), ca.vec(ca.vertcat(yaw, pitch)))
        f = -ca.norm_2(frames[9:11, -1]) + c * steps * ca.sum2(energies)
        factor, lam = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", g.numel())
        hessian = ca.triu(ca.hessian(factor * f + ca.dot(lam, g), x)[0])
        return {
            "f": ca.Function("f", [x, c], [f], ["x", "p"], ["f"]),
            "g": ca.Function("g", [x, c], [g], ["x", "p"], ["g"]),
            "grad_f": ca.Function("grad_f", [x, c], [f, ca.gradient(f, x)], ["x", "p"], ["f", "grad_f_x"]),
            "jac_g": ca.Function("jac_g", [x, c], [g, ca.jacobian(g, x)], ["x", "p"], ["g", "jac_g_x"]),
            "hess_lag": ca.Function(
                "hess_lag", [x, c, factor, lam], [hessian], ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]
            ),
        }

    def bounds(self) -> Bounds:
        """Of variables and constraints."""
        lower, upper = self.body.bounds
        free = np.full(18 * self.steps, np.inf)
        limit = self.body.problem.joint_limit_deg
        zero = np.zeros(18 * self.steps)
        joints = np.full(self.constraint_counts[2], np.inf if limit is None else np.deg2rad(limit))
        lbx, ubx = np.concatenate([-free, lower]), np.concatenate([free, upper])
        return Bounds(lbx, ubx, np.concatenate([zero, -joints]), np.concatenate([zero, joints]))


@dataclass(frozen=True, repr=False)
class SpatialSolution(Shown):
    """An optimal gait in space.

    q (4): `lifted.NAMES`; vertices (T + 1, N, 3) in the world; contact (T + 1, N): shares of the weights; joints
    (T, 2 m): yaw, then pitch [rad]; standing: share of the rows whose contacts hold the centre of mass.
    """

    status: Status
    problem: Problem
    c: float
    q: Floats
    motion: SpatialMotion
    vertices: Floats
    contact: Floats
    joints: Floats
    cost: float
    residuals: Residuals
    resimulation_error: float
    polishing_gain: float | None
    mesh: MeshStudy
    standing: float
    iterations: int
    seconds: float

    def summary(self) -> str:
        """How it ended, how far it goes, and which way."""
        went = f"{self.motion.displacement:.6f} body lengths, {self.sideways_deg:.0f} degrees off the body's axis"
        return f"{self.problem.name}: {self.status.name.lower()}, {went}"

    @property
    def sideways_deg(self) -> float:
        """Angle between the way and the body's mean axis, 0 to 90 [degrees]: a sidewinder's is large."""
        axes = self.motion.rotations[:-1, :2, 0].sum(0)
        way = self.motion.places[-1, :2]
        cosine = abs(axes @ way) / max(float(np.linalg.norm(axes) * np.linalg.norm(way)), 1e-300)
        return float(np.rad2deg(np.arccos(np.clip(cosine, 0, 1))))


@dataclass(frozen=True)
class SpatialSolver:
    """Prepared once per problem."""

    problem: Problem

    @cached_property
    def body(self) -> LiftedBody:
        """Shapes, contacts, steps."""
        return LiftedBody(self.problem)

    @cached_property
    def _prepared(self) -> tuple[SpatialNLP, Ipopt]:
        nlp = SpatialNLP(self.body, self.problem.task.steps)
        rows = np.arange(sum(nlp.constraint_counts if self.problem.joint_limit_deg else nlp.constraint_counts[:2]))
        return nlp, Ipopt(nlp, rows)

    def start(self, q: Floats) -> Floats:
        """The motion of gait q as NLP variables."""
        motion = self.body.play(q, self.problem.task.steps)
        return np.concatenate([motion.poses.ravel(), motion.frames[1:].ravel(), q])

    def solve(self, q: Floats, c: float, flag: StopFlag | None = None) -> SpatialSolution:
        """Optimise from gait q and certify the answer."""
        nlp, ipopt = self._prepared
        outcome = ipopt.solve(self.start(q), np.array([c]), nlp.bounds(), flag)
        return self._certified(outcome, c)

    def cost(self, q: Floats, c: float) -> float:
        """Objective of a simulated gait; infinite where it cannot be, or exceeds joint limits."""
        motion = self.body.play(q, self.problem.task.steps)
        limit = self.problem.joint_limit_deg
        joints = self.body.rows(q, self.problem.task.steps)[2]
        bent = limit is not None and np.abs(joints).max() > np.deg2rad(limit) + POSE_TOLERANCE
        return np.inf if bent or not motion.sound else -motion.displacement + c * motion.dissipation

    def random(self, rng: np.random.Generator) -> Floats:
        """A start within the bounds that can be simulated and keeps the joint limits."""
        lower, upper = self.body.bounds
        q = rng.uniform(lower, upper)
        while not np.isfinite(self.cost(q, 0.0)) and q[0] > lower[0] + WIDTHS[0]:
            q[0] = lower[0] + 0.8 * (q[0] - lower[0])
        return q

    def _certified(self, outcome: Outcome, c: float) -> SpatialSolution:
        steps, q = self.problem.task.steps, outcome.point.x[-len(NAMES) :]
        motion = self.body.play(q, steps)
        vertices, contact, joints = self.body.rows(q, steps)
        error = float(np.abs(motion.frames[1:].ravel() - outcome.point.x[6 * steps : 18 * steps]).max())
        mesh = study_mesh(lambda factor: self.body.play(q, factor * steps), steps)
        status, gain = outcome.status, None
        if status.ok and not (motion.sound and error <= POSE_TOLERANCE):
            status = Status.RESIMULATION_DISAGREES
        if status.ok and not outcome.residuals.largest <= KKT_TOLERANCE:
            status = Status.NOT_STATIONARY
        if status.ok:
            gain = self._gain(q, c)
            status = status if gain < GAIN_TOLERANCE else Status.NOT_A_MINIMUM
        if status.ok and not mesh.converged:
            status = Status.MESH_TOO_COARSE
        placed = np.einsum("rij,rnj->rni", motion.rotations, vertices) + motion.places[:, None]
        return SpatialSolution(
            status, self.problem, c, q, motion, placed, contact, joints, -motion.displacement + c * motion.dissipation,
            outcome.residuals, error, gain, mesh, standing(vertices, contact, self.body.model.body.vertex_weights),
            outcome.iterations, outcome.timing["total"],
        )  # fmt: skip

    def _gain(self, q: Floats, c: float) -> float:
        """What a derivative-free search around the answer gains."""
        rng, (lower, upper) = np.random.default_rng(0), self.body.bounds
        first = lowest = self.cost(q, c)
        best = q
        for distance in DISTANCES:
            for _ in range(TRIALS):
                trial = np.clip(best + distance * WIDTHS * rng.standard_normal(len(NAMES)), lower, upper)
                cost = self.cost(trial, c)
                if cost < lowest:
                    lowest, best = cost, trial
        return first - lowest


def solve_in_space(
    problem: Problem,
    starts: int = 6,
    seed: int = 0,
    progress: Callable[[int, SpatialSolution], None] | None = None,
) -> list[SpatialSolution]:
    """Gaits of a problem with `[lift]` from random starts, best first, certified ones before the others."""
    solver, rng = SpatialSolver(problem), np.random.default_rng(seed)
    found: list[SpatialSolution] = []
    with catch_interrupt() as flag:
        for index in range(starts):
            if flag:
                break
            found.append(solver.solve(solver.random(rng), problem.task.c, flag))
            if progress is not None:
                progress(index + 1, min(found, key=_order))
    return sorted(found, key=_order)


def _order(solution: SpatialSolution) -> tuple[bool, float]:
    return not solution.status.ok, solution.cost


def standing(vertices: Floats, contact: Floats, weights: Floats) -> float:
    """Share of the rows in which the centre of mass is over the hull of what rests: gravity alone holds the body."""
    held = 0
    for points, shares in zip(vertices[:, :, :2], contact, strict=True):
        resting = points[shares * weights > RESTING * (shares * weights).max()]
        held += _inside(resting, weights @ points)
    return held / len(vertices)


def _inside(points: Floats, place: Floats) -> bool:
    """Whether a place is in the hull of points: there is no direction that all of them lie away in."""
    angles = np.sort(np.arctan2(*(points - place).T[::-1]))
    gaps = np.diff(np.append(angles, angles[0] + 2 * np.pi))
    return bool(gaps.max() < np.pi)
