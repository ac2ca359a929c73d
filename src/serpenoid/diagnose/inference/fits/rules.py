"""How one of several fits is chosen, or none of them: by what they leave, at a price for parameters and tries.

What a law gets wrong differs between gaits, and between parts of an animal's recording; whether what was found is a
cause, the null says in the end (null.py). A cause that one gait alone shows is not lost so.
"""

from __future__ import annotations

from collections.abc import Sequence

from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest


def choose(base: Fit, fits: Sequence[Fit], tries: int) -> int | None:
    """Index of the best of fits that extend a base, None if the base is as good; tries: how many candidates there were.

    A fit that leaves windows out is none.
    """
    count = float(base.evidence.count.sum())
    whole = [i for i, f in enumerate(fits) if f.evidence.count.sum() >= count]
    priced = [Priced(f.chi2, len(f.coordinates), count) for f in (base, *(fits[i] for i in whole))]
    best = cheapest(priced[0], priced[1:], tries)
    return None if best is None else whole[best]
