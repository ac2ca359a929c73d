"""One hypothesis laid over one signal: log evidence of the measured angles under a commanded motion.

    measured_j(t) = gain_j commanded_j(t - start) + zero_j + discrepancy_j(t) + noise
    log evidence = max over start, gain, zero of  sum_j [ log t(residual_j) + log p(gain_j) + log p(zero_j) ]

Gain (0 .. 1.5: a joint may be weak or stuck, never turn backwards; 1 of one that is told to stand still) and zero are
what physics may do to a joint; both have priors with a narrow part (a healthy servo) and a wide one (a damaged one),
and all joints may be weak alike. The discrepancy's size is unknown: its Student t has one observation's worth of belief
in a tenth of the joint's own motion, and as many degrees of freedom as that motion has, whatever the number of frames:
amplitudes and phases of two harmonics. Repeated cycles repeat their discrepancy, so they do not count again.

Legend: n grid points, Q rates, K starts, m joints.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.fft import irfft, next_fast_len, rfft

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.signals import LEAST_ROWS, Sampled
from serpenoid.measure.logs import TICK
from serpenoid.measure.schedule import Schedule

FREEDOM = 4.0  # numbers per joint that a discrepancy disturbs independently (above)
TYPICAL = 0.1  # of a joint's motion: the discrepancy that is no surprise
DAMAGED = 0.1  # prior share of joints that do what a healthy one does not
HIGHEST_GAIN = 1.5
COARSE = 0.1  # of a cycle that the ends of a signal may be off in a first look at a clock's rate
FINER = 9  # rates on either side of the best in the second look: its ends are within a hundredth of a cycle
BETWEEN = 2  # parts of a step of rates, and of half a step of starts, at which it is looked then,
CLOSER = (1, 2, 4)  # of such, and of such steps' parts again
AT_ONCE = 8_000  # numbers of a signal, once for each rate, that are laid together: more leave the cache of a core
NEARBY = 0.1  # of a period: what is done before and after draws a start aside by less
RATES = 0.035  # clocks differ by this share and more is no crystal: a player's loop in software is the worst
WITHIN = RATES * (1 + 1e-9)  # 1 - 0.035 is farther from 1 than that, by rounding


@dataclass(frozen=True)
class Course:
    """A motion as promised: joint angles (R, m) at times (R,) [s] since its start, how long, how soon it repeats.

    told: whether servos were told it; else it is what they did.
    """

    angles: Callable[[Floats], Floats]
    total_s: float
    period_s: float
    told: bool = True

    def slowed(self, factor: float) -> Course:
        """The same, lasting `factor` times as long."""
        total, period = self.total_s * factor, self.period_s * factor
        return replace(self, angles=lambda time: self.angles(time / factor), total_s=total, period_s=period)

    def stopped(self, after_s: float) -> Course:
        """The same until so many seconds after its start, and no motion from then on."""
        return replace(self, angles=lambda time: self.angles(np.minimum(time, after_s)))

    def changed(self, change: Callable[[Floats], Floats]) -> Course:
        """The same with its angles (R, m) changed."""
        return replace(self, angles=lambda time: change(self.angles(time)))


def course_of(schedule: Schedule) -> Course:
    """What a schedule promises, from its own start on."""
    return Course(lambda time: schedule.commanded(time + schedule.start_s), schedule.whole_s, schedule.period_s)


@dataclass(frozen=True)
class Prior:
    """Of gain and zero: standard deviations of a healthy joint; `damage` False: there is no other kind."""

    gain_sd: float = 0.1
    zero_sd: float = 0.05  # rad
    play: float = 0.03  # rad: of a worn joint, whatever its amplitude
    damage: bool = True


PHYSICAL = Prior()
EXACT = Prior(0.02, 0.01, 0.0, damage=False)  # commands in a log are the table itself, but for rounding


@dataclass(frozen=True)
class Match:
    """Log evidence [nats], the same joint by joint (m,), the best start [s], gains and zeros (m,), variance explained.

    rate: how many times as long as promised the motion lasted; course: the promise at that rate.
    """

    evidence: float
    by_joint: Floats
    start_s: float
    gain: Floats
    zero: Floats
    explained: float
    course: Course
    rate: float = 1.0


def match(signal: Sampled, course: Course, prior: Prior = PHYSICAL) -> Match:
    """The best start of `course` in the signal; its clock may run fast or slow by `RATES`.

    The rates of the first look leave the ends of the signal within a tenth of a cycle of the nearest; those of the
    second, about the best of them, within a hundredth. Then it is looked between the starts of the grid: what begins
    between two of them fits better at a wrong rate. Promises and rivals are laid alike, or the finer look wins.
    """
    cycles = min(signal.span_s, course.total_s) / course.period_s
    step = 1 / max(1.0, np.ceil(RATES * cycles / COARSE))
    first = max(_at_rates(signal, course, 1 + RATES * np.arange(-1, 1 + step / 2, step), prior), key=_score)
    finer = first.rate + RATES * step * np.arange(-FINER, FINER + 1) / (FINER + 1)
    second = max([first, *_at_rates(signal, course, finer[np.abs(finer - 1) <= WITHIN], prior)], key=_score)
    found, apart = second, max(RATES * step / (FINER + 1), signal.step_s / signal.span_s)
    for closer in CLOSER:
        nearer = _between(signal, course, found, apart / closer, signal.step_s / closer, prior)
        found = max([found, *nearer], key=_score)
    return found


def _between(
    signal: Sampled, course: Course, found: Match, rates_apart: float, starts_apart_s: float, prior: Prior
) -> list[Match]:
    """The same at rates and starts about it, within one step of rates and half a step of starts either way: a start
    that is off is made up for by a rate that is."""
    parts = np.arange(-BETWEEN, BETWEEN + 1) / BETWEEN
    rates, starts = found.rate + rates_apart * parts, signal.start_s - found.start_s + starts_apart_s / 2 * parts
    rates, starts = (x.ravel() for x in np.meshgrid(rates[np.abs(rates - 1) <= WITHIN], starts))
    return _fitted(signal, course, starts, np.ones(len(rates), dtype=np.int64), rates, prior)


def _score(found: Match) -> float:
    return found.evidence


def match_at(signal: Sampled, course: Course, rate: float, prior: Prior = PHYSICAL) -> Match:
    """The best start of `course` lasting `rate` times as long as promised."""
    return _at_rates(signal, course, np.array([rate]), prior)[0]


def _at_rates(signal: Sampled, course: Course, rates: Floats, prior: Prior) -> list[Match]:
    """The best start at each of Q rates; some rates at once, or most of the time goes into calling NumPy."""
    parts = min(len(rates), -(-len(rates) * signal.values.size // AT_ONCE))
    return [found for some in np.array_split(rates, parts) for found in _laid(signal, course, some, prior)]


def _laid(signal: Sampled, course: Course, rates: Floats, prior: Prior) -> list[Match]:
    total, span = course.total_s * rates, signal.span_s
    common = 0.5 * np.minimum(span, total)  # all starts leave half of the shorter of the two in common
    begin, end = common - span, total - common + span
    count = np.maximum(((end - begin) / signal.step_s).astype(int) + 1, len(signal.values))
    return _fitted(signal, course, begin, count - len(signal.values) + 1, rates, prior)


def _fitted(
    signal: Sampled, course: Course, begin: Floats, starts: NDArray[np.int64], rates: Floats, prior: Prior
) -> list[Match]:
    """The best of so many starts (Q,), a step of the grid apart from `begin` (Q,) on, at each of Q rates."""
    at = (begin[:, None] + signal.step_s * np.arange(starts.max() + len(signal.values) - 1)) / rates[:, None]
    commanded = course.angles(at.ravel()).reshape(*at.shape, -1)
    cov, variance, mean = _sliding(signal, commanded)
    gain = _gains(cov, variance, np.asarray(np.ptp(commanded, axis=1).max(axis=0) < TICK))
    left = np.maximum(signal.spread - 2 * gain * cov + gain**2 * variance, 0.0)  # (Q, K, m)
    zero = signal.mean - gain * mean
    fits = log_student(left, signal, prior) + log_prior(zero, 0.0, prior.zero_sd, np.pi, prior.damage)
    there = np.arange(fits.shape[1]) < starts[:, None]
    best = np.where(there, fits.sum(axis=2), -np.inf).argmax(axis=1)
    found = []
    for q, (k, rate) in enumerate(zip(best, rates.tolist(), strict=True)):
        by_gain = log_gains(gain[q, k], prior)
        start = signal.start_s - float(begin[q] + k * signal.step_s)
        evidence = float(fits[q, k].sum() + by_gain.sum())
        explained = explained_by(left[q, k], signal)
        laid = course.slowed(rate)
        found.append(Match(evidence, fits[q, k] + by_gain, start, gain[q, k], zero[q, k], explained, laid, rate))
    return found


def _gains(cov: Floats, variance: Floats, still: NDArray[np.bool_]) -> Floats:
    """The likeliest gains; 1 of joints (m,) that are told to stand still (to move by less than a tick):
    nothing says that they are weak."""
    return np.where(still, 1.0, np.clip(cov / np.maximum(variance, 1e-12), 0.0, HIGHEST_GAIN))


def explained_by(left: Floats, signal: Sampled) -> float:
    """Share of the motion's variance that residuals (m,) [rad^2] leave explained, noise taken off both.

    1 where there is no motion beyond noise.
    """
    noise = float(signal.noise_variance.sum())
    moved = float(signal.spread.sum()) - noise
    return 1.0 if moved < noise else 1 - max(float(left.sum()) - noise, 0.0) / moved


def _sliding(signal: Sampled, commanded: Floats) -> tuple[Floats, Floats, Floats]:
    """Covariance with the signal, variance and mean of the commands under every start (Q, K, m)."""
    _, count, joints = commanded.shape
    starts = count - len(signal.values) + 1
    if starts == 1:
        sums = [signal.weight @ commanded, signal.weight @ commanded**2, (signal.values * commanded).sum(axis=1)]
        sliding = np.concatenate(sums, axis=1)[:, None]
    else:
        size = next_fast_len(count + len(signal.values), real=True)
        known = signal.transforms(size)
        there = rfft(np.concatenate([commanded, commanded**2], axis=2), size, axis=1)
        both = np.concatenate([known[:, :1] * there, known[:, 1:] * there[..., :joints]], axis=2)
        sliding = irfft(both, size, axis=1)[:, :starts]
    mean, second, product = np.split(sliding / signal.weight.sum(), 3, axis=2)
    return product - mean * signal.mean, second - mean**2, mean


def log_student(left: Floats, signal: Sampled, prior: Prior) -> Floats:
    """Log density of mean square residuals (..., m) [rad^2], up to a constant of the signal."""
    typical = TYPICAL**2 * signal.spread + prior.play**2 + signal.noise_variance
    return np.asarray(-(FREEDOM + 1) / 2 * np.log1p(FREEDOM * left / typical))


def log_prior(value: Floats, centre: float, sd: float, width: float, damage: bool = True) -> Floats:
    """Log density of a normal about `centre`, mixed with a uniform one of `width` for what is damaged."""
    narrow = -0.5 * ((value - centre) / sd) ** 2 - np.log(sd * np.sqrt(2 * np.pi))
    if not damage:
        return np.asarray(narrow)
    return np.logaddexp(np.log(1 - DAMAGED) + narrow, np.log(DAMAGED / width))


def log_gains(gain: Floats, prior: Prior) -> Floats:
    """Log prior of gains (m,): about 1, or about one weakness that all joints share."""
    alone = log_prior(gain, 1.0, prior.gain_sd, HIGHEST_GAIN, prior.damage)
    if not prior.damage:
        return alone
    weak = float(np.clip(np.median(gain), 0.05, HIGHEST_GAIN))
    together = log_prior(gain, weak, prior.gain_sd * weak, HIGHEST_GAIN) + np.log(DAMAGED / HIGHEST_GAIN) / len(gain)
    return alone if alone.sum() >= together.sum() else together


def commanded_at(signal: Sampled, contract: Match) -> Floats:
    """What the contract commands (n, m) on the signal's grid, where it was laid."""
    return contract.course.angles(_since(signal, contract))


def _since(signal: Sampled, contract: Match) -> Floats:
    """Times (n,) [s] of the signal's grid since the contract's start."""
    at = signal.start_s - contract.start_s + signal.step_s * np.arange(len(signal.values))
    return at.astype(np.float64)


def gains_meanwhile(signal: Sampled, contract: Match) -> Floats:
    """Gains (m,) while the motion lasts alone: what is done before its first row and after its last, as where a player
    ramps up to the one and down from the other, is no part of the promise, and draws its start and rate aside. 1 where
    hardly a row is known: a few are met by any gains."""
    if signal.weight.sum() < LEAST_ROWS:
        return np.ones_like(contract.gain)
    first, last = NEARBY * contract.course.period_s, contract.course.slowed(1 / contract.rate)
    aside = np.arange(-first, first, signal.step_s / max(CLOSER))
    laid = [replace(contract, start_s=contract.start_s + x, course=c) for c in (contract.course, last) for x in aside]
    found = [one for one in (_meanwhile(signal, m) for m in (contract, *laid)) if one is not None]
    left, gain = min(found, key=lambda one: one[0], default=(1.0, contract.gain))
    return gain if left < 1 - contract.explained else contract.gain  # few rows may tell nothing by themselves


def _meanwhile(signal: Sampled, laid: Match) -> tuple[float, Floats] | None:
    """Share of the motion that is left while a promise lasts, and gains (m,); None where hardly anything is known."""
    since, commanded = _since(signal, laid), commanded_at(signal, laid)
    weight = signal.weight * ((since >= 0) & (since <= laid.course.total_s))
    if weight.sum() < LEAST_ROWS:
        return None
    here, there = (x - weight @ x / weight.sum() for x in (signal.values, commanded))
    cov, variance, spread = weight @ (here * there), weight @ there**2, weight @ here**2
    gain = _gains(cov, variance, np.asarray(np.ptp(commanded, axis=0) < TICK))
    return float((spread - 2 * gain * cov + gain**2 * variance).sum() / max(spread.sum(), 1e-12)), gain


def match_columns(signal: Sampled, contract: Match, prior: Prior) -> tuple[Floats, Floats]:
    """Measured joint i under commanded joint j, laid as the contract is, gains about 1: log evidence and mean square
    residual [rad^2], each (2, m, m).

    [0, i, j]: joint j as it is; [1, i, j]: its sign flipped. Such a fault is not also a weak servo, so no damage.
    """
    commanded = commanded_at(signal, contract)
    count, still = signal.weight.sum(), np.asarray(np.ptp(commanded, axis=0) < TICK)
    mean, own = (signal.weight @ commanded) / count, signal.mean
    there, here = (commanded - mean) * signal.weight[:, None], signal.values - own * signal.weight[:, None]
    cov, variance = here.T @ there / count, np.asarray((there**2).sum(axis=0) / count)
    healthy = np.log(1 - DAMAGED) if prior.damage else 0.0
    found, residuals = [], []
    for sign in (1.0, -1.0):
        gain = _gains(sign * cov, variance, still)
        left = np.maximum(signal.spread[:, None] - 2 * gain * sign * cov + gain**2 * variance, 0.0)
        zero = own[:, None] - sign * gain * mean
        fit = log_student(left.T, signal, prior).T + log_prior(zero, 0.0, prior.zero_sd, np.pi, prior.damage)
        found.append(fit + healthy + log_prior(gain, 1.0, prior.gain_sd, 1.0, damage=False))
        residuals.append(left)
    return np.stack(found), np.stack(residuals)
