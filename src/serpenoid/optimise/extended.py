"""The gait NLP of a model with effects: the same variables and constraints, with the residual that has the effects.

    T (drag_t + dt (c_0 P_t + c_1 P_{t-1} + c_2 P_{t-2})) = 0 for every step     (on the floor; see mechanics.extended)

The cycle begins at the origin, heading along x, at rest, with the clock at zero: what depends on place, time or history
is optimised as a robot would play it. Rows are the realised ones: a lag makes an ellipse smaller and later, other servo
effects are formulas (`ActuationEffect.in_gait`), and a speed saturation becomes a limit (`limits.py`).
Derivatives come from CasADi, vertex by vertex. Legend: T steps, M vertices, m joints, q gait (6).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import casadi as ca
import numpy as np
from scipy import sparse

from serpenoid.body import Floats
from serpenoid.effects.base import Wave
from serpenoid.effects.catalogue import actuation_effects, medium_effects
from serpenoid.mechanics import kinematics
from serpenoid.mechanics.extended import SETTING, with_links, wrench
from serpenoid.mechanics.functions import CSE, split_parameters
from serpenoid.model import Model
from serpenoid.optimise.assembly import GAIT, scatter_jacobian
from serpenoid.optimise.transcription import GaitNLP
from serpenoid.simulation.chain import difference_weights
from serpenoid.simulation.law import Law, coordinates
from serpenoid.simulation.servos import coordinates as servo_coordinates


class ExtendedNLP(GaitNLP):
    """A GaitNLP for a model with effects. What `customise` adds works as for the baseline."""

    def __init__(self, model: Model, steps: int, path_rows: int = 0) -> None:
        self.model = model
        super().__init__(model.structure, steps, path_rows)

    @property
    def dissipation(self) -> ca.MX:
        """T times E, E half the work against the drag."""
        return self.steps * self._motion()[1]

    def functions(self) -> dict[str, ca.Function]:
        """The NLP as named Functions, as `casadi.nlpsol` takes them; names as in GaitNLP."""
        x, p = self.variables, self.parameters
        residual, energy = self._motion()
        weight = 0 if self.replaced else p[0] * self.steps
        f = self._base_objective() + weight * energy
        added = ca.vertcat(*(expression for expression, _, _ in self.added)) if self.added else ca.MX(0, 1)
        path, path_jacobian = self._path_terms()
        scaled, counts = ca.vec(residual) * self.steps, self.constraint_counts
        jacobian = ca.vertcat(self._jacobian() * self.steps, path_jacobian, ca.jacobian(added, x))
        factor, multipliers = ca.MX.sym("multiplier"), ca.MX.sym("multipliers", sum(counts))
        momentum, on_path, on_added = ca.vertsplit(multipliers, [0, counts[0], counts[0] + counts[1], sum(counts)])
        smooth = factor * f + ca.dot(momentum, scaled) + ca.dot(on_added, added)
        hessian = ca.triu(ca.hessian(smooth, x)[0]) + self._path_hessian(on_path)
        make: Callable[..., ca.Function] = ca.Function
        g = ca.vertcat(scaled, path, added)
        lagrange = (["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"])
        return {
            "f": make("gait_nlp_objective", [x, p], [f], ["x", "p"], ["f"]),
            "g": make("gait_nlp_constraints", [x, p], [g], ["x", "p"], ["g"]),
            "grad_f": make(
                "gait_nlp_gradient", [x, p], [f, ca.densify(ca.gradient(f, x))], ["x", "p"], ["f", "grad_f_x"]
            ),
            "jac_g": make("gait_nlp_jacobian", [x, p], [g, jacobian], ["x", "p"], ["g", "jac_g_x"]),
            "hess_lag": make("gait_nlp_hessian", [x, p, factor, multipliers], [hessian], *lagrange),
        }

    def _motion(self) -> tuple[ca.MX, ca.MX]:
        """Residuals (3, T) of all steps, and the sum of their energies."""
        value = self._over_all_steps(self._step)
        return self._with_history(value[:3, :], value[3:6, :]), ca.sum2(value[6, :])

    def _jacobian(self) -> ca.MX:
        """Derivatives (3 T, 3 T + 6) of the residuals, step by step into their places."""
        blocks = self._over_all_steps(self._step_jacobian)
        drag, momentum = (scatter_jacobian(blocks[rows, :], self.steps) for rows in (slice(0, 3), slice(3, 6)))
        if not self.model.knows("history"):
            return drag
        shifts = (np.diag(self._rates[age:, age], -age) for age in range(3))
        return drag + ca.DM(sparse.csc_matrix(np.kron(sum(shifts), np.eye(3)))) @ momentum

    def _with_history(self, drag: ca.MX, momentum: ca.MX) -> ca.MX:
        if not self.model.knows("history"):
            return drag
        t, rates = self.steps, ca.DM(self._rates).T
        momenta = ca.horzcat(ca.MX.zeros(3, 2), momentum)
        return sum((ca.repmat(rates[a, :], 3, 1) * momenta[:, 2 - a : 2 - a + t] for a in range(3)), drag)

    @property
    def _times(self) -> Floats:
        return self.model.step_duration(self.steps) * np.arange(self.steps + 1, dtype=float)

    @property
    def _rates(self) -> Floats:
        """Dimensionless coefficients (T, 3) of a step's momentum and of the two before it."""
        return difference_weights(self._times) * self.model.step_duration(self.steps)

    def _over_all_steps(self, function: ca.Function) -> ca.MX:
        poses, phases = ca.horzcat(ca.MX.zeros(3, 1), self.poses), self._phases()
        settings = Law.of(self.model).settings(np.column_stack([self._times[:-1], self._times[1:]]))
        mapped = function.map("steps", "serial", self.steps, [2, 6], [])
        inputs = [poses[:, :-1], poses[:, 1:], self.gait, phases[:, :-1], phases[:, 1:], settings]
        return mapped(*inputs, self.model_parameters)

    @cached_property
    def _step(self) -> ca.Function:
        return step_function(self.model, self.steps)

    @cached_property
    def _step_jacobian(self) -> ca.Function:
        inputs = self._step.sx_in()
        value = self._step(*inputs)
        slope = ca.densify(ca.jacobian(value[:6], ca.vertcat(*inputs[:3])))
        return ca.Function("extended_jacobian", inputs, [slope], CSE)


def step_function(model: Model, steps: int) -> ca.Function:
    """(g_t, g_{t+1}, q, phase_t, phase_{t+1}, setting, parameters) -> drag (3), momentum (3), energy: one step, (7)."""
    g0, g1, q = ca.SX.sym("g0", 3), ca.SX.sym("g1", 3), ca.SX.sym("q", GAIT)
    t0, t1, setting = ca.SX.sym("t0"), ca.SX.sym("t1"), ca.SX.sym("setting", SETTING)
    parameters = ca.SX.sym("parameters", 2 * model.structure.vertices)
    edges, weights, eps = split_parameters(parameters, model.structure)
    present = {e.name for e in model.medium_effects}
    kinds = tuple(kind for kind in medium_effects() if kind.name in present)
    theta = ca.SX(ca.DM(coordinates(model, kinds=kinds)))
    shares = kinematics.element_weights(weights, edges, model.structure)
    before, after = (ca.horzsplit(with_links(_row(model, q, t, parameters, steps))) for t in (t0, t1))
    total = ca.SX.zeros(7)
    for k, (b, a) in enumerate(zip(before, after, strict=True)):
        medium = ca.vertcat(shares[k], eps)
        total += wrench(kinds, b, a, ca.vertcat(g0, g1), medium, setting, theta[:, k])
    inputs = [g0, g1, q, t0, t1, setting, parameters]
    return ca.Function("extended_step", inputs, [ca.densify(total)], CSE)


def _row(model: Model, q: ca.SX, phase: ca.SX, parameters: ca.SX, steps: int) -> ca.SX:
    """Elements (4, M) of the realised row, in the body frame."""
    edges, weights, _ = split_parameters(parameters, model.structure)
    realised = realised_angles(model, q, phase * steps, edges, steps)
    points, unit = kinematics.vertices(realised, edges, weights, model.structure)
    return kinematics.elements(points, unit, model.structure)


def realised_angles(model: Model, q: ca.SX, row: ca.SX, edges: ca.SX, steps: int) -> ca.SX:
    """Joint angles (m) on which the servos settle when gait q is played again and again, at `row` of its table."""
    joints = range(len(model.structure.joints))
    return ca.vertcat(*(_realised(model, joint, q, edges, steps).at(row) for joint in joints))


def _realised(model: Model, joint: int, q: ca.SX, edges: ca.SX, steps: int) -> Wave:
    def commanded(row: ca.SX) -> ca.SX:
        coordinates = kinematics.ellipse_coordinates(q, row / steps)
        return kinematics.serpenoid_joint_angles(coordinates, edges, model.structure)[joint]

    wave = Wave(commanded, steps, model.step_duration(steps))
    theta, start = ca.SX(ca.DM(servo_coordinates(model)[:, joint])), 0
    for kind in actuation_effects():
        count = len(kind.parameters) + 1
        if any(active.name == kind.name and active.place in (None, joint + 1) for active in model.actuation_effects):
            wave = kind.in_gait(wave, kind.symbols(theta[start : start + count]))
        start += count
    return wave
