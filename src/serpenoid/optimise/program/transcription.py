"""The gait NLP: the only place that lays one out, for every family, model and criterion.

    variables    poses g_1 .. g_T of the body frame (g_0 = origin), [dissipation], [servos' states], gait parameters p
    minimise     the criteria's objective
    subject to   T (step values combined) = 0 for every step    (d T equations: the geometric momentum vanishes)
                 [dissipation = T * E]                          (a variable where the criteria are not linear in it)
                 [servos with memory do what they do]           (see played.py)
                 joint angles and their changes in limits       (at K rows of the table; see limits.py)
                 what the criteria add

Direct transcription after Even et al., Sec. III-A, with the paper's simulation as constraints. Everything is derived in
the variables (poses, shapes) of the steps; `Layer`s carry it to the gait's parameters by the chain rule, and for free
tables there is nothing to carry.

Legend: T steps, R rows, d numbers of a pose (`layout`), s coordinates of a shape, m joints, n parameters, K path rows.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits.lifted import LiftedFamily
from serpenoid.objectives.criteria import Criteria
from serpenoid.optimise.clear.along import Along, gap_functions
from serpenoid.optimise.clear.watch import Watch
from serpenoid.optimise.program.criteria_rows import CriteriaRows
from serpenoid.optimise.program.layout import Layout
from serpenoid.optimise.program.placed import placed_lifted_vertices, placed_vertices
from serpenoid.optimise.step.assembly import Places, Upper
from serpenoid.optimise.step.layer import Layer
from serpenoid.optimise.step.motion_law import MotionLaw, path_layer
from serpenoid.optimise.step.serpenoid_blocks import SerpenoidBlocks

Names = tuple[list[str], list[str]]


class GaitNLP:
    """The whole-cycle NLP of one model, family and criteria; take its Functions.

    variables: MX (d T + [1] + n); parameters: MX: c, the data of the K path rows and of those after them, model
    parameters (2 N). `penalised=False` leaves the dissipation out of the derivatives (faster where its
    weight is zero). `watch`: what is kept clear of obstacles, and when. `portable` Functions are self-contained: they
    can be saved, loaded elsewhere and generated as C; the others call libraries compiled on this machine, and are
    faster.
    """

    def __init__(
        self,
        law: MotionLaw,
        criteria: Criteria,
        path_rows: int = 0,
        portable: bool = False,
        penalised: bool = True,
        watch: Watch | None = None,
    ) -> None:
        self.law, self.family, self.criteria, self.penalised = law, law.family, criteria, penalised
        self.steps, self.path_rows, self.portable = law.steps, path_rows, portable
        self.structure, self.watch = law.structure, watch or Watch()
        self._layout = Layout(law, criteria, path_rows, portable)
        self.variables, self.parameters = self._layout.variables, self._layout.parameters
        self.priced, self.size = self._layout.priced, self._layout.size
        self.gait, self.model_parameters = self._layout.gait, self._layout.model_parameters

    @cached_property
    def vertices(self) -> ca.MX:
        """Vertices (2 or 3, N (T + 1)) at rows 0 .. T, tail to head, in the body frame of row 0 [body lengths]."""
        cycle = self._layout.cycle
        if isinstance(self.family, LiftedFamily):
            at = self.structure, self.family.lift, cycle.poses, cycle.shapes
            return placed_lifted_vertices(*at, self.model_parameters)
        return placed_vertices(self.structure, cycle.poses, self.joint_angles, self.model_parameters)

    @cached_property
    def joint_angles(self) -> ca.MX:
        """The joint table (m, R); in space yaws, then pitches, (2 m, R) [rad]."""
        layout = self._layout
        angles = self.gait if self.family.free else (layout.table or layout.table_layer()).value(*layout.at)
        return ca.reshape(angles, self.family.joints, -1)

    @property
    def poses(self) -> ca.MX:
        """Poses (3 or 6, T + 1) of the body frame, the first of them the origin [body lengths, rad]."""
        return self._layout.cycle.poses

    @property
    def head(self) -> ca.MX:
        """Where the head is after the cycle (2 or 3)."""
        return self.vertices[:, -1]

    def __repr__(self) -> str:
        n, g = self.variables.numel(), sum(self.constraint_counts)
        return f"<GaitNLP {n} variables, {g} constraints, {self.steps} steps, {self.structure.vertices} vertices>"

    @property
    def constraint_counts(self) -> tuple[int, int, int]:
        """Numbers of (motion, path, added) constraints; added ones: the criteria's, then gaps, instant by instant."""
        path = 2 * self.family.joints * self.path_rows
        added = self.criteria.count + (self._along.total if self._along else 0)
        return self._layout.start + self.law.states, path, added

    def split(self, x: Floats) -> tuple[Floats, Floats]:
        """Poses (T, d) and gait parameters (n,) of a point."""
        return x[: self._layout.moved].reshape(self.steps, -1), x[self._layout.start + self.law.states :]

    def functions(self) -> dict[str, ca.Function]:
        """The NLP as named Functions, as `casadi.nlpsol` takes them.

        gait_nlp_objective (variables, parameters) -> f; gait_nlp_constraints -> g; gait_nlp_gradient -> f, gradient;
        gait_nlp_jacobian -> g, J; gait_nlp_hessian (variables, parameters, multiplier of f, multipliers of g) -> upper
        triangle.
        """
        x, p = self.variables, self.parameters
        f, g = self._asked.value[0], self._constraints()
        factor, multipliers = ca.MX.sym("multiplier"), ca.MX.sym("multipliers", sum(self.constraint_counts))
        hessian = self._hessian(factor, multipliers)
        make: Callable[..., ca.Function] = ca.Function
        lagrange: Names = ["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"]
        return {
            "f": make("gait_nlp_objective", [x, p], [f], ["x", "p"], ["f"]),
            "g": make("gait_nlp_constraints", [x, p], [g], ["x", "p"], ["g"]),
            "grad_f": make("gait_nlp_gradient", [x, p], [f, self._gradient()], ["x", "p"], ["f", "grad_f_x"]),
            "jac_g": make("gait_nlp_jacobian", [x, p], [g, self._jacobian()], ["x", "p"], ["g", "jac_g_x"]),
            "hess_lag": make("gait_nlp_hessian", [x, p, factor, multipliers], [hessian], *lagrange),
        }

    # parts: steps (with the dissipation), layers (servos, path rows), criteria, gaps

    @cached_property
    def _values(self) -> tuple[ca.MX, ca.MX]:
        values, energies = self.law.blocks.value(self._layout.cycle)
        return values, self.steps * ca.sum2(energies)

    @cached_property
    def _places(self) -> Places:
        return Places(self.steps, self.family.rows, self.law.coordinates, self.family.closed, self.family.pose_size)

    @cached_property
    def _asked(self) -> CriteriaRows:
        return CriteriaRows(self._layout, self._values[1], self.penalised)

    @cached_property
    def _layers(self) -> list[tuple[Layer, tuple[ca.MX, ca.MX, ca.MX]]]:
        """Rows that depend on the parameters alone, and what they are evaluated at: servos' equations, path rows."""
        layout, found = self._layout, []
        if self.law.played is not None:
            layer, data = self.law.played.equations()
            found.append((layer, layout.at_data(ca.MX(ca.DM(data.T)))))
        if self.path_rows:
            rows = path_layer(self.family, self.structure, self.path_rows, self.portable)
            found.append((self.law.behind(rows), layout.at_path))
        return found

    @cached_property
    def _along(self) -> Along | None:
        if not self.watch.points:
            return None
        law = self.law
        serpenoid = law.coordinates == 3 and isinstance(law.blocks, SerpenoidBlocks)
        gaps = tuple(self.criteria.clear_of)
        functions = gap_functions(gaps, law.structure, law.coordinates, serpenoid, self.portable)
        return Along(functions, self.watch, self.steps, self.family.rows)

    def _constraints(self) -> ca.MX:
        values, energy = self._values
        flat = ca.vec(values) if self.law.combine is None else self.law.combine @ ca.vec(values)
        priced = [energy - self._layout.dissipation] if self.priced else []
        rows = [ca.vec(layer.value(*at)) for layer, at in self._layers]
        gaps = [self._along.value(self._layout.cycle)] if self._along else []
        return ca.vertcat(flat * self.steps, *priced, *rows, self._asked.value[1], *gaps)

    def _energy_slope(self) -> tuple[ca.MX, ca.MX]:
        """Derivatives of the dissipation by poses and q, rows."""
        pose_places, shape_places = self._places.gradient()
        falls = self.law.blocks.gradient(self._layout.cycle) * self.steps
        return pose_places(falls).T, self._layout.beside(shape_places(falls).T)

    def _gradient(self) -> ca.MX:
        poses, dissipation, by_q = self._asked.slope()
        if not self.priced and self._asked.needs_energy:
            by_poses, by_shapes = self._energy_slope()
            poses, by_q = poses + dissipation * by_poses, by_q + dissipation * by_shapes
        return ca.densify(self._layout.row(poses, dissipation, by_q).T)

    def _jacobian(self) -> ca.MX:
        layout = self._layout
        blocks = self.law.blocks.jacobian(layout.cycle) * self.steps
        by_poses, by_shapes = (places(blocks) for places in self._places.jacobian(self.law.blocks.values))
        if self.law.combine is not None:
            by_poses, by_shapes = self.law.combine @ by_poses, self.law.combine @ by_shapes
        rows = [layout.row(by_poses, ca.MX(by_poses.size1(), 1), layout.beside(by_shapes))]
        if self.priced:
            by_poses, by_q = self._energy_slope()
            rows.append(layout.row(by_poses, ca.MX(-1), by_q))
        rows += [layout.row_of_free(layer.slope(*at)) for layer, at in self._layers]
        if self._asked.count:
            rows.append(layout.row(*self._asked.jacobian()))
        if self._along:
            by_poses, by_shapes = self._along.jacobian(layout.cycle)
            rows.append(layout.row(by_poses, ca.MX(by_poses.size1(), 1), layout.beside(by_shapes)))
        return ca.vertcat(*rows)

    def _hessian(self, factor: ca.MX, multipliers: ca.MX) -> ca.MX:
        layout, start = self._layout, self._layout.start
        counts = [layout.moved, int(self.priced), *(int(v.numel()) for v in self._layer_values), self._asked.count]
        ends = np.cumsum([0, *counts, multipliers.numel() - sum(counts)]).tolist()
        on_steps, on_price, *on_layers, on_asked, on_gaps = ca.vertsplit(multipliers, ends)
        gradient, jacobian, hessian = self._asked.derived(factor, on_asked)
        on_energy = on_price if self.priced else factor * self._asked.of_energy(gradient)
        weights, energy = self._step_weights(on_steps, on_energy)
        slope, blocks = self.law.blocks.hessian(layout.cycle, weights, energy)
        force, placed = ca.densify(self._places.gradient()[1](slope)), [(self._places.hessian(), blocks)]
        if self._along:
            gap_force, gap_parts = self._along.hessian(layout.cycle, on_gaps)
            force, placed = force + ca.vec(gap_force), placed + gap_parts
        corner, mixed, square = self._asked.curvature(hessian)
        total = Upper(start + self.size)
        for (by_poses, by_both, by_shapes), values in placed:
            beside = [(by_both, 0, start), (by_shapes, start, start)] if layout.psi is None else []
            total.scatter(values, [(by_poses, 0, 0), *beside])
        total.matrix(corner)
        if layout.psi is not None:
            sums = [sum(same[1:], same[0]) for same in zip(*([p(v) for p in ps[1:]] for ps, v in placed), strict=True)]
            uq = ca.vertcat(layout.beside(sums[0]), ca.MX(int(self.priced), sum(layout.groups)))
            mixed = (uq + mixed) @ layout.psi
            square = layout.psi.T @ ((layout.square(sums[1]) + square) @ layout.psi)
            square = square + self._curvature(force, ca.densify(factor * gradient + jacobian.T @ on_asked))
        total.matrix(mixed, 0, start)
        total.matrix(square, start, start)
        for (layer, at), value, on_rows in zip(self._layers, self._layer_values, on_layers, strict=True):
            total.matrix(layer.curvature(*at, ca.reshape(on_rows, *value.shape)), start, start)
        return total()

    @property
    def _layer_values(self) -> list[ca.MX]:
        return [layer.value(*at) for layer, at in self._layers]

    def _step_weights(self, on_steps: ca.MX, on_energy: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Multipliers of the steps' values (v, T) and the factor of each step's energy (1, T)."""
        residual, combine = on_steps * self.steps, self.law.combine
        flat = residual if combine is None else combine.T @ residual
        return ca.reshape(flat, self.law.blocks.values, self.steps), ca.repmat(on_energy * self.steps, 1, self.steps)

    def _curvature(self, on_shapes: ca.MX, by_z: ca.MX) -> ca.MX:
        """What the layers' own second derivatives add, (n, n), from gradients of the Lagrangian."""
        layout, total = self._layout, ca.MX(self.size, self.size)
        pairs = [(self.law.shapes, ca.reshape(on_shapes, self.law.coordinates, -1))]
        if layout.table is not None:
            pairs.append((layout.table, self._asked.on_table(by_z)))
        for layer, on_rows in pairs:
            if layer is not None and layer.functions.curvature is not None:
                total = total + layer.curvature(*layout.at, on_rows)
        return total
