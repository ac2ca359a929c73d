"""A table row's dissipation elements with first and second derivatives by the shape coordinates (w1, w2, xi).

Every quantity is carried as the coefficients of its second-order Taylor polynomial: value, three first and six second
derivatives. Small functions act on one edge or one vertex and are mapped along the chain (a C loop), so that the
compiled code does not grow with the number of vertices.

Legend: N vertices, M elements, l numbers of one, C = 1, 4 or 10 coefficients for derivatives up to order 0, 1, 2.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.gaits import GaitFamily
from serpenoid.mechanics import kinematics
from serpenoid.mechanics.functions import CSE, split_parameters
from serpenoid.model import Structure

COEFFICIENTS = (1, 4, 10)
PAIRS = [(i, j) for j in range(3) for i in range(j + 1)]


def polynomial(coefficients: ca.SX, d: ca.SX, size: int) -> ca.SX:
    """Value (size,) at the offset d (3,) of the polynomial whose coefficients are stacked in blocks of `size`."""
    monomials = [ca.SX(1), *ca.vertsplit(d), *(d[i] * d[j] * (0.5 if i == j else 1.0) for i, j in PAIRS)]
    parts = ca.vertsplit(coefficients, size)
    return sum((part * monomial for part, monomial in zip(parts, monomials, strict=False)), ca.SX.zeros(size))


def gait_row(structure: Structure, order: int) -> ca.Function:
    """(coordinates (3), parameters) -> elements with derivatives up to `order`, shape (l C, M).

    An element: its position above its unit tangent (l = 4), where `order` is two above the tangent's direction (l = 3).
    """
    n, c = structure.vertices, COEFFICIENTS[order]
    coordinates, parameters = ca.MX.sym("coordinates", 3), ca.MX.sym("parameters", 2 * n)
    edges, weights, _ = split_parameters(parameters, structure)
    psi = _along(_direction(order), len(structure.links), [0])(coordinates, link_midpoints(structure)(parameters))
    psi = psi[:, [i for i, group in enumerate(structure.links) for _ in group]]
    psi -= ca.repmat(ca.sum2(psi) / (n - 1), 1, n - 1)
    at_vertices = structure.dissipation == "vertex"
    # the tangent at a vertex halves the angle between its edges (its sign does not matter)
    middle = (ca.horzcat(psi[:, :1], psi) + ca.horzcat(psi, psi[:, -1:])) / 2 if at_vertices else psi
    unit = _along(_unit(order), n - 1, [])(psi)
    turned = _along(_unit(order), n, [])(middle) if at_vertices else unit
    tangents = middle if order == 2 else turned
    one = _chain(n)
    chain = ca.vertcat(*(one(unit[2 * k : 2 * k + 2, :], edges) for k in range(c)))
    points = chain - ca.repmat(chain @ weights, 1, n)
    if structure.dissipation == "edge":
        points = (points[:, 1:] + points[:, :-1]) / 2
    elements = _interleave(points, tangents, c)
    return ca.Function(f"gait_row_{order}", [coordinates, parameters], [elements])


def _along(function: ca.Function, count: int, shared: list[int]) -> ca.Function:
    return function.map(f"{function.name()}_{count}", "serial", count, shared, [])


def _chain(n: int) -> ca.Function:
    """Vertices (2, N) from unit edges (2, N - 1) and edge lengths; vertex 0 at the origin. Linear: any coefficient."""
    unit, edges = ca.SX.sym("unit", 2, n - 1), ca.SX.sym("edges", n - 1)
    points = [ca.SX.zeros(2, 1)]
    for j in range(n - 1):
        points.append(points[-1] + edges[j] * unit[:, j])
    return ca.Function("chain", [unit, edges], [ca.densify(ca.horzcat(*points))])


def _interleave(positions: ca.MX, tangents: ca.MX, c: int) -> ca.MX:
    """Blocks of (position, tangent) per coefficient from stacks of both."""
    size = tangents.size1() // c
    order = [row for k in range(c) for row in (2 * k, 2 * k + 1, *range(2 * c + size * k, 2 * c + size * (k + 1)))]
    return ca.vertcat(positions, tangents)[order, :]


def link_midpoints(structure: Structure) -> ca.Function:
    """parameters -> midpoints of the rigid links along the body, shape (1, m + 1)."""
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    edges, _, _ = split_parameters(parameters, structure)
    return ca.Function("link_midpoints", [parameters], [kinematics.link_midpoints(edges, structure).T])


def joint_functions(family: GaitFamily, structure: Structure, changes: bool) -> list[ca.Function]:
    """Joint angles (m) of a row by the parameters of a serpenoid family: value, slope, curvature; a loop over joints.

    changes: the row's data are followed by those of the next row, and the changes to it by the angles: (2 m).
    """
    m, k, d = len(structure.joints), family.indices.shape[1], family.data.shape[1]
    q, data = ca.MX.sym("q", k), ca.MX.sym("data", d * (1 + changes))
    parameters, multipliers = (
        ca.MX.sym("parameters", 2 * structure.vertices),
        ca.MX.sym("multipliers", m * (1 + changes)),
    )
    middle = link_midpoints(structure)(parameters)
    value, jacobian, hessian = _joint(family, changes)
    common, ends = [q, data], [middle[:, :-1], middle[:, 1:]]
    values = value.map("joints", "serial", m, [0, 1], [])(*common, *ends)
    slopes = jacobian.map("joints_jacobian", "serial", m, [0, 1], [])(*common, *ends)
    columns = ca.reshape(multipliers, m, 1 + changes).T
    total = hessian.map("joints_hessian", "serial", m, [0, 1], [0])(*common, *ends, columns)
    stacked = ca.vertcat(*(ca.reshape(slopes[i, :], k, m).T for i in range(1 + changes)))
    inputs = [q, data, parameters]
    return [
        ca.Function("gait_path", inputs, [ca.vec(values.T)]),
        ca.Function("gait_path_jacobian", inputs, [stacked]),
        ca.Function("gait_path_hessian", [*inputs, multipliers], [total]),
    ]


def _joint(family: GaitFamily, changes: bool) -> list[ca.Function]:
    """Angle of the joint between links with midpoints s0, s1 (and its change), Jacobian, Hessian by q."""
    k, d = family.indices.shape[1], family.data.shape[1]
    q, data, s0, s1 = ca.SX.sym("q", k), ca.SX.sym("data", d * (1 + changes)), ca.SX.sym("s0"), ca.SX.sym("s1")

    def angle(row: ca.SX) -> ca.SX:
        modes = ca.vertsplit(family.at(q, row), 3)
        bends = (kinematics.serpenoid_direction(v, s1) - kinematics.serpenoid_direction(v, s0) for v in modes)
        return sum(bends, ca.SX(0))

    here, inputs = angle(data[:d]), [q, data, s0, s1]
    found = ca.vertcat(here, angle(data[d:]) - here) if changes else here
    multipliers = ca.SX.sym("multipliers", found.numel())
    hessian = ca.densify(ca.hessian(ca.dot(multipliers, found), q)[0])
    return [
        ca.Function("joint", inputs, [found], CSE),
        ca.Function("joint_jacobian", inputs, [ca.densify(ca.jacobian(found, q))], CSE),
        ca.Function("joint_hessian", [*inputs, multipliers], [hessian], CSE),
    ]


def _taylor(value: ca.SX, d: ca.SX, order: int) -> ca.SX:
    """Coefficients at d = 0 of an expression in d, stacked in blocks."""
    first = ca.jacobian(value, d)
    second = [ca.jacobian(first[:, j], d)[:, i] for i, j in PAIRS]
    blocks = [value, *ca.horzsplit(first), *second][: COEFFICIENTS[order]]
    return ca.densify(ca.substitute(ca.vertcat(*blocks), d, ca.SX.zeros(3)))


def _direction(order: int) -> ca.Function:
    """Direction of the edge whose link has its midpoint at s: psi(s), the integral of the serpenoid curvature."""
    v, s, d = ca.SX.sym("v", 3), ca.SX.sym("s"), ca.SX.sym("d", 3)
    psi = kinematics.serpenoid_direction(v + d, s)
    return ca.Function(f"direction_{order}", [v, s], [_taylor(psi, d, order)], CSE)


def _unit(order: int) -> ca.Function:
    """(cos psi, sin psi) from the coefficients of psi."""
    psi, d = ca.SX.sym("psi", COEFFICIENTS[order]), ca.SX.sym("d", 3)
    angle = polynomial(psi, d, 1)
    return ca.Function(f"unit_{order}", [psi], [_taylor(ca.vertcat(ca.cos(angle), ca.sin(angle)), d, order)], CSE)
