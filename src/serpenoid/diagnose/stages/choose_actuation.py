"""Which actuation effects the servos' readings show, joint by joint."""

from __future__ import annotations

import numpy as np

from serpenoid.diagnose.inference.finding import Named, Rival, Stage, excludable, interval
from serpenoid.diagnose.stages.actuation import Attempt, Plays, attempts, channels, fit_everywhere
from serpenoid.effects.active import ActiveEffect
from serpenoid.files.store import remembered

AT_MOST = 3
VISIBLE, SUSPECT = 1.6, 1.0  # times the noise level: what is named, and what is told of
SHARE = 0.3  # of the excess of chi squared that one more effect must take away
T_SYSTEMATIC = 1e-4  # s: when the motion began is known to a fraction of a log interval
SETTLED = 1.6  # RMS of the worst joint, in noise


@remembered
def choose_actuation(data: Plays) -> Stage:
    """Forward selection on the worst joints' misfit."""
    chosen: list[ActiveEffect] = []
    undetected: tuple[Named, ...] = ()
    singles: list[Attempt] = []
    for _ in range(AT_MOST):
        now = channels(data, chosen)
        seen = np.sqrt(max(now.max() ** 2 - 1, 0))
        if seen < SUSPECT:
            break
        tries = sorted(attempts(data, chosen), key=lambda a: a.chi2.sum())
        singles = singles or tries
        best = tries[0]
        excess = ((now**2 - 1) * len(data.readings)).sum()
        if (now**2).sum() * len(data.readings) - best.chi2.sum() < SHARE * excess:
            break
        if seen < VISIBLE:
            undetected = (_named(data, [*chosen, best.effect], best.effect),)
            break
        chosen = _refined(data, [*chosen, best.effect])
    left = channels(data, [*chosen, *(n.effect for n in undetected)])
    worst = int(left.argmax())
    words: tuple[str, ...] = ()
    if left[worst] > SETTLED:
        words = (f"joint {worst + 1} follows its command no better than {left[worst]:.1f} times the reading's noise",)
    every = [_named(data, chosen, e) for e in chosen]
    named = tuple(n for n in every if n.strength >= VISIBLE)
    undetected = (*(n for n in every if n.strength < VISIBLE), *undetected)
    visible = {n.effect.key for n in named}
    rivals = tuple(r for r in _rivals(data, chosen, singles) if r.instead_of.key in visible)
    return Stage("actuation", named, rivals, undetected, float(left[worst]), words)


def _rivals(data: Plays, chosen: list[ActiveEffect], singles: list[Attempt]) -> list[Rival]:
    """What else could stand in the place of each chosen effect, the others kept; S_ab: the worst joint's RMS."""
    here = data.realised(chosen)
    least, keys = float(((data.left(here) / data.noise) ** 2).sum()), {e.key for e in chosen}
    found = []
    for effect in chosen:
        kept = [e for e in chosen if e is not effect]
        for t in attempts(data, kept) if kept else singles:
            same = t.effect.key in keys
            if same or excludable(float(t.chi2.sum()), least, data.readings.size):
                continue
            apart = data.realised([*kept, t.effect]) - here
            rival = Rival(t.effect, effect, float((np.sqrt((apart**2).mean(axis=0)) / data.noise).max()))
            found += [] if rival.separable else [rival]
    return found


def _refined(data: Plays, chosen: list[ActiveEffect]) -> list[ActiveEffect]:
    """Fit each given the others, twice round."""
    if len(chosen) < 2:
        return chosen
    for _ in range(2):
        for i, effect in enumerate(chosen):
            others = [e for e in chosen if e is not effect]
            start = effect.coordinates[0]
            for a in fit_everywhere(data, effect.name, others, start):
                if a.effect.place == effect.place:
                    chosen = [*chosen[:i], a.effect, *chosen[i + 1 :]]
    return chosen


def _named(data: Plays, chosen: list[ActiveEffect], effect: ActiveEffect) -> Named:
    parameter = effect.effect.parameters[0]
    x = effect.coordinates[0]
    step = 1e-4 * max(abs(x), 1e-3 * abs(parameter.coordinate(parameter.typical)))
    others = [e for e in chosen if e is not effect]
    here = data.realised([*others, effect])
    slope = data.slope(here, data.realised([*others, effect.with_coordinates([x + step])]), step) / data.noise
    left = data.left(here) / data.noise
    power = (slope**2).sum()
    scores = np.array([(slope * left)[data.trials == t].sum() for t in np.unique(data.trials)])
    shift = T_SYSTEMATIC * abs((slope * data.speed(here) / data.noise).sum()) / max(power, 1e-12)
    sd = np.sqrt(max(1 / power, (scores**2).sum() / power**2) + shift**2)
    ends = [parameter.value(float(v)) for v in (x - 2.3 * sd, x + 2.3 * sd)]
    alone = data.realised([effect]) - data.realised([])
    strength = float((np.sqrt((alone**2).mean(axis=0)) / data.noise).max())
    bound = (
        (parameter.name,)
        if min(abs(effect.parameters[parameter.name] - b) for b in (parameter.lower, parameter.upper)) == 0
        else ()
    )
    return Named(effect, {parameter.name: interval(ends)}, strength, bound)
