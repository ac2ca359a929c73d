"""Shape and pose of a chain of rigid links from its markers and its servos together, with covariance, frame by frame.

Unknowns of a frame: the weighted centroid c and the direction psi_l of every rigid link; vertices
p_k = c + sum_j (e_j' u(psi_l(j))). Markers measure p_k with SD s_m, servos measure psi_{l+1} - psi_l with SD s_a.
Weighted least squares, many frames at once.

Legend: F frames, N vertices, L = m + 1 links, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammainc, gammaincinv

from serpenoid.body import Body
from serpenoid.measure.blocks import blocks
from serpenoid.measure.cells import Floats
from serpenoid.measure.shapes.bends import Bends, bends_in_time
from serpenoid.measure.shapes.chain_start import start, within_half_a_turn
from serpenoid.measure.shapes.links import link_directions, link_of_edge, vertices_by_links
from serpenoid.measure.shapes.whole_bends import whole_bends

Flags = NDArray[np.bool_]
OF_FRAMES = ("poses", "joint_angles", "covariance", "vertices", "determined", "marker_residual")
Weighted = tuple[Floats, Floats]
ITERATIONS = 60
FEW = 4  # of these, after which links that fit are fitted, but for the last digits
CONVERGED = 1e-9  # rad and body lengths: far below any marker noise
LEAST_DAMPING = 1e-12  # of information
ROUNDING = 1e-14  # of its trace: an edge may be thousands of times another
SINGULAR = 1e-9  # smallest eigenvalue of the information over its largest: no more than rounding
LINEAR = 0.03  # rad: cosines of angles so well known are right to half a thousandth, whatever the markers' noise
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
    vague: float  # SD of a link's direction, in that of a marker, beyond which a frame is not determined


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
    said = Bends.of(servo, servo_sd)
    unknowns, information, residual = _fit(body, vertices, said, marker_sd or 1e-3)
    uncertain = _uncertainty(information)
    regular = np.isfinite(uncertain)
    vague = UNCERTAIN * float(np.median(uncertain[regular])) if regular.any() else 0.0
    determined = uncertain <= vague
    if surely is not None:
        determined = determined | surely
    sd = marker_sd or _misfit(
        residual[determined],
        np.isfinite(vertices[determined]),
        servo_given=said is not None,
        unknowns=unknowns.shape[1],
        joints=body.joint_count,
    )
    if np.isnan(sd):  # as many unknowns as numbers in every frame: any mirror image of a hidden stretch fits exactly
        determined = np.zeros_like(determined)
    elif marker_sd is None and said is not None:
        return estimate_chain(body, vertices, servo, servo_sd, sd)
    return _assemble(body, unknowns, information, residual, determined, sd, vague)


def completed(body: Body, vertices: Floats, time_s: Floats, by_markers: ChainEstimate) -> ChainEstimate:
    """The same where frames that markers alone leave open have bends of the frames about them; others as they are.

    The nearer they are, and the smoother the motion, the better they are known (`serpenoid.measure.shapes.bends`). An
    animal's hidden points are found by what the rest of the frame shows, too (`serpenoid.measure.shapes.whole_bends`).
    """
    hidden = body.is_animal & ~np.isfinite(vertices).all(axis=(1, 2))
    left = np.flatnonzero(~by_markers.determined | hidden)
    if not len(left) or not by_markers.determined.any():
        return by_markers
    variance = np.diagonal(by_markers.covariance[:, 3:, 3:], axis1=1, axis2=2)
    wholly = by_markers.determined & ~hidden  # a hidden point has a mirror position, which time knows from its own
    said = bends_in_time(body, time_s, vertices, by_markers.joint_angles, variance, wholly)
    if body.is_animal:
        said = whole_bends(body, vertices, by_markers.marker_sd, said)
    fit = _fit(body, vertices[left], said.of_rows(left), by_markers.marker_sd)
    _where_better(body, vertices[left], said.of_rows(left), by_markers, left, fit)
    vague = np.fmax(by_markers.vague, LINEAR / by_markers.marker_sd) if body.is_animal else by_markers.vague
    told = (_uncertainty(fit[1]) <= vague) | by_markers.determined[left]
    part = _assemble(body, *fit, told, by_markers.marker_sd, by_markers.vague)
    whole = replace(by_markers, **{name: getattr(by_markers, name).copy() for name in OF_FRAMES})
    for name in OF_FRAMES:
        getattr(whole, name)[left] = getattr(part, name)
    whole.poses[whole.determined, 2] = np.unwrap(whole.poses[whole.determined, 2])
    return whole


def _where_better(
    body: Body, vertices: Floats, said: Bends, by_markers: ChainEstimate, rows: NDArray[np.int64], fit: tuple
) -> None:
    """Puts into a fit to frames (F, N, 2) beside bends, in place, what is found from where their markers alone led:
    where that costs less. Bends that are hardly known are no place to begin."""
    own = np.flatnonzero(by_markers.determined[rows])
    if not len(own):
        return
    weighted = _weighted(said, own, by_markers.marker_sd)
    unknowns = link_directions(body, by_markers.poses[rows[own]], by_markers.joint_angles[rows[own]])
    found = (unknowns, *_descended(body, vertices[own], weighted, unknowns))
    costs = [_normal(body, vertices[own], weighted, each)[0] for each in (fit[0][own], unknowns)]
    better = costs[1] < costs[0]
    for kept, new in zip(fit, found, strict=True):
        kept[own[better]] = new[better]


def fitted_beside(body: Body, vertices: Floats, said: Bends, marker_sd: float) -> tuple[Floats, Floats, Floats]:
    """Of each frame: chi squared (F,) of markers (F, N, 2) and of all joint angles, which are said (F, m); how far
    these are missed (F, m) [standard deviations]; the chain (F, N, 2)."""
    unknowns, _, residual = _fit(body, vertices, said, marker_sd)
    missed = (said.angles - unknowns[:, 2:] @ _bending(body).T) / said.sd
    cost = (residual**2).sum(axis=(1, 2)) / marker_sd**2 + (missed**2).sum(axis=1)
    return cost, missed, vertices_by_links(body, unknowns)[0]


def fits_within(body: Body, vertices: Floats, limit: float) -> bool:
    """Whether links fit the markers (F, N, 2) [body lengths] of every frame to within a limit: the root of the sum of
    squares of all residuals in it. Not fitted farther than that, in a quarter of the time of an estimate."""
    unknowns = start(body, vertices, None)
    for b in blocks(len(vertices), _numbers(body)):
        _, residual = _descended(body, vertices[b], None, unknowns[b], limit**2, FEW)
        if ((residual**2).sum(axis=(1, 2)) > limit**2).any():
            return False
    return True


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
    said = Bends.of(servo, servo_sd)
    moved = link_directions(body, poses, joint_angles)
    information, residual = _room(moved, vertices)
    for b in blocks(len(moved), _numbers(body)):
        _, own, gradient, _ = _normal(body, vertices[b], _weighted(said, b, marker_sd), moved[b])
        information[b] = own + (marker_sd / VAGUE_SD) ** 2 * np.eye(moved.shape[1])
        moved[b] += np.linalg.solve(information[b], gradient[..., None])[..., 0]
        residual[b] = _normal(body, vertices[b], None, moved[b])[3]
    return _assemble(body, moved, information, residual, np.ones(len(poses), dtype=bool), marker_sd, np.inf)


def _fit(body: Body, vertices: Floats, said: Bends | None, marker_sd: float) -> tuple[Floats, Floats, Floats]:
    """Unknowns (F, 2 + L), information (F, 2 + L, 2 + L) per unit marker variance, residuals (F, N, 2).

    Levenberg-Marquardt, every frame with its own damping: a hidden vertex in a straight stretch is nearly singular.
    """
    unknowns = start(body, vertices, None if said is None else said.angles)
    information, residual = _room(unknowns, vertices)
    for b in blocks(len(vertices), _numbers(body)):
        information[b], residual[b] = _descended(body, vertices[b], _weighted(said, b, marker_sd), unknowns[b])
    unknowns[:, 2:] = within_half_a_turn(unknowns[:, 2:])
    return unknowns, information, residual


def _room(unknowns: Floats, vertices: Floats) -> tuple[Floats, Floats]:
    """For information and residuals of every frame."""
    return np.empty((*unknowns.shape, unknowns.shape[1])), np.empty_like(vertices)


def _weighted(said: Bends | None, block: slice | NDArray[np.int64], marker_sd: float) -> Weighted | None:
    """Angles of a block (F, m), 0 where nothing says them, and their weights beside a marker's."""
    if said is None:
        return None
    own = said.of_rows(block)
    return np.nan_to_num(own.angles), own.weights(marker_sd)


def _descended(
    body: Body, vertices: Floats, said: Weighted | None, unknowns: Floats, enough: float = -1.0, most: int = ITERATIONS
) -> tuple[Floats, Floats]:
    """Moves `unknowns`, in place, to where the cost is least, or as little as `enough`; information and residuals."""
    damping = np.full(len(vertices), 1e-6)
    kept = list(_normal(body, vertices, said, unknowns))
    live = np.flatnonzero(kept[0] > enough)
    for _ in range(most if len(live) else 0):
        least = np.maximum(LEAST_DAMPING, ROUNDING * np.trace(kept[1][live], axis1=1, axis2=2))
        regular = kept[1][live] + (damping[live] + least)[:, None, None] * np.eye(unknowns.shape[1])
        step = np.linalg.solve(regular, kept[2][live][..., None])[..., 0]
        tried = unknowns[live] + np.clip(step, -0.5, 0.5)
        new = _normal(body, vertices[live], None if said is None else (said[0][live], said[1][live]), tried)
        better = new[0] <= kept[0][live]
        damping[live] = np.where(better, damping[live] / 10, np.minimum(damping[live] * 20, 1e3))
        unknowns[live[better]] = tried[better]
        for old, values in zip(kept, new, strict=True):
            old[live[better]] = values[better]
        live = live[(np.abs(step).max(axis=1) > CONVERGED) & (kept[0][live] > enough)]
        if not len(live):
            break
    return kept[1], kept[3]


def _normal(
    body: Body, vertices: Floats, said: Weighted | None, unknowns: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Cost (F,), information, gradient and marker residuals at `unknowns`."""
    seen = np.asarray(np.isfinite(vertices).all(axis=2))
    points, jacobian = vertices_by_links(body, unknowns)
    residual = np.where(seen[..., None], vertices - points, 0.0)
    masked = np.where(seen[..., None, None], jacobian, 0.0).reshape(len(vertices), -1, unknowns.shape[1])
    information = np.swapaxes(masked, 1, 2) @ masked
    gradient = np.einsum("fia,fi->fa", masked, residual.reshape(len(vertices), -1))
    cost = (residual**2).sum(axis=(1, 2))
    if said is not None:
        angles, weights = said
        bend = _bending(body)
        miss = angles - unknowns[:, 2:] @ bend.T
        information[:, 2:, 2:] += bend.T @ (weights[..., None] * bend)
        gradient[:, 2:] += (weights * miss) @ bend
        cost = cost + (weights * miss**2).sum(axis=1)
    return cost, information, gradient, residual


def _numbers(body: Body) -> int:
    """Of a frame's Jacobian."""
    return 2 * body.vertices * (body.joint_count + 3)


def _bending(body: Body) -> Floats:
    """Joint angles from link directions, (m, L)."""
    links = np.eye(body.joint_count + 1)
    return links[1:] - links[:-1]


def _uncertainty(information: Floats) -> Floats:
    """SD (F,) of the least certain link direction for markers of SD 1; infinite where the information is singular."""
    eigen = np.linalg.eigvalsh(information)
    worst = np.full(len(information), np.inf)
    rows = np.flatnonzero(eigen[:, 0] > SINGULAR * eigen[:, -1])
    for b in blocks(len(rows)):
        variance = np.diagonal(np.linalg.inv(information[rows[b]]), axis1=1, axis2=2)
        worst[rows[b]] = np.sqrt(variance[:, 2:].max(axis=1))
    return worst


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
    body: Body, unknowns: Floats, information: Floats, residual: Floats, determined: Flags, sd: float, vague: float
) -> ChainEstimate:
    """The covariance takes the place of the information, which is as large as all else together."""
    share = np.bincount(link_of_edge(body), minlength=body.joint_count + 1) / (body.vertices - 1)
    m = body.joint_count
    to_state = np.zeros((3 + m, 3 + m))
    to_state[:2, :2] = np.eye(2)
    to_state[2, 2:] = share
    to_state[3:, 2:] = _bending(body)
    state = unknowns @ to_state.T
    covariance, points = information, np.empty_like(residual)
    for b in blocks(len(state), _numbers(body)):
        safe = np.where(determined[b, None, None], information[b], np.eye(3 + m))
        covariance[b] = sd**2 * to_state @ np.linalg.inv(safe) @ to_state.T
        points[b] = vertices_by_links(body, unknowns[b])[0]
    poses, angles = state[:, :3].copy(), state[:, 3:].copy()
    poses[determined, 2] = np.unwrap(poses[determined, 2])
    for values in (poses, angles, covariance, points):
        values[~determined] = np.nan
    hidden = np.where(residual == 0.0, np.nan, residual)
    return ChainEstimate(poses, angles, covariance, points, determined, sd, hidden, vague)
