"""Newton's method for the equations of steps, side by side or in a chain, and the derivative of what it finds.

    r_i(x_i, x_{i-1}, .., x_{i-K+1}; theta) = 0,   slopes[k, i] = d r_i / d x_{i-k}
    dx = -A^{-1} r,   dx / dtheta = -A^{-1} dr / dtheta        (implicit function theorem: the same system)

A is block-banded: of steps that do not know each other K is 1; of a chain (place, momentum) each step knows those
before. Every chain (or step alone) has a damping of its own and leaves when it is done. Equations are the only
difference.

Legend: S steps in G chains, n some of them, d unknowns of a step (3 in the plane, 6 in space), P parameters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics.substitution import substituted

TOLERANCE = 1e-12  # of a root: by how much another step would move it, or of its residual
ENOUGH = TOLERANCE / 10  # of the residual: where the search ends
ITERATIONS = 60
LEAST_DAMPING = 1e-8


@dataclass(frozen=True)
class State:
    """Residuals (n, d) and slopes (K, n, d, d) of n steps; more: what else is known of them, arrays (n, ...)."""

    residual: Floats
    slopes: Floats
    more: tuple[Floats, ...] = ()

    @property
    def size(self) -> Floats:
        """Largest residual of each step (n,)."""
        return np.asarray(np.abs(self.residual).max(1))

    @property
    def found(self) -> np.ndarray:
        """Whether each step is at a root (n,)."""
        return at_root(self.size, self.slopes[0])

    @property
    def resisting(self) -> np.ndarray:
        """Whether each step's own slope has the sign of a resisting medium (n,)."""
        return np.asarray(np.linalg.det(self.slopes[0]) > 0)

    def put(self, steps: np.ndarray, other: State, which: np.ndarray) -> None:
        """Take over steps of another state."""
        self.residual[steps], self.slopes[:, steps] = other.residual[which], other.slopes[:, which]
        for mine, theirs in zip(self.more, other.more, strict=True):
            mine[steps] = theirs[which]


def at_root(size: Floats, slopes: Floats) -> np.ndarray:
    """Whether residuals of these sizes (n,) are those of roots (n,), by slopes (n, d, d).

    Dry friction on an element that hardly moves is a million times as stiff as drag, and rounding of a place as much
    larger in the residual. So where that is not small, what it is worth as a motion decides.
    """
    found = np.asarray(size <= TOLERANCE)
    left = np.flatnonzero(~found & np.isfinite(slopes).all((1, 2)))
    found[left] = size[left] <= TOLERANCE * np.linalg.svd(slopes[left], compute_uv=False)[:, -1]
    return found


Equations = Callable[[Floats, np.ndarray], State]  # unknowns (n, d), numbers of these steps (n,)


def newton(
    equations: Equations, guess: Floats, chains: np.ndarray | None = None, tolerance: float = ENOUGH
) -> tuple[Floats, State]:
    """Unknowns (S, d) and the state there, from a guess; chains (G,): how many successive steps each has (one).

    Whether they are roots says the state: a step that finds none stays where its residual was least.
    """
    lengths = np.ones(len(guess), int) if chains is None else chains
    owner = np.repeat(np.arange(len(lengths)), lengths)
    x, kept = guess.copy(), equations(guess, np.arange(len(guess)))
    size, damping = _largest(kept, lengths), np.ones(len(lengths))
    step = -solution(kept.slopes, kept.residual[..., None], lengths)[..., 0]
    bad = ~np.isfinite(kept.residual).all(1)
    kept.residual[bad], kept.slopes[:, bad] = np.inf, 0.0
    todo = np.flatnonzero((size > tolerance) & (size < np.inf))
    for _ in range(ITERATIONS):
        if todo.size == 0:
            break
        going = np.zeros(len(lengths), bool)
        going[todo] = True
        steps = np.flatnonzero(going[owner])
        trial = x[steps] + damping[owner[steps], None] * step[steps]
        found = equations(trial, steps)
        now = _largest(found, lengths[todo])
        better = now < size[todo]
        won, lost, which = todo[better], todo[~better], np.repeat(better, lengths[todo])
        x[steps[which]], size[won] = trial[which], now[better]
        kept.put(steps[which], found, which)
        further = solution(found.slopes[:, which], found.residual[which, :, None], lengths[won])
        step[steps[which]] = -further[..., 0]
        damping[won], damping[lost] = np.minimum(1.0, 2 * damping[won]), damping[lost] / 3
        todo = todo[(size[todo] > tolerance) & (damping[todo] > LEAST_DAMPING)]
    return x, kept


def _largest(state: State, lengths: np.ndarray) -> Floats:
    """Largest residual of each chain; infinite where one is not a number."""
    size = state.size
    if len(lengths) < len(size):
        size = np.maximum.reduceat(size, np.cumsum(lengths) - lengths)
    return np.where(np.isfinite(size), size, np.inf)


def implicit_derivative(slopes: Floats, by: Floats, chains: np.ndarray | None = None) -> Floats:
    """Derivatives (S, d, P) of the roots, from slopes (K, S, d, d) and derivatives (S, d, P) of the residuals there."""
    return -solution(slopes, by, chains)


def solution(slopes: Floats, right: Floats, chains: np.ndarray | None = None) -> Floats:
    """Solutions (n, d, P) of the block-banded system with `right` (n, d, P); chains: their lengths, by default one.

    Where it is singular: of a step alone `right` itself (a short step downhill), of a chain zero (a body that touches
    nothing, a window that went astray).
    """
    if len(slopes) == 1:
        return _alone(slopes[0], right)
    return substituted(slopes, right, np.array([len(right)]) if chains is None else chains)


def _alone(matrix: Floats, right: Floats) -> Floats:
    known = np.where(np.isfinite(matrix).all((1, 2), keepdims=True), matrix, 0.0)
    singular = np.abs(np.linalg.det(known)) <= 1e-300
    regular = np.where(singular[:, None, None], np.eye(matrix.shape[1]), known)
    return np.asarray(np.linalg.solve(regular, right))
