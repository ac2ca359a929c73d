"""The step energy and the geometric momentum, in the plane and in space.

E(g) = 1/2 sum_k <D_k^(t,t+1) dp_k, dp_k>,  D^(t,t+1) = (D^t + D^{t+1}) / 2,  D_k = w_k (I + (eps - 1) T_k T_k^t)
mu(g) = d/d delta E(exp(delta) g) at delta = 0     (Even et al., Eqs. 3-6; the paper's mu is -1/2 (2 rot, tran) of it)

The step is written in the body frame of time t, so that g is the relative pose. The dissipation law is the medium's: a
potential of the squared slip (serpenoid.media); the formulas above are those of linear drag.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.media import VISCOUS, Law

NONE = ca.SX(0)
LEAST = 1e-9  # body lengths: in a pause nothing changes shape, and nothing slips


def element_energy(
    before: ca.SX, after: ca.SX, weight: ca.SX, anisotropy_ratio: ca.SX, law: Law = VISCOUS, softening: ca.SX = NONE
) -> ca.SX:
    """Energy of one element moving from `before` to `after`, each (position, tangent), shape (2 d,), in one frame."""
    return weight * law.cost(*squared_slips(before, after), law.form_ratio(anisotropy_ratio), softening)


def squared_slips(before: ca.SX, after: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Of one element, across and along."""
    d = before.numel() // 2
    dp = after[:d] - before[:d]
    slide, slide_after = ca.dot(dp, before[d:]), ca.dot(dp, after[d:])
    along = (slide**2 + slide_after**2) / 2
    return ca.dot(dp, dp) - along, along


def step_energy(
    before: ca.SX,
    after: ca.SX,
    weights: ca.SX,
    anisotropy_ratio: ca.SX,
    law: Law = VISCOUS,
    softening: ca.SX = NONE,
) -> ca.SX:
    """Sum of the element energies; elements (2 d, M) in one frame, weights (M)."""
    pairs = zip(ca.horzsplit(before), ca.horzsplit(after), ca.vertsplit(weights), strict=True)
    soft = ca.horzsplit(softening) if softening.numel() > 1 else [softening] * before.size2()
    return sum((element_energy(*e, anisotropy_ratio, law, s) for e, s in zip(pairs, soft, strict=True)), NONE)


def softening_length(before: ca.SX, after: ca.SX, share: float | ca.SX) -> ca.SX:
    """`share` of how far each element (2 d, M) moves in the body frame, shape (1, M) [body lengths]."""
    d = before.size1() // 2
    return ca.sqrt(share**2 * ca.sum1((after[:d, :] - before[:d, :]) ** 2) + LEAST**2)


def planar_rotation(angle: ca.SX) -> ca.SX:
    """Rotation matrix (2, 2)."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s), ca.horzcat(s, c))


def placed(pose: ca.SX, points: ca.SX) -> ca.SX:
    """Points (2, N) of the body frame in the world, where the body has the pose (x, y, heading)."""
    return planar_rotation(pose[2]) @ points + ca.repmat(pose[:2], 1, points.size2())


def spatial_rotation(vector: ca.SX) -> ca.SX:
    """Rotation matrix (3, 3) of a rotation vector (3,): Cayley's map, exact and free of a singularity at zero."""
    n = vector / 2
    cross = ca.skew(n)
    return ca.SX.eye(3) + 2 / (1 + ca.dot(n, n)) * (cross + cross @ cross)


def move(pose: ca.SX, elements: ca.SX) -> ca.SX:
    """Elements (2 d, M) moved by a pose: (x, y, heading) in the plane, (x, y, z, rotation vector) in space."""
    d = elements.size1() // 2
    rotation = planar_rotation(pose[2]) if d == 2 else spatial_rotation(pose[3:])
    positions = rotation @ elements[:d, :] + ca.repmat(pose[:d], 1, elements.size2())
    return ca.vertcat(positions, rotation @ elements[d:, :])
