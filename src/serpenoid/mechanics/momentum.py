"""The geometric momentum as automatic derivative of the step energy.

mu(g) = d/d delta E(exp(delta) g) at delta = 0: (rotation, translation), 3 numbers in the plane and 6 in space.
It equals (1/2 sum mu_rot, sum mu_tran) of Even et al., Eq. 6, whose own factor is -1/2 on both blocks: the roots are
the same, the scaling is not. Of a law without a potential it is the wrench: the slope of the quadratic form that has
the law's multipliers as they are.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.mechanics.energy import NONE, move, squared_slips, step_energy
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
    moved = move(delta, move(pose, after))
    if law.variational:
        energy = step_energy(before, moved, weights, anisotropy_ratio, law, softening)
        return _slope(energy, delta, d)
    ratio = law.form_ratio(anisotropy_ratio)
    slips = [squared_slips(*pair) for pair in zip(ca.horzsplit(before), ca.horzsplit(moved), strict=True)]
    held = ca.SX.sym("multipliers", 2, len(slips))
    energy = sum(
        (w * (m[0] * across + m[1] * ratio * along) / 2
         for w, m, (across, along) in zip(ca.vertsplit(weights), ca.horzsplit(held), slips, strict=True)), NONE
    )  # fmt: skip
    soft = ca.horzsplit(softening) if softening.numel() > 1 else [softening] * len(slips)
    values = [ca.vertcat(*law.multipliers(*slip, ratio, s)) for slip, s in zip(slips, soft, strict=True)]
    there = ca.substitute(ca.horzcat(*values), delta, ca.SX.zeros(delta.shape))
    return ca.substitute(_slope(energy, delta, d), held, there)


def _slope(energy: ca.SX, delta: ca.SX, d: int) -> ca.SX:
    """Of an energy by delta, at delta = 0."""
    gradient = ca.substitute(ca.gradient(energy, delta), delta, ca.SX.zeros(delta.shape))
    return ca.vertcat(gradient[d:], gradient[:d])
