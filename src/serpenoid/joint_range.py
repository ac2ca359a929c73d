"""How far joints may bend: one angle to either side, one range for all joints, or a range for each of them.

    joint_limit_deg = 60                       # -60 to 60 degrees, every joint
    joint_limit_deg = [0, 60]                  # 0 to 60 degrees, every joint
    joint_limit_deg = [[0, 60], [-30, 30]]     # joint_1 (next to the tail), joint_2

m: joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import BeforeValidator, Field

LARGEST = 180.0
EXAMPLE = "give one number, [lower, upper], or a list of [lower, upper], one per joint"
Side = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
Pair = tuple[Side, Side]


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _plain(value: Any) -> Any:
    """The same limit in the fewest numbers: a range like to both sides is one number, the same of all joints one range.

    So a limit that means the same is the same value, with the same hash. Raises ValueError with rule and remedy.
    """
    if value is None:
        return None
    if _number(value):
        if not 0 < value <= LARGEST:  # also what is not a number
            rule = f"less than or equal to {LARGEST:g}" if value > LARGEST else "greater than 0"
            raise ValueError(f"must be {rule}")
        return float(value)
    if not isinstance(value, list | tuple) or not value:
        raise ValueError(f"must be degrees; {EXAMPLE}")
    if all(map(_number, value)):
        return _pair(value)
    pairs = [_pair(entry) for entry in value]
    return pairs[0] if all(pair == pairs[0] for pair in pairs) else tuple(map(as_pair, pairs))


def _pair(value: Any) -> float | tuple[float, float]:
    if not isinstance(value, list | tuple) or len(value) != 2 or not all(map(_number, value)):
        raise ValueError(f"needs [lower, upper]; {EXAMPLE}")
    return as_range(float(value[0]), float(value[1]))


def as_range(lower: float, upper: float, most: float = LARGEST) -> float | tuple[float, float]:
    """The range from angle to angle [degrees]; raises ValueError with rule and remedy where they are none."""
    if not -most <= lower < upper <= most:
        remedy = "a vertex that does not bend is left out of `joints`"
        raise ValueError(f"needs -{most:g} <= lower < upper <= {most:g}; {remedy}")
    return upper if lower == -upper else (lower, upper)


def as_pair(limit: float | tuple[float, float]) -> tuple[float, float]:
    """Lower and upper angle [degrees] of a limit that is the same for all joints."""
    return limit if isinstance(limit, tuple) else (-limit, limit)


JointLimit: TypeAlias = Annotated[
    Annotated[float, Field(gt=0, le=LARGEST)] | Pair | tuple[Pair, ...], BeforeValidator(_plain)
]
"""Degrees: a number, (lower, upper), or one of these for each joint, tail to head."""
Limit: TypeAlias = float | tuple[float, float] | tuple[tuple[float, float], ...]


def of_each(limit: Limit) -> Sequence[tuple[float, float]] | None:
    """The ranges of a limit that gives one for each joint; None: it is the same for all."""
    given = limit if isinstance(limit, tuple) else ()
    each = tuple(entry for entry in given if isinstance(entry, tuple))
    return each or None


def misfit(limit: Limit | None, joints: int) -> str | None:
    """Why a limit is none of a body with so many joints; None: it is."""
    each = None if limit is None else of_each(limit)
    if each is None or len(each) == joints:
        return None
    return f"`joint_limit_deg` needs {joints} pairs [lower, upper], one per joint from tail to head, got {len(each)}"


def ranges_deg(limit: Limit, joints: int) -> NDArray[np.float64]:
    """Lower and upper angle of every joint, shape (m, 2) [degrees]."""
    return np.array(np.broadcast_to(np.array(limit if isinstance(limit, tuple) else (-limit, limit)), (joints, 2)))


def limit_words(limit: Limit) -> str:
    """`60`, `0 to 60`, `0 to 60 and -30 to 30 (by joint)`; degrees."""
    each = of_each(limit)
    if each is not None:
        *others, last = (range_words(*pair) for pair in each)
        return f"{', '.join(others)} and {last} (by joint)"
    return range_words(*limit) if isinstance(limit, tuple) else f"{limit:g}"


def range_words(lower: float, upper: float) -> str:
    """A joint's range in words, one number where it is the same to either side."""
    return f"{upper:g}" if lower == -upper else f"{lower:g} to {upper:g}"
