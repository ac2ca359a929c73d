"""What else does as much as another anisotropy ratio: beside a reference, where that takes most of what has changed.

eps is fitted before effects are looked for, and what one wheel does to a path another eps may do as well. So where
nothing is named and another eps leaves more than noise, single changes are fitted once more with eps as it was, and
held against it by their likelihood, the law's error included (explanations.py). They have no names: which of them it
is, is left open.
"""

from __future__ import annotations

from collections.abc import Sequence

from serpenoid.diagnose.data.chance import CONFIDENCE
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.inference.doubt.explanations import likely, singles
from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.diagnose.inference.search.names import Try
from serpenoid.diagnose.inference.search.ratio_as_it_was import as_it_was, taken
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import at_other_places, attempts
from serpenoid.wording import listed


def as_much_as_another_ratio(found: Selection) -> tuple[str, ...]:
    """In words; none without a reference, or where an effect is named, or another eps does not take most."""
    motion, null = found.motion, found.null
    if found.best.effects or not discrepancy(motion, null.predictions):
        return ()
    base = as_it_was(motion, null)
    if base is None:
        return ()
    tries = singles(motion, base.model)
    tries += attempts(motion, base, at_other_places(motion, base, tries))
    same = _as_likely(motion, null, tries)
    if not same:
        return ()
    return (
        f"another anisotropy ratio takes away {taken(base, null):.0%} of what has changed; if it is what it was, "
        f"{_which(base, same)} may do it: which of them it is, what the law gets wrong leaves open",
    )


def _which(base: Fit, same: Sequence[Try]) -> str:
    """Changes by name, with places and how much they take away, the likeliest first."""
    said = []
    for name in dict.fromkeys(t.added.name for t in same):
        mine = [t for t in same if t.added.name == name]
        shares = sorted({f"{taken(base, t.fit):.0%}" for t in mine})
        places = [str(t.added.place) for t in mine if t.added.place is not None]
        where = f" at {mine[0].added.effect.place} {listed(places, 'or')}" if places else ""
        said.append(f"{name}{where} ({' to '.join(dict.fromkeys((shares[0], shares[-1])))})")
    return listed(said, "or")


def _as_likely(motion: Motion, null: Fit, tries: list[Try]) -> list[Try]:
    """Single changes that the data do not exclude beside the likeliest and another eps, the likeliest first."""
    each = {t.added.key: (likely(motion, t.fit, 1.0), t) for t in sorted(tries, key=lambda t: -t.fit.chi2)}
    ordered = sorted(each.values(), key=lambda pair: pair[0].left)
    every = [likely(motion, null, 1.0), *(how for how, _ in ordered)]
    most = min(every, key=lambda how: how.left)
    return [t for how, t in ordered if how.over(most) > 1 - CONFIDENCE]
