"""Where the vertices of a cycle stand, in symbols: for objectives and checks of one's own on an opened NLP."""

from __future__ import annotations

import casadi as ca

from serpenoid.gaits.lifted import Lift
from serpenoid.mechanics import functions
from serpenoid.model import Structure
from serpenoid.objectives import frames


def placed_vertices(structure: Structure, poses: ca.MX, angles: ca.MX, parameters: ca.MX) -> ca.MX:
    """Vertices (2, N (T + 1)) of poses (3, T + 1) and joint angles (m, R), row by row; after the last the first."""
    return _placed(functions.shape(structure), poses, angles, parameters)


def placed_lifted_vertices(
    structure: Structure, lift: Lift, poses: ca.MX, coordinates: ca.MX, parameters: ca.MX
) -> ca.MX:
    """Vertices (3, N (T + 1)) of poses (6, T + 1) and coordinates of both waves (5, R), likewise."""
    return _placed(functions.lifted_row(structure, lift), poses, coordinates, parameters)


def _placed(body: ca.Function, poses: ca.MX, rows: ca.MX, parameters: ca.MX) -> ca.MX:
    """What `body` makes of rows and parameters first, placed."""
    count = poses.size2()
    every = ca.horzcat(rows, rows[:, : count - rows.size2()])
    chains = body.map(count)(every, ca.repmat(parameters, 1, count))[0]
    pose, points = ca.SX.sym("pose", poses.size1()), ca.SX.sym("points", *body.size_out(0))
    return ca.Function("placed", [pose, points], [frames.placed(pose, points)]).map(count)(poses, chains)
