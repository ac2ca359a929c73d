"""Groups on the stage of motion: what else could stand in the place of each chosen effect, the others kept.

A rival is fitted to the data together with eps and the kept effects. It belongs to the group if the data cannot exclude
it: were it true, the choice would by chance be as much better as it is. S_ab, the path RMS between the predictions of
the choice and of the rival over the noise level, is told. Candidates are scored linearly first; those that could come
close are fitted in full.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from serpenoid.diagnose.data.noise.paths import strength
from serpenoid.diagnose.inference.fits.finding import Rival, excludable
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, candidates_of
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.diagnose.inference.search.ranking import score, shortlist
from serpenoid.diagnose.inference.search.scans import Ranked
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import SCREENING, attempt, finished
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

AT_MOST = 10  # full fits for each chosen effect
FIRST_ORDER = 0.4  # of the choice's gain: what linear scores fall short by, where effects are strong
SCREENED = 0.1  # of the choice's gain: what the last steps of a fit may still win


@dataclass(frozen=True)
class Swap:
    """A rival and the fit in which it stands in the place of a chosen effect."""

    rival: Rival
    fit: Fit


def groups(found: Selection) -> tuple[Swap, ...]:
    """Rivals of every chosen effect, best fit first."""
    swaps = [s for e, base in zip(found.best.effects, found.bases, strict=True) for s in _of(found, e, base)]
    return tuple(sorted(swaps, key=lambda s: s.fit.chi2))


def band(choice: Fit) -> float:
    """Chi squared by which a rival of an effect of a fit must be worse to be excluded."""
    parameters = max((len(e.effect.parameters) for e in choice.effects), default=1)
    return most_gained(parameters, len(candidates_of(choice)))


def _of(found: Selection, effect: ActiveEffect, base: Fit) -> list[Swap]:
    motion, best, gained = found.motion, found.best, base.chi2 - found.best.chi2
    size = float(best.evidence.count.sum())
    close = promising(score(motion, base), {e.key for e in best.effects}, FIRST_ORDER * gained)
    tries = in_processes([(attempt, (motion, base, e, x, SCREENING)) for e, _, x in close])
    width = band(best)
    tries = [t for t in tries if not excludable(t.fit.chi2, best.chi2, size, width, SCREENED * gained)]
    rivals: dict[tuple[str, int | None], Swap] = {}
    for t in in_processes([(finished, (motion, t, TO_THE_END)) for t in tries]):
        apart = strength(motion, best.predictions, t.fit.predictions) / found.noise_level_m
        rival = Rival(t.fitted, effect, apart)
        key = t.added.key
        if excludable(t.fit.chi2, best.chi2, size, width):
            continue
        if key not in rivals or t.fit.chi2 < rivals[key].fit.chi2:
            rivals[key] = Swap(rival, t.fit)
    return list(rivals.values())


def promising(ranked: Sequence[Ranked], chosen: set[tuple[str, int | None]], slack: float) -> list[Ranked]:
    """Candidates other than the chosen, of names whose best falls short of the largest gain by no more than `slack`."""
    most = max((gain for _, gain, _ in ranked), default=0.0)
    near = {e.name for e, gain, _ in ranked if e.key not in chosen and most - gain <= slack}
    return shortlist([r for r in ranked if r[0].key not in chosen and r[0].name in near], AT_MOST)
