"""What callers give to simulations, checked before compiled code reads it: that code trusts its lengths."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from itertools import permutations

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError, of_kind
from serpenoid.model import Model

ODD_LENGTH = 0.1  # of a body length, on the average of all rows: an animal's points bring a few percent
FARTHEST = 1e5  # body lengths, rad: poses have 1e-11 there, far below the 1e-8 to which they are confirmed


def model_of(model: Model) -> Model:
    """The model itself; a problem has one."""
    return of_kind("model", model, Model, "Of a problem: problem.model.")


def shaped(name: str, values: Floats, shape: Sequence[int], least: int = 1) -> Floats:
    """`values` as floats of that shape, where -1 stands for `least` or more; they need not be finite."""
    try:
        if np.iscomplexobj(values):  # NumPy would drop the imaginary part, with a warning at most
            raise TypeError("got complex ones. Take the real part where that is what is meant")
        if np.ma.is_masked(values):  # NumPy would take what stands behind the mask
            raise TypeError("some are masked. Fill them with what is meant, or with NaN: values.filled(np.nan)")
        if np.asarray(values).dtype.kind in "mM":  # NumPy would count the units, whichever they are
            raise TypeError("got dates or durations of NumPy or pandas. Divide them by np.timedelta64(1, 's')")
        values = np.asarray(values, float)
    except (TypeError, ValueError) as fault:
        raise InputError(f"`{name}` must be an array of numbers of shape {_words(shape, least)}: {fault}.") from None
    if not _fits(values.shape, shape, least):
        turned = " Transposed?" if any(_fits(axes, shape, least) for axes in permutations(values.shape)) else ""
        raise InputError(f"`{name}` must have shape {_words(shape, least)}, got {values.shape}.{turned}")
    return values


def _fits(sizes: Sequence[int], shape: Sequence[int], least: int) -> bool:
    """Whether an array of these sizes is of that shape."""
    return len(sizes) == len(shape) and all(n == m or (m < 0 and n >= least) for n, m in zip(sizes, shape, strict=True))


def finite(name: str, values: Floats) -> Floats:
    """`values`, all of which are numbers."""
    lost = np.argwhere(~np.isfinite(values))
    if len(lost):
        place, value = ", ".join(map(str, lost[0])), values[tuple(lost[0])]
        raise InputError(f"`{name}` must be finite numbers, got {value} at [{place}]. Did what made it fail?")
    return values


def apart(name: str, vertices: Floats) -> Floats:
    """`vertices` (R, N, d), no two neighbours of which are one point; what is no number may be anywhere."""
    lost = np.argwhere(np.linalg.norm(np.diff(vertices, axis=1), axis=2) == 0)
    if len(lost):
        row, vertex = lost[0].tolist()
        raise InputError(
            f"`{name}` {vertex + 1} and {vertex + 2} of row {row} are one point: an edge needs a length. Where a point "
            "is not known, give NaN."
        )
    return vertices


def odd_lengths(vertices: Floats) -> tuple[str, ...]:
    """That chains (R, N, d) [body lengths] look to be told in another unit, as a sentence: a body is 1 of them long."""
    length = float(np.linalg.norm(np.diff(vertices, axis=1), axis=2).sum(1).mean())
    if abs(length - 1) <= ODD_LENGTH:
        return ()
    return (
        f"the chains are {length:.4g} body lengths long. Vertices are in body lengths, as is what comes of them: "
        "divide by the body's length, in the unit that they have",
    )


def first_poses(start: Floats | None) -> Floats | None:
    """A first pose (3,), or the first poses (K + 1, 3) of a body that is moving."""
    if start is None:
        return None
    shape = (3,) if np.ndim(start) == 1 else (-1, 3)
    start = finite("start", shaped("start", start, shape))
    if np.abs(start).max() > FARTHEST:
        raise InputError(
            f"`start` must be within +-{FARTHEST:g} body lengths and radians, got {np.abs(start).max():.3g}: beyond, "
            "steps of a body are rounding."
        )
    return start


def times_of(times: Floats | None, rows: int) -> Floats | None:
    """A clock (R,) [s] that runs forward."""
    if times is None:
        return None
    times = finite("times", shaped("times", times, (rows,)))
    if not (np.diff(times) > 0).all():
        raise InputError("`times` must increase from row to row [s]. Are two rows the same moment?")
    return times


def cycles_of(cycles: int, closed: bool) -> int:
    """How often a gait is played; rows that are not closed, once."""
    if not isinstance(closed, bool | np.bool_):
        raise InputError(f"`closed` must be True or False, got {closed!r}.")
    try:
        count = operator.index(cycles)
    except TypeError:
        count = 0
    if count < 1:
        raise InputError(
            f"`cycles` must be a whole number, 1 or more, got {cycles!r}. Cut the table for a part of one?"
        )
    if count > 1 and not closed:
        raise InputError(f"`cycles` must be 1 with `closed=False`, got {count}. Such rows are played once.")
    return count


def _words(shape: Sequence[int], least: int) -> str:
    sizes = [f"{least} or more" if n < 0 else str(n) for n in shape]
    return f"({', '.join(sizes)}{',' * (len(sizes) == 1)})"
