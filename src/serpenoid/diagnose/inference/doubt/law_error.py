"""What a law may get wrong of what it does: the same where servos are judged by their readings and by markers.

What a law gets wrong is in proportion to what it does. An effect at a place that leaves more of it than LAW_ERROR is
not what happens there, and has no name; nor has one that the whole body shares and that leaves more than it does. What
leaves less, but visibly, is the nearest law: of servos a stand-in; of what all markers show, from LAW_ERROR on.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.diagnose.inference.fits.prices import E
from serpenoid.effects.active import ActiveEffect

LAW_ERROR = 1 / 3  # of what an effect does
ON_A_LINE = 4  # trials: three points lie nearly on one by chance


def far_less(calm: Floats, astray: Floats) -> NDArray[np.bool_]:
    """Whether every one of some trials' mean squares (T, ..) is less than every other's by what a law may get wrong."""
    return np.asarray(calm.max(axis=0) <= LAW_ERROR**2 * astray.min(axis=0))


def lawful(
    best: E,
    effects: Callable[[E], list[ActiveEffect]],
    error: Callable[[E, ActiveEffect], float],
    without: Callable[[E, int], E],
    shared: float = 1.0,
) -> tuple[E, tuple[str, ...]]:
    """Without effects that are no law of what happens, and what is said of them; the others are fitted again.

    effects: an explanation's; error: what one leaves of what it does, as a share; without: one less, by index; shared:
    the most of it that one of the whole body may leave.
    """
    refused: tuple[str, ...] = ()
    while every := effects(best):
        shares = [error(best, e) for e in every]
        excess = [s / (shared if e.place is None else LAW_ERROR) for s, e in zip(shares, every, strict=True)]
        worst = int(np.argmax(excess))
        if excess[worst] <= 1:
            break
        refused += (_words(every[worst], shares[worst]),)
        best = without(best, worst)
    return best, refused


def _words(e: ActiveEffect, share: float) -> str:
    where = "" if e.place is None else f" at {e.effect.place} {e.place}"
    much = f"{share:.0%} of what it does" if share <= 1 else "more than it does"
    return f"{e.name}{where} would leave {much}: not its law"
