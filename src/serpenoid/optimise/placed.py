"""Where the vertices of a cycle stand, in symbols: for objectives and checks of one's own on an opened NLP."""

from __future__ import annotations

import casadi as ca

from serpenoid.mechanics import energy, functions
from serpenoid.model import Structure


def placed_vertices(structure: Structure, poses: ca.MX, angles: ca.MX, parameters: ca.MX) -> ca.MX:
    """Vertices (2, N (T + 1)) of poses (3, T + 1) and joint angles (m, R), row by row; after the last the first."""
    count, rows = poses.size2(), angles.size2()
    every = ca.horzcat(angles, angles[:, : count - rows])
    chains = functions.shape(structure).map(count)(every, ca.repmat(parameters, 1, count))[0]
    pose, body = ca.SX.sym("pose", 3), ca.SX.sym("body", 2, structure.vertices)
    return ca.Function("placed", [pose, body], [energy.placed(pose, body)]).map(count)(poses, chains)
