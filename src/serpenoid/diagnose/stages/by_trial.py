"""An effect whose numbers are each trial's own: in words, and by which trials, if it has two values in all of them."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.finding import Divided, alone
from serpenoid.effects.active import ActiveEffect
from serpenoid.wording import listed


@dataclass(frozen=True)
class ByTrial:
    """How a law differs from trial to trial, in words; steady: whether it runs one way, and not mostly by one step;
    called: the effects that do; divided: trials, where it has one value in some and another in the others."""

    words: str
    steady: bool
    called: tuple[str, ...] = ()
    divided: Divided | None = None

    @property
    def said(self) -> tuple[Divided, ...]:
        """In these words, and with trials where it divides them."""
        return (Divided(self.words), *([] if self.divided is None else [self.divided]))

    def of_others(self, refused: Sequence[str]) -> tuple[str, ...]:
        """Why effects were refused (`lawful`), but for these: that they differ is why."""
        return tuple(w for w in refused if not any(w.startswith(f"{e} would") for e in self.called))


def said_by_trial(
    effects: Sequence[Sequence[ActiveEffect]], names: Sequence[str], joints: int, unit: str = "trial"
) -> ByTrial:
    """How values of an effect, in the mean of several joints, run from trial to trial; joints: of the body; unit: what
    they differ by."""
    of = effects[0][0]
    numbers = [[np.mean([e.parameters[p.name] for e in some]) for p in of.effect.parameters] for some in effects]
    values, units = np.array(numbers), [p.unit for p in of.effect.parameters]
    way = values @ (values[-1] - values[0]) if len(set(units)) == 1 else values[:, 0]  # of one kind: how far they run
    steady, runs = _steady(way), []
    for p, run in zip(of.effect.parameters, values.T, strict=True):
        first, last = (0, -1) if steady else (int(run.argmin()), int(run.argmax()))
        told = (f"{with_unit(run[t], p.unit, np.abs(run).max())} in `{names[t]}`" for t in (first, last))
        runs.append(f"{p.name} {', '.join(told)}")
    how = "changes steadily" if steady else "differs"
    where = "all joints" if len(effects[0]) == joints else f"joints {listed([str(e.place) for e in effects[0]])}"
    called, mean = (of.called, "") if len(effects[0]) == 1 else (f"{of.name} at {where}", " in the mean")
    words = f"{called} {how} from {unit} to {unit}: {', and '.join(runs)}{mean}"
    return ByTrial(words, steady, tuple(e.called for e in effects[0]))


def with_unit(value: float, unit: str, largest: float) -> str:
    """A value of a run, by three digits of its largest."""
    scale, unit = (1e3, " mm") if unit == "m" else (1.0, "" if unit == "1" else f" {unit}")
    digits = 2 - int(np.floor(np.log10(max(scale * largest, 1e-12))))
    return f"{round(scale * value, digits) + 0.0:g}{unit}"


def _steady(values: Floats) -> bool:
    """Whether values run one way from trial to trial, but for a law's error, and by no step that is most of the way."""
    steps = np.array([b - a for a, b in pairwise(values)])
    way = abs(steps.sum())
    return bool(way > (1 - LAW_ERROR) * np.abs(steps).sum() and np.abs(steps).max() < way / 2)


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


def by_gait(changed: Collection[str], names: Sequence[str], settings: Sequence[Hashable]) -> bool:
    """Whether sides are gaits and not trials: each setting's trials are all on one side, and in the order in which they
    were played they change sides more often than what begins (once), or begins and goes again (twice)."""
    of_setting = {(s, n in changed) for s, n in zip(settings, names, strict=True)}
    return len(of_setting) == len(set(settings)) and changes_of_side(changed, names) > 2


def changes_of_side(changed: Collection[str], names: Sequence[str]) -> int:
    """How often trials, in the order in which they were played, change from one side to the other."""
    return sum((a in changed) != (b in changed) for a, b in pairwise(names))


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
