"""Names under the doubt that their intervals show: where the law is wrong, what it leaves open about a value it leaves
open about a name, too.

What an effect takes away counts by how much less the value is known with the law's error than without (law_doubt.py):
the likelihood ratio over that is held against chi squared at 5 %, or, if that is more, the squared distance from the
value that changes nothing, in standard deviations with the law's error. Of several parameters each counts by what it
tells. A law that saturates is known to act where nobody can say how much: its likelihood ratio is more. What data push
beyond a bound, for more than the law's error leaves open, is no value of its law.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.special import chdtri, ndtr

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import NORMAL
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.doubt.law_doubt import doubted
from serpenoid.diagnose.inference.fits.bounds import gained_beyond
from serpenoid.diagnose.inference.fits.evidence import SILENT
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, fit_guided, fit_without, linearised
from serpenoid.diagnose.inference.search.names import Key, Refused, bases_of
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.effects.active import ActiveEffect

Explained = Sequence[tuple[Motion, Fit, float]]


def believed(found: Selection, explained: Callable[[Selection], Explained]) -> Selection:
    """Without names that the law's own error leaves open, the most doubtful first; explained: what is settled on beside
    every explanation of what the law misses, each with its weight; none where the law is not known to be wrong."""
    while found.best.effects and (several := explained(found)):
        gained, beyond = known(found, several)
        doubts = np.maximum(beyond, 1 / np.maximum(gained, SILENT))
        doubtful = int(np.argmax(doubts))
        if doubts[doubtful] < 1:
            break
        found = without(found, doubtful, beyond=bool(beyond[doubtful] >= 1))
    return found


def known(found: Selection, explained: Explained) -> tuple[Floats, Floats]:
    """What each name takes away under the law's error, and what it would take away beyond its bounds, both over what
    leaves nothing out of 95 %."""
    doubt, settled = doubted(explained, hold=False), found.settled
    evidence, _ = linearised(found.motion, settled.model, settled.effects, near=settled.predictions, hold=False)
    usual = evidence.solve(range(len(settled.coordinates)))[1]
    outside = gained_beyond(settled.model, settled.effects, evidence)
    at, surely, shares, beyond = 1, dict[Key, float](), dict[Key, float](), dict[Key, float]()
    for e, more in zip(settled.effects, outside, strict=True):
        moves = [i for i, p in enumerate(e.effect.parameters) if p.neutral is not None]
        rest = found.motion.unchanged(e)
        away = np.array([(e.coordinates[i] - rest[i]) ** 2 for i in moves])
        sure = np.array([doubt[e.name, e.place, i].away ** 2 for i in moves])
        usually = away / np.array([usual[at + i, at + i] for i in moves])
        least = chdtri(len(moves), 2 * ndtr(-NORMAL))
        surely[e.key] = float(np.minimum(sure, usually).sum() / least)
        shares[e.key] = surely[e.key] / float(usually.sum())
        beyond[e.key] = more * shares[e.key]
        at += len(e.effect.parameters)
    best = found.best
    gained = [
        max(surely[e.key], (base.chi2 - best.chi2) * shares[e.key])
        for e, base in zip(best.effects, found.bases, strict=True)
    ]
    return np.array(gained), np.array([beyond[e.key] for e in best.effects])


def without(found: Selection, index: int, beyond: bool = False) -> Selection:
    """The same without one of its names, which is refused; beyond: because the data push it beyond a bound."""
    effect, base = found.best.effects[index], found.bases[index]
    refused = Refused(effect, (base.chi2 - found.best.chi2) / base.chi2, found.best, beyond)
    best = fit_guided(found.motion, base, TO_THE_END)
    return replace(
        found,
        best=best,
        bases=bases_of(found.motion, found.null, best),
        settled=_settled(found, effect) if found.undetected else best,
        refused=(refused, *found.refused),  # first: a law need not be the cause to predict
    )


def _settled(found: Selection, effect: ActiveEffect) -> Fit:
    return fit_without(found.motion, found.settled, effect)
