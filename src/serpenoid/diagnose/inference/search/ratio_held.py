"""Beside a reference: the anisotropy ratio as it was, or another one, which is a cause like others and has its price.

eps is common to all of a body. Where fits may change it for nothing, it takes over most of what one wheel or a slippery
place does, and what is left says next to nothing of the cause. So changes are looked for with eps as it was. Another
eps is asked about where it earns its price: alone, or beside what was found. Then all is searched with eps free, too,
and the likelier of both answers is taken, errors of the law included (discrepancy.py): those of another eps are in
proportion to what it does, as those of any cause.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, candidates_of, fit_eps, fit_guided
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.inference.search.discrepancy import by_gait, deviance, price, worse
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.model import Model


def held(motion: Motion, model: Model) -> tuple[Motion, Fit]:
    """A motion whose fits leave eps as it is in a model, and a fit of nothing."""
    motion = replace(motion, ratio_held=True)
    return motion, fit_eps(motion, model)


def as_it_was_or_another(found: Selection, again: Callable[[], Selection], wrong: bool) -> Selection:
    """What was found with eps as it was, or, if it is likelier for its price, what is found `again` with eps free.

    wrong: the law is known to be. Then another eps beside the same causes may mend it: gaits must agree about that.
    """
    if not _worth_asking(found):
        return found
    free = again()
    motion = replace(free.motion, ratio_held=True)
    same = fit_guided(motion, found.best, TO_THE_END)
    if same.evidence.count.sum() < free.best.evidence.count.sum():
        return free
    if _criterion(motion, same) <= _criterion(free.motion, free.best):
        return found
    beside = {e.key for e in same.effects} <= {e.key for e in free.best.effects} and bool(same.effects)
    law_open = wrong or free.motion.unrepeated or discrepancy(free.motion, free.best.predictions) > 0
    if beside and law_open and not worse(by_gait(motion, same), by_gait(free.motion, free.best)):
        return found
    return free


def _worth_asking(found: Selection) -> bool:
    """Whether another eps, alone or beside what was found, is likelier for its price than eps as it was."""
    free, least = replace(found.motion, ratio_held=False), _criterion(found.motion, found.best)
    bare = fit_eps(free, found.null.model)
    others = [bare, fit_guided(free, found.best, TO_THE_END)] if found.best.effects else [bare]
    return any(_criterion(free, other) < least for other in others)


def _criterion(motion: Motion, found: Fit) -> float:
    """See `information_criterion`; another eps counts as one more effect of one parameter."""
    deviated, count = deviance(motion, found)
    criterion = deviated + price(found, count)
    if motion.ratio_held:
        return criterion - float(np.log(max(count, 2)))
    return criterion + gained_by_chance(len(candidates_of(found)) + len(found.effects))
