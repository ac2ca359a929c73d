"""K of an animal: how much more the floor resists across the body than along it, by the law of the answer.

`fit` goes frame by frame: noise of close points shifts that less than windows. It knows a law by eps alone.
Where the law of the answer has numbers of its own, or effects are known, K is 1 / eps of the answer, window by window.
"""

from __future__ import annotations

from math import nan

from serpenoid.compare.calibrate import anisotropy, drag_ratio
from serpenoid.diagnose.diagnose import Diagnosis, DragRatio
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS, MOST_EPS
from serpenoid.diagnose.stages.motion.choose_tracked import STILL
from serpenoid.diagnose.stages.motion.values_of_motion import ratio_ends, ratio_interval
from serpenoid.measure.load import Campaign
from serpenoid.medium import Medium
from serpenoid.model import Model


def drag_ratio_of(found: Diagnosis, campaign: Campaign, begun: Medium) -> DragRatio:
    """K and its 95 % interval if the law of the answer, with what was known, is all there is; begun: with what eps a
    fit begins."""
    selection = found.motion.selection
    alone = selection.null.model
    if STILL in found.motion.stage.words:  # of what moves it nothing is told
        low, high = alone.medium.limits(LEAST_EPS, MOST_EPS)
        return DragRatio(nan, 1 / high, 1 / low, by_frames=not alone.effects)
    if not alone.effects:
        plain = Model(campaign.body, alone.medium.with_ratio(begun.anisotropy_ratio))
        return DragRatio(*drag_ratio(anisotropy(campaign, plain), plain), by_frames=True)
    if found.named:
        ratio, (low, high) = alone.medium.anisotropy_ratio, ratio_ends(selection.motion, selection.null)
    else:
        ratio = selection.settled.model.medium.anisotropy_ratio
        low, high = ratio_interval(selection, found.motion.stage)
    return DragRatio(1 / ratio, 1 / high, 1 / low, by_frames=False)
