"""The gait NLP: the only place that lays one out, for every family, model and criterion.

    variables    poses g_1 .. g_T of the body frame (g_0 = origin), [dissipation], [servos' states], gait parameters p
    minimise     the criteria's objective
    subject to   T (step values combined) = 0 for every step    (3 T equations: the geometric momentum vanishes)
                 [dissipation = T * E]                          (a variable where the criteria are not linear in it)
                 [servos with memory do what they do]           (see played.py)
                 joint angles and their changes in limits       (at K rows of the table; see limits.py)
                 what the criteria add

Direct transcription after Even et al., Sec. III-A, with the paper's simulation as constraints. Everything is derived in
the variables (poses, shapes) of the steps; `Layer`s carry it to the gait's parameters by the chain rule, and for free
tables there is nothing to carry.

Legend: T steps, R rows, s coordinates of a shape, m joints, n parameters, d data of a row, K path rows.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import casadi as ca

from serpenoid.body import Floats
from serpenoid.objectives.criteria import Criteria
from serpenoid.optimise.along import Along, gap_functions
from serpenoid.optimise.assembly import Places, Upper
from serpenoid.optimise.blocks import Cycle
from serpenoid.optimise.layer import Layer
from serpenoid.optimise.motion_law import MotionLaw, path_layer, table_layer
from serpenoid.optimise.placed import placed_vertices
from serpenoid.optimise.serpenoid_blocks import SerpenoidBlocks
from serpenoid.optimise.watch import Watch

Names = tuple[list[str], list[str]]


class GaitNLP:
    """The whole-cycle NLP of one model, family and criteria; take its Functions.

    variables: MX (3 T + [1] + n); parameters: MX (1 + 2 d K + 2 N): c, the data of the K path rows and of those
    after them, model parameters. `penalised=False` leaves the dissipation out of the derivatives (faster where its
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
        self.lifted = not criteria.separable
        self.structure, self.watch = law.structure, watch or Watch()
        d = self.family.data.shape[1]
        self.size = law.states + self.family.size
        self.variables = ca.MX.sym("variables", 3 * self.steps + self.lifted + self.size)
        self.parameters = ca.MX.sym("parameters", 1 + 2 * d * path_rows + 2 * self.structure.vertices)

    @property
    def gait(self) -> ca.MX:
        """Gait parameters (n)."""
        return self._free[self.law.states :]

    @property
    def _free(self) -> ca.MX:
        """What the shapes depend on: states of the servos, gait parameters."""
        return self.variables[3 * self.steps + self.lifted :]

    @cached_property
    def vertices(self) -> ca.MX:
        """Vertices (2, N (T + 1)) at rows 0 .. T, tail to head, in the body frame of row 0 [body lengths]."""
        if self.family.free:
            angles = self.gait
        else:
            made = self._angles or self._table_layer()
            angles = made.value(self._free, self._data, self.model_parameters)
        table = ca.reshape(angles, len(self.structure.joints), -1)
        return placed_vertices(self.structure, self._cycle.poses, table, self.model_parameters)

    @property
    def head(self) -> ca.MX:
        """Where the head is after the cycle (2,)."""
        return self.vertices[:, -1]

    def __repr__(self) -> str:
        n, g = self.variables.numel(), sum(self.constraint_counts)
        return f"<GaitNLP {n} variables, {g} constraints, {self.steps} steps, {self.structure.vertices} vertices>"

    @property
    def model_parameters(self) -> ca.MX:
        """Edge lengths, weights, anisotropy ratio, shape (2 N,)."""
        return self.parameters[-2 * self.structure.vertices :]

    @property
    def constraint_counts(self) -> tuple[int, int, int]:
        """Numbers of (motion, path, added) constraints; added ones: the criteria's, then gaps, instant by instant."""
        path = 2 * len(self.structure.joints) * self.path_rows
        added = self.criteria.constraints.numel() + (self._along.total if self._along else 0)
        return 3 * self.steps + self.lifted + self._servo_count, path, added

    def split(self, x: Floats) -> tuple[Floats, Floats]:
        """Poses (T, 3) and gait parameters (n,) of a point."""
        n = 3 * self.steps
        return x[:n].reshape(-1, 3), x[n + self.lifted + self.law.states :]

    def functions(self) -> dict[str, ca.Function]:
        """The NLP as named Functions, as `casadi.nlpsol` takes them.

        gait_nlp_objective (variables, parameters) -> f; gait_nlp_constraints -> g; gait_nlp_gradient -> f, gradient;
        gait_nlp_jacobian -> g, J; gait_nlp_hessian (variables, parameters, multiplier of f, multipliers of g) -> upper
        triangle.
        """
        x, p = self.variables, self.parameters
        values, energy = self._values
        f, _ = self._asked
        g = ca.vertcat(self._residual(values), *self._lift(energy), self._path_value, self._asked[1], *self._gaps)
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

    @cached_property
    def _along(self) -> Along | None:
        if not self.watch.points:
            return None
        law = self.law
        serpenoid = law.coordinates == 3 and isinstance(law.blocks, SerpenoidBlocks)
        gaps = tuple(self.criteria.clear_of)
        functions = gap_functions(gaps, law.structure, law.coordinates, serpenoid, self.portable)
        return Along(functions, self.watch, self.steps, self.family.rows)

    @property
    def _gaps(self) -> list[ca.MX]:
        return [self._along.value(self._cycle)] if self._along else []

    # What the steps and the criteria are evaluated at.

    @cached_property
    def _data(self) -> ca.MX:
        return ca.MX(ca.DM(self.family.data.T))

    @cached_property
    def _cycle(self) -> Cycle:
        poses = ca.horzcat(ca.MX.zeros(3, 1), ca.reshape(self.variables[: 3 * self.steps], 3, self.steps))
        layer = self.law.shapes
        shapes = (
            ca.reshape(self.gait, self.law.coordinates, -1)
            if layer is None
            else layer.value(self._free, self._data, self.model_parameters)
        )
        return Cycle(poses, shapes, self.family.closed, self.model_parameters, self.law.settings)

    @cached_property
    def _values(self) -> tuple[ca.MX, ca.MX]:
        values, energies = self.law.blocks.value(self._cycle)
        return values, self.steps * ca.sum2(energies)

    @cached_property
    def _places(self) -> Places:
        return Places(self.steps, self.family.rows, self.law.coordinates, self.family.closed)

    @cached_property
    def _angles(self) -> Layer | None:
        """The layer of the joint table, where the criteria ask for it and the shapes are something else."""
        if not self.criteria.needs(self.criteria.angles):
            return None
        return None if self.family.free and not self.law.states else self._table_layer()

    def _table_layer(self) -> Layer:
        return self.law.behind(table_layer(self.law.family, self.structure, self.portable))

    @cached_property
    def _asked_at(self) -> list[ca.MX]:
        """Arguments of the criteria's functions."""
        c, size = self.criteria, self.criteria.angles.numel()
        if self._angles is not None:
            angles = ca.vec(self._angles.value(self._free, self._data, self.model_parameters))
        else:
            angles = self.gait if c.needs(c.angles) else ca.MX.zeros(size)
        needed = self.lifted or (self.penalised and c.needs(c.dissipation))
        dissipation = self.variables[3 * self.steps] if self.lifted else self._values[1] if needed else ca.MX(0)
        return [self.variables[: 3 * self.steps], angles, dissipation, self.gait, self.parameters[0]]

    @cached_property
    def _asked(self) -> tuple[ca.MX, ca.MX]:
        f, g = self.criteria.function(*self._asked_at)
        return f, g

    @cached_property
    def _derived(self) -> ca.Function:
        """Criteria's inputs, factor, multipliers -> gradient, Jacobian, Hessian by (poses, dissipation, angles, p)."""
        c = self.criteria
        factor, multipliers = ca.SX.sym("factor"), ca.SX.sym("multipliers", c.constraints.numel())
        z = ca.vertcat(c.moved, c.dissipation, c.angles, c.gait)
        lagrangian = factor * c.objective + ca.dot(multipliers, c.constraints)
        outputs = [ca.gradient(c.objective, z), ca.jacobian(c.constraints, z), ca.hessian(lagrangian, z)[0]]
        return ca.Function("criteria_derivatives", [*c.inputs, factor, multipliers], outputs)

    # q = (shapes, joint table, parameters) as far as they are not the same; Psi carries it to the parameters.

    @cached_property
    def _groups(self) -> tuple[int, int, int]:
        """Sizes of (shapes, joint table, parameters) in q; zero where a group is left out."""
        shapes = self.law.coordinates * self.family.rows
        if self.law.shapes is None:
            return shapes, 0, 0  # all three are the same
        table = self.criteria.angles.numel() if self._angles is not None or self.family.free else 0
        return shapes, 0 if self._angles is None else table, self.size

    @cached_property
    def _psi(self) -> ca.MX | None:
        if self.law.shapes is None:
            return None
        at = self._free, self._data, self.model_parameters
        parts = [self.law.shapes.slope(*at)]
        if self._groups[1] and self._angles is not None:
            parts.append(self._angles.slope(*at))
        return ca.vertcat(*parts, ca.MX.eye(self.size))

    def _to_parameters(self, by_q: ca.MX) -> ca.MX:
        return by_q if self._psi is None else by_q @ self._psi

    def _asked_columns(self, matrix: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """A derivative by the criteria's z split into those by poses, dissipation and q (shapes first: none)."""
        n, m = 3 * self.steps, self.criteria.angles.numel()
        poses, dissipation, angles, gait = ca.horzsplit(matrix, [0, n, n + 1, n + 1 + m, matrix.size2()])
        shapes, table, _ = self._groups
        if self.law.shapes is None:
            return poses, dissipation, (angles if angles.numel() and self.family.free else 0) + gait
        if self.law.states:
            gait = ca.horzcat(ca.MX(matrix.size1(), self.law.states), gait)
        elif self.family.free:
            return poses, dissipation, ca.horzcat(ca.MX(matrix.size1(), shapes), angles + gait)
        middle = [angles] if table else []
        return poses, dissipation, ca.horzcat(ca.MX(matrix.size1(), shapes), *middle, gait)

    def _beside(self, by_shapes: ca.MX) -> ca.MX:
        """A derivative by the shapes as one by q."""
        return ca.horzcat(by_shapes, ca.MX(by_shapes.size1(), sum(self._groups) - by_shapes.size2()))

    # Constraints.

    def _residual(self, values: ca.MX) -> ca.MX:
        combine = self.law.combine
        flat = ca.vec(values) if combine is None else combine @ ca.vec(values)
        return flat * self.steps

    def _lift(self, energy: ca.MX) -> list[ca.MX]:
        lifted = [energy - self.variables[3 * self.steps]] if self.lifted else []
        return lifted if self._servos is None else [*lifted, ca.vec(self._servos[0].value(*self._servos[1]))]

    @cached_property
    def _path(self) -> Layer | None:
        if not self.path_rows:
            return None
        return self.law.behind(path_layer(self.family, self.structure, self.path_rows, self.portable))

    @cached_property
    def _servos(self) -> tuple[Layer, tuple[ca.MX, ca.MX, ca.MX]] | None:
        """The equations of servos with memory, and what they are evaluated at."""
        if self.law.played is None:
            return None
        layer, data = self.law.played.equations()
        return layer, (self._free, ca.MX(ca.DM(data.T)), self.model_parameters)

    @property
    def _servo_count(self) -> int:
        return self.law.states

    @cached_property
    def _path_at(self) -> tuple[ca.MX, ca.MX, ca.MX]:
        d = self.family.data.shape[1]
        data = ca.reshape(self.parameters[1 : 1 + 2 * d * self.path_rows], 2 * d, self.path_rows)
        return self._free, data, self.model_parameters

    @property
    def _path_value(self) -> ca.MX:
        return ca.MX(0, 1) if self._path is None else ca.vec(self._path.value(*self._path_at))

    # Derivatives by x = (poses, [dissipation], parameters).

    def _gradient(self) -> ca.MX:
        nothing = ca.MX.zeros(self.criteria.constraints.numel())
        slope = ca.densify(self._derived(*self._asked_at, 1, nothing)[0]).T
        poses, dissipation, by_q = self._asked_columns(slope)
        if not self.lifted and self._needs_energy:
            pose_places, shape_places = self._places.gradient()
            blocks = self.law.blocks.gradient(self._cycle) * self.steps
            poses = poses + dissipation * pose_places(blocks).T
            by_q = by_q + dissipation * self._beside(shape_places(blocks).T)
        u = [poses, dissipation] if self.lifted else [poses]
        return ca.densify(ca.horzcat(*u, self._to_parameters(by_q)).T)

    @property
    def _needs_energy(self) -> bool:
        return self.lifted or (self.penalised and self.criteria.needs(self.criteria.dissipation))

    def _jacobian(self) -> ca.MX:
        blocks = self.law.blocks.jacobian(self._cycle) * self.steps
        by_poses, by_shapes = (places(blocks) for places in self._places.jacobian(self.law.blocks.values))
        if self.law.combine is not None:
            by_poses, by_shapes = self.law.combine @ by_poses, self.law.combine @ by_shapes
        extra = ca.MX(by_poses.size1(), 1)
        rows = [self._row(by_poses, extra, self._beside(by_shapes))]
        if self.lifted:
            pose_places, shape_places = self._places.gradient()
            falls = self.law.blocks.gradient(self._cycle) * self.steps
            rows.append(self._row(pose_places(falls).T, ca.MX(-1), self._beside(shape_places(falls).T)))
        if self._servos is not None:
            slope = self._servos[0].slope(*self._servos[1])
            rows.append(ca.horzcat(ca.MX(slope.size1(), 3 * self.steps + self.lifted), slope))
        if self._path is not None:
            slope = self._path.slope(*self._path_at)
            rows.append(ca.horzcat(ca.MX(slope.size1(), 3 * self.steps + self.lifted), slope))
        if self.criteria.constraints.numel():
            nothing = ca.MX.zeros(self.criteria.constraints.numel())
            rows.append(self._row(*self._asked_columns(self._derived(*self._asked_at, 0, nothing)[1])))
        if self._along:
            gap_poses, gap_shapes = self._along.jacobian(self._cycle)
            rows.append(self._row(gap_poses, ca.MX(gap_poses.size1(), 1), self._beside(gap_shapes)))
        return ca.vertcat(*rows)

    def _row(self, by_poses: ca.MX, by_dissipation: ca.MX, by_q: ca.MX) -> ca.MX:
        u = [by_poses, by_dissipation] if self.lifted else [by_poses]
        return ca.horzcat(*u, self._to_parameters(by_q))

    def _hessian(self, factor: ca.MX, multipliers: ca.MX) -> ca.MX:
        motion, path, added = self.constraint_counts
        ends = [0, motion, motion + path, motion + path + self.criteria.constraints.numel(), motion + path + added]
        on_motion, on_path, on_asked, on_gaps = ca.vertsplit(multipliers, ends)
        asked = self._derived(*self._asked_at, factor, on_asked)
        weights, energy = self._step_weights(factor, on_motion, asked)
        slope, blocks = self.law.blocks.hessian(self._cycle, weights, energy)
        force, placed = ca.densify(self._places.gradient()[1](slope)), [(self._places.hessian(), blocks)]
        if self._along:
            gap_force, gap_parts = self._along.hessian(self._cycle, on_gaps)
            force, placed = force + ca.vec(gap_force), placed + gap_parts
        more, start = self._asked_hessian(asked[2]), 3 * self.steps + self.lifted
        total = Upper(start + self.size)
        free = self._psi is None
        for (by_poses, mixed, by_shapes), values in placed:
            beside = [(mixed, 0, start), (by_shapes, start, start)] if free else []
            total.scatter(values, [(by_poses, 0, 0), *beside])
        total.matrix(more[0])
        if self._psi is None:
            mixed, square = more[1:]
        else:
            sums = [sum(same[1:], same[0]) for same in zip(*([p(v) for p in ps[1:]] for ps, v in placed), strict=True)]
            uq = ca.vertcat(self._beside(sums[0]), ca.MX(int(self.lifted), sum(self._groups)))
            mixed = (uq + more[1]) @ self._psi
            square = self._psi.T @ ((self._square(sums[1]) + more[2]) @ self._psi)
            square = square + self._curvature(force, factor, on_asked)
        total.matrix(mixed, 0, start)
        total.matrix(square, start, start)
        if self._servos is not None:
            on_states = ca.reshape(on_motion[3 * self.steps + self.lifted :], -1, self.family.rows)
            total.matrix(self._servos[0].curvature(*self._servos[1], on_states), start, start)
        if self._path is not None:
            on_rows = ca.reshape(on_path, -1, self.path_rows)
            total.matrix(self._path.curvature(*self._path_at, on_rows), start, start)
        return total()

    def _step_weights(self, factor: ca.MX, on_motion: ca.MX, asked: tuple[ca.MX, ...]) -> tuple[ca.MX, ca.MX]:
        """Multipliers of the steps' values (v, T) and the factor of each step's energy (1, T)."""
        residual = on_motion[: 3 * self.steps] * self.steps
        combine = self.law.combine
        flat = residual if combine is None else combine.T @ residual
        if self.lifted:
            energy = on_motion[3 * self.steps] * self.steps
        elif self._needs_energy:
            energy = factor * self.steps * ca.densify(asked[0])[3 * self.steps]
        else:
            energy = ca.MX(0)
        return ca.reshape(flat, self.law.blocks.values, self.steps), ca.repmat(energy, 1, self.steps)

    def _square(self, by_shapes: ca.MX) -> ca.MX:
        rest = sum(self._groups) - by_shapes.size1()
        return ca.diagcat(by_shapes, ca.MX(rest, rest)) if rest else by_shapes

    def _asked_hessian(self, hessian: ca.MX) -> tuple[ca.MX, ca.MX, ca.MX]:
        """The criteria's Hessian as (u by u, u by q, q by q)."""
        poses, dissipation, by_q = self._asked_columns(hessian)
        left = ca.horzcat(poses, dissipation) if self.lifted else poses
        size = 3 * self.steps + self.lifted
        uu, uq = left[:size, :], by_q[:size, :]
        _, _, qq = self._asked_columns(by_q.T)
        return uu, uq, qq

    def _curvature(self, force: ca.MX, factor: ca.MX, on_asked: ca.MX) -> ca.MX:
        """What the layers' own second derivatives add, (n, n)."""
        at = self._free, self._data, self.model_parameters
        layer = self.law.shapes
        total = ca.MX(self.size, self.size)
        if layer is not None and layer.functions.curvature is not None:
            total = total + layer.curvature(*at, ca.reshape(force, self.law.coordinates, -1))
        if self._angles is not None and self._angles.functions.curvature is not None:
            first, jacobian, _ = self._derived(*self._asked_at, factor, on_asked)
            both = factor * first + jacobian.T @ on_asked
            start = 3 * self.steps + 1
            on_angles = ca.densify(both)[start : start + self.criteria.angles.numel()]
            total = total + self._angles.curvature(*at, ca.reshape(on_angles, self.criteria.joints, -1))
        return total
