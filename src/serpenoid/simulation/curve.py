"""An animal's points stand for a smooth curve: drag acts along the curve, not along straight links between the points.

The curve (`serpenoid.body_curve`) and splines through time are cut into `finer` times as many links and steps, which
are simulated; with g_r the curve's pose (centroid, mean direction) in the frame of the chain, the chain's pose is (pose
of the curve) o g_r^-1. Drag sits amid the pieces, whatever the model says: then what cutting misses goes with even
powers of a link's length and of a step's duration alone (at vertices the two end ones add a third power), and the
motion between two rows is extrapolated twice, by Romberg's rule:

    s_12 = s_2 + (s_2 - s_1) / 3,     s_24 = s_4 + (s_4 - s_2) / 3,     s = s_24 + (s_24 - s_12) / 15

Between the points nobody knows the curve; `degree` is one of two ways to draw it.

Legend: R rows, N vertices.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline

from serpenoid import group
from serpenoid.body import LEAST, Body, Floats
from serpenoid.body_curve import SMOOTH, curve, directions_of
from serpenoid.model import Model
from serpenoid.simulation.poses import body_poses
from serpenoid.simulation.rollout import simulate_vertices
from serpenoid.trajectory import Trajectory

CUTS = (1, 2, 4)  # each twice as fine as the one before


def simulate_curve(model: Model, vertices: Floats, start: Floats | None = None, degree: int = SMOOTH) -> Trajectory:
    """The motion of chains (R, N, 2) [body lengths] from a pose, when the medium (no effects) acts on their curves.

    Poses and vertices are those of the curve's own points at the chain's arcs, step energies the curve's.
    """
    directions = directions_of(model.body, np.asarray(vertices, float))
    motions = [_cut(model, directions, finer, degree) for finer in CUTS]
    fine, chain = motions[-1]
    poses = group.accumulate(_extrapolated([group.relative(t.poses[:-1], t.poses[1:]) for t, _ in motions]), start)
    return replace(fine, poses=poses, vertices=group.place(poses, chain))


def amid_edges(model: Model) -> Model:
    """The same model with its dissipation in the middles of its edges."""
    if model.medium.dissipation == "edge":
        return model
    body = model.body.changed(weights=tuple(model.body.vertex_weights.tolist()))
    return Model(body, model.medium.model_copy(update={"dissipation": "edge"}), model.effects, model.cycle_duration_s)


def _extrapolated(steps: list[Floats]) -> Floats:
    """Steps of no mesh, from those of meshes of which each is twice as fine as the one before."""
    power = 1
    while len(steps) > 1:
        power *= 4
        steps = [finer + (finer - rough) / (power - 1) for rough, finer in pairwise(steps)]
    return steps[0]


def _cut(model: Model, directions: Floats, finer: int, degree: int) -> tuple[Trajectory, Floats]:
    """Motion of the chain's frame at its rows, with `finer` times as many links and steps; its vertices there."""
    body, rows = cut(model.body, finer), np.arange(len(directions))
    some = slice(None, None, finer if len(rows) > 3 else 1)
    if len(rows) > 3:
        directions = CubicSpline(rows, directions)(np.arange(finer * (len(rows) - 1) + 1) / finer)
    drawn = curve(model.body, directions, finer, degree)
    finer_model = amid_edges(Model(body, model.medium))
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
