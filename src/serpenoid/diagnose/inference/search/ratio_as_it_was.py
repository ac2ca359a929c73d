"""Beside a reference: a fit with the anisotropy ratio that it had, where another ratio takes most of what has changed.

eps is fitted before effects are looked for, and what one wheel or a slippery place does another eps may do nearly as
well. Of what is left then the cause takes next to nothing, and a fit of it that begins there ends there. So the search
begins here, too.
"""

from __future__ import annotations

from dataclasses import replace

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.fits.medium import Fit, fit_eps

MOST = 1 / 2  # of what has changed: another eps that takes less stands in nobody's way
HELD = 1e-4  # of eps: between bounds so near to it


def as_it_was(motion: Motion, null: Fit) -> Fit | None:
    """Nothing but the earlier eps, which stays; None without a reference, or where another one takes less than most, or
    the body has no path with the earlier one.

    null: another eps alone.
    """
    if motion.ratio is None:
        return None
    medium, near = null.model.medium.with_ratio(motion.ratio), motion.ratio * HELD
    base = fit_eps(motion, replace(null.model, medium=medium.within(motion.ratio - near, motion.ratio + near)))
    if taken(base, null) < MOST or base.evidence.count.sum() < null.evidence.count.sum():
        return None
    return base


def freed(base: Fit, null: Fit) -> Fit:
    """The same where fits that go on from it may change eps again."""
    medium = null.model.medium.with_ratio(base.model.medium.anisotropy_ratio)
    return replace(base, model=replace(base.model, medium=medium))


def taken(base: Fit, found: Fit) -> float:
    """Share of chi squared that is gone."""
    return 1 - found.chi2 / base.chi2
