"""What an explanation must be worth: the same on every stage.

While effects are looked for, the extended Bayesian information criterion (Chen and Chen, Biometrika 95, 759, 2008): chi
squared and ln n for each parameter, 2 ln M for M candidates; in units of what the best fit leaves per number, where
that is more than chance. In the end each must take away more than the best of all candidates would take of what is left
if none were a cause (null.py).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeVar

import numpy as np
from scipy.special import chdtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR


@dataclass(frozen=True)
class Priced:
    """A fit's chi squared, number of parameters and number of residuals."""

    chi2: float
    parameters: int
    count: float

    @property
    def spread(self) -> float:
        """RMS of the residuals, in units of their noise."""
        return float(np.sqrt(self.chi2 / self.count))


class Explanation(Protocol):
    """Some effects and what they leave."""

    @property
    def priced(self) -> Priced:
        """What it leaves."""

    @property
    def size(self) -> int:
        """How many effects it has."""


E = TypeVar("E", bound=Explanation)

PLAINLY = 10.0  # times what is needed: first order is not off by as much


def gained_by_chance(tries: int) -> float:
    """Chi squared, beyond the price of its parameters, that the best of so many candidates gains by chance."""
    return float(2 * np.log(max(tries, 1)))


def most_gained(parameters: int, tries: int) -> float:
    """Chi squared that none of so many candidates of so many parameters each gains by chance, but for ERROR.

    If one of them is true, none of the others is better by more: a rival that is worse by more is excluded.
    """
    return float(chdtri(parameters, ERROR / max(tries, 1)))


def cheapest(base: Priced, fits: Sequence[Priced], tries: int, more: Sequence[float] | None = None) -> int | None:
    """Index of the best fit, None if the base is as good. more: what names that a fit has beyond the base's are to
    gain, by fit; less than none where it has fewer."""
    spread = max(1.0, min(f.chi2 for f in (base, *fits)) / max(base.count, 1.0))
    toll = float(np.log(max(base.count, 2.0)))
    extra = (0.0, *(more if more is not None else np.zeros(len(fits))))
    prices = [f.chi2 + spread * (toll * f.parameters + e) for f, e in zip((base, *fits), extra, strict=True)]
    best = int(np.argmin(prices[1:])) if fits else 0
    return best if fits and prices[0] - prices[1 + best] > spread * gained_by_chance(tries) else None


def outweighed(bare: Priced, best: Priced) -> bool:
    """Whether effects take away less chi squared than they leave above chance: that is an error of another kind.

    bare: no effect at all.
    """
    return bool(bare.chi2 - best.chi2 < best.chi2 - best.count)


def earned(
    best: E, bare: E, without: Callable[[E, Sequence[int]], Sequence[E | None]], needed: Callable[[E], float]
) -> E:
    """Without effects that gain no more, beside the others, than the null of what is left; the least first.

    bare: no effect at all; without: fits without each of some effects, by index; None: it is plainly a cause.
    """
    gains = np.full(best.size, -np.inf)
    while best.size:
        base, gains = _without_the_least(best, bare, without, needed(best), gains)
        if base is None:
            break
        best = base
    return best


def _without_the_least(
    best: E, bare: E, without: Callable[[E, Sequence[int]], Sequence[E | None]], needed: float, gains: Floats
) -> tuple[E | None, Floats]:
    """The explanation without the effect that gains least, None if that is more than is needed; and what each of the
    others gains. gains: the same before the last was dropped; since then they have grown, so that only where it is the
    least of all is another fit needed (Minoux, Optimization Techniques, 234, 1978), and before all are kept."""
    bases, gains = dict[int, E | None](), gains.copy()
    while len(bases) < best.size:
        first = int(gains.argmin())
        asked = [i for i in range(best.size) if i not in bases and (first in bases or gains[i] == gains[first])]
        found = [bare] if best.size == 1 else without(best, asked)
        bases |= zip(asked, found, strict=True)
        gains[asked] = [np.inf if b is None else b.priced.chi2 - best.priced.chi2 for b in found]
        first = int(gains.argmin())
        base = bases.get(first)
        if base is not None and not gains[first] > needed:
            return base, np.delete(gains, first)
    return None, gains


def least_idle(
    best: Priced,
    bases: Sequence[Priced],
    needed: float,
    causes: Callable[[list[int]], Collection[int]] = frozenset,
    more: Sequence[float] | None = None,
) -> int | None:
    """Which effect of an explanation is no cause, by index; of several the one that takes away least. None: all are.

    bases: without each; needed: chi squared that each must take away, and `more` of each; causes: which of those that
    do are causes.
    """
    gains = [b.chi2 - best.chi2 - own for b, own in zip(bases, more or [0.0] * len(bases), strict=True)]
    named = causes([i for i, gain in enumerate(gains) if gain > needed])
    return min((i for i in range(len(bases)) if i not in named), key=lambda i: gains[i], default=None)
