"""Does a law of the servos act by another number in each trial, as one does that warms up or wears?

A law that all trials share leaves more than its error then. Fitted to each trial by itself, with what else is found, it
leaves little: less than LAW_ERROR of what was left. Where a trial begins must be known: else its clock takes up a lag.

Legend: R log rows, T trials, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR, ON_A_LINE
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.stages.actuation.actuation_by_joint import fit_everywhere
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.by_trial import ByTrial, by_gait, divided, said_by_trial
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes

Key = tuple[str, int | None]


def law_by_trial(data: Plays, found: Sequence[ActiveEffect], suspects: Sequence[ActiveEffect]) -> ByTrial | None:
    """How the suspect that leaves least so differs from trial to trial, beside what is found; None where none does. One
    law at several joints counts as each of them alone, and as all together: a battery that sags weakens every servo."""
    trials = len(data.recordings)
    if not suspects or trials < ON_A_LINE or not all(data.begun(r) for r in data.recordings):
        return None
    beyond = _beyond(data, data.chi2(data.realised(found)))
    parts = [of_trial(data, t) for t in range(trials)]
    alone = {}
    for suspect in suspects:
        others = [e for e in found if e.key != suspect.key]
        alone[suspect.key] = in_processes([(_fitted, (part, suspect, others)) for part in parts])
    every = []
    for some in _groups(suspects):
        others = [e for e in found if e.key not in some]
        together = [[alone[key][t] for key in some] for t in range(trials)]
        judged = [_judged(part, fits, others) for part, fits in zip(parts, together, strict=True)]
        share = float(np.sqrt(_beyond(data, np.sum([c for c, _ in judged], axis=0)).max() / max(beyond.max(), 1e-12)))
        every.append((share, together, [does for _, does in judged]))
    share, effects, does = min(every, key=lambda one: one[0])
    acts = [t for t in range(trials) if does[t] > VISIBLE] if share < LAW_ERROR else []
    if len(acts) < ON_A_LINE:
        return None
    joints, names = data.readings.shape[1], [r.name for r in data.recordings]
    told = [effects[t] for t in acts], [names[t] for t in acts], joints
    said = said_by_trial(*told)
    if len(effects[0]) > 1 or said.steady:
        return said
    sides = divided([e for (e,) in effects], names, said.words)
    if by_gait(sides.changed, names, [r.setting for r in data.recordings]):  # another law: repeats agree about it
        return replace(said_by_trial(*told, unit="gait"), called=())
    return replace(said, divided=sides if sides.changed else None)


def _groups(suspects: Sequence[ActiveEffect]) -> list[list[Key]]:
    """Each by itself, and those of one law together."""
    by_law: dict[str, list[Key]] = {}
    for suspect in suspects:
        by_law.setdefault(suspect.name, []).append(suspect.key)
    return [*([s.key] for s in suspects), *(keys for keys in by_law.values() if keys[1:])]


def of_trial(data: Plays, trial: int) -> Plays:
    """One trial alone."""
    rows = data.trials == trial
    habit = data.habit[rows] if isinstance(data.habit, np.ndarray) and data.habit.ndim > 1 else data.habit
    parts: dict[str, Any] = {
        name: (getattr(data, name)[trial],) for name in ("recordings", "times", "meshes", "setpoints", "where")
    }
    return replace(data, readings=data.readings[rows], trials=np.zeros(rows.sum(), dtype=int), habit=habit, **parts)


def _fitted(data: Plays, effect: ActiveEffect, others: Sequence[ActiveEffect]) -> ActiveEffect:
    """An effect as one trial has it."""
    law: Any = effect.effect
    here = np.tile(np.array(effect.coordinates[:-1])[:, None], (1, data.readings.shape[1]))
    starts = [here, *law.starts(data.readings, data.quickest)]
    (one,) = fit_everywhere(data, effect.name, others, starts, effect.place)
    return one.effect


def _judged(data: Plays, fits: Sequence[ActiveEffect], others: Sequence[ActiveEffect]) -> tuple[Floats, float]:
    """Of one trial: chi squared (m,) with effects, and how far they move the worst joint, over the noise."""
    played, without = data.realised([*others, *fits]), data.realised(others)
    moved = np.where(data.read, (played - without) / data.level, 0.0)
    return data.chi2(played), float(np.sqrt((moved**2).sum(axis=0) / data.often).max())


def _beyond(data: Plays, chi2: Floats) -> Floats:
    """Mean square (m,) of what is left beyond noise."""
    return np.maximum(chi2 / data.often - 1, 0.0)
