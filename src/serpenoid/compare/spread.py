"""Whether trials differ by more than chance, and the interval that holds all the same.

Trial g pulls the joint estimate by d_g = C s_g, with s_g = J_g' e_g its part of the score (the parts sum to 0 at the
best fit), H_g = J_g' J_g its information and C = (sum H_g)^-1. Noise alone makes

    cov(d_g, d_h) = C (H_g [g = h] - H_g C H_h) C,

so that F = sum d_g^2 / sum var(d_g) is 1 by chance, spread as chi squared over its degrees of freedom (Satterthwaite).
Where F is beyond the 95 % point of that, the variance of the estimate is F times that of noise, told by so many trials:
best +- t(0.975) sqrt(C F). The clustered sandwich, with the small-sample correction of Bell & McCaffrey (2002).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import chdtri, stdtrit

from serpenoid.body import Floats
from serpenoid.compare.likelihood import Solution

LEVEL = 0.95  # of intervals, and so of the question whether there is a spread at all


def spread_half(solution: Solution, trials: Sequence[str]) -> Floats:
    """Half of a 95 % interval (P,) by the spread of the trials (one name a segment); NaN where that is chance."""
    names = list(dict.fromkeys(trials))
    if len(names) < 2:
        return np.full(len(solution.covariance), np.nan)
    parts = [[w for w, name in zip(solution.segments, trials, strict=True) if name == own] for own in names]
    slopes = [np.concatenate([w.by_parameters.reshape(w.defect.size, -1) for w in part]) for part in parts]
    scores = np.array([j.T @ np.concatenate([w.defect.ravel() for w in p]) for p, j in zip(parts, slopes, strict=True)])
    info, cov = np.stack([j.T @ j for j in slopes]), solution.covariance
    pulls = scores @ cov  # (G, P)
    noise = max(1.0, solution.noise_scale) ** 2
    half = np.full(len(cov), np.nan)
    for p, column in enumerate(cov):
        felt = info @ column  # (G, P)
        chance = np.diag(felt @ column) - felt @ cov @ felt.T
        expected = float(np.trace(chance))
        if expected <= np.finfo(float).eps * column[p]:  # one trial alone tells this number
            continue
        freedom = expected**2 / float((chance**2).sum())
        found = float((pulls[:, p] ** 2).sum()) / expected
        if found > noise * chdtri(freedom, 1 - LEVEL) / freedom:
            half[p] = stdtrit(freedom, (1 + LEVEL) / 2) * np.sqrt(column[p] * found)
    return half
