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
from serpenoid.mechanics.functions import CSE, split_parameters
from serpenoid.model import Structure

LOCAL = 9  # h, coordinates of row t, coordinates of row t + 1
OUTER = 12  # g_t, g_{t+1}, q
ROW = 4 * (1 + 3 + 6)  # an element's values, first and second derivatives by (w1, w2, xi)


@dataclass(frozen=True)
class StepBlocks:
    """Compiled functions of one step; inputs g_t, g_{t+1}, q, phase_t, phase_{t+1}, row_t, row_{t+1}, ..., parameters.

    row:      (q, phase, parameters) -> (40, M)
    value:    -> residual (3), energy
    jacobian: -> d residual (3, 12), d energy (1, 12)
    hessian:  (..., multipliers (3), energy multiplier, parameters) -> upper triangle by columns (78)
    path:     (q, phase, phase of the next row, parameters) -> joint angles and their change (2 m)
    """

    row: ca.Function
    value: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    path: ca.Function
    path_jacobian: ca.Function
    path_hessian: ca.Function


@lru_cache(maxsize=16)
def step_blocks(structure: Structure) -> StepBlocks:
    """The functions of `structure`, compiled where possible."""
    return StepBlocks(*compiled([_row(structure), *_steps(structure), *_path(structure)]))


def upper(n: int) -> list[tuple[int, int]]:
    """Index pairs (i, j), i <= j, column by column."""
    return [(i, j) for j in range(n) for i in range(j + 1)]


def _row(structure: Structure) -> ca.Function:
    v, parameters = ca.SX.sym("v", 3), ca.SX.sym("parameters", 2 * structure.vertices)
    q, phase = ca.SX.sym("q", 6), ca.SX.sym("phase")
    edges, weights, _ = split_parameters(parameters, structure)
    angles = kinematics.serpenoid_joint_angles(v, edges, structure)
    points, unit = kinematics.vertices(angles, edges, weights, structure)
    values = ca.vec(kinematics.elements(points, unit, structure))
    first = ca.jacobian(values, v)
    second = [ca.jacobian(first[:, j], v)[:, : j + 1] for j in range(3)]
    m = structure.elements
    table = ca.vertcat(*(ca.reshape(c, 4, m) for c in ca.horzsplit(ca.densify(ca.horzcat(values, first, *second)))))
    inner = ca.Function("row_shape", [v, parameters], [table], CSE)
    return ca.Function("gait_row", [q, phase, parameters], [inner(kinematics.ellipse_coordinates(q, phase), parameters)])


def _steps(structure: Structure) -> list[ca.Function]:
    m = structure.elements
    g0, g1, q = ca.MX.sym("g0", 3), ca.MX.sym("g1", 3), ca.MX.sym("q", 6)
    t0, t1 = ca.MX.sym("t0"), ca.MX.sym("t1")
    r0, r1 = ca.MX.sym("r0", ROW, m), ca.MX.sym("r1", ROW, m)
    parameters = ca.MX.sym("parameters", 2 * structure.vertices)
    multipliers, factor = ca.MX.sym("multipliers", 3), ca.MX.sym("factor")
    weights, eps = _element_parameters(structure)(parameters)
    local, local_jacobian, compose = _composition()
    h = local(g0, g1, q, t0, t1)[:3]
    common = [g0, g1, q, t0, t1, r0, r1]

    def over_elements(function: ca.Function, shared: list[int]) -> ca.Function:
        outputs = list(range(function.n_out()))
        return function.map(f"all_{function.name()}", "serial", m, shared, outputs)

    value, jacobian, hessian = _element()
    gradient, total = over_elements(value, [2, 4])(r0[:4, :], r1[:4, :], h, weights.T, eps)
    slopes, energy_slope = over_elements(jacobian, [2, 4])(r0, r1, h, weights.T, eps)
    sensitivity = local_jacobian(g0, g1, q, t0, t1)
    slope, curvature = over_elements(hessian, [2, 3, 4, 6])(r0, r1, h, multipliers, factor, weights.T, eps)
    outer = compose(g0, g1, q, t0, t1, slope, curvature)
    return [
        ca.Function("gait_value", [*common, parameters], [gradient, total]),
        ca.Function("gait_jacobian", [*common, parameters], [slopes @ sensitivity, energy_slope @ sensitivity]),
        ca.Function("gait_hessian", [*common, multipliers, factor, parameters], [outer]),
    ]


def _element() -> tuple[ca.Function, ca.Function, ca.Function]:
    """Value, Jacobian and Hessian of one element's share, from the Taylor polynomials of its two rows."""
    h, w, eps = ca.SX.sym("h", 3), ca.SX.sym("w"), ca.SX.sym("eps")
    r0, r1 = ca.SX.sym("r0", ROW), ca.SX.sym("r1", ROW)
    d0, d1 = ca.SX.sym("d0", 3), ca.SX.sym("d1", 3)
    multipliers, factor = ca.SX.sym("multipliers", 3), ca.SX.sym("factor")
    share = energy.element_energy(_taylor(r0, d0), energy.move(h, _taylor(r1, d1)), w, eps)
    residual = ca.gradient(share, h)
    z, zero = ca.vertcat(h, d0, d1), ca.vertcat(h, ca.SX.zeros(6))

    def at_row(expression: ca.SX) -> ca.SX:
        return ca.densify(ca.substitute(expression, z, zero))

    lagrangian = ca.dot(multipliers, residual) + factor * share
    curvature, slope = ca.hessian(lagrangian, z)
    b0, b1 = ca.SX.sym("b0", 4), ca.SX.sym("b1", 4)
    bare = energy.element_energy(b0, energy.move(h, b1), w, eps)
    packed = ca.vertcat(*(curvature[i, j] for i, j in upper(LOCAL)))
    return (
        ca.Function("element_value", [b0, b1, h, w, eps], [ca.gradient(bare, h), bare], CSE),
        ca.Function(
            "element_jacobian", [r0, r1, h, w, eps], [at_row(ca.jacobian(residual, z)), at_row(ca.jacobian(share, z))], CSE
        ),
        ca.Function("element_hessian", [r0, r1, h, multipliers, factor, w, eps], [at_row(slope), at_row(packed)], CSE),
    )


def _taylor(row: ca.SX, d: ca.SX) -> ca.SX:
    """Second-order polynomial of one element (position, tangent) in its row's shape coordinates."""
    value, index = row[:4], 4
    for j in range(3):
        value += row[index : index + 4] * d[j]
        index += 4
    for j in range(3):
        for i in range(j + 1):
            value += row[index : index + 4] * (d[i] * d[j] * (0.5 if i == j else 1.0))
            index += 4
    return value


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


def _element_parameters(structure: Structure) -> ca.Function:
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    _, weights, eps = split_parameters(parameters, structure)
    return ca.Function("element_parameters", [parameters], [kinematics.element_weights(weights, structure), eps])


def _path(structure: Structure) -> list[ca.Function]:
    """Joint angles of a row and their change to the next, with derivatives by q."""
    m = len(structure.joints)
    q, t0, t1 = ca.SX.sym("q", 6), ca.SX.sym("t0"), ca.SX.sym("t1")
    parameters, multipliers = ca.SX.sym("parameters", 2 * structure.vertices), ca.SX.sym("multipliers", 2 * m)
    edges, _, _ = split_parameters(parameters, structure)
    here, there = (
        kinematics.serpenoid_joint_angles(kinematics.ellipse_coordinates(q, t), edges, structure) for t in (t0, t1)
    )
    path, inputs = ca.vertcat(here, there - here), [q, t0, t1, parameters]
    hessian = ca.hessian(ca.dot(multipliers, path), q)[0]
    return [
        ca.Function("gait_path", inputs, [path], CSE),
        ca.Function("gait_path_jacobian", inputs, [ca.densify(ca.jacobian(path, q))], CSE),
        ca.Function("gait_path_hessian", [*inputs, multipliers], [ca.densify(hessian)], CSE),
    ]
