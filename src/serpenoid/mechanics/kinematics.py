"""Chain kinematics: shape coordinates -> joint angles -> vertices in the body frame -> dissipation elements.

kappa(s) = w1 sin(2 pi xi s) + w2 cos(2 pi xi s);  psi(s) = integral of kappa;  joint angle = psi_{j+1} - psi_j.
The body frame has its origin at the weighted centroid and its first axis along the mean edge angle.

Legend: N vertices, m joints, M elements; everything is casadi.SX. Source: Even et al., Sec. III; docs/theory.md.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.gaits import GaitFamily
from serpenoid.model import Structure


def family_joint_angles(family: GaitFamily, p: ca.SX, data: ca.SX, edges: ca.SX, structure: Structure) -> ca.SX:
    """Joint angles (m) of a row of a family's table, from the parameters it depends on (k) and its data (d)."""
    coordinates = family.at(p, data)
    if family.coordinates == "serpenoid":
        modes = ca.vertsplit(coordinates, 3)
        return sum((serpenoid_joint_angles(mode, edges, structure) for mode in modes), ca.SX(0))
    return coordinates


def serpenoid_joint_angles(coordinates: ca.SX, edges: ca.SX, structure: Structure) -> ca.SX:
    """Joint angles (m) of the serpenoid curve with coordinates (w1, w2, xi)."""
    psi = serpenoid_direction(coordinates, link_midpoints(edges, structure))
    return psi[1:] - psi[:-1]


def serpenoid_direction(coordinates: ca.SX, s: ca.SX) -> ca.SX:
    """psi(s), the integral of the curvature from the tail to s."""
    w1, w2, xi = ca.vertsplit(coordinates)
    k = 2 * ca.pi * xi
    return w1 * (1 - ca.cos(k * s)) / k + w2 * ca.sin(k * s) / k


def vertices(joint_angles: ca.SX, edges: ca.SX, weights: ca.SX, structure: Structure) -> tuple[ca.SX, ca.SX]:
    """Vertices (2, N) and unit edges (2, N - 1) in the body frame."""
    link = [ca.SX(0)]
    for j in range(len(structure.joints)):
        link.append(link[-1] + joint_angles[j])
    psi = ca.vertcat(*(link[i] for i, group in enumerate(structure.links) for _ in group))
    psi -= ca.sum1(psi) / (structure.vertices - 1)
    unit = ca.horzcat(ca.cos(psi), ca.sin(psi)).T
    points = [ca.SX.zeros(2, 1)]
    for j in range(structure.vertices - 1):
        points.append(points[-1] + edges[j] * unit[:, j])
    chain = ca.horzcat(*points)
    return chain - chain @ weights, unit


def unit_edges(points: ca.SX) -> ca.SX:
    """Unit edge vectors (d, N - 1) of a chain with vertices `points` (d, N)."""
    edge = points[:, 1:] - points[:, :-1]
    return ca.horzcat(*(_normalised(column) for column in ca.horzsplit(edge)))


def elements(points: ca.SX, unit: ca.SX, structure: Structure) -> ca.SX:
    """Dissipation elements of a chain: positions above unit tangents, shape (2 d, M).

    At vertices the tangent is the normalised sum of the adjacent unit edges; an end vertex has its one edge's.
    """
    if structure.dissipation == "edge":
        return ca.vertcat((points[:, 1:] + points[:, :-1]) / 2, unit)
    sums = ca.horzsplit(unit[:, 1:] + unit[:, :-1])
    tangents = [unit[:, 0], *(_normalised(column) for column in sums), unit[:, -1]]
    return ca.vertcat(points, ca.horzcat(*tangents))


def element_weights(weights: ca.SX, edges: ca.SX, structure: Structure) -> ca.SX:
    """Weights (M) of the dissipation elements; a vertex shares its weight among its edges in proportion to length."""
    if structure.dissipation == "vertex":
        return weights
    n = structure.vertices
    around = [sum((edges[j] for j in (k - 1, k) if 0 <= j < n - 1), ca.SX(0)) for k in range(n)]
    return ca.vertcat(*(edges[j] * sum(weights[k] / around[k] for k in (j, j + 1)) for j in range(n - 1)))


def link_midpoints(edges: ca.SX, structure: Structure) -> ca.SX:
    """Midpoints of the rigid links along the body, shape (m + 1,)."""
    ends = ca.vertcat(0, ca.cumsum(edges))
    return ca.vertcat(*((ends[group[0]] + ends[group[-1] + 1]) / 2 for group in structure.links))


def _normalised(vector: ca.SX) -> ca.SX:
    return vector / ca.norm_2(vector)
