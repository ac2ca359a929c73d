"""Coulomb friction of each way on its own: E = w (|v_n| + eps |v_t|), a box of forces instead of an ellipse.

    force = -w (sign(v_n) N + eps sign(v_t) T):  |f_n| <= w, |f_t| <= eps w

So wheels with dry axles resist, whose rolling knows nothing of what their tyres do sideways, and so many models of
snake robots are written (Transeth, Leine, Glocker and Pettersen 2008; Liljeback et al. 2013). With the friction ellipse
(`coulomb`) a wheel that slides sideways hardly resists rolling; here it resists as much as ever.

Softened as `coulomb` is, each way by itself.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.media.base import Rival
from serpenoid.media.coulomb import LAW as COULOMB
from serpenoid.media.viscous import LAW as VISCOUS

LAW = replace(
    COULOMB,
    name="coulomb_by_components",
    title="dry friction by components",
    slip="parts",
    rival=Rival(VISCOUS, "dry friction (Coulomb) by components", frozenset({"ground"})),
)
