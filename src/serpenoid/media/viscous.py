"""Linear drag: E = w q / 2, and eps is the ratio of the drag coefficients (Even et al., Eq. 3)."""

from __future__ import annotations

import casadi as ca

from serpenoid.media.base import Law


def _potential(q: ca.SX, softening: ca.SX) -> ca.SX:
    return q / 2


def _multiplier(q: ca.SX, softening: ca.SX) -> ca.SX:
    return ca.SX(1)


def _form_ratio(eps: ca.SX) -> ca.SX:
    return eps


VISCOUS = Law("viscous", 2, _potential, _multiplier, _form_ratio)
