"""Where the vertices of a cycle stand, in symbols: for objectives and checks of one's own on an opened NLP."""

from __future__ import annotations

import casadi as ca

from serpenoid.mechanics import functions
from serpenoid.model import Structure


def placed_vertices(structure: Structure, poses: ca.MX, angles: ca.MX, parameters: ca.MX) -> ca.MX:
    """Vertices (2, N (T + 1)) of poses (3, T + 1) and joint angles (m, R), row by row; after the last the first."""
    count, rows = poses.size2(), angles.size2()
    every = ca.horzcat(angles, angles[:, : count - rows])
    chains = functions.shape(structure).map(count)(every, ca.repmat(parameters, 1, count))[0]
    angle = ca.SX.sym("angle")
    c, s = ca.cos(angle), ca.sin(angle)
    place, body = ca.SX.sym("place", 2), ca.SX.sym("body", 2, structure.vertices)
    rotation = ca.vertcat(ca.horzcat(c, -s), ca.horzcat(s, c))
    moved = rotation @ body + ca.repmat(place, 1, structure.vertices)
    return ca.Function("placed", [place, angle, body], [moved]).map(count)(poses[:2, :], poses[2, :], chains)
