"""Which actuation effects the servos' readings show, joint by joint."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.actuation import Attempt, Plays, attempts, channels, fit_everywhere, plays
from serpenoid.diagnose.finding import Named, Rung, interval
from serpenoid.diagnose.recording import Recording
from serpenoid.effects.active import ActiveEffect

AT_MOST = 3
VISIBLE, SUSPECT = 1.6, 1.0  # floors: what is named, and what is told of
SHARE = 0.3  # of the excess of chi squared that one more effect must take away
RIVAL = 14.0
SETTLED = 1.6  # RMS of the worst joint, in noise
T_SYSTEMATIC = 1e-4  # s: when the motion began is known to a fraction of a log interval


def choose_actuation(recordings: Sequence[Recording]) -> Rung:
    """Forward selection on the worst joints' misfit."""
    data = plays(recordings)
    chosen: list[ActiveEffect] = []
    rivals: list[ActiveEffect] = []
    faint: tuple[Named, ...] = ()
    for _ in range(AT_MOST):
        now = channels(data, chosen)
        seen = np.sqrt(max(now.max() ** 2 - 1, 0))
        if seen < SUSPECT:
            break
        tries = sorted(attempts(data, chosen), key=lambda a: a.chi2.sum())
        best = tries[0]
        excess = ((now**2 - 1) * len(data.readings)).sum()
        if (now**2).sum() * len(data.readings) - best.chi2.sum() < SHARE * excess:
            break
        if seen < VISIBLE:
            faint = (_named(data, [*chosen, best.effect], best.effect),)
            break
        rivals += [t.effect for t in tries[1:] if _rivals(t, best)]
        chosen = _refined(data, [*chosen, best.effect])
    left = channels(data, chosen)
    worst = int(left.argmax())
    words: tuple[str, ...] = ()
    if left[worst] > SETTLED:
        words = (f"joint {worst + 1} follows its command no better than {left[worst]:.1f} times the reading's noise",)
    named = tuple(_named(data, chosen, e) for e in chosen)
    return Rung("actuation", named, tuple(rivals), faint, float(left[worst]), words)


def _rivals(a: Attempt, best: Attempt) -> bool:
    same = (a.effect.name, a.effect.place) == (best.effect.name, best.effect.place)
    return not same and bool(a.chi2.sum() - best.chi2.sum() < RIVAL)


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
    slope = (data.realised([*others, effect.with_coordinates([x + step])]) - here) / step
    left = data.readings - here
    power = (slope**2).sum()
    scores = np.array([(slope * left)[data.trials == t].sum() for t in np.unique(data.trials)])
    speed = np.gradient(here, axis=0) * 60.0
    shift = T_SYSTEMATIC * abs((slope * speed).sum()) / max(power, 1e-12)
    sd = np.sqrt(max(data.noise**2 / power, (scores**2).sum() / power**2) + shift**2)
    ends = [parameter.value(float(v)) for v in (x - 2.3 * sd, x + 2.3 * sd)]
    alone = data.realised([effect]) - data.realised([])
    strength = float(np.sqrt((alone**2).mean(axis=0)).max() / data.noise)
    bound = (
        (parameter.name,)
        if min(abs(effect.parameters[parameter.name] - b) for b in (parameter.lower, parameter.upper)) == 0
        else ()
    )
    return Named(effect, {parameter.name: interval(ends)}, strength, bound)
