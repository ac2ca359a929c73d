"""How a body beats, though no beat is as long as the next: by the phase of its bends.

    angles about t = mean + Re z(t) e^(2 pi i s / T),    by least squares, weighted by a Hann window of two periods:
                                                         the shortest that neither a mean nor a harmonic disturbs
    turn from t to t'  = arg sum_j z_j(t') conj z_j(t),  of all joints together
    T                  : of all scales the one whose sines leave least of what varies in their windows

It is a beat if, half of it at least, the body does the same once more when its phase has turned once: what merely
wanders has a scale, too, and does not.

Legend: R rows, C centres, m joints, K rows in a window.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from serpenoid.measure.blocks import blocks
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.signals import AGREES, LEAST_OVERLAP, Signal
from serpenoid.measure.shapes.principal_bends import shown_bends

if TYPE_CHECKING:
    from serpenoid.measure.trial import Motion

PER_TURN = 8  # centres: their phases are told apart though a beat is thrice as quick as another
PER_OCTAVE = 8  # scales that are tried: a window of two periods tells them no finer
LEAST_FRAMES = 4  # of a beat: with three unknowns, its two periods still leave something to compare
MOST_FRAMES = 32  # of a beat: of more, so many means are taken
MOST_CENTRES = 400  # of a scale that is tried
ROUNDS = 5  # of turning at the period that the last one found, unless it has
SETTLED = 1e-6  # of a period
UNKNOWNS = 3  # of a window: mean, cosine, sine
STANDING = 0.05  # waves on the body: fewer are told as none
SINGULAR = 1e-6  # of the Gram matrix: rows at the edge of a window


@dataclass(frozen=True)
class Beat:
    """How a body bends, where it repeats: mean period [s] and SD of single beats [s], amplitude (m,) of each joint's
    sine [rad], and waves on the body, > 0 where they run from head to tail most of the time; 0: bends that stand.

    turns (C,): beats since the first of the moments centres_s (C,) [s]."""

    period_s: float
    spread_s: float
    amplitude_rad: Floats
    waves: float
    centres_s: Floats
    turns: Floats

    @property
    def runs(self) -> bool:
        """Whether its bends travel."""
        return abs(self.waves) > STANDING


@dataclass(frozen=True)
class Sines:
    """Complex amplitudes (C, m) about centres (C,) [s], zero where a window has too few rows; left, varied (C,):
    squares with and without the sine, over the degrees of freedom."""

    centres: Floats
    amplitudes: NDArray[np.complex128]
    left: Floats
    varied: Floats


def beat(motion: Motion) -> Beat | None:
    """None where nothing repeats; of close points noise is most of every joint angle, and little of whole bends."""
    rows = np.concatenate([np.arange(run.start, run.stop) for run in motion.runs])
    bends = shown_bends(motion.joint_angles[rows], motion.covariance[rows][:, 3:, 3:])
    if not Signal(motion.time_s[rows], bends).moves:
        return None
    time_s, angles = motion.time_s[rows], motion.smooth_angles[rows]
    period = _scale(time_s, angles)
    if period is None:
        return None
    time_s, angles, _ = _averaged(time_s, angles, period)
    sines, turned, period = _turned(time_s, angles, period)
    agreement, seconds = _once_more(time_s, angles, sines.centres, turned)
    if not agreement >= AGREES:
        return None
    rate = np.clip(np.gradient(turned, sines.centres), 1 / (2 * period), 2 / period)
    own = _evenly_seen(time_s, sines_about(time_s, angles, sines.centres, 1 / rate), period)
    amplitude = np.sqrt((np.abs(own) ** 2).mean(axis=0))
    waves = _lag(own) * (own.shape[1] + 1) / (2 * np.pi)
    return Beat(period, float(seconds.std()), amplitude, waves, sines.centres, turned)


def _lag(amplitudes: NDArray[np.complex128]) -> float:
    """Mean phase from a joint to the next: of an animal that reverses, waves that run back are as long, not none."""
    lags = (amplitudes[:, 1:] * amplitudes[:, :-1].conj()).sum(axis=1)
    way = -1.0 if lags.imag.sum() < 0 else 1.0
    return float(way * np.angle((lags.real + 1j * np.abs(lags.imag)).sum()))


def _scale(time_s: Floats, angles: Floats) -> float | None:
    """The period whose sines leave least of what varies; None: too few rows for any."""
    shortest, longest = LEAST_FRAMES * np.median(np.diff(time_s)), (1 - LEAST_OVERLAP) * np.ptp(time_s)
    if not longest > shortest:
        return None
    scales = shortest * 2 ** np.arange(0, np.log2(longest / shortest), 1 / PER_OCTAVE)
    shares = []
    for period in scales:
        count = min(int(2 * np.ptp(time_s) / period) + 1, MOST_CENTRES)
        at, means, within = _averaged(time_s, angles, period)
        found = sines_about(at, means, np.linspace(time_s[0], time_s[-1], count), period)
        varied = found.varied.mean() + within
        shares.append((found.left.mean() + within) / varied if varied > 0 else 1.0)
    return float(scales[int(np.argmin(shares))])


def _averaged(time_s: Floats, angles: Floats, period: float) -> tuple[Floats, Floats, float]:
    """Means of successive rows, as many as leave enough of a period, and the variance within them, of all joints."""
    rows = int(period / np.median(np.diff(time_s)) / MOST_FRAMES)
    if rows < 2:
        return time_s, angles, 0.0
    kept = len(time_s) // rows * rows
    groups = angles[:kept].reshape(-1, rows, angles.shape[1])
    return (
        time_s[:kept].reshape(-1, rows).mean(axis=1),
        groups.mean(axis=1),
        float(groups.var(axis=1).sum(axis=1).mean()),
    )


def _turned(time_s: Floats, angles: Floats, period: float) -> tuple[Sines, Floats, float]:
    """Sines at the mean period, turns (C,) since the first centre, and that period: by turns of all that bends, each
    weighing the more the farther it is from the film's ends."""
    for _ in range(ROUNDS):
        centres = np.arange(time_s[0], time_s[-1], period / PER_TURN)
        sines = sines_about(time_s, angles, centres, period)
        moved = (sines.amplitudes[1:] * sines.amplitudes[:-1].conj()).sum(axis=1)
        turns = np.where(moved != 0, np.abs(np.angle(moved)) / (2 * np.pi), 1 / PER_TURN)
        inside = np.minimum(centres[:-1] - time_s[0], time_s[-1] - centres[1:]) / period
        share = np.abs(moved) * np.clip(inside, 0.0, 1.0)
        before = period
        if share @ turns > 0:
            period = float(period / PER_TURN * share.sum() / (share @ turns))
        if abs(period - before) <= SETTLED * before:
            break
    return sines, np.concatenate([[0.0], np.cumsum(turns)]), period


def _once_more(time_s: Floats, angles: Floats, centres: Floats, turned: Floats) -> tuple[float, Floats]:
    """How well angles (R, m) agree with those one turn later, each about their mean, and after what seconds those are,
    for every row of which both are seen."""
    phase = np.interp(time_s, centres, turned)
    rising = np.concatenate([[True], np.diff(np.maximum.accumulate(phase)) > 0])
    later = np.interp(phase + 1, phase[rising], time_s[rising], right=np.nan)
    row = np.clip(np.searchsorted(time_s, later), 1, len(time_s) - 1)
    seen = np.isfinite(later) & (time_s[row] - time_s[row - 1] <= 3 * np.median(np.diff(time_s)))
    if seen.sum() < 2:
        return 0.0, np.zeros(1)
    after = np.stack([np.interp(later[seen], time_s, column) for column in angles.T], axis=1)
    now, after = angles[seen] - angles[seen].mean(axis=0), after - after.mean(axis=0)
    both = np.sqrt((now**2).sum() * (after**2).sum())
    return float((now * after).sum() / both) if both > 0 else 0.0, later[seen] - time_s[seen]


def _evenly_seen(time_s: Floats, sines: Sines, period: float) -> NDArray[np.complex128]:
    """Amplitudes in the better half of the windows by frames seen: points that scatter in single frames bend neighbours
    to opposite sides, which passes for short waves."""
    count = np.searchsorted(time_s, sines.centres + period) - np.searchsorted(time_s, sines.centres - period)
    solved = np.abs(sines.amplitudes).sum(axis=1) > 0
    return sines.amplitudes[solved & (count >= np.median(count[solved]))]


def sines_about(time_s: Floats, angles: Floats, centres: Floats, period: Floats | float) -> Sines:
    """Sines in windows about centres (C,), of one period or each of its own (C,)."""
    period = np.broadcast_to(np.asarray(period, dtype=float), centres.shape)
    first, stop = np.searchsorted(time_s, centres - period), np.searchsorted(time_s, centres + period, side="right")
    width, joints = max(1, int((stop - first).max())), angles.shape[1]  # in a gap windows are empty
    found = Sines(centres, np.zeros((len(centres), joints), complex), *np.zeros((2, len(centres))))
    for b in blocks(len(centres), width * (joints + UNKNOWNS)):
        rows = first[b, None] + np.arange(width)
        inside, rows = rows < stop[b, None], np.minimum(rows, len(time_s) - 1)
        since = (time_s[rows] - centres[b, None]) / period[b, None]
        weight = np.where(inside, np.cos(np.pi / 2 * since) ** 2, 0.0)
        _solve(found, b, since, weight, angles[rows])
    return found


def _solve(found: Sines, b: slice, since: Floats, weight: Floats, angles: Floats) -> None:
    """Fill in windows b: rows (B, K) since their centres [periods], with weights, and angles (B, K, m)."""
    total, effective = weight.sum(axis=1), weight.sum(axis=1) ** 2 / np.maximum((weight**2).sum(axis=1), 1e-300)
    share = weight / np.maximum(total, 1e-300)[:, None]
    angles = angles - np.einsum("bk,bkm->bm", share, angles)[:, None]
    turn = 2 * np.pi * since
    basis = np.stack([np.ones_like(turn), np.cos(turn), np.sin(turn)], axis=-1)
    gram = np.einsum("bki,bk,bkj->bij", basis, share, basis)
    right = np.einsum("bki,bk,bkm->bim", basis, share, angles)
    good = (effective > UNKNOWNS + 1) & (np.linalg.eigvalsh(gram)[:, 0] > SINGULAR)
    sines = np.linalg.solve(np.where(good[:, None, None], gram, np.eye(UNKNOWNS)), right)
    varied = np.einsum("bk,bkm->b", share, angles**2)
    left = varied - np.einsum("bim,bim->b", sines, right)
    found.amplitudes[b] = np.where(good[:, None], sines[:, 1] - 1j * sines[:, 2], 0.0)
    freedom = np.where(good, effective, np.inf)
    found.varied[b] = np.where(good, varied * effective / (freedom - 1), 0.0)
    found.left[b] = np.where(good, left * effective / (freedom - UNKNOWNS), 0.0)
