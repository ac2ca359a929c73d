"""Does what markers show beside the servos differ from trial to trial, as where a marker peels off or a horn slips?

One value for all trials leaves more than its error then. Every effect is fitted to each trial by itself, beside what is
found: to first order, and the best of them to the end. The cheapest counts, each trial's numbers at their price, if it
leaves less than LAW_ERROR of what was left.

Legend: T trials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.diagnose.data.cameras.columns import columns_of
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR, ON_A_LINE
from serpenoid.diagnose.inference.fits.finding import Divided
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest
from serpenoid.diagnose.stages.by_trial import ByTrial, divided, said_by_trial
from serpenoid.diagnose.stages.observation.looked import Key, Looked, effect_of, solved
from serpenoid.diagnose.stages.observation.marker_evidence import sample
from serpenoid.parallel import in_processes


@dataclass(frozen=True)
class SeenByTrial:
    """An effect whose numbers are each trial's own, beside what is found in all of them: in words; models: of each
    trial; key: which it is; priced: what all of it leaves, and how many numbers it has; divided: trials, where it has
    one value in some and another in the others."""

    told: ByTrial
    models: tuple[Observation, ...]
    key: Key
    priced: Priced
    divided: Divided


def slipping(recordings: Sequence[Recording], best: Looked, full_fits: int) -> tuple[Looked, SeenByTrial | None]:
    """What is found in all trials, and the effect that differs beside it, if one does: without what was found at the
    place of that one, if the two together cost less so. Several effects of one marker may mend what one of them, which
    slips, leaves. full_fits: how many effects, those that are best to first order, are fitted to the end."""
    found = seen_by_trial(recordings, best, full_fits)
    there = [] if found is None else [i for i, key in enumerate(best.keys) if key[1] == found.key[1] is not None]
    if found is None or not there:
        return best, found
    less = best
    for i in reversed(there):
        less = less.without_one(i)
    other = seen_by_trial(recordings, less, full_fits)
    return (best, found) if other is None or cheapest(found.priced, [other.priced], 1) is None else (less, other)


def seen_by_trial(recordings: Sequence[Recording], best: Looked, full_fits: int) -> SeenByTrial | None:
    """The effect that costs least so, beside what is found in all trials; None where none differs."""
    if len(recordings) < ON_A_LINE:
        return None
    parts = [replace(best, data=sample([r])) for r in recordings]
    body, count = best.data.body, sum(p.data.count for p in parts)
    every = [*best.keys, *best.others]
    first = [sum(p.sums.chi2(columns_of(body, *key)) for p in parts) for key in every]
    tried = [every[i] for i in np.argsort(first)[:full_fits]]
    fits = in_processes([(_fitted, (parts, key)) for key in tried])
    left = [sum(p.priced.chi2 for p in of) for of in fits]
    numbers = [len(parts) * len(columns_of(body, *key)) for key in tried]
    before = sum(p.priced.chi2 for p in parts)
    prices = [Priced(chi2, n, count) for chi2, n in zip(left, numbers, strict=True)]
    found = cheapest(Priced(before, 0, count), prices, len(every))
    if found is None or left[found] - count > LAW_ERROR**2 * (before - count):
        return None
    effects = [[effect_of(p, tried[found])] for p in fits[found]]
    names = [r.name for r in recordings]
    said = said_by_trial(effects, names, body.joint_count)
    all_numbers = numbers[found] + len(best.own)
    models, priced = tuple(p.now for p in fits[found]), Priced(left[found], all_numbers, count)
    return SeenByTrial(said, models, tried[found], priced, divided([e for (e,) in effects], names, said.words))


def _fitted(parts: Sequence[Looked], key: Key) -> list[Looked]:
    """Each trial with this effect as it has it, what else is found as it is in all of them."""
    return [replace(p, now=solved(p.data, p.now, (key,), p.sums)) for p in parts]
