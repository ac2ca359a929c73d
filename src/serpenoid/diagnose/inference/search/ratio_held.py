"""Beside a reference: eps as it was, or another one, which is a cause like any other and has its price."""

from __future__ import annotations

import os
import sys
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, candidates_of, fit_eps, fit_guided
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.inference.search.discrepancy import deviance, information_criterion
from serpenoid.diagnose.inference.search.select import Selection


def as_taken(chosen: Selection, motion: Motion, null: Fit) -> tuple[Motion, Fit]:
    """A motion beside another explanation, and a fit of nothing; eps held if it is so in what was chosen."""
    if not chosen.motion.ratio_held:
        return motion, null
    held = replace(motion, ratio_held=True)
    return held, fit_eps(held, replace(null.model, medium=null.model.medium.with_ratio(motion.ratio)))


def the_same_or_another(free: Selection, held: Selection) -> Selection:
    """What is found with eps as it was, unless what is found with another one is likelier for its price."""
    motion = free.motion
    base = replace(motion, ratio_held=True)
    other = fit_guided(base, held.best, TO_THE_END)
    if other.evidence.count.sum() < free.best.evidence.count.sum():
        return free
    count = float(other.evidence.count.sum())
    price = gained_by_chance(len(candidates_of(free.best)) + len(free.best.effects))
    a = information_criterion(motion, free.best) + price
    b = information_criterion(base, other) - float(np.log(max(deviance(motion, other)[1], 2)))
    if os.environ.get("SHOW"):
        def show(fit):
            return [(e.name, e.place, [round(float(c), 3) for c in e.coordinates[:-1]]) for e in fit.effects], round(fit.model.medium.anisotropy_ratio, 4), round(fit.chi2)
        print("FREE", show(free.best), "ic", a, "before", motion.ratio, "HELD", show(held.best), show(other), "ic", b, "refused", [(r.effect.name, r.effect.place, round(r.share, 3)) for r in held.refused], "count", count, "null", round(free.null.chi2), round(held.null.chi2), file=sys.stderr)
    return held if b <= a else free
