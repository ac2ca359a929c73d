"""One step of the gait NLP with exact first and second derivatives, in three small layers.

    gait q, phase  --coordinates-->  (w1, w2, xi) per row       (compose: 12 -> 9 variables, cheap)
    (w1, w2, xi)   --row_shape-->    elements, with first and second derivatives (once per row)
    elements, relative pose --element--> one summand of energy and momentum, mapped over the elements (a C loop)

The layers keep the compiled code small and the shape kinematics out of the pose derivatives. The residual is dE/d pose
in the relative pose's own coordinates: its roots are those of the geometric momentum.

Legend: M elements, q gait (6), g pose (3), z = (relative pose h (3), row t (3), row t + 1 (3)): 9 local variables.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from serpenoid.mechanics import energy, kinematics
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.functions import CSE, element_parameters
from serpenoid.model import Structure
from serpenoid.optimise.rows import COEFFICIENTS, gait_row, link_midpoints, polynomial

LOCAL = 9  # h, coordinates of row t, coordinates of row t + 1
GAIT = 6
OUTER = 6 + GAIT  # g_t, g_{t+1}, q
ROW = tuple(4 * c for c in COEFFICIENTS)  # an element's values; with first; with second derivatives by (w1, w2, xi)


@dataclass(frozen=True)
class StepBlocks:
    """Compiled functions of one step; inputs g_t, g_{t+1}, q, phase_t, phase_{t+1}, row_t, row_{t+1}, ..., parameters.

    rows:     by order of derivatives 0, 1, 2: (q, phase, parameters) -> (4, M), (16, M), (40, M)
    value:    -> residual (3), energy
    gradient: -> d energy (1, 12)
    jacobian: -> d residual (3, 12)
    hessian:  (..., multipliers (3), energy multiplier, parameters) -> upper triangle by columns (78)
    path:     (q, phase, phase of the next row, parameters) -> joint angles and their change (2 m)
    """

    rows: tuple[ca.Function, ca.Function, ca.Function]
    value: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    path: ca.Function
    path_jacobian: ca.Function
    path_hessian: ca.Function


@lru_cache(maxsize=16)
def step_blocks(structure: Structure) -> StepBlocks:
    """The functions of `structure`, compiled where possible."""
    return _named(compiled(_all(structure)))


@lru_cache(maxsize=16)
def portable_step_blocks(structure: Structure) -> StepBlocks:
    """The same functions as they are: no reference to a compiled library on this machine."""
    return _named(_all(structure))


def _all(structure: Structure) -> list[ca.Function]:
    rows = [gait_row(structure, order) for order in range(len(ROW))]
    return [*rows, *_steps(structure), *_path(structure)]


def _named(functions: list[ca.Function]) -> StepBlocks:
    first, second, third, *others = functions
    return StepBlocks((first, second, third), *others)


def upper(n: int) -> list[tuple[int, int]]:
    """Index pairs (i, j), i <= j, column by column."""
    return [(i, j) for j in range(n) for i in range(j + 1)]


def _steps(structure: Structure) -> list[ca.Function]:
    """value, gradient, jacobian, hessian of one step: sums over the elements, then the chain rule to (g, g', q)."""
    m = structure.elements
    outer = [ca.MX.sym("g0", 3), ca.MX.sym("g1", 3), ca.MX.sym("q", 6), ca.MX.sym("t0"), ca.MX.sym("t1")]
    rows = [[ca.MX.sym("r0", size, m), ca.MX.sym("r1", size, m)] for size in ROW]
    parameters = ca.MX.sym("parameters", 2 * structure.vertices)
    multipliers, factor = ca.MX.sym("multipliers", 3), ca.MX.sym("factor")
    weights, eps = element_parameters(structure)(parameters)
    local, local_jacobian, compose = _composition()
    h, sensitivity = local(*outer)[:3], local_jacobian(*outer)

    def total(function: ca.Function, order: int, *more: ca.MX) -> tuple[ca.MX, ...]:
        shared = [2, *range(3, 3 + len(more)), function.n_in() - 1]
        name, outputs = f"all_{function.name()}", list(range(function.n_out()))
        summed = function.map(name, "serial", m, shared, outputs)(*rows[order], h, *more, weights.T, eps)
        return summed if isinstance(summed, tuple) else (summed,)

    value, gradient, jacobian, hessian = _element()
    slope, curvature = total(hessian, 2, multipliers, factor)
    return [
        ca.Function("gait_value", [*outer, *rows[0], parameters], list(total(value, 0))),
        ca.Function("gait_gradient", [*outer, *rows[1], parameters], [total(gradient, 1)[0] @ sensitivity]),
        ca.Function("gait_jacobian", [*outer, *rows[1], parameters], [total(jacobian, 1)[0] @ sensitivity]),
        ca.Function(
            "gait_hessian",
            [*outer, *rows[2], multipliers, factor, parameters],
            [compose(*outer, slope, curvature)],
        ),
    ]


def _element() -> list[ca.Function]:
    """Value, gradient, Jacobian and Hessian of one element's share, from the Taylor polynomials of its two rows."""
    h, w, eps = ca.SX.sym("h", 3), ca.SX.sym("w"), ca.SX.sym("eps")
    d0, d1 = ca.SX.sym("d0", 3), ca.SX.sym("d1", 3)
    multipliers, factor = ca.SX.sym("multipliers", 3), ca.SX.sym("factor")
    z, zero = ca.vertcat(h, d0, d1), ca.vertcat(h, ca.SX.zeros(6))

    def share(order: int) -> tuple[list[ca.SX], ca.SX]:
        r0, r1 = ca.SX.sym("r0", ROW[order]), ca.SX.sym("r1", ROW[order])
        after = energy.move(h, polynomial(r1, d1, 4))
        return [r0, r1, h], energy.element_energy(polynomial(r0, d0, 4), after, w, eps)

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        at_row = [ca.densify(ca.substitute(expression, z, zero)) for expression in outputs]
        return ca.Function(f"element_{name}", [*inputs, w, eps], at_row, CSE)

    (rows0, plain), (rows1, linear), (rows2, quadratic) = share(0), share(1), share(2)
    lagrangian = ca.dot(multipliers, ca.gradient(quadratic, h)) + factor * quadratic
    curvature, slope = ca.hessian(lagrangian, z)
    packed = ca.vertcat(*(curvature[i, j] for i, j in upper(LOCAL)))
    return [
        function("value", rows0, [ca.gradient(plain, h), plain]),
        function("gradient", rows1, [ca.jacobian(linear, z)]),
        function("jacobian", rows1, [ca.jacobian(ca.gradient(linear, h), z)]),
        function("hessian", [*rows2, multipliers, factor], [slope, packed]),
    ]


def _composition() -> tuple[ca.Function, ca.Function, ca.Function]:
    """Local variables z from (g_t, g_{t+1}, q), their Jacobian, and the Hessian's chain rule."""
    g0, g1, q = ca.SX.sym("g0", 3), ca.SX.sym("g1", 3), ca.SX.sym("q", 6)
    t0, t1 = ca.SX.sym("t0"), ca.SX.sym("t1")
    back = energy.planar_rotation(g0[2]).T @ (g1[:2] - g0[:2])
    rows = [kinematics.ellipse_coordinates(q, t) for t in (t0, t1)]
    z, outer = ca.vertcat(back, g1[2] - g0[2], *rows), ca.vertcat(g0, g1, q)
    inputs = [g0, g1, q, t0, t1]
    sensitivity = ca.jacobian(z, outer)
    slope, packed = ca.SX.sym("slope", LOCAL), ca.SX.sym("packed", len(upper(LOCAL)))
    inner = ca.SX.zeros(LOCAL, LOCAL)
    for (i, j), value in zip(upper(LOCAL), ca.vertsplit(packed), strict=True):
        inner[i, j] = inner[j, i] = value
    total = sensitivity.T @ inner @ sensitivity + ca.hessian(ca.dot(slope, z), outer)[0]
    result = ca.vertcat(*(total[i, j] for i, j in upper(OUTER)))
    return (
        ca.Function("local", inputs, [z], CSE),
        ca.Function("local_jacobian", inputs, [ca.densify(sensitivity)], CSE),
        ca.Function("compose", [*inputs, slope, packed], [ca.densify(result)], CSE),
    )


def _path(structure: Structure) -> list[ca.Function]:
    """Joint angles of a row and their change to the next, (2 m), with derivatives by q: a loop over the joints."""
    m = len(structure.joints)
    q, t0, t1 = ca.MX.sym("q", 6), ca.MX.sym("t0"), ca.MX.sym("t1")
    parameters, multipliers = ca.MX.sym("parameters", 2 * structure.vertices), ca.MX.sym("multipliers", 2 * m)
    middle = link_midpoints(structure)(parameters)
    value, jacobian, hessian = _joint()
    common, ends = [q, t0, t1], [middle[:, :-1], middle[:, 1:]]
    values = value.map("joints", "serial", m, [0, 1, 2], [])(*common, *ends)
    slopes = jacobian.map("joints_jacobian", "serial", m, [0, 1, 2], [])(*common, *ends)
    both = ca.reshape(multipliers, m, 2).T
    total = hessian.map("joints_hessian", "serial", m, [0, 1, 2], [0])(*common, *ends, both)
    stacked = ca.vertcat(*(ca.reshape(part, GAIT, m).T for part in (slopes[0, :], slopes[1, :])))
    inputs = [q, t0, t1, parameters]
    return [
        ca.Function("gait_path", inputs, [ca.vec(values.T)]),
        ca.Function("gait_path_jacobian", inputs, [stacked]),
        ca.Function("gait_path_hessian", [*inputs, multipliers], [total]),
    ]


def _joint() -> list[ca.Function]:
    """Angle of the joint between links with midpoints s0, s1 at two phases: (angle, change), Jacobian, Hessian by q."""
    q, t0, t1, s0, s1 = ca.SX.sym("q", GAIT), *(ca.SX.sym(name) for name in ("t0", "t1", "s0", "s1"))
    multipliers = ca.SX.sym("multipliers", 2)

    def angle(phase: ca.SX) -> ca.SX:
        v = kinematics.ellipse_coordinates(q, phase)
        return kinematics.serpenoid_direction(v, s1) - kinematics.serpenoid_direction(v, s0)

    here, inputs = angle(t0), [q, t0, t1, s0, s1]
    pair = ca.vertcat(here, angle(t1) - here)
    hessian = ca.densify(ca.hessian(ca.dot(multipliers, pair), q)[0])
    return [
        ca.Function("joint", inputs, [pair], CSE),
        ca.Function("joint_jacobian", inputs, [ca.densify(ca.jacobian(pair, q))], CSE),
        ca.Function("joint_hessian", [*inputs, multipliers], [hessian], CSE),
    ]
