"""Calibration: the anisotropy ratio by best RMS as in the paper, and by maximum likelihood with an interval.

Intervals answer different questions:
  noise     camera and servo noise alone; right where the model is right (noise scale near 1)
  robust    what is left is allowed to be correlated in time (sandwich with Bartlett weights): honest where it is wrong
  trials    by what each trial adds to the fit (`spread.py`), where trials differ by more than chance
  mean      SD over trials / sqrt(trials), as the paper averages: honest about everything that changes between trials
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from serpenoid.body import Floats
from serpenoid.body_curve import PLAIN
from serpenoid.compare.complaints import complaints, determined
from serpenoid.compare.intervals import Z95, chi2_lost, likelihood_intervals, mean_intervals, within
from serpenoid.compare.lengths import Others, lengths_sd, others_of
from serpenoid.compare.likelihood import Segment, Solution, Whitened, fit, whiten
from serpenoid.compare.parameters import changed, start_values
from serpenoid.compare.plain import refuse_effects
from serpenoid.compare.redraw import redrawn_sd
from serpenoid.compare.scales import scales_sd
from serpenoid.compare.segments import trial_segments
from serpenoid.compare.spread import spread_half
from serpenoid.compare.three import simulate_path
from serpenoid.errors import InputError
from serpenoid.files.store import remember
from serpenoid.measure.load import Campaign
from serpenoid.measure.trial import Trial
from serpenoid.model import Model

LOWEST, HIGHEST = 1e-3, 1.0
GIVEN = Others()
LAGS = 40  # of the autocorrelation
POINTS = 7  # of the profile, to either side
MEMORY = 0.1  # of a segment: the lags over which what is left may be correlated


@dataclass(frozen=True)
class Estimate:
    """Fitted numbers with standard errors and 95 % intervals (P,) and (P, 2)."""

    names: tuple[str, ...]
    values: Floats
    sd: Floats
    interval: Floats
    robust_sd: Floats
    spread_half: Floats  # half of a 95 % interval by how trials differ; NaN where that is chance
    correlation: Floats
    noise_scale: float
    autocorrelation: Floats  # of the white defects, lags 1..
    warnings: tuple[str, ...]
    solution: Solution
    determined: NDArray[np.bool_]  # (P,) whether data tell the number at all; where not, its value is where a fit ended

    @property
    def told(self) -> Floats:
        """The values (P,), NaN where the data do not determine them."""
        return np.where(self.determined, self.values, np.nan)


@dataclass(frozen=True)
class TrialFit:
    """One trial's best-RMS eps, its RMS, and its likelihood estimate."""

    trial: str
    gait: str
    best_rms_eps: float
    rms: float
    at_bound: bool
    estimate: Estimate


@dataclass(frozen=True)
class Calibration:
    """All trials singly, their spread, and all together."""

    names: tuple[str, ...]
    trials: tuple[TrialFit, ...]
    together: Estimate
    mean: Floats  # (P,) of the trials' likelihood estimates
    spread: Floats  # (P,) SD over trials
    mean_interval: Floats  # (P, 2) 95 %, Student
    mean_best_rms: float
    spread_best_rms: float
    profile: Floats  # (K, 2): first number, chi2 above its minimum, where the interval's standard error is 1


def calibrate(
    campaign: Campaign, model: Model, names: tuple[str, ...], progress: Callable[[int, int, str], None] | None = None
) -> Calibration:
    """Fit every trial with motion, then all of them together."""
    refuse_effects(model)
    usable = [trial for trial in campaign.trials if trial.motion is not None and trial.passages]
    segments: list[Segment] = []
    others, fits = others_of(campaign, model), []
    for index, trial in enumerate(usable):
        if progress is not None:
            progress(index, len(usable) + 1, trial.name)
        mine = trial_segments(trial)
        segments += mine
        fits.append(_fit_trial(trial, mine, model, names, others(trial.name)))
    if not fits:
        raise InputError("no trial has a motion file with a whole cycle in it: nothing to fit.")
    if progress is not None:
        progress(len(usable), len(usable) + 1, "all trials together")
    every = tuple(segments)
    together = estimate(model, every, names, others(None))
    values = np.array([f.estimate.values for f in fits])
    rms = np.array([f.best_rms_eps for f in fits])
    mean, spread = values.mean(axis=0), _sd(values)
    interval = mean_intervals(values, model, names)
    profile = remember(lambda: profile_likelihood(model, every, names, together), "profile", model, every, names)
    return Calibration(
        names, tuple(fits), together, mean, spread, interval, float(rms.mean()), float(_sd(rms[:, None])[0]), profile
    )


def anisotropy(campaign: Campaign, model: Model) -> Estimate:
    """eps of all trials together: the number that `fit`, `compare` and `diagnose` print, with K = 1 / eps."""
    usable = [trial for trial in campaign.trials if trial.motion is not None and trial.passages]
    segments = tuple(segment for trial in usable for segment in trial_segments(trial))
    if not segments:
        raise InputError("no trial has a motion file with a whole cycle in it: nothing to fit.")
    return estimate(model, segments, ("anisotropy_ratio",), others_of(campaign, model)(None))


def drag_ratio(found: Estimate, model: Model) -> tuple[float, float, float]:
    """K = 1 / eps (NaN: not determined) and its 95 % interval, the widest of `wider_intervals`; within the bounds of
    eps."""
    i = found.names.index("anisotropy_ratio")
    low, high = wider_intervals(found, model)[i]
    return 1 / float(found.told[i]), 1 / float(high), 1 / float(low)


def wider_intervals(found: Estimate, model: Model) -> Floats:
    """95 % intervals (P, 2) of noise, robust, or by the spread of trials where they differ by more than chance:
    whichever end is farthest; within the bounds of the fit."""
    away = within(found.names, model, found.values, np.fmax(Z95 * found.robust_sd, found.spread_half))
    return np.column_stack([np.fmin(found.interval[:, 0], away[:, 0]), np.fmax(found.interval[:, 1], away[:, 1])])


def robust_intervals(found: Estimate, model: Model) -> Floats:
    """95 % intervals (P, 2) that hold where what is left lasts; within the bounds of the fit."""
    return within(found.names, model, found.values, Z95 * found.robust_sd)


def estimate(model: Model, segments: tuple[Segment, ...], names: tuple[str, ...], others: Others = GIVEN) -> Estimate:
    """Maximum likelihood with intervals and complaints; kept, as it takes long. others: lengths that could be."""
    return remember(lambda: _estimate(model, segments, names, others), "estimate", model, segments, names, others)


def _estimate(model: Model, segments: tuple[Segment, ...], names: tuple[str, ...], others: Others) -> Estimate:
    solution = fit(model, segments, names, start_values(names, model))
    scale = max(1.0, solution.noise_scale)
    lengths = np.hypot(lengths_sd(others, solution), scales_sd(model, segments, others.films, solution))
    beside = np.hypot(lengths, redrawn_sd(model, segments, solution))
    unknown = np.hypot(curve_sd(model, segments, solution), beside)
    noise = np.sqrt(np.diag(solution.covariance))
    silent = np.where(noise > 0, 0.0, np.inf)  # of what the data do not say, an error may have any size
    sd = np.hypot(noise * scale, unknown) + silent
    interval = likelihood_intervals(model, segments, solution, sd)
    trials = [segment.trial for segment in segments]
    correlation = solution.covariance / np.outer(*(2 * [np.where(noise > 0, noise, 1.0)]))
    differ = np.hypot(spread_half(solution, trials), Z95 * unknown)
    return Estimate(
        names, solution.values, sd, interval, np.hypot(robust_sd(solution), beside) + silent, differ, correlation,
        solution.noise_scale, autocorrelation(solution.segments),
        complaints(solution, model, sd, interval, correlation, len(set(trials))), solution,
        determined(names, sd, model),
    )  # fmt: skip


def curve_sd(model: Model, segments: tuple[Segment, ...], solution: Solution) -> Floats:
    """Standard error (P,) from not knowing how an animal's body runs between its points: two ways, one SD apart."""
    if not model.body.is_animal:
        return np.zeros(len(solution.values))
    other = whiten(model, segments, solution.names, solution.values, degree=PLAIN)
    pull = [w.by_parameters.reshape(-1, len(solution.values)).T @ (o.defect - w.defect).ravel()
            for w, o in zip(solution.segments, other, strict=True)]  # fmt: skip
    return np.asarray(np.abs(solution.covariance @ np.sum(pull, axis=0)))


def robust_sd(solution: Solution) -> Floats:
    """Sandwich standard errors with Bartlett weights over a tenth of each segment."""
    meat = np.zeros_like(solution.covariance)
    for left in solution.segments:
        score = np.einsum("si,sip->sp", left.defect, left.by_parameters)
        lags = max(1, int(MEMORY * len(score)))
        meat += score.T @ score
        for lag in range(1, lags + 1):
            product = score[lag:].T @ score[:-lag]
            meat += (1 - lag / (lags + 1)) * (product + product.T)
    return np.asarray(np.sqrt(np.maximum(np.diag(solution.covariance @ meat @ solution.covariance), 0.0)))


def autocorrelation(left: tuple[Whitened, ...]) -> Floats:
    """Of the white defects, over components and segments; within +-2/sqrt(3 S) of zero if the model is right."""
    total, power = np.zeros(LAGS), 0.0
    for w in left:
        power += float((w.defect**2).sum())
        for lag in range(1, min(LAGS, len(w.defect) - 1) + 1):
            total[lag - 1] += float((w.defect[lag:] * w.defect[:-lag]).sum())
    return total / power


def profile_likelihood(model: Model, segments: tuple[Segment, ...], names: tuple[str, ...], best: Estimate) -> Floats:
    """Chi2 above its minimum along the first number, the others fitted again, within 3 standard errors and its bounds:
    (K, 2), POINTS to either side. The standard error is the interval's."""
    value, sd = float(best.values[0]), float(best.sd[0])
    ends = within(names, model, best.values, 3 * best.sd)[0]
    lost = chi2_lost(model, segments, best.solution, 0, sd)
    grid = np.unique([np.linspace(value, end, POINTS) for end in ends])
    return np.array([(at, lost(at)) for at in grid.tolist()])


def displacement_curve(model: Model, segment: Segment) -> Floats:
    """Distance of the recorded body's centroid from where it began, were the model right, (R,) [body lengths]."""
    poses = simulate_path(model, segment.smooth_angles, segment.weights, np.zeros(3)).poses
    return np.asarray(np.hypot(poses[:, 0] - poses[0, 0], poses[:, 1] - poses[0, 1]))


def rms_of(model: Model, segments: tuple[Segment, ...]) -> float:
    """RMS over all rows between simulated and measured displacement-time curves: the paper's measure."""
    squares = []
    for s in segments:
        measured = np.hypot(*(s.smooth_poses - s.smooth_poses[0]).T[:2])
        squares.append((displacement_curve(model, s) - measured) ** 2)
    return float(np.sqrt(np.concatenate(squares).mean()))


def best_rms(model: Model, segments: tuple[Segment, ...]) -> tuple[float, float, bool]:
    """eps with the least RMS by a bounded search on its logarithm: (eps, RMS, whether it ran into a bound)."""

    def cost(log_eps: float) -> float:
        return rms_of(changed(model, ("anisotropy_ratio",), np.array([np.exp(log_eps)])), segments)

    lowest, highest = model.medium.limits(LOWEST, HIGHEST)
    grid = np.linspace(np.log(lowest), np.log(highest), 13)
    start = int(np.argmin([cost(x) for x in grid]))
    low, high = grid[max(start - 1, 0)], grid[min(start + 1, len(grid) - 1)]
    found = minimize_scalar(cost, bounds=(low, high), method="bounded", options={"xatol": 1e-5})
    eps = float(np.exp(found.x))
    return eps, float(found.fun), bool(eps < 1.01 * lowest or eps > 0.99 * highest)


def _fit_trial(
    trial: Trial, segments: tuple[Segment, ...], model: Model, names: tuple[str, ...], others: Others
) -> TrialFit:
    eps, rms, bound = remember(lambda: best_rms(model, segments), "best RMS", model, segments)
    return TrialFit(trial.name, trial.gait, eps, rms, bound, estimate(model, segments, names, others))


def _sd(values: Floats) -> Floats:
    return values.std(axis=0, ddof=1) if len(values) > 1 else np.full(values.shape[1], np.nan)
