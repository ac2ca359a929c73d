"""Does a law of the servos act by another number in each trial, as one does that warms up or wears?

A law that all trials share leaves more than its error then. Fitted to each trial by itself, with what else is found, it
leaves little: less than LAW_ERROR of what was left. Where a trial begins must be known: else its clock takes up a lag.

Legend: R log rows, T trials, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.inference.finding import VISIBLE
from serpenoid.diagnose.inference.law_error import LAW_ERROR
from serpenoid.diagnose.stages.actuation_by_joint import fit_everywhere
from serpenoid.diagnose.stages.plays import Plays
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

LEAST = 4  # trials: three points lie nearly on a line by chance


@dataclass(frozen=True)
class ByTrial:
    """How a law differs from trial to trial, in words; steady: whether it runs one way, and not mostly by one step."""

    words: str
    steady: bool


def law_by_trial(data: Plays, found: Sequence[ActiveEffect], suspects: Sequence[ActiveEffect]) -> ByTrial | None:
    """How the suspect that leaves least so differs from trial to trial, beside what is found; None where none does."""
    trials = len(data.recordings)
    if not suspects or trials < LEAST or not all(data.begun(r) for r in data.recordings):
        return None
    beyond = _beyond(data, data.chi2(data.realised(found)))
    every = []
    for suspect in suspects:
        others = [e for e in found if e.key != suspect.key]
        fits = in_processes([(_fitted, (of_trial(data, t), suspect, others)) for t in range(trials)])
        chi2 = np.sum([c for _, c, _ in fits], axis=0)
        share = float(np.sqrt(_beyond(data, chi2).max() / max(beyond.max(), 1e-12)))
        every.append((share, [e for e, _, _ in fits], [does for _, _, does in fits]))
    share, effects, does = min(every, key=lambda one: one[0], default=(np.inf, [], []))
    acts = [t for t in range(trials) if does[t] > VISIBLE] if share < LAW_ERROR else []
    if len(acts) < LEAST:
        return None
    return _said([effects[t] for t in acts], [data.recordings[t].name for t in acts])


def of_trial(data: Plays, trial: int) -> Plays:
    """One trial alone."""
    rows = data.trials == trial
    habit = data.habit[rows] if isinstance(data.habit, np.ndarray) and data.habit.ndim > 1 else data.habit
    parts: dict[str, Any] = {
        name: (getattr(data, name)[trial],) for name in ("recordings", "times", "meshes", "setpoints", "where")
    }
    return replace(data, readings=data.readings[rows], trials=np.zeros(rows.sum(), dtype=int), habit=habit, **parts)


def _fitted(data: Plays, effect: ActiveEffect, others: Sequence[ActiveEffect]) -> tuple[ActiveEffect, Floats, float]:
    """An effect as one trial has it, chi squared (m,) with it, and how far it moves the worst joint, over the noise."""
    law: Any = effect.effect
    here = np.tile(np.array(effect.coordinates[:-1])[:, None], (1, data.readings.shape[1]))
    starts = [here, *law.starts(data.readings, data.quickest)]
    (one,) = fit_everywhere(data, effect.name, others, starts, effect.place)
    played, without = data.realised([*others, one.effect]), data.realised(others)
    moved = np.where(data.read, (played - without) / data.level, 0.0)
    return one.effect, data.chi2(played), float(np.sqrt((moved**2).sum(axis=0) / data.often).max())


def _beyond(data: Plays, chi2: Floats) -> Floats:
    """Mean square (m,) of what is left beyond noise."""
    return np.maximum(chi2 / data.often - 1, 0.0)


def _said(effects: Sequence[ActiveEffect], names: Sequence[str]) -> ByTrial:
    """How an effect's values run from trial to trial."""
    runs, steady = [], _steady(np.array([e.coordinates[0] for e in effects]))
    for p in effects[0].effect.parameters:
        values = np.array([e.parameters[p.name] for e in effects])
        first, last = (0, -1) if steady else (int(values.argmin()), int(values.argmax()))
        unit = "" if p.unit == "1" else f" {p.unit}"
        runs.append(
            f"{p.name} {values[first]:.3g}{unit} in `{names[first]}`, {values[last]:.3g}{unit} in `{names[last]}`"
        )
    how = "changes steadily" if steady else "differs"
    return ByTrial(f"{effects[0].called} {how} from trial to trial: {'; '.join(runs)}", steady)


def _steady(values: Floats) -> bool:
    """Whether values run one way from trial to trial, but for a law's error, and by no step that is most of the way."""
    steps = np.array([b - a for a, b in pairwise(values)])
    way = abs(steps.sum())
    return bool(way > (1 - LAW_ERROR) * np.abs(steps).sum() and np.abs(steps).max() < way / 2)
