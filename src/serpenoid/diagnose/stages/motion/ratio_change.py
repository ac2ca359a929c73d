"""Whether eps is another than in the reference: what all of a body has in common (wheels, scales) has no name, and may
change.

Where the reference played the same gaits its own error of eps is in what it left, which is taken out: eps is then
another where it is not what the reference's model says. Of gaits that are new, the reference's interval counts.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from scipy.special import ndtri

from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.noise.paths import strength
from serpenoid.diagnose.data.noise.repeats import chance_from
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.inference.fits.medium import Fit, linearised
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding
from serpenoid.diagnose.stages.motion.values_of_motion import ends_by_gaits, fits_of_ratio, ratio_ends, ratio_interval
from serpenoid.model import Model


@dataclass(frozen=True)
class RatioChange:
    """eps in the reference and now; strength: path RMS between both, in noise levels."""

    before: float
    after: float
    strength: float

    def record(self) -> dict[str, Any]:
        """As it stands in diagnosis.json."""
        return {
            "before": self.before, "after": self.after, "factor": self.after / self.before,
            "strength_over_noise": self.strength,
        }  # fmt: skip


def ratio_changed(found: MotionFinding, baseline: Baseline) -> RatioChange | None:
    """By more than chance makes of it at the stated error, with and without names that may be stand-ins and effects
    below detection, which may take its place, and visibly; where something is left, by more than gaits disagree about,
    and so where cycles of a trial tell noise: what they share, as a body that was laid elsewhere, each gait has once.
    None where it is not, or without a reference."""
    motion, settled = found.selection.motion, found.selection.settled
    then = baseline.ratio_before(motion.tracks)
    if then is None or motion.ratio_held:
        return None
    far = float(ndtri(1 - ERROR / 2))
    fits = (*fits_of_ratio(found.selection, found.stage), found.selection.best)
    held = [ratio_ends(motion, fit, far) for fit in fits] + [ratio_interval(found.selection, found.stage)]
    held += [ends_by_gaits(motion, fit) for fit in fits] if chance_from(motion.tracks) == "cycles" else []
    if any(low <= then[1] and then[0] <= high for low, high in held):
        return None
    before, after = baseline.model.medium.anisotropy_ratio, settled.model.medium.anisotropy_ratio
    size = strength(motion, settled.predictions, linearised(motion, _with(settled, before), settled.effects)[1])
    change = RatioChange(before, after, size / found.selection.noise_level_m)
    return change if change.strength >= VISIBLE else None


def _with(fit: Fit, ratio: float) -> Model:
    return replace(fit.model, medium=fit.model.medium.with_ratio(ratio))
