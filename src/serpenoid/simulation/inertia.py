"""How steps know the momentum of those before: one set of coefficients for simulation, fits and the NLP.

    impulse of step t = c_0 P_t + c_1 P_{t-1} + c_2 P_{t-2},   P: momentum in the middle of a step

Legend: S steps.
"""

from __future__ import annotations

import numpy as np

from serpenoid.body import Floats


def coefficients(times: Floats) -> Floats:
    """c (S, 3) of steps between `times` (S + 1,), at rest before; a step's duration is its unit of time.

    Momentum at a step's end is extrapolated from the middles of it and of the step before; its change over a step is
    the impulse. On even steps this is BDF2; on uneven ones no impulse is lost where force jumps and the step changes at
    once, as at a pause. Second order, and momenta that relax within a step are damped.
    """
    step = np.diff(times)
    beyond = step / np.concatenate([step[:1], step[1:] + step[:-1]])  # half a step over the distance of the middles
    earlier = np.concatenate([[0.0], beyond[:-1]])
    c = np.column_stack([1 + beyond, -(1 + beyond + earlier), earlier])
    c[0, 1:], c[1:2, 2] = 0.0, 0.0  # nothing moved before: motions may stand one after the other
    return c


def carried(c: Floats, momenta: Floats, before: Floats | None = None) -> Floats:
    """What earlier momenta add to each step's impulse: those (S, ...) of the steps, two `before` (default: at rest)."""
    first = np.zeros((2, *momenta.shape[1:])) if before is None else before
    known = np.concatenate([first, momenta])
    shape = (-1, *[1] * (momenta.ndim - 1))
    return np.asarray(c[:, 1].reshape(shape) * known[1:-1] + c[:, 2].reshape(shape) * known[:-2])


def matrix(c: Floats) -> Floats:
    """(S, S): impulses from momenta, at rest before."""
    return np.asarray(sum(np.diag(c[age:, age], -age) for age in range(3)))
