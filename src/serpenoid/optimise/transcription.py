"""The gait NLP: the only place that lays one out.

    variables    poses g_1 .. g_T of the body frame (g_0 = origin) and the gait q = (sigma, x_c, y_c, theta, a, xi)
    minimise     -Delta + c * dissipation                       Delta = |(x, y) of g_T|, dissipation = T * E
    subject to   T dE/d pose = 0 for every step                 (3 T equations: the geometric momentum vanishes)
                 joint angles and their changes in limits       (at K rows of the table; see limits.py)
                 whatever the user adds with `subject_to`

Direct transcription after Even et al., Sec. III-A, with the paper's simulation as constraints.
Legend: T steps, N vertices, m joints, K path rows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import casadi as ca
import numpy as np

from serpenoid.mechanics import functions
from serpenoid.model import Structure
from serpenoid.optimise.assembly import gather_gradient, scatter_hessian, scatter_jacobian
from serpenoid.optimise.blocks import GAIT, StepBlocks, portable_step_blocks, step_blocks


@dataclass
class GaitNLP:
    """The whole-cycle NLP of one Structure. Build it, optionally add terms, then take its Functions.

    variables: MX (3 T + 6), poses then gait; `poses` (3, T), `gait` (6). parameters: MX (1 + K + 2 N): c, the phases of
    the K path rows, model parameters. `penalised=False` leaves the dissipation out (faster where c = 0). `portable`
    Functions are self-contained: they can be saved, loaded elsewhere and generated as C; the others call the library
    compiled on this machine, and are faster.
    """

    structure: Structure
    steps: int
    path_rows: int = 0
    portable: bool = False
    penalised: bool = True
    variables: ca.MX = field(init=False)
    parameters: ca.MX = field(init=False)
    own_objective: ca.MX = field(init=False)
    replaced: bool = field(init=False, default=False)
    added: list[tuple[ca.MX, float, float]] = field(init=False, default_factory=list)

    def __post_init__(self) -> None:
        self.variables = ca.MX.sym("variables", 3 * self.steps + GAIT)
        self.parameters = ca.MX.sym("parameters", 1 + self.path_rows + 2 * self.structure.vertices)
        self.own_objective = ca.MX(0)

    @property
    def poses(self) -> ca.MX:
        """Poses g_1 .. g_T (x, y, heading), shape (3, T) [body lengths, rad]."""
        return ca.reshape(self.variables[: 3 * self.steps], 3, self.steps)

    @property
    def gait(self) -> ca.MX:
        """(sigma, x_c, y_c, theta, a, xi), shape (6,)."""
        return self.variables[3 * self.steps :]

    @property
    def model_parameters(self) -> ca.MX:
        """Edge lengths, weights, anisotropy ratio, shape (2 N,)."""
        return self.parameters[1 + self.path_rows :]

    @property
    def displacement(self) -> ca.MX:
        """Distance of the centroid over the cycle [body lengths]."""
        return ca.norm_2(self.poses[:2, -1])

    @property
    def heading_change(self) -> ca.MX:
        """Turn over the cycle [rad]."""
        return self.poses[2, -1]

    @property
    def joint_angles(self) -> ca.MX:
        """Joint table, shape (m, T) [rad], for terms of the user's own."""
        angles = functions.gait_joint_angles(self.structure)
        repeated = ca.repmat(self.gait, 1, self.steps), self._phases()[:, :-1]
        return angles.map(self.steps)(*repeated, ca.repmat(self.model_parameters, 1, self.steps))

    @property
    def dissipation(self) -> ca.MX:
        """T times E as an expression, for terms of the user's own (the built-in objective has its own, faster one)."""
        shape = functions.shape(self.structure).map(self.steps)
        parameters = ca.repmat(self.model_parameters, 1, self.steps)
        _, rows = shape(self.joint_angles, parameters)
        m = self.structure.elements
        after = ca.horzcat(rows[:, m:], rows[:, :m])
        poses = ca.horzcat(ca.MX.zeros(3, 1), self.poses)
        relative = functions.relative_pose().map(self.steps)(poses[:, :-1], poses[:, 1:])
        energies = functions.step_energy(self.structure).map(self.steps)(rows, after, relative, parameters)
        return self.steps * ca.sum2(energies)

    def minimise(self, expression: ca.MX) -> None:
        """Replace the objective by an expression of the symbols above."""
        self.own_objective, self.replaced = expression, True

    def also_minimise(self, expression: ca.MX) -> None:
        """Add an expression of the symbols above to the objective."""
        self.own_objective = self.own_objective + expression

    def subject_to(self, expression: ca.MX, lower: float, upper: float) -> None:
        """Add `lower <= expression <= upper` (scalars or columns of the symbols above)."""
        self.added.append((ca.vec(expression), lower, upper))

    @property
    def constraint_counts(self) -> tuple[int, int, int]:
        """Numbers of (momentum, path, added) constraints."""
        added = sum(expression.numel() for expression, _, _ in self.added)
        return 3 * self.steps, 2 * len(self.structure.joints) * self.path_rows, added

    @property
    def _blocks(self) -> StepBlocks:
        return (portable_step_blocks if self.portable else step_blocks)(self.structure)

    def _phases(self) -> ca.MX:
        return ca.MX(ca.DM(np.arange(self.steps + 1) / self.steps)).T

    def _base_objective(self) -> ca.MX:
        base = ca.MX(0) if self.replaced else -self.displacement
        return base + self.own_objective

    def _step_inputs(self, order: int) -> list[ca.MX]:
        """Inputs of the step blocks, one column (or block of columns) per step, with row derivatives up to `order`."""
        blocks, t, m = self._blocks, self.steps, self.structure.elements
        phases = self._phases()
        rows = blocks.rows[order].map(f"rows_{order}", "serial", t + 1, [0, 2], [])
        row = rows(self.gait, phases, self.model_parameters)
        poses = ca.horzcat(ca.MX.zeros(3, 1), self.poses)
        repeated = ca.repmat(self.gait, 1, t)
        return [poses[:, :-1], poses[:, 1:], repeated, phases[:, :-1], phases[:, 1:], row[:, : m * t], row[:, m:]]

    def _over_steps(self, function: ca.Function, order: int, *more: ca.MX) -> ca.MX:
        shared = [function.n_in() - 1]
        mapped = function.map(f"steps_{function.name()}", "serial", self.steps, shared, [])
        return mapped(*self._step_inputs(order), *more, self.model_parameters)

    def _path(self, function: ca.Function, *more: ca.MX) -> ca.MX:
        phases = self.parameters[1 : 1 + self.path_rows].T
        k, last = self.path_rows, [0, 3]
        mapped = function.map(f"path_{function.name()}", "serial", k, last, [])
        return mapped(self.gait, phases, phases + 1 / self.steps, self.model_parameters, *more)

    def functions(self) -> dict[str, ca.Function]:
        """The NLP as named Functions, as `casadi.nlpsol` takes them.

        gait_nlp_objective (variables, parameters) -> f, gradient; gait_nlp_constraints -> g; gait_nlp_jacobian -> g, J;
        gait_nlp_hessian (variables, parameters, multiplier of f, multipliers of g) -> upper triangle.
        """
        blocks, x, p = self._blocks, self.variables, self.parameters
        added = ca.vertcat(*(expression for expression, _, _ in self.added)) if self.added else ca.MX(0, 1)
        counts = self.constraint_counts
        weight = p[0] * self.steps if self.penalised and not self.replaced else ca.MX(0)
        residual, energy = self._over_steps(blocks.value, 0)
        slopes = self._over_steps(blocks.jacobian, 1)
        f, gradient = self._base_objective(), ca.gradient(self._base_objective(), x)
        if not weight.is_zero():
            f += weight * ca.sum2(energy)
            gradient += weight * gather_gradient(self._over_steps(blocks.gradient, 1), self.steps)
        path, path_jacobian = self._path_terms()
        g = ca.vertcat(ca.vec(residual) * self.steps, path, added)
        jacobian = scatter_jacobian(slopes * self.steps, self.steps)
        jacobian = ca.vertcat(jacobian, path_jacobian, ca.jacobian(added, x))
        factor, multipliers = ca.MX.sym("multiplier"), ca.MX.sym("multipliers", sum(counts))
        momentum, on_path, on_added = ca.vertsplit(multipliers, [0, counts[0], counts[0] + counts[1], sum(counts)])
        step_multipliers = ca.reshape(momentum, 3, self.steps) * self.steps
        packed = self._over_steps(blocks.hessian, 2, step_multipliers, ca.repmat(factor * weight, 1, self.steps))
        smooth = factor * self._base_objective() + ca.dot(on_added, added)
        hessian = scatter_hessian(packed, self.steps) + ca.triu(ca.hessian(smooth, x)[0])
        hessian += self._path_hessian(on_path)
        make: Callable[..., ca.Function] = ca.Function
        return {
            "f": make("gait_nlp_objective", [x, p], [f], ["x", "p"], ["f"]),
            "g": make("gait_nlp_constraints", [x, p], [g], ["x", "p"], ["g"]),
            "grad_f": make("gait_nlp_gradient", [x, p], [f, ca.densify(gradient)], ["x", "p"], ["f", "grad_f_x"]),
            "jac_g": make("gait_nlp_jacobian", [x, p], [g, jacobian], ["x", "p"], ["g", "jac_g_x"]),
            "hess_lag": make(
                "gait_nlp_hessian",
                [x, p, factor, multipliers],
                [hessian],
                ["x", "p", "lam_f", "lam_g"],
                ["triu_hess_gamma_x_x"],
            ),
        }

    def _path_terms(self) -> tuple[ca.MX, ca.MX]:
        if not self.path_rows:
            return ca.MX(0, 1), ca.MX(0, self.variables.numel())
        blocks = self._blocks
        slopes = ca.horzsplit(self._path(blocks.path_jacobian), GAIT)
        count = 2 * len(self.structure.joints) * self.path_rows
        jacobian = ca.horzcat(ca.MX(count, 3 * self.steps), ca.vertcat(*slopes))
        return ca.vec(self._path(blocks.path)), jacobian

    def _path_hessian(self, multipliers: ca.MX) -> ca.MX:
        n = 3 * self.steps
        if not self.path_rows:
            return ca.MX(n + GAIT, n + GAIT)
        columns = ca.reshape(multipliers, 2 * len(self.structure.joints), self.path_rows)
        blocks = self._path(self._blocks.path_hessian, columns)
        total = sum(ca.horzsplit(blocks, GAIT), ca.MX.zeros(GAIT, GAIT))
        return ca.diagcat(ca.MX(n, n), ca.triu(total))
