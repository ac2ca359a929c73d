"""The geometric momentum as automatic derivative of the step energy.

mu(g) = d/d delta E(exp(delta) g) at delta = 0: (rotation, translation), 3 numbers in the plane and 6 in space.
It equals (1/2 sum mu_rot, sum mu_tran) of Even et al., Eq. 6, whose own factor is -1/2 on both blocks: the roots are
the same, the scaling is not.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.mechanics.energy import NONE, move, step_energy
from serpenoid.media import VISCOUS, Law


def momentum(
    before: ca.SX,
    after: ca.SX,
    pose: ca.SX,
    weights: ca.SX,
    anisotropy_ratio: ca.SX,
    law: Law = VISCOUS,
    softening: ca.SX = NONE,
) -> ca.SX:
    """Momentum of the step from elements `before` to `pose` applied to `after`; (rotation, translation)."""
    d = before.size1() // 2
    delta = ca.SX.sym("delta", pose.numel())
    energy = step_energy(before, move(delta, move(pose, after)), weights, anisotropy_ratio, law, softening)
    gradient = ca.substitute(ca.gradient(energy, delta), delta, ca.SX.zeros(delta.shape))
    return ca.vertcat(gradient[d:], gradient[:d])
