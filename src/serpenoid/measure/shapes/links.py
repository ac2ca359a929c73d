"""A chain of rigid links in numbers: vertices from link directions, joint angles from vertices.

Unknowns of a frame: the weighted centroid c and the direction psi_l of every rigid link; vertices
p_k = c + sum_j (e_j' u(psi_l(j))). An animal's links are arcs of a curve (`serpenoid.body_curve`).
Legend: F frames, N vertices, L = m + 1 links, m joints, Q nodes of the curve; lengths in body lengths.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.body_curve import NODES, nodes_along
from serpenoid.measure.cells import Floats


def link_of_edge(body: Body) -> NDArray[np.int64]:
    """Which rigid link each edge belongs to, shape (N - 1,)."""
    begins = np.zeros(body.vertices - 1, dtype=np.int64)
    begins[list(body.joint_vertices)] = 1
    return np.cumsum(begins)


def marker_angles(body: Body, markers: Floats) -> Floats:
    """Joint angles (F, m) between the links that markers (F, N, 2) show; NaN where an end of one is hidden."""
    return bends(markers[:, body.corners])


def bends(points: Floats) -> Floats:
    """Angles (F, K - 2) between the successive stretches of a polygon with K corners (F, K, 2)."""
    return _turns(np.diff(points, axis=1))


def _turns(stretches: Floats) -> Floats:
    a, b = stretches[:, :-1], stretches[:, 1:]
    cross = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return np.asarray(np.arctan2(cross, a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1]))


def wrapped(angles: Floats) -> Floats:
    """Angles [rad] less whole turns, from -pi up to pi."""
    return np.asarray((angles + np.pi) % (2 * np.pi) - np.pi)


def laid_over(points: Floats, markers: Floats) -> tuple[Floats, Floats, Floats]:
    """Turn (F,) that lays points (F, N, 2) over the visible markers by least squares; the means (F, 2) of both."""
    seen = np.isfinite(markers[..., 0])
    share = (seen / np.maximum(seen.sum(axis=1), 1)[:, None])[:, None]
    there = np.where(seen[..., None], markers, 0.0)
    mid_p, mid_m = share @ points, share @ there  # products of matrices: sums along short axes take thrice as long
    products = ((points - mid_p) * seen[..., None]).swapaxes(1, 2) @ (there - mid_m)
    cross, dot = products[:, 0, 1] - products[:, 1, 0], products[:, 0, 0] + products[:, 1, 1]
    return np.asarray(np.arctan2(cross, dot)), mid_p[:, 0], mid_m[:, 0]


def chain_vertices(body: Body, poses: Floats, joint_angles: Floats) -> Floats:
    """Vertices (R, N, 2) of poses (R, 3) and joint angles (R, m)."""
    points, _ = vertices_by_links(body, link_directions(body, poses, joint_angles))
    return points


def link_directions(body: Body, poses: Floats, joint_angles: Floats) -> Floats:
    """Centroid and link directions of poses and joint angles, shape (R, 2 + L)."""
    share = np.bincount(link_of_edge(body), minlength=body.joint_count + 1) / (body.vertices - 1)
    psi = np.concatenate([np.zeros((len(poses), 1)), np.cumsum(joint_angles, axis=1)], axis=1)
    psi += (poses[:, 2] - psi @ share)[:, None]
    return np.concatenate([poses[:, :2], psi], axis=1)


def vertices_by_links(body: Body, unknowns: Floats) -> tuple[Floats, Floats]:
    """Vertices (F, N, 2) and their Jacobian (F, N, 2, 2 + L)."""
    if body.is_animal:
        return _along_curve(body, unknowns)
    link, n = link_of_edge(body), body.vertices
    psi = unknowns[:, 2:]
    unit = np.stack([np.cos(psi), np.sin(psi)], axis=2)[:, link] * body.edges[:, None]
    reach = from_centroid(body)
    points = unknowns[:, None, :2] + np.einsum("kj,fji->fki", reach, unit)
    jacobian = np.zeros((len(psi), n, 2, unknowns.shape[1]))
    jacobian[:, :, 0, 0] = jacobian[:, :, 1, 1] = 1.0
    turned = np.einsum("kj,jl->jkl", reach, np.eye(psi.shape[1])[link]).reshape(len(link), -1)
    for axis, normal in enumerate((-unit[..., 1], unit[..., 0])):
        jacobian[:, :, axis, 2:] = (normal @ turned).reshape(jacobian[:, :, axis, 2:].shape)
    return points, jacobian


def _along_curve(body: Body, unknowns: Floats) -> tuple[Floats, Floats]:
    """The same of a curve without corners: u(psi_l) of an edge is the integral of u along it."""
    tangents, lengths = nodes_along(body)
    theta = unknowns[:, 2:] @ tangents.T
    along, across = np.cos(theta) * lengths, np.sin(theta) * lengths  # each by itself: products of matrices are fast
    reach = np.repeat(from_centroid(body), NODES, axis=1)  # (N, Q)
    jacobian = np.zeros((len(theta), body.vertices, 2, unknowns.shape[1]))
    jacobian[:, :, 0, 0] = jacobian[:, :, 1, 1] = 1.0
    own = tangents.reshape(-1, NODES, tangents.shape[1])  # of each edge
    for axis, normal in enumerate((-across, along)):
        by_edge = normal.reshape(len(theta), len(own), NODES).swapaxes(0, 1) @ own  # (E, F, L)
        turned = jacobian[:, :, axis, 2:]
        turned[:, 0] = np.tensordot(reach[0, ::NODES], by_edge, axes=1)
        for k, moved in enumerate(by_edge):  # many times as fast as `cumsum` along the first axis
            np.add(turned[:, k], moved, out=turned[:, k + 1])
    return unknowns[:, None, :2] + np.stack([along @ reach.T, across @ reach.T], axis=2), jacobian


def from_centroid(body: Body) -> Floats:
    """How much of edge j lies between the centroid and vertex k, (N, N - 1)."""
    behind = np.tril(np.ones((body.vertices, body.vertices - 1)), -1)
    return behind - body.vertex_weights @ behind
