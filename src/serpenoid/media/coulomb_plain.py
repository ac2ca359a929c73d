"""Coulomb friction in the direction of the drag: force = -w (v_n N + eps v_t T) / |v|, as of slithering snakes.

The coefficients weigh the direction of the slip, 1 across and eps along (Hu, Nirody, Scott and Shelley 2009; Alben
2013). With the friction ellipse (`coulomb`) the slip is normal to the ellipse of forces, and the force the slope of a
potential; here it is not, so that a step is found by its balance of forces, and what is told of it is its work.

Softened as `coulomb` is.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.media.base import Rival
from serpenoid.media.coulomb import LAW as COULOMB
from serpenoid.media.viscous import LAW as VISCOUS

LAW = replace(
    COULOMB,
    name="coulomb_plain",
    title="dry friction by the plain slip",
    slip="plain",
    rival=Rival(VISCOUS, "dry friction (Coulomb) by the plain slip", frozenset({"ground"})),
)
