"""Actuation effects that were found, fitted again beside one another: one more at a joint, other laws of all servos."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.stages.actuation.actuation_by_joint import fit_everywhere
from serpenoid.diagnose.stages.actuation.actuation_candidates import shown
from serpenoid.diagnose.stages.actuation.actuation_together import fit_together
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect

CENTRED = np.linspace(0.0, 1.0, 5)  # of a move after which no trial's start, in the mean, explains anything


def refined(data: Plays, chosen: Sequence[ActiveEffect], new: ActiveEffect | None = None) -> tuple[ActiveEffect, ...]:
    """Fit each given the others, at its own joint alone, twice round. new: what came to them, or left them, just now;
    those at other joints stay as they are: no joint touches another, but by when a trial began. Where nothing says when
    that was, all are fitted together, and so they are where several laws share all joints."""
    chosen = list(chosen)
    shared = sum(e.place is None for e in chosen) > 1
    if chosen and (shared or not all(data.begun(r) for r in data.recordings)):
        return _told_later(data, fit_together(data, chosen))
    touched = {e.place for e in chosen} if new is None or new.place is None else {None, new.place}
    for _ in range(2):
        for i, effect in enumerate(chosen):
            if effect.place not in touched:
                continue
            others = [e for e in chosen if e is not effect]
            start = np.tile(np.array(effect.coordinates[:-1])[:, None], (1, data.readings.shape[1]))
            (alone,) = fit_everywhere(data, effect.name, others, [start], effect.place)
            chosen[i] = alone.effect
    return _told_later(data, chosen)


def with_laws(data: Plays, found: Sequence[ActiveEffect], names: Sequence[str]) -> tuple[ActiveEffect, ...]:
    """These laws of all servos beside what was found at joints: those that were there, others in turn, and then all
    together."""
    late = {k.name for k in shown(data) if k.dead_time}
    kept = [e for e in found if e.place is not None or e.name in names and e.name not in late]
    return refined(data, in_turn(data, kept, [n for n in names if all(e.name != n for e in kept)]))


def in_turn(data: Plays, found: Sequence[ActiveEffect], names: Sequence[str]) -> list[ActiveEffect]:
    """Laws of all servos beside what was found, each from where its fits begin beside those before it. A dead time
    comes last: a law that is fitted beside all of one finds nothing left that is late, and no way back."""
    effects, late = list(found), {k.name for k in shown(data) if k.dead_time}
    for name in sorted(names, key=lambda n: n in late):
        kind = next(k for k in shown(data) if k.name == name)
        (law,) = fit_everywhere(data, name, effects, kind.starts(data.readings, data.quickest))
        effects.append(law.effect)
    return effects


def _told_later(data: Plays, chosen: Sequence[ActiveEffect]) -> tuple[ActiveEffect, ...]:
    """With a dead time about which trials begin when logs say, as far as readings leave that open: each may begin a
    little later, or they are all told later. A start that is open has the variance that it is given in intervals."""
    late = next((e for e in chosen if isinstance(e.effect, ActuationEffect) and e.effect.dead_time), None)
    if late is None:
        return tuple(chosen)
    most = np.array([data.unsure_start(r) for r in data.recordings])
    whole = float(data.later(chosen).mean())
    tried = [tuple(e.moved(0, share * whole) if e is late else e for e in chosen) for share in CENTRED]
    costs = [float(data.chi2(data.realised(t)).sum() + 3 * ((data.later(t) / most) ** 2).sum()) for t in tried]
    return tried[int(np.argmin(costs))]
