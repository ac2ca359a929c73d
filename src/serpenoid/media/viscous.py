"""Linear drag: E = w q / 2, and eps is the ratio of the drag coefficients (Even et al., Eq. 3)."""

from __future__ import annotations

from serpenoid.media.base import Law, Quantity


def _potential(q: Quantity, softening: Quantity) -> Quantity:
    return q / 2


def _multiplier(q: Quantity, softening: Quantity) -> Quantity:
    return q**0


LAW = Law(
    name="viscous",
    words="drag",
    title="linear drag",
    degree=2,
    potential=_potential,
    multiplier=_multiplier,
)
