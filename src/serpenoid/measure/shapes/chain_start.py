"""Where the fit of a chain to a frame's markers begins: directions of its links as far as anything tells them."""

from __future__ import annotations

import numpy as np

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import bridged, unwrapped
from serpenoid.measure.shapes.links import laid_over, link_of_edge, vertices_by_links, wrapped


def start(body: Body, vertices: Floats, servo: Floats | None) -> Floats:
    """Link directions from seen vertices, else bent from a neighbour as servos say, else as in frames before and after;
    a frame that shows no two neighbours is turned to meet the vertices that it shows; centroid to match them."""
    link, edge = link_of_edge(body), np.diff(vertices, axis=1)
    psi = _directions(np.diff(vertices[:, body.corners], axis=1))
    for its_link in range(psi.shape[1]):
        parts = _directions(np.nansum(edge[:, link == its_link], axis=1))
        psi[:, its_link] = np.where(np.isfinite(psi[:, its_link]), psi[:, its_link], parts)
    adrift = ~np.isfinite(psi).any(axis=1)
    psi[adrift, 0] = 0.0
    if servo is not None:
        psi = _fill_by_bends(psi, servo)
    # not directions: while a vertex is hidden the body may turn, and a bend of it to the other side fits as well
    bends = wrapped(np.diff(psi, axis=1))
    rows = np.arange(float(len(psi)))
    psi = bridged(rows, unwrapped(_fill_by_bends(psi, bridged(rows, unwrapped(bends)))))
    unknowns = np.concatenate([np.zeros((len(psi), 2)), within_half_a_turn(psi)], axis=1)
    unknowns[adrift, 2:] += laid_over(vertices_by_links(body, unknowns[adrift])[0], vertices[adrift])[0][:, None]
    shape, _ = vertices_by_links(body, unknowns)
    with np.errstate(invalid="ignore"):
        seen = np.isfinite(vertices)
        offset = np.where(seen, vertices - shape, 0.0).sum(axis=1) / np.maximum(seen.sum(axis=1), 1)
    unknowns[:, :2] = offset
    return unknowns


def _directions(stretches: Floats) -> Floats:
    """Of vectors (..., 2); NaN where one is unknown or nothing."""
    known = np.abs(stretches).sum(axis=-1) > 0
    return np.asarray(np.where(known, np.arctan2(stretches[..., 1], stretches[..., 0]), np.nan))


def within_half_a_turn(psi: Floats) -> Floats:
    """Link directions (F, L), less whole turns, such that joint angles are within half a turn."""
    straight = psi.copy()
    for its_link in range(1, psi.shape[1]):
        turns = np.round((straight[:, its_link] - straight[:, its_link - 1]) / (2 * np.pi))
        straight[:, its_link] -= 2 * np.pi * turns
    return straight


def _fill_by_bends(psi: Floats, bends: Floats) -> Floats:
    """Link directions (F, L), unknown ones from the next known link and joint angles (F, m)."""
    filled = psi.copy()
    for its_link in range(1, psi.shape[1]):
        guess = filled[:, its_link - 1] + bends[:, its_link - 1]
        filled[:, its_link] = np.where(np.isfinite(filled[:, its_link]), filled[:, its_link], guess)
    for its_link in range(psi.shape[1] - 2, -1, -1):
        guess = filled[:, its_link + 1] - bends[:, its_link]
        filled[:, its_link] = np.where(np.isfinite(filled[:, its_link]), filled[:, its_link], guess)
    return filled
