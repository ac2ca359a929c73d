"""Steps with effects that know place or history: each one needs those before it.

Newton's method for a window of steps at once: the residual of step i contains the poses i - 2 .. i + 1. A window that
does not converge is halved, down to single steps.

Legend: S steps, W steps of a window, M elements.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.simulation.balance import about
from serpenoid.simulation.inertia import carried, coefficients
from serpenoid.simulation.law import MediumNumbers, evaluate
from serpenoid.simulation.newton import TOLERANCE, State, newton
from serpenoid.simulation.steps import Steps

WINDOW = 256


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
        energy[:done], momenta[2 : done + 2] = given.more
        residual[:done], sound[:done] = 0.0, True
    window = min(WINDOW, count)
    while done < count:
        end = min(done + window, count)
        found = _window(chain, poses, momenta, done, group.accumulate(guess[done:end], poses[done])[1:])
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
    return Steps(group.relative(poses[:-1], poses[1:]), energy, residual, sound)


@dataclass(frozen=True)
class Chain:
    """What does not change about the steps: numbers, elements by step (4, S, M), settings, inertia (S, 3)."""

    law: MediumNumbers
    before: Floats
    after: Floats
    settings: Floats
    inertia: Floats

    @classmethod
    def of(cls, model: Model, before: Floats, after: Floats, times: Floats) -> Chain:
        law, m = MediumNumbers.of(model), model.structure.elements
        settings = law.settings(np.column_stack([times[:-1], times[1:]]))
        return cls(law, before.reshape(4, -1, m), after.reshape(4, -1, m), settings, coefficients(times))


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
    before = about(momenta[first : first + 2], home)

    def equations(trial: Floats, _: np.ndarray) -> State:
        return evaluate_window(chain, part, np.vstack([poses[first] - home, trial]), before, home[:2])

    x, state = newton(equations, guess - home, together=len(guess))
    energy, own = state.more
    converged = bool((state.size <= TOLERANCE).all())
    return _Found(converged, x + home, about(own, -home), energy, state.size, state.resisting)


def evaluate_window(chain: Chain, part: slice, poses: Floats, before: Floats, origin: Floats | None = None) -> State:
    """Equations of the steps in `part`: poses (W + 1, 3) and the two momenta before (2, 3), all about `origin`.

    Slopes by the poses i + 1 .. i - 2; more: energy (W,), momenta (W, 3).
    """
    pairs = np.hstack([poses[:-1], poses[1:]]).T
    ends = chain.before[:, part].reshape(4, -1), chain.after[:, part].reshape(4, -1)
    settings = chain.settings[:, part].copy()
    settings[3:5] = 0.0 if origin is None else origin[:, None]
    value, energy, slope = evaluate("coupled", chain.law, *ends, pairs, settings)
    c, momenta = chain.inertia[part], value[:, 3:]
    residual = value[:, :3] + c[:, :1] * momenta + carried(c, momenta, before)
    zero = np.zeros((2, 3, 3))
    start, end = (np.concatenate([zero, by]) for by in (slope[:, 3:, :3], slope[:, 3:, 3:]))
    c0, c1, c2 = c.T[..., None, None]
    slopes = np.stack(
        [
            slope[:, :3, 3:] + c0 * end[2:],
            slope[:, :3, :3] + c0 * start[2:] + c1 * end[1:-1],
            c1 * start[1:-1] + c2 * end[:-2],
            c2 * start[:-2],
        ]
    )
    return State(residual, slopes, (energy, momenta))
