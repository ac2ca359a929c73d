"""Whether one cause began to act with some gait, where each gait is played through before the next: no repeat shows it.

Then gaits differ by it, as they may by any error of the law. So it is told only where it leaves nothing but chance:

    r_t = J_eps d_eps + s_t J theta + e,    s_t: 1 in trials in which it acts, else 0

Every cause at every moment that parts no repeats is tried to first order, and one that grows evenly over the trials'
order. The best, if it is one that began, is fitted in full, and what it leaves is asked for any pattern. Which trials
are the changed ones is a guess (`perhaps`): it is told if they are explained alone.

Legend: T trials.
"""

from __future__ import annotations

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import path_error
from serpenoid.diagnose.data.noise.repeats import pairs
from serpenoid.diagnose.data.windows.windows import predictions
from serpenoid.diagnose.inference.doubt.growing import priced_by_shares
from serpenoid.diagnose.inference.fits.finding import Divided
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of
from serpenoid.diagnose.inference.fits.prices import cheapest
from serpenoid.diagnose.residuals.acting import acting
from serpenoid.diagnose.residuals.in_some_trials import runs_of
from serpenoid.diagnose.residuals.residual_words import pattern
from serpenoid.wording import listed


def begun_with_a_gait(motion: Motion, null: Fit) -> Divided | None:
    """Trials in which it acts, beside eps alone (`null`); None where repeats tell it, and where it leaves more than
    chance."""
    played = pairs(motion.tracks)
    runs = [run for run in runs_of(len(motion.tracks)) if all(run[a] == run[b] for a, b in played)]
    if not played or not runs or any(t.noise is not None for t in motion.tracks):
        return None
    tried = [c for c in candidates_of(null) if not c.effect.remembers]  # as in growing.py
    predicted = predictions(null.model, motion.tracks, tried, null.predictions)
    begun = [p for run in runs for p in priced_by_shares(motion, null, predicted, tried, run)[1:]]  # eps is each gait's
    growing = priced_by_shares(motion, null, predicted, tried, np.linspace(0, 1, len(motion.tracks)))
    best = cheapest(null.priced, [*begun, *growing], len(begun) + len(growing))
    if best is None or best >= len(begun):
        return None
    at, which = divmod(best, len(tried))
    acts, cause = runs[at], tried[which]
    left = acting(motion, null, cause, acts).predicted
    if pattern(motion, left, path_error(motion, left)):
        return None
    changed, others = (
        tuple(t.recording.name for t, x in zip(motion.tracks, acts, strict=True) if x == side) for side in (True, False)
    )
    few = min(changed, others, key=len)
    words = (
        f"one cause (to first order `{cause.called}`) that acts in {listed([f'`{n}`' for n in few])} alone, or in all "
        "other trials alone, leaves nothing but chance: play all gaits, then all of them again, to be sure"
    )
    return Divided(words, changed, others, perhaps=True, any_gait=True, cause=f"`{cause.called}`")
