"""An animal's points stand for a smooth curve: drag acts along the curve, not along straight links between the points.

The curve (`serpenoid.body_curve`) and splines through time are cut into `finer` times as many links and steps, which
are simulated; with g_r the curve's pose (centroid, mean direction) in the frame of the chain, the chain's pose is (pose
of the curve) o g_r^-1. What cutting misses goes with the squares of a link's length and of a step's duration, so the
motion between two rows is extrapolated, s = s_4 + (s_4 - s_2) / 3. Between the points nobody knows the curve; `degree`
is one of two ways to draw it.

Legend: R rows, N vertices.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import CubicSpline

from serpenoid import group
from serpenoid.body import LEAST, Body, Floats
from serpenoid.body_curve import SMOOTH, curve, directions_of
from serpenoid.model import Model
from serpenoid.simulation.poses import body_poses
from serpenoid.simulation.rollout import simulate_vertices
from serpenoid.trajectory import Trajectory

ROUGH, FINE = 2, 4


def simulate_curve(model: Model, vertices: Floats, start: Floats | None = None, degree: int = SMOOTH) -> Trajectory:
    """The motion of chains (R, N, 2) [body lengths] from a pose, when the medium (no effects) acts on their curves.

    Poses and vertices are those of the curve's own points at the chain's arcs, step energies the curve's.
    """
    directions = directions_of(model.body, np.asarray(vertices, float))
    (rough, _), (fine, chain) = (_cut(model, directions, finer, degree) for finer in (ROUGH, FINE))
    steps = [group.compose(group.inverse(t.poses[:-1]), t.poses[1:]) for t in (rough, fine)]
    extrapolated = steps[1] + (steps[1] - steps[0]) / ((FINE / ROUGH) ** 2 - 1)
    poses = group.accumulate(extrapolated, start)
    return replace(fine, poses=poses, vertices=group.place(poses, chain))


def _cut(model: Model, directions: Floats, finer: int, degree: int) -> tuple[Trajectory, Floats]:
    """Motion of the chain's frame at its rows, with `finer` times as many links and steps; its vertices there."""
    body, rows = cut(model.body, finer), np.arange(len(directions))
    some = slice(None, None, finer if len(rows) > 3 else 1)
    if len(rows) > 3:
        directions = CubicSpline(rows, directions)(np.arange(finer * (len(rows) - 1) + 1) / finer)
    drawn = curve(model.body, directions, finer, degree)
    finer_model = Model(body, model.medium)
    inside = body_poses(finer_model, drawn)
    found = simulate_vertices(finer_model, drawn, inside[0])
    poses = group.compose(found.poses[some], group.inverse(inside[some]))
    energy = found.step_energy.reshape(len(rows) - 1, -1)
    energy = energy.sum(axis=1) * energy.shape[1] ** (found.degree - 1)
    return replace(found, poses=poses, step_energy=energy), drawn[some, ::finer]


def cut(body: Body, finer: int) -> Body:
    """The body with every edge cut into `finer`; its weight per length runs linearly between the vertices'."""
    edges = np.repeat(body.edges / finer, finer)
    before, after = (np.concatenate([[0.0], np.cumsum(e)]) for e in (body.edges, edges))
    weights = np.interp(after, before, body.vertex_weights / _around(body.edges)) * _around(edges)
    return Body(
        kind=body.kind, vertices=len(after), edge_lengths=tuple(edges), weights=tuple(np.maximum(weights, LEAST))
    )


def _around(edges: Floats) -> Floats:
    """Length that belongs to each vertex: half of either edge."""
    ends = np.concatenate([[0.0], edges, [0.0]])
    return np.asarray((ends[1:] + ends[:-1]) / 2)
