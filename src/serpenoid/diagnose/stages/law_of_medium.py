"""Which law the medium follows, where no file says so: what is named beside a rival, and which of the two is taken."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.inference.bounds import LEAST_EPS
from serpenoid.diagnose.inference.law_error import LAW_ERROR
from serpenoid.diagnose.inference.laws import by_its_own_numbers, misses, numbers_of, rival_laws, share_left
from serpenoid.diagnose.inference.select import Selection
from serpenoid.diagnose.stages.baseline import Baseline


@dataclass(frozen=True)
class Taken:
    """The law that is taken instead: what is found beside it, its baseline, and why, in words; None and empty: the
    same. rivals: how others do beside the one that is taken, in words by their names."""

    selection: Selection | None = None
    baseline: Baseline | None = None
    words: str = ""
    rivals: dict[str, str] = field(default_factory=dict)


SAME = Taken()


def law_of(found: Selection, baseline: Baseline, search: Callable[[Baseline], Selection]) -> Taken:
    """A rival of the law, where with what is named beside it less than LAW_ERROR remains of what the law with what is
    named beside that leaves beyond chance: as with laws of servos, a law that leaves more is not the one.

    search: finds what is to be named beside a baseline.
    """
    rivals = rival_laws(found)
    said = {name: rival.words for name, rival in rivals.items() if rival.words}
    if not baseline.law_open:
        return Taken(rivals=said)
    others = [replace(baseline, model=rival.model) for rival in rivals.values() if rival.better]
    searched = [(share_left(found, selection), selection, other) for other in others for selection in (search(other),)]
    share, best, other = min(searched, key=lambda x: x[0], default=(1.0, found, baseline))
    if share >= LAW_ERROR:
        return Taken(rivals=said)
    then, now = misses(found.motion, [(s.motion.tracks, s.best) for s in (found, best)])
    before, after = (s.null.model.law for s in (found, best))
    words = (
        f"{after.title} is taken for it: with what is named it misses windows by {now:.1f} times chance, "
        f"{before.title} by {then:.1f}"
    )
    return Taken(best, other, words)


def with_own_numbers(baseline: Baseline, motion: Callable[[Baseline], Motion]) -> Baseline:
    """A baseline whose model has all numbers of its law; motion: as it is beside a baseline."""
    model = baseline.model
    if baseline.ratio is not None or not numbers_of(model):
        return baseline
    found = by_its_own_numbers(motion(baseline), model, LEAST_EPS)
    return replace(baseline, model=found.model) if np.isfinite(found.chi2) and found.evidence.count.sum() else baseline
