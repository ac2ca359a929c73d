"""How an effect is looked for that lies somewhere on the floor: places to try, what a weak one does to first order.

A spot of other friction changes the grip of every vertex that is on it. So to first order it is a sum of an effect that
sits at a vertex, weighed by how much of the spot each vertex feels: all places are scored from these columns.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from serpenoid.body import Floats


@dataclass(frozen=True)
class Grid:
    """Candidates alike in size: `values` (K = X Y) of what has no neutral value, the second axis running fastest.

    felt: from places (..., 2) [m] on the floor to (..., X) and (..., Y); products of the two are how much of each
    candidate is felt there. Y = 1 where it is no product.
    """

    values: tuple[Mapping[str, float], ...]
    felt: Callable[[Floats], tuple[Floats, Floats]]


@dataclass(frozen=True)
class Scan:
    """An effect's strength is its first parameter, the only one with a neutral value; the others are tried on grids.

    made_of: the effect of a vertex that it is to first order, but for what pulls there beside the drag: of that one's
    parameter, strength times what is felt there (by_weight: times the vertex's share of the body's weight). size: the
    parameter in which the candidates of a grid are alike; the best of each size is fitted in full. begins: least and
    most strength where such a fit begins, linear steps lead farther. grids: by the corners (2,) [m] of the floor that
    was visited and the body's length [m].
    """

    made_of: str
    size: str
    begins: tuple[float, float]
    grids: Callable[[Floats, Floats, float], Sequence[Grid]]
    by_weight: bool = True
