"""An animal's body between its points: an inextensible curve, drawn from the directions of the links that points show.

    mean of theta(s) over link l = psi_l,     x(s) = x(0) + int_0^s u(theta),     u = (cos, sin)

theta is the slope of the spline through the sums of psi_l times length at the links' ends, hence linear in psi; lengths
are arcs along the body, which bending does not change (distances between points it does). The chord of an arc points
along its mean tangent but for E[(theta - psi)^3] / 6. Between the points nobody knows the curve: splines of degree
`SMOOTH` and of degree `PLAIN` are two ways to draw it, and how far they differ says how well it is known.

Legend: F frames, L links, E = N - 1 edges, Q nodes of quadrature.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from serpenoid.body import Body, Floats

SMOOTH, PLAIN = 5, 3  # degrees of the spline whose slope is theta
NODES = 3  # of Gauss-Legendre quadrature in a piece: exact to rounding of a body that bends by less than a radian in it


def nodes_along(body: Body, cuts: int = 1, degree: int = SMOOTH) -> tuple[Floats, Floats]:
    """What makes tangent angles of link directions (Q, L), and the lengths (Q,) that stand at these [body lengths].

    Every edge is cut into `cuts` pieces of NODES nodes each.
    """
    return _nodes_along(tuple(body.edges.tolist()), tuple(body.corners), cuts, degree)


@lru_cache(maxsize=64)
def _nodes_along(edges: tuple[float, ...], corners: tuple[int, ...], cuts: int, degree: int) -> tuple[Floats, Floats]:
    from scipy.interpolate import make_interp_spline  # as long to import as all the rest, and robots need it not

    place = np.concatenate([[0.0], np.cumsum(edges)])
    ends = place[list(corners)]
    piece = np.repeat(np.array(edges) / cuts, cuts)
    at, weight = np.polynomial.legendre.leggauss(NODES)
    begin = np.concatenate([[0.0], np.cumsum(piece)])[:-1]
    arcs = (begin[:, None] + piece[:, None] * (at + 1) / 2).ravel()
    sums = np.tril(np.ones((len(ends), len(ends) - 1)), -1) * np.diff(ends)
    theta = make_interp_spline(ends, sums, k=min(degree, len(ends) - 1)).derivative()(arcs)
    return np.asarray(theta), (piece[:, None] * weight / 2).ravel()


def curve(body: Body, directions: Floats, cuts: int = 1, degree: int = SMOOTH) -> Floats:
    """Points (F, E cuts + 1, 2) of the curve at the ends of its pieces, in the frame of its vertices: their weighted
    centroid and the mean direction of the edges [body lengths].

    directions (F, L): of the links [rad], continuous along the body.
    """
    tangents, lengths = nodes_along(body, cuts, degree)
    theta = (directions - (directions @ _shares(body))[:, None]) @ tangents.T
    moved = np.stack([np.cos(theta), np.sin(theta)], axis=2) * lengths[:, None]
    steps = moved.reshape(len(theta), -1, NODES, 2).sum(axis=2)
    points = np.concatenate([np.zeros((len(theta), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    centroid: Floats = np.einsum("k,fki->fi", body.vertex_weights, points[:, ::cuts])
    return np.asarray(points - centroid[:, None])


def _shares(body: Body) -> Floats:
    """Share of the edges that each link has (L,)."""
    return np.diff(body.corners) / (body.vertices - 1)


def directions_of(body: Body, vertices: Floats) -> Floats:
    """Directions (F, L) of the links between vertices (F, N, 2), continuous along the body and from row to row."""
    chords = np.diff(vertices[:, body.corners], axis=1)
    along = np.unwrap(np.arctan2(chords[..., 1], chords[..., 0]), axis=1)
    turns = np.round(np.diff(along[:, 0]) / (2 * np.pi))
    along[1:] -= 2 * np.pi * np.cumsum(turns)[:, None]
    return np.asarray(along)
