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

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.columns import columns_of
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR, ON_A_LINE
from serpenoid.diagnose.inference.fits.finding import Divided, alone
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest
from serpenoid.diagnose.stages.actuation.law_by_trial import ByTrial, said_by_trial, with_unit
from serpenoid.diagnose.stages.observation.looked import Key, Looked, effect_of, solved
from serpenoid.diagnose.stages.observation.marker_evidence import sample
from serpenoid.effects.active import ActiveEffect
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


def divided(effects: Sequence[ActiveEffect], names: Sequence[str], words: str) -> Divided:
    """Trials by an effect's values in each: those in which there is more of it, and the others; in other words where
    there are no two values."""
    parameters = effects[0].effect.parameters
    values = np.array([[e.parameters[p.name] for p in parameters] for e in effects])
    acts = two_values(values if len({p.unit for p in parameters}) == 1 else values[:, :1])
    if acts is None:
        return Divided(words)
    changed, others = (tuple(n for n, a in zip(names, acts, strict=True) if a is side) for side in (True, False))
    means = zip(parameters, values[acts].mean(axis=0), values[~np.array(acts)].mean(axis=0), strict=True)
    sizes = [(p, a, b, max(abs(a), abs(b))) for p, a, b in means]
    runs = [
        f"{p.name} {with_unit(a, p.unit, most)} there, {with_unit(b, p.unit, most)} else" for p, a, b, most in sizes
    ]
    where = alone(changed, others)
    return Divided(f"{effects[0].called} is another in {where}: {', and '.join(runs)}", changed, others)


def two_values(values: Floats) -> list[bool] | None:
    """Of values (T, C) in each trial, whether they are the larger ones of two; None where they differ within the two
    sides by LAW_ERROR of what they differ by, as values on a line do."""
    about = values - values.mean(axis=0)
    along = about @ np.linalg.svd(about, full_matrices=False)[2][0]
    order = np.argsort(along)
    ways = [np.isin(np.arange(len(values)), order[:first]) for first in range(1, len(values))]
    within = [sum(((values[side] - values[side].mean(axis=0)) ** 2).sum() for side in (w, ~w)) for w in ways]
    best = int(np.argmin(within))
    if within[best] >= LAW_ERROR**2 * (about**2).sum():
        return None
    size = [float(np.linalg.norm(values[side].mean(axis=0))) for side in (ways[best], ~ways[best])]
    return [bool(x) for x in (ways[best] if size[0] > size[1] else ~ways[best])]


def _fitted(parts: Sequence[Looked], key: Key) -> list[Looked]:
    """Each trial with this effect as it has it, what else is found as it is in all of them."""
    return [replace(p, now=solved(p.data, p.now, (key,), p.sums)) for p in parts]
