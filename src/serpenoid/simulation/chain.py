"""Steps with effects that know place or history: each one needs those before it.

Newton's method for a window of steps at once: the residual of step i contains the poses i - 2 .. i + 1, so its Jacobian
is banded and block-triangular. A window that does not converge is halved, down to single steps with damping.

Legend: S steps, W steps of a window, M elements.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import LinAlgError, solve_banded

from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.simulation.balance import about, compose, relative
from serpenoid.simulation.law import MediumNumbers, evaluate
from serpenoid.simulation.steps import TOLERANCE, Steps

WINDOW = 256
ITERATIONS = 40
LEAST_DAMPING = 1e-6
LOWER, UPPER = 11, 2  # bands of a 3 x 3 block matrix with three blocks below the diagonal one


def solve_chain(model: Model, before: Floats, after: Floats, times: Floats, start: Floats, guess: Floats) -> Steps:
    """Relative poses of S steps between `times` (S + 1,) [s] from pose `start` on the floor, at rest before.

    before, after: elements (4, M S); guess: relative poses (S, 3) to begin with. `start` (K + 1, 3): the body is
    moving; its first K steps are these, and what momentum they leave it with is carried on.
    """
    chain = Chain.of(model, before, after, times)
    count = len(times) - 1
    poses, momenta = np.empty((count + 1, 3)), np.zeros((count + 2, 3))  # momenta: two zeros, then one per step
    energy, residual, sound = np.full(count, np.nan), np.full(count, np.inf), np.zeros(count, bool)
    known = np.atleast_2d(start)
    done = len(known) - 1
    poses[: done + 1] = known
    if done:
        given = evaluate_window(chain, slice(0, done), known, momenta[:2])
        momenta[2 : done + 2], energy[:done], residual[:done], sound[:done] = given.momenta, given.energy, 0.0, True
    window = min(WINDOW, count)
    while done < count:
        end = min(done + window, count)
        found = _window(chain, poses, momenta, done, _continued(poses[done], guess[done:end]))
        if not found.converged and window > 1 and end - done > 1:
            window = max((end - done) // 2, 1)
            continue
        part = slice(done, end)
        poses[done + 1 : end + 1], momenta[done + 2 : end + 2] = found.poses, found.momenta
        energy[part], residual[part], sound[part] = found.energy, found.residual, found.converged & found.resisting
        if not found.converged:
            break
        done, window = end, min(2 * window, WINDOW)
    poses[done + 1 :] = np.nan if done < count else poses[done + 1 :]
    return Steps(relative(poses[:-1], poses[1:]), energy, residual, sound)


def difference_weights(times: Floats) -> Floats:
    """Coefficients (S, 3) of momentum in the middle of each step and of the two before it, for its rate there [1/s].

    Momentum at a step's end is extrapolated from the middles of it and of the step before; its change over a step is
    the impulse. On even steps this is BDF2; on uneven ones no impulse is lost where force jumps and the step changes at
    once, as at a pause. Second order, and momenta that relax within a step are damped. At rest at times[0].
    """
    step = np.diff(times)
    beyond = step / np.concatenate([step[:1], step[1:] + step[:-1]])  # half a step over the distance of the middles
    earlier = np.concatenate([[0.0], beyond[:-1]])
    return np.column_stack([1 + beyond, -(1 + beyond + earlier), earlier]) / step[:, None]


@dataclass(frozen=True)
class Chain:
    """Everything about the steps that does not change: numbers, elements by step (4, S, M), settings, rates (S, 3)."""

    law: MediumNumbers
    before: Floats
    after: Floats
    settings: Floats
    rates: Floats

    @classmethod
    def of(cls, model: Model, before: Floats, after: Floats, times: Floats) -> Chain:
        law, m = MediumNumbers.of(model), model.structure.elements
        settings = law.settings(np.column_stack([times[:-1], times[1:]]))
        rates = difference_weights(times) * settings[1][:, None]  # dt times the coefficients: dimensionless
        return cls(law, before.reshape(4, -1, m), after.reshape(4, -1, m), settings, rates)


@dataclass(frozen=True)
class _Found:
    converged: bool
    poses: Floats
    momenta: Floats
    energy: Floats
    residual: Floats
    resisting: np.ndarray


def _window(chain: Chain, poses: Floats, momenta: Floats, first: int, guess: Floats) -> _Found:
    """Solve the steps first .. first + W - 1 for their second poses (W, 3)."""
    part = slice(first, first + len(guess))
    home = poses[first] * [1, 1, 0]
    carried = about(momenta[first : first + 2], home)
    x, size, damping = guess - home, np.inf, 1.0
    best, step = None, np.zeros_like(guess)
    for _ in range(ITERATIONS):
        trial = x + damping * step
        now = evaluate_window(chain, part, np.vstack([poses[first] - home, trial]), carried, home[:2])
        value = float(np.max(np.abs(now.residual)))
        if np.isfinite(value) and value < size:
            x, size, best, damping = trial, value, now, min(1.0, 2 * damping)
            if size <= TOLERANCE / 10:
                break
            step = -solve_linear(now.slopes, now.residual[..., None])[..., 0]
        else:
            damping /= 3
            if damping < LEAST_DAMPING:
                break
    if best is None:
        count = len(guess)
        nothing = np.full(count, np.nan)
        return _Found(False, guess, np.zeros((count, 3)), nothing, nothing, np.zeros(count, bool))
    resisting = np.linalg.det(best.slopes[0]) > 0
    return _Found(
        size <= TOLERANCE, x + home, about(best.momenta, -home), best.energy, np.abs(best.residual).max(1), resisting
    )


@dataclass(frozen=True)
class Evaluation:
    """Residuals (W, 3), momenta (W, 3), energy (W,), and derivatives by the poses i + 1 .. i - 2 (4, W, 3, 3)."""

    residual: Floats
    momenta: Floats
    energy: Floats
    slopes: Floats


def evaluate_window(
    chain: Chain, part: slice, poses: Floats, carried: Floats, origin: Floats | None = None
) -> Evaluation:
    """Residuals of the steps in `part`: poses (W + 1, 3) and the two momenta before (2, 3), all about `origin`."""
    pairs = np.hstack([poses[:-1], poses[1:]]).T
    before, after = chain.before[:, part].reshape(4, -1), chain.after[:, part].reshape(4, -1)
    settings = chain.settings[:, part].copy()
    settings[3:5] = 0.0 if origin is None else origin[:, None]
    value, energy, slope = evaluate("coupled", chain.law, before, after, pairs, settings)
    c0, c1, c2 = (chain.rates[part, i, None] for i in range(3))
    momenta = np.vstack([carried, value[:, 3:]])
    residual = value[:, :3] + c0 * momenta[2:] + c1 * momenta[1:-1] + c2 * momenta[:-2]
    by_start, by_end = slope[:, :, :3], slope[:, :, 3:]
    slopes = np.zeros((4, len(pairs.T), 3, 3))
    zero = np.zeros((1, 3, 3))
    start = np.concatenate([zero, zero, by_start[:, 3:]])
    end = np.concatenate([zero, zero, by_end[:, 3:]])
    a, b, c = c0[..., None], c1[..., None], c2[..., None]
    slopes[0] = by_end[:, :3] + a * end[2:]
    slopes[1] = by_start[:, :3] + a * start[2:] + b * end[1:-1]
    slopes[2] = b * start[1:-1] + c * end[:-2]
    slopes[3] = c * start[:-2]
    return Evaluation(residual, value[:, 3:], energy, slopes)


def solve_linear(slopes: Floats, right: Floats) -> Floats:
    """Solutions (W, 3, K) of the banded system of a window; the unknowns are the second poses, the first is given.

    Zero where the system is singular: a body that touches nothing, a window that went astray.
    """
    count = len(right)
    bands = np.zeros((LOWER + UPPER + 1, 3 * count))
    row, column = np.meshgrid(np.arange(3), np.arange(3), indexing="ij")
    for below in range(4):
        steps = np.arange(below, count)
        i, j = 3 * steps[:, None, None] + row, 3 * (steps[:, None, None] - below) + column
        bands[UPPER + i - j, j] = slopes[below, below:]
    if not np.isfinite(bands).all():
        return np.zeros_like(right)
    try:
        solution = solve_banded((LOWER, UPPER), bands, right.reshape(3 * count, -1))
    except LinAlgError:
        return np.zeros_like(right)
    return np.asarray(solution).reshape(right.shape)


def _continued(start: Floats, relative_poses: Floats) -> Floats:
    """Poses (W, 3) reached from `start` by relative ones."""
    poses = [start]
    for motion in relative_poses:
        poses.append(compose(poses[-1][None], motion[None])[0])
    return np.array(poses[1:])
