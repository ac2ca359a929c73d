"""How much more an effect's score differs from trial to trial than its windows say.

A floor that grips a little more in one trial than in another shows in no window, and adds up along whatever effect
looks like it: to a name, where windows count as independent. Of trials t of one setting that were laid alike, the
scores of an effect beside the others,

    u_t = J_t^T r_t,    var(u_t) = J_t^T J_t  (residuals r and derivatives J made white),

tell by their differences, without any law of the floor, how large chance is along it (the clustered sandwich of
Liang and Zeger, Biometrika 73, 13, 1986). Where repeats exclude that it is as large as windows say, at the stated
error, an effect must take away as many times more as the best of all candidates would by chance.

Legend: T trials, P columns of the fit, C of an effect.
"""

from __future__ import annotations

import numpy as np
from scipy.special import chdtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.repeats import laid_alike
from serpenoid.diagnose.data.windows.windows import columns_of
from serpenoid.diagnose.inference.fits.evidence import Evidence, inverted
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of, of_trial
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.simulation.sensitivity import EPS


def gained(motion: Motion, found: Fit) -> list[float]:
    """Chi squared that each effect of a fit may gain by such chance, beyond what windows say."""
    tries = len(candidates_of(found)) + len(found.effects)
    return [
        (times - 1) * most_gained(len(e.effect.parameters), tries)
        for e, times in zip(found.effects, larger(motion, found), strict=True)
    ]


def larger(motion: Motion, found: Fit) -> list[float]:
    """How many times as large chance is along each effect of a fit as windows say; 1 where that is not excluded."""
    pairs = laid_alike(motion.tracks)
    if not pairs or not found.effects or any(t.noise is not None for t in motion.tracks):
        return [1.0] * len(found.effects)
    listed = (EPS, *columns_of(found.effects))
    trials = []
    for number, p in enumerate(found.predictions):
        rows, columns = of_trial(motion, number, p, p.by(listed))
        trials.append(Evidence.of(rows, columns, np.zeros(len(rows))))
    return [_beyond(trials, pairs, columns) for columns in found.columns]


def _beyond(trials: list[Evidence], pairs: list[tuple[int, int]], columns: range) -> float:
    """Of some columns (C,), by evidence of each trial (T)."""
    own, others = list(columns), [i for i in range(trials[0].matrix.shape[1]) if i not in columns]
    total = sum(t.matrix[0] for t in trials)
    beside = np.zeros((len(own), total.shape[0]))
    beside[:, own] = np.eye(len(own))
    beside[:, others] = -total[np.ix_(own, others)] @ inverted(total[np.ix_(others, others)])
    metric = inverted(beside @ total @ beside.T)
    squares, expected = np.empty(len(pairs)), np.empty(len(pairs))
    for k, (one, other) in enumerate(pairs):
        apart = beside @ (trials[one].vector[0] - trials[other].vector[0])
        windows = beside @ (trials[one].matrix[0] + trials[other].matrix[0]) @ beside.T
        squares[k], expected[k] = apart @ metric @ apart / 2, float(np.trace(metric @ windows)) / 2
    return _unless_by_chance(squares, expected, len(own))


def _unless_by_chance(squares: Floats, expected: Floats, columns: int) -> float:
    """The ratio of sums (K,), or 1 where chance alone makes as large a one with the stated probability."""
    whole = float(expected.sum())
    if not whole > 0:
        return 1.0
    ratio = float(squares.sum()) / whole
    degrees = columns / float(((expected / whole) ** 2).sum())  # squares of what a trace hardly shows are none
    return ratio if ratio > float(chdtri(degrees, ERROR)) / degrees else 1.0
