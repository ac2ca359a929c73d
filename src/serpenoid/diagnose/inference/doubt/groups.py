"""Groups on the stage of motion: what else could stand in the place of each chosen effect, the others kept.

A rival is fitted to the data together with eps and the kept effects. It belongs to the group if the data cannot exclude
it: were it true, the choice would by chance be as much better as it is. S_ab, the path RMS between the predictions of
the choice and of the rival over the noise level, is told. Candidates are scored linearly first; those that could come
close are fitted in full.

Where a law is known to be wrong beside a reference, what it gets wrong makes one of two explanations better in some
gaits than in others. So they are held against each other by their likelihood, the law's error included
(discrepancy.py), and gaits and directions are the independent numbers: a rival is excluded if they agree that it is
worse (Student's t of their differences; Vuong, Econometrica 57, 307, 1989, by groups).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from serpenoid.diagnose.data.noise.paths import strength
from serpenoid.diagnose.inference.fits.finding import Rival, excludable
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, candidates_of, fit_guided
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.diagnose.inference.search.discrepancy import by_gait, worse
from serpenoid.diagnose.inference.search.names import Key, Try
from serpenoid.diagnose.inference.search.ranking import score, shortlist
from serpenoid.diagnose.inference.search.scans import Ranked
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import OUT_OF_REACH, SCREENING, as_much_elsewhere, attempt, finished
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


def groups(found: Selection, wrong: bool = False) -> tuple[Swap, ...]:
    """Rivals of every chosen effect, best fit first; wrong: a law is, or may be."""
    pairs = list(zip(found.best.effects, found.bases, strict=True))
    swaps = [s for e, base in pairs for s in _of(found, e, base)]
    if wrong and found.motion.ratio is not None:
        known = {(s.rival.effect.key, s.rival.instead_of.key) for s in swaps}
        more = [s for e, base in pairs for s in _by_gaits(found, e, base)]
        swaps += [s for s in more if (s.rival.effect.key, s.rival.instead_of.key) not in known]
    return tuple(sorted(swaps, key=lambda s: s.fit.chi2))


def as_another_ratio(found: Selection) -> list[ActiveEffect]:
    """Names instead of which another eps than the reference's would do as well, by what gaits tell."""
    motion = found.motion
    if not motion.ratio_held:
        return []
    free, best = replace(motion, ratio_held=False), by_gait(motion, found.best)
    each = zip(found.best.effects, found.bases, strict=True)
    return [e for e, base in each if not worse(by_gait(free, fit_guided(free, base, TO_THE_END)), best)]


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
    return _not_excluded(found, effect, tries, lambda fit: excludable(fit.chi2, best.chi2, size, width))


def _by_gaits(found: Selection, effect: ActiveEffect, base: Fit) -> list[Swap]:
    """Rivals that gaits do not agree to exclude: the best to first order, and the same effect at other places."""
    motion, best, taken = found.motion, found.best, {e.key for e in found.best.effects}
    close = shortlist([r for r in score(motion, base) if r[0].key not in taken and r[1] > 0], AT_MOST)
    close += [r for r in as_much_elsewhere(motion, base, effect) if r[0].key not in taken]
    tries = in_processes([(attempt, (motion, base, e, x, SCREENING)) for e, _, x in close])
    whole, left = base.evidence.count.sum(), by_gait(motion, best)
    tries = [t for t in tries if t.fit.chi2 < OUT_OF_REACH * best.chi2 and t.fit.evidence.count.sum() >= whole]
    return _not_excluded(found, effect, tries, lambda fit: worse(by_gait(motion, fit), left))


def _not_excluded(
    found: Selection, effect: ActiveEffect, tries: Sequence[Try], excluded: Callable[[Fit], bool]
) -> list[Swap]:
    """Rivals of an effect that are not excluded when they are fitted to the end, the best of each name and place."""
    motion, rivals = found.motion, dict[Key, Swap]()
    for t in in_processes([(finished, (motion, t, TO_THE_END)) for t in tries]):
        known = rivals.get(t.added.key)
        if excluded(t.fit) or (known is not None and t.fit.chi2 >= known.fit.chi2):
            continue
        apart = strength(motion, found.best.predictions, t.fit.predictions) / found.noise_level_m
        rivals[t.added.key] = Swap(Rival(t.fitted, effect, apart), t.fit)
    return list(rivals.values())


def promising(ranked: Sequence[Ranked], chosen: set[tuple[str, int | None]], slack: float) -> list[Ranked]:
    """Candidates other than the chosen, of names whose best falls short of the largest gain by no more than `slack`."""
    most = max((gain for _, gain, _ in ranked), default=0.0)
    near = {e.name for e, gain, _ in ranked if e.key not in chosen and most - gain <= slack}
    return shortlist([r for r in ranked if r[0].key not in chosen and r[0].name in near], AT_MOST)
