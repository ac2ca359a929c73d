"""Does something that grows from trial to trial do better than what is named?

Gait by gait, a wheel that wears makes gaits differ, and repeats little: a law that all trials share may mend that. So
what is named is held against eps and each single effect that grows evenly over the trials' order, from nothing in the
first, to first order beside eps alone,

    r_t = J_eps d_eps + s_t J theta + e,    s_t: from 0 to 1

by the same price, all that are tried counted. First order falls short of what a large effect does, so the rival is
weighed too lightly, never too much. Where nothing is named, it is held against each single effect that is the same in
all trials (s_t = 1), by the same first order.

Legend: T trials.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.windows.windows import Prediction, columns_of, predictions
from serpenoid.diagnose.inference.doubt.law_error import ON_A_LINE
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of, of_windows
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.effects.active import ActiveEffect
from serpenoid.simulation.sensitivity import EPS
from serpenoid.wording import GROWING


def grows_instead(found: Selection) -> str:
    """What grows, in words, if that is cheaper than all that is named of the motion; else empty."""
    motion, null, best = found.motion, found.null, found.best
    if len(motion.tracks) < ON_A_LINE or any(t.noise is not None for t in motion.tracks):
        return ""
    tried = [c for c in candidates_of(null) if not c.effect.remembers]  # to first order what does explains all pauses
    predicted = predictions(null.model, motion.tracks, tried, null.predictions)
    rivals = priced_by_shares(motion, null, predicted, tried, np.linspace(0, 1, len(motion.tracks)))
    alike = best.priced
    if not best.effects:
        same = priced_by_shares(motion, null, predicted, tried, np.ones(len(motion.tracks)))[
            1:
        ]  # eps is in all of them
        least = cheapest(alike, same, len(same))
        alike = alike if least is None else same[least]
    cheaper = cheapest(alike, rivals, len(rivals))
    if cheaper is None:
        return ""
    called = "another anisotropy ratio" if cheaper == 0 else f"`{tried[cheaper - 1].called}`"
    named = "what is named, which acts in all of them alike" if best.effects else "any that acts in all of them alike"
    return f"one cause that grows from trial to trial (to first order {called}) explains more than {named}: {GROWING}"


def priced_by_shares(
    motion: Motion, null: Fit, predicted: Sequence[Prediction], tried: Sequence[ActiveEffect], shares: Floats
) -> list[Priced]:
    """What another eps, and each effect, leaves to first order beside eps, where so much of it acts in each trial (T,);
    predicted: by the fit of eps (`null`), with columns of all that is tried."""
    columns = (EPS, *columns_of(tried))
    by = [np.concatenate([p.by((EPS,)), s * p.by(columns)], axis=2) for p, s in zip(predicted, shares, strict=True)]
    ends = [1, 2, *(2 + np.cumsum([len(c.effect.parameters) for c in tried])).tolist()]
    groups = tuple(tuple(range(a, b)) for a, b in zip(ends[:-1], ends[1:], strict=True))
    gains = of_windows(motion, predicted, by).gains(range(1), groups)
    count = null.priced.count
    return [Priced(null.chi2 - gained, 1 + len(g), count) for (gained, _), g in zip(gains, groups, strict=True)]
