"""Shape and pose of a chain of rigid links from its markers and its servos together, with covariance, frame by frame.

Unknowns of a frame: the weighted centroid c and the direction psi_l of every rigid link; vertices
p_k = c + sum_j (e_j' u(psi_l(j))). Markers measure p_k with SD s_m, servos measure psi_{l+1} - psi_l with SD s_a.
Weighted least squares, many frames at once.

Legend: F frames, N vertices, L = m + 1 links, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc, gammaincinv

from serpenoid.body import Body
from serpenoid.measure.blocks import blocks
from serpenoid.measure.cells import Floats
from serpenoid.measure.links import laid_over, link_directions, link_of_edge, vertices_by_links

Flags = NDArray[np.bool_]
ITERATIONS = 60
CONVERGED = 1e-9  # rad and body lengths: far below any marker noise
SINGULAR = 1e-9  # smallest eigenvalue of the information over its largest: no more than rounding
VAGUE_SD = 1.0  # rad and body lengths: what is known of a state that nothing measured
UNCERTAIN = (
    4.0  # a frame whose least certain direction is this much worse than usual is not determined: a hidden vertex
)
# in a nearly straight stretch has two mirror positions, and the fit's covariance is no longer the truth


@dataclass(frozen=True)
class ChainEstimate:
    """Per frame: pose (F, 3), joint angles (F, m), covariance (F, 3 + m, 3 + m), determined or not."""

    poses: Floats  # x, y [body lengths], heading [rad], unwrapped
    joint_angles: Floats  # [rad]
    covariance: Floats  # of (x, y, heading, joint angles)
    vertices: Floats  # (F, N, 2) of the rigid chain [body lengths]
    determined: Flags  # (F,)
    marker_sd: float  # [body lengths], from the misfit of the rigid links
    marker_residual: Floats  # (F, N, 2), NaN where hidden


def estimate_chain(
    body: Body,
    vertices: Floats,
    servo: Floats | None = None,
    servo_sd: float | None = None,
    marker_sd: float | None = None,
    surely: Flags | None = None,
) -> ChainEstimate:
    """Fit to markers (F, N, 2) [body lengths] and servo angles (F, m) [rad]. `marker_sd` None: from the misfit.

    `surely` (F,): frames that are known to be determined (by their markers alone).
    """
    first = marker_sd or 1e-3
    weight_servo = None if servo is None or servo_sd is None else (first / servo_sd) ** 2
    unknowns, information, residual = _fit(body, vertices, servo, weight_servo)
    determined = _determined(information)
    if surely is not None:
        determined = determined | surely
    sd = marker_sd or _misfit(
        residual[determined],
        np.isfinite(vertices[determined]),
        servo_given=weight_servo is not None,
        unknowns=unknowns.shape[1],
        joints=body.joint_count,
    )
    if np.isnan(sd):  # as many unknowns as numbers in every frame: any mirror image of a hidden stretch fits exactly
        determined = np.zeros_like(determined)
    elif marker_sd is None and weight_servo is not None:
        return estimate_chain(body, vertices, servo, servo_sd, sd)
    return _assemble(body, unknowns, information, residual, determined, sd)


def estimate_about(
    body: Body,
    vertices: Floats,
    poses: Floats,
    joint_angles: Floats,
    marker_sd: float,
    servo: Floats | None = None,
    servo_sd: float | None = None,
) -> ChainEstimate:
    """The same by one linear step from a smooth path: unbiased to second order, where the fit frame by frame is not.

    (A fit's own noise is in its Jacobian and in its covariance, and both are correlated with its error.) Where markers
    are hidden the covariance is large instead of the frame missing: the time grid stays whole.
    """
    weight = None if servo is None or servo_sd is None else (marker_sd / servo_sd) ** 2
    moved = link_directions(body, poses, joint_angles)
    information, residual = _room(moved, vertices)
    for b in blocks(len(moved)):
        _, own, gradient, _ = _normal(body, vertices[b], _of(servo, b), weight, moved[b])
        information[b] = own + (marker_sd / VAGUE_SD) ** 2 * np.eye(moved.shape[1])
        moved[b] += np.linalg.solve(information[b], gradient[..., None])[..., 0]
        residual[b] = _normal(body, vertices[b], None, None, moved[b])[3]
    return _assemble(body, moved, information, residual, np.ones(len(poses), dtype=bool), marker_sd)


def _fit(body: Body, vertices: Floats, servo: Floats | None, weight: float | None) -> tuple[Floats, Floats, Floats]:
    """Unknowns (F, 2 + L), information (F, 2 + L, 2 + L) per unit marker variance, residuals (F, N, 2).

    Levenberg-Marquardt, every frame with its own damping: a hidden vertex in a straight stretch is nearly singular.
    """
    unknowns = _start(body, vertices, servo)
    information, residual = _room(unknowns, vertices)
    for b in blocks(len(vertices)):
        information[b], residual[b] = _descended(body, vertices[b], _of(servo, b), weight, unknowns[b])
    unknowns[:, 2:] = _within_half_a_turn(unknowns[:, 2:])
    return unknowns, information, residual


def _room(unknowns: Floats, vertices: Floats) -> tuple[Floats, Floats]:
    """For information and residuals of every frame."""
    return np.empty((*unknowns.shape, unknowns.shape[1])), np.empty_like(vertices)


def _of(servo: Floats | None, block: slice) -> Floats | None:
    return None if servo is None else servo[block]


def _descended(
    body: Body, vertices: Floats, servo: Floats | None, weight: float | None, unknowns: Floats
) -> tuple[Floats, Floats]:
    """Moves `unknowns`, in place, to where the cost is least; information and residuals there."""
    damping = np.full(len(vertices), 1e-6)
    kept = list(_normal(body, vertices, servo, weight, unknowns))
    live = np.arange(len(vertices))
    for _ in range(ITERATIONS):
        regular = kept[1][live] + (damping[live, None] + 1e-12)[..., None] * np.eye(unknowns.shape[1])
        step = np.linalg.solve(regular, kept[2][live][..., None])[..., 0]
        tried = unknowns[live] + np.clip(step, -0.5, 0.5)
        new = _normal(body, vertices[live], None if servo is None else servo[live], weight, tried)
        better = new[0] <= kept[0][live]
        damping[live] = np.where(better, damping[live] / 10, np.minimum(damping[live] * 20, 1e3))
        unknowns[live[better]] = tried[better]
        for old, values in zip(kept, new, strict=True):
            old[live[better]] = values[better]
        live = live[np.abs(step).max(axis=1) > CONVERGED]
        if not len(live):
            break
    return kept[1], kept[3]


def _normal(
    body: Body, vertices: Floats, servo: Floats | None, weight: float | None, unknowns: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Cost (F,), information, gradient and marker residuals at `unknowns`."""
    seen = np.asarray(np.isfinite(vertices).all(axis=2))
    points, jacobian = vertices_by_links(body, unknowns)
    residual = np.where(seen[..., None], vertices - points, 0.0)
    masked = np.where(seen[..., None, None], jacobian, 0.0).reshape(len(vertices), -1, unknowns.shape[1])
    information = np.swapaxes(masked, 1, 2) @ masked
    gradient = np.einsum("fia,fi->fa", masked, residual.reshape(len(vertices), -1))
    cost = (residual**2).sum(axis=(1, 2))
    if servo is not None and weight is not None:
        bend = np.eye(body.joint_count + 1)[1:] - np.eye(body.joint_count + 1)[:-1]  # psi -> joint angles
        usable = np.asarray(np.isfinite(servo).all(axis=1))
        miss = np.where(usable[:, None], servo - unknowns[:, 2:] @ bend.T, 0.0)
        information[:, 2:, 2:] += weight * usable[:, None, None] * (bend.T @ bend)
        gradient[:, 2:] += weight * miss @ bend
        cost = cost + weight * (miss**2).sum(axis=1)
    return cost, information, gradient, residual


def _start(body: Body, vertices: Floats, servo: Floats | None) -> Floats:
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
    bends = (np.diff(psi, axis=1) + np.pi) % (2 * np.pi) - np.pi
    psi = _fill_by_bends(psi, np.stack([_fill_in_time(column) for column in bends.T], axis=1))
    psi = np.stack([_fill_in_time(column) for column in psi.T], axis=1)
    unknowns = np.concatenate([np.zeros((len(psi), 2)), _within_half_a_turn(psi)], axis=1)
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


def _within_half_a_turn(psi: Floats) -> Floats:
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


def _fill_in_time(angle: Floats) -> Floats:
    known = np.flatnonzero(np.isfinite(angle))
    if not len(known):
        return np.zeros_like(angle)
    return np.interp(np.arange(len(angle)), known, np.unwrap(angle[known]))


def _determined(information: Floats) -> Flags:
    eigen = np.linalg.eigvalsh(information)
    regular = eigen[:, 0] > SINGULAR * eigen[:, -1]
    if not regular.any():
        return regular
    worst = np.full(len(information), np.inf)
    rows = np.flatnonzero(regular)
    for b in blocks(len(rows)):
        variance = np.diagonal(np.linalg.inv(information[rows[b]]), axis1=1, axis2=2)
        worst[rows[b]] = np.sqrt(variance[:, 2:].max(axis=1))
    return np.asarray(worst <= UNCERTAIN * np.median(worst[regular]))


def _misfit(residual: Floats, seen: Flags, servo_given: bool, unknowns: int, joints: int) -> float:
    """Marker SD from the misfit: sum of squares over degrees of freedom, a tenth trimmed against swapped markers."""
    freedom = seen.sum(axis=(1, 2)) - unknowns + (joints if servo_given else 0)
    squares = (residual**2).sum(axis=(1, 2))
    usable = freedom > 0
    if not usable.any():
        return float("nan")
    per_frame = squares[usable] / freedom[usable]
    trimmed = np.sort(per_frame)[: max(1, int(0.9 * len(per_frame)))]
    typical = float(np.mean(freedom[usable]))
    return float(np.sqrt(trimmed.mean() / _trimming_bias(typical)))


def _trimming_bias(freedom: float) -> float:
    """Mean of chi2(freedom)/freedom below its 90th percentile."""
    cut = gammaincinv(freedom / 2, 0.9)  # half of it; scipy.stats takes as long to import as everything else here
    return float(gammainc(freedom / 2 + 1, cut) / 0.9)


def _assemble(
    body: Body, unknowns: Floats, information: Floats, residual: Floats, determined: Flags, sd: float
) -> ChainEstimate:
    """The covariance takes the place of the information, which is as large as all else together."""
    share = np.bincount(link_of_edge(body), minlength=body.joint_count + 1) / (body.vertices - 1)
    m = body.joint_count
    to_state = np.zeros((3 + m, 3 + m))
    to_state[:2, :2] = np.eye(2)
    to_state[2, 2:] = share
    to_state[3:, 2:] = np.eye(m + 1)[1:] - np.eye(m + 1)[:-1]
    state = unknowns @ to_state.T
    covariance, points = information, np.empty_like(residual)
    for b in blocks(len(state)):
        safe = np.where(determined[b, None, None], information[b], np.eye(3 + m))
        covariance[b] = sd**2 * to_state @ np.linalg.inv(safe) @ to_state.T
        points[b] = vertices_by_links(body, unknowns[b])[0]
    poses, angles = state[:, :3].copy(), state[:, 3:].copy()
    poses[determined, 2] = np.unwrap(poses[determined, 2])
    for values in (poses, angles, covariance, points):
        values[~determined] = np.nan
    hidden = np.where(residual == 0.0, np.nan, residual)
    return ChainEstimate(poses, angles, covariance, points, determined, sd, hidden)
