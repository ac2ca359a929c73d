"""Gaits in space: a wave of bending and a wave of lifting, six equations a step, contact weights that vary.

    curvature  a sin 2 pi (xi s + t)                         in the plane of the floor, as a serpenoid's
    contact    1 / (1 + exp(-k (cos 2 pi (xi s + t - phase) + bias)))     shares of the weights, which add up to one
    height     lift (1 - contact)                            edges keep their lengths: they rise by pitching

    variables    xi_t (6): pose of row t + 1 in the frame of row t;  g_t (12) of the frames in the world;  gait (4)
    minimise     -distance + c T E
    subject to   d(E_t + S_t) / d xi_t = 0,   g_{t+1} = g_t xi_t,   joint limits

S_t = SUPPORT / 2 sum_k w_k (z_k - height_k)^2: the floor carries the body, which neither sinks in nor falls over;
whether gravity would let it stand like that is reported beside (`standing`). The two waves are the template of
sidewinding snakes (Astley et al., 2015, PNAS 112, 6200); here their phase is found.

Legend: T steps, N vertices, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseBounds, EllipseGait
from serpenoid.mechanics import energy, functions, kinematics
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.model import Model
from serpenoid.problem import Lift, Problem
from serpenoid.simulation.newton import TOLERANCE, State, newton
from serpenoid.status import Status

NAMES = ("a", "xi", "phase", "bias")  # [per body length], [waves], [cycles], none
SUPPORT = 100.0  # times the drag of a step of a body length: what stands tilts by thousandths of a radian
LIMITS = {"joint_limits"}  # constraints that gaits in space know


@dataclass(frozen=True)
class SpatialMotion:
    """A cycle: poses (T, 6) of rows in the frames of those before, frames (T + 1, 12), dissipation T * E."""

    sound: bool
    poses: Floats
    frames: Floats
    dissipation: float

    @property
    def status(self) -> Status:
        """Whether every step has its root."""
        return Status.SOLVED if self.sound else Status.STEP_UNSOLVED

    @property
    def rotations(self) -> Floats:
        """Of all rows, (T + 1, 3, 3)."""
        return self.frames[:, :9].reshape(-1, 3, 3).transpose(0, 2, 1)

    @property
    def places(self) -> Floats:
        """Of all rows, (T + 1, 3) [body lengths]."""
        return self.frames[:, 9:]

    @property
    def displacement(self) -> float:
        """Along the floor [body lengths]."""
        return float(np.hypot(*self.places[-1, :2]))

    @property
    def tilt(self) -> float:
        """Largest angle between the body's plane and the floor [rad]."""
        return float(np.arccos(np.clip(self.rotations[:, 2, 2], -1, 1)).max())

    @property
    def heading_change(self) -> float:
        """Over the cycle [rad]."""
        last = self.rotations[-1]
        return float(np.arctan2(last[1, 0], last[0, 0]))


@dataclass(frozen=True)
class LiftedBody:
    """Shapes and contacts of a problem's body as functions of gait and phase."""

    problem: Problem

    def __post_init__(self) -> None:
        problem = self.problem
        if not isinstance(problem.gait, EllipseGait):
            raise InputError("[lift]: bends and lifts in two waves; [gait] must be an ellipse (for its `a`, `xi`).")
        task, terms = problem.task, [term.kind for term in problem.task.objectives]
        if terms != ["displacement"] or task.transient or any(task.constraints.model_dump(exclude=LIMITS).values()):
            raise InputError("[lift]: gaits in space go for displacement, within joint limits; leave the rest out.")
        if problem.model.effects or problem.medium.law != "viscous" or task.demands or task.robust:
            raise InputError(
                "[lift]: effects, demands, cases, dry friction are for gaits in the plane; leave them out."
            )

        if not np.isfinite(self._steepest).all():
            raise InputError(
                f"[lift] height: edges are too short to rise by {self.lift.height:g} body lengths in a wave; "
                "lower `height`, `sharpness` or the upper bound of `xi`."
            )

    @property
    def _steepest(self) -> Floats:
        """Pitches of the shortest wave at many phases; not finite where an edge would have to stretch."""
        _, upper = self.bounds
        waves = [np.array([0.0, upper[1], 0.0, bias]) for bias in (self.lift.bias[0], self.lift.bias[1])]
        found = [self.row(q, t)[3].full() for q in waves for t in np.linspace(0, 1, 24, endpoint=False)]
        return np.concatenate(found)

    @property
    def model(self) -> Model:
        """Body and medium."""
        return self.problem.model

    @property
    def lift(self) -> Lift:
        """How parts are lifted."""
        return self.problem.lift or Lift()

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Of the gait's parameters."""
        bounds, lift = self.problem.task.bounds, self.lift
        given = bounds if isinstance(bounds, EllipseBounds) else EllipseBounds()
        lower, upper = np.array([given.a, given.xi, lift.phase, lift.bias]).T
        return lower, upper

    @cached_property
    def row(self) -> ca.Function:
        """(gait (4), phase [cycles]) -> vertices (3, N), contact weights (N), yaw (m), pitch (m)."""
        q, t = ca.SX.sym("gait", 4), ca.SX.sym("t")
        body, structure, lift = self.model.body, self.model.structure, self.lift
        edges, weights, n = ca.SX(body.edges), ca.SX(body.vertex_weights), body.vertices
        wave = 2 * ca.pi * t
        curve = ca.vertcat(q[0] * ca.cos(wave), q[0] * ca.sin(wave), q[1])
        yaw = kinematics.serpenoid_joint_angles(curve, edges, structure)
        _, unit = kinematics.vertices(yaw, edges, weights, structure)
        s = ca.SX(np.concatenate([[0.0], np.cumsum(body.edges)]))
        crest = ca.cos(2 * ca.pi * (q[1] * s + t - q[2])) + q[3]
        contact = 1 / (1 + ca.exp(-lift.sharpness * crest))
        height = lift.height * (1 - contact)
        rise = (height[1:] - height[:-1]) / edges
        along = ca.sqrt(1 - rise**2)
        points = [ca.SX.zeros(2, 1)]
        for j in range(n - 1):
            points.append(points[-1] + edges[j] * along[j] * unit[:, j])
        flat = ca.horzcat(*points)
        flat -= ca.repmat(flat @ weights, 1, n)
        resting = weights * (lift.air + (1 - lift.air) * contact)
        pitch = ca.asin(rise)
        joints = [j - 1 for j in structure.joints]
        bends = pitch[[j + 1 for j in joints]] - pitch[joints]
        outputs = [ca.vertcat(flat, height.T), resting / ca.sum1(resting), yaw, bends]
        return ca.Function("lifted_row", [q, t], [ca.densify(x) for x in outputs], functions.CSE)

    @cached_property
    def step(self) -> ca.Function:
        """(pose (6), gait, phase, phase after) -> dE / d pose (6), E."""
        pose, q, t, u = ca.SX.sym("pose", 6), ca.SX.sym("gait", 4), ca.SX.sym("t"), ca.SX.sym("u")
        structure = self.model.structure
        before, after = self.row(q, t), self.row(q, u)
        ends = [kinematics.elements(x[0], kinematics.unit_edges(x[0]), structure) for x in (before, after)]
        share = (before[1] + after[1]) / 2
        weights = kinematics.element_weights(share, ca.SX(self.model.body.edges), structure)
        eps = ca.SX(self.model.medium.anisotropy_ratio)
        value = energy.step_energy(ends[0], energy.move(pose, ends[1]), weights, eps)
        points = energy.spatial_rotation(pose[3:]) @ after[0] + ca.repmat(pose[:3], 1, structure.vertices)
        sunk = points[2, :] - after[0][2, :]
        support = SUPPORT / 2 * ca.dot(ca.SX(self.model.body.vertex_weights), sunk.T**2)
        curvature, slope = ca.hessian(value + support, pose)
        outputs = [slope, value, ca.densify(curvature)]
        return ca.Function("lifted_step", [pose, q, t, u], outputs, functions.CSE)

    def play(self, gait: Floats, steps: int) -> SpatialMotion:
        """All steps side by side by Newton's method from rest, then the frames one after the other."""
        t = np.arange(steps) / steps

        def equations(poses: Floats, which: np.ndarray) -> State:
            given = np.tile(gait, (len(which), 1)), t[which], t[which] + 1 / steps
            slope, value, curvature = evaluate(_over(self.step, len(which)), poses, *given)
            return State(slope.T, np.ascontiguousarray(curvature.T).reshape(1, -1, 6, 6), (value[0],))

        poses, state = newton(equations, np.zeros((steps, 6)))
        sound = bool((state.size <= TOLERANCE).all()) and np.linalg.eigvalsh(state.slopes[0]).min() > 0
        frames = np.zeros((steps + 1, 12))
        frames[0, [0, 4, 8]] = 1.0
        after = compose()
        for i in range(steps):
            frames[i + 1] = after(frames[i], poses[i]).full()[:, 0]
        return SpatialMotion(bool(sound), poses, frames, steps * float(state.more[0].sum()))

    def rows(self, gait: Floats, steps: int) -> tuple[Floats, Floats, Floats]:
        """Vertices (T + 1, N, 3), contact over the body's weights (T + 1, N), joints yaw and pitch (T, 2 m)."""
        phases = np.arange(steps + 1) / steps
        found = [self.row(gait, t) for t in phases]
        vertices = np.array([f[0].full().T for f in found])
        contact = np.array([f[1].full()[:, 0] for f in found]) / self.model.body.vertex_weights
        joints = np.array([np.concatenate([f[2].full()[:, 0], f[3].full()[:, 0]]) for f in found[:-1]])
        return vertices, contact, joints


@lru_cache(maxsize=64)
def _over(function: ca.Function, steps: int) -> ca.Function:
    return function.map(steps)


@lru_cache(maxsize=1)
def compose() -> ca.Function:
    """(frame (12): rotation columns and place; pose (6)) -> frame."""
    frame, pose = ca.SX.sym("frame", 12), ca.SX.sym("pose", 6)
    rotation = ca.reshape(frame[:9], 3, 3)
    turned = rotation @ energy.spatial_rotation(pose[3:])
    return ca.Function("compose", [frame, pose], [ca.vertcat(ca.vec(turned), frame[9:] + rotation @ pose[:3])])
