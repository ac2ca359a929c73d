"""How one of several fits is chosen, or none of them: by what they leave or by how they predict.

Robots play several gaits several times, and what a law gets wrong differs between gaits: what a fit leaves, with a
price on parameters and tries, decides here, and the null (null.py) in the end. A cause that one gait alone shows is
not lost so. An animal does much the same over and over: there the prediction of unseen parts decides, and an effect
must be worth something.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.bounds import overstrained
from serpenoid.diagnose.inference.held_out import LeaveOut, each_held_out
from serpenoid.diagnose.inference.medium import Fit
from serpenoid.diagnose.inference.prices import Priced, cheapest

GAIN = 25.0  # chi squared on held-out parts: the best of 60 tries on nothing stays below 20


class Rule(Protocol):
    """Chooses among fits that extend a base."""

    def choose(self, motion: Motion, base: Fit, fits: Sequence[Fit], tries: int) -> int | None:
        """Index of the best fit, None if the base is as good; tries: how many candidates there were."""
        ...


@dataclass(frozen=True)
class Penalised:
    """By what they leave, at a price for parameters and tries (prices.py)."""

    def choose(self, motion: Motion, base: Fit, fits: Sequence[Fit], tries: int) -> int | None:
        """See `Rule`. A fit that leaves windows out is none."""
        count = float(base.evidence.count.sum())
        whole = [i for i, f in enumerate(fits) if f.evidence.count.sum() >= count]
        priced = [Priced(f.chi2, len(f.coordinates), count) for f in (base, *(fits[i] for i in whole))]
        best = cheapest(priced[0], priced[1:], tries)
        return None if best is None else whole[best]


@dataclass(frozen=True)
class Unseen:
    """By the prediction of held-out parts.

    worth: share of what is left above chance that an effect must take away, however significant it is. An effect that
    ends at a bound of its own explains nothing.
    """

    leave_out: LeaveOut
    worth: float

    def choose(self, motion: Motion, base: Fit, fits: Sequence[Fit], tries: int) -> int | None:
        """See `Rule`."""
        before = self._held_out(motion, base)
        goal = before - max(GAIN, self.worth * (before - float(base.evidence.count.sum())))
        # nothing is predicted better than what is fitted
        held_out = {i: self._held_out(motion, f) for i, f in enumerate(fits) if f.chi2 < goal}
        best = min(held_out, key=lambda i: held_out[i], default=None)
        return None if best is None or held_out[best] >= goal else best

    def _held_out(self, motion: Motion, found: Fit) -> float:
        """Chi squared of every part predicted by a fit to the others, summed; infinite where steps have no root."""
        if any(overstrained(found.model, e) for e in found.effects):
            return np.inf
        total = 0.0
        for unseen in each_held_out(motion, found, self.leave_out):
            whole = 3 * sum(int(motion.tracks[i].usable.sum()) for i in unseen.index)
            total += float(unseen.evidence.constant.sum()) if unseen.evidence.count.sum() == whole else np.inf
        return total


PENALISED = Penalised()
