"""A row's elements over joint angles: where they are, and how each angle moves them.

    places w = (x, y, direction of its tangent[, of its link]) of the elements in the body frame

Directions psi of the edges are linear in the angles, positions are B (cos psi, sin psi) with B constant in the angles.
Legend: N vertices, n = N - 1 edges, M elements, m joints, l numbers per place (3 or 4).
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics import kinematics
from serpenoid.mechanics.functions import CSE, split_parameters
from serpenoid.model import Structure


def directions(structure: Structure, links: bool) -> tuple[Floats, list[Floats]]:
    """Constant matrices: edge directions psi (n, m) by joint angles; tangent (and link) directions (M, n) by psi."""
    n, group = structure.vertices - 1, np.zeros(structure.vertices - 1)
    for i, edges in enumerate(structure.links):
        group[list(edges)] = i
    psi = (group[:, None] > np.arange(len(structure.joints))[None]).astype(float)
    psi -= psi.mean(0)
    if structure.dissipation == "edge":
        return psi, [np.eye(n)] * (1 + links)
    ahead, behind = np.vstack([np.eye(n), np.eye(n)[-1:]]), np.vstack([np.eye(n)[:1], np.eye(n)])
    return psi, [(ahead + behind) / 2, *([behind] if links else [])]


def placement(structure: Structure, parameters: ca.MX) -> ca.MX:
    """B (N, n): vertices in the body frame are B times the unit edges."""
    edges, weights, _ = split_parameters(parameters, structure)
    n = structure.vertices - 1
    reach = ca.DM(np.tril(np.ones((n + 1, n)), -1))  # vertex k lies behind edges 0 .. k - 1
    return (reach - ca.repmat(weights.T @ reach, n + 1, 1)) * ca.repmat(edges.T, n + 1, 1)


def row_function(structure: Structure, place: int) -> ca.Function:
    """(angles (m), parameters) -> w (l, M) and the twists of the joints (4, m), see `joint_twists`."""
    angles = ca.SX.sym("angles", len(structure.joints))
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    edges, weights, _ = split_parameters(parameters, structure)
    vertices, _ = kinematics.vertices(angles, edges, weights, structure)
    points = vertices if structure.dissipation == "vertex" else (vertices[:, 1:] + vertices[:, :-1]) / 2
    psi = _edge_directions(angles, structure)
    _, others = directions(structure, links=place == 4)
    w = ca.vertcat(points, *((ca.sparsify(ca.DM(matrix)) @ psi).T for matrix in others))
    twists = _twists(vertices, weights, structure)
    return ca.Function("joint_row", [angles, parameters], [ca.densify(w), ca.densify(twists)], CSE)


def _edge_directions(angles: ca.SX, structure: Structure) -> ca.SX:
    """psi (n), central."""
    turns = ca.cumsum(ca.vertcat(0, angles))
    psi = ca.vertcat(*(turns[i] for i, group in enumerate(structure.links) for _ in group))
    return psi - ca.sum1(psi) / psi.numel()


def _twists(vertices: ca.SX, weights: ca.SX, structure: Structure) -> ca.SX:
    """(-J p_j, J tau_j) of every joint: where it is, and how far the centroid comes when what is beyond it moves."""
    columns: list[ca.SX] = []
    moment, mass = ca.SX.zeros(2), ca.SX(0)
    for k in range(structure.vertices - 1, 0, -1):
        if k in structure.joints:
            at = vertices[:, k]
            shift = moment - mass * at
            columns.insert(0, ca.vertcat(at[1], -at[0], -shift[1], shift[0]))
        moment, mass = moment + weights[k] * vertices[:, k], mass + weights[k]
    return ca.horzcat(*columns)
