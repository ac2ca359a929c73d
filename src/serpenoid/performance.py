"""Measures of performance: cost of transport, Pareto front, and the idle power that decides where the optimum lies.

Normalised cost of transport: (p_idle + dissipation) / Delta, with p_idle the idle energy per cycle in units of the
normalised dissipation T * E. In SI: CoT = P / (m g v) with electrical P = P_idle + k * dissipation / cycle duration.
Efficiency, where drag is linear: what pulling the straight body costs over what the gait costs.
Along a family of gaits that minimise -Delta + c * dissipation it is least where p_idle = Delta / c - dissipation.
"""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.problem import Problem

Range: TypeAlias = tuple[float, float]
GRAVITY = 9.81  # m / s^2
STANDS = 1e-8  # body lengths: as far as a certificate takes two poses for the same


def moving(displacement: Floats) -> NDArray[np.bool_]:
    """Which displacements (n,) are more than what certificates let pass for none: others have no cost of transport."""
    return np.asarray(displacement) > STANDS


def normalised_cost_of_transport(displacement: Floats, dissipation: Floats, idle: float) -> Floats:
    """(idle + dissipation) / displacement, element by element."""
    return (idle + np.asarray(dissipation)) / np.asarray(displacement)


def electrical_cost_of_transport(problem: Problem, displacement: float, dissipation: float) -> float | None:
    """P / (m g v), dimensionless; None where the problem lacks mass, cycle duration or [power]."""
    power, mass, duration = problem.power, problem.body.mass_kg, problem.task.cycle_duration_s
    if power is None or mass is None or duration is None or displacement <= 0:
        return None
    energy = power.idle_W * duration + power.dissipation_J * dissipation
    return energy / (mass * GRAVITY * displacement * problem.body.total_length_m)


def lighthill_efficiency(problem: Problem, displacement: float, dissipation: float) -> float | None:
    """Work to pull the straight body along its axis as far in a cycle, over the work done (Lighthill 1976).

    eps * displacement^2 / (2 T E); None where the drag of a straight body is not eps: effects, and laws that are not
    linear; and where parts are lifted, which may move with less work than pulling takes.
    """
    if not problem.model.law.linear or problem.model.effects or problem.lift is not None or dissipation <= 0:
        return None
    return problem.medium.anisotropy_ratio * displacement**2 / (2 * dissipation)


def pareto_front(displacement: Floats, dissipation: Floats) -> np.ndarray:
    """True for points that no other point beats in both displacement (more) and dissipation (less), shape (n,)."""
    more = displacement[None] >= displacement[:, None]
    less = dissipation[None] <= dissipation[:, None]
    strictly = (displacement[None] > displacement[:, None]) | (dissipation[None] < dissipation[:, None])
    return np.asarray(~(more & less & strictly).any(axis=1))


def between(c: Floats, displacement: Floats, dissipation: Floats, at: Floats) -> tuple[Floats, Floats]:
    """Displacement and dissipation of a family of gaits with rising c (n,) between them; exact at the gaits.

    Gaits that minimise V = c D - Delta have V' = D (the other terms cancel) and D falling, so over each interval both
    ends and the mean of D are known, the mean from the chord of V. D runs between them as the quadratic of these three
    (V is the cubic of Hermite) where that falls, else as the power that does; Delta = c D - V then obeys
    Delta' = c D', and the quotient (p + D) / Delta is least where p = Delta / c - D, as the gaits' own is.
    An interval whose chord is not between its two D (other goals, a better branch that was missed) has both piecewise
    cubic, each by itself (Fritsch & Carlson 1980).
    """
    i = np.clip(np.searchsorted(c, at, side="right") - 1, 0, c.size - 2)
    wide, t = np.diff(c)[i], (at - c[i]) / np.diff(c)[i]
    least = c * dissipation - displacement
    falls, mean = -np.diff(dissipation), np.diff(least) / np.diff(c) - dissipation[1:]
    obeys = (mean > 0) & (mean < falls)
    share, below = _falling(t, np.divide(mean, falls, out=np.full(mean.shape, 0.5), where=obeys)[i])
    spent = dissipation[i + 1] + falls[i] * share
    went = at * spent - least[i] - wide * (dissipation[i + 1] * t + falls[i] * below)
    if obeys.all():
        return went, spent
    from scipy.interpolate import PchipInterpolator

    return (
        np.where(obeys[i], went, PchipInterpolator(c, displacement)(at)),
        np.where(obeys[i], spent, PchipInterpolator(c, dissipation)(at)),
    )


def _falling(t: Floats, mean: Floats) -> tuple[Floats, Floats]:
    """What falls from 1 at t = 0 to 0 at t = 1 with this mean (0 .. 1), and its integral from 0 to t."""
    early, late = np.minimum(mean, 1 / 3), np.minimum(1 - mean, 1 / 3)  # at a third the quadratic is the power
    bend = 6 * mean - 3
    return (
        np.select(
            [mean < 1 / 3, mean > 2 / 3],
            [(1 - t) ** (1 / early - 1), 1 - t ** (1 / late - 1)],
            1 - t + bend * t * (1 - t),
        ),
        np.select(
            [mean < 1 / 3, mean > 2 / 3],
            [early * (1 - (1 - t) ** (1 / early)), t - late * t ** (1 / late)],
            t - t**2 / 2 + bend * (t**2 / 2 - t**3 / 3),
        ),
    )


def idle_for_minimum(c: Floats, displacement: Floats, dissipation: Floats, low: float, high: float) -> Range | None:
    """Idle levels for which the cost of transport is least at a c between low and high; None where none is known.

    p(c) = Delta / c - dissipation falls with c (its slope is -Delta / c^2), so the two ends bound the levels. Gaits on
    either side of the interval say nothing of it unless one lies in it, and no idle level is negative.
    """
    if c.size < 2 or c.min() > low or c.max() < high or not ((c >= low) & (c <= high)).any():
        return None
    ends = np.array([low, high])
    went, spent = between(c, displacement, dissipation, ends)
    upper, lower = went / ends - spent
    return (max(float(lower), 0.0), float(upper)) if upper > 0 else None
