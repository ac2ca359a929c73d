"""Points that a film has beside an animal's midline: said where its mean bends are those of one point that is off.

A point i that is o to the left of the midline turns its two edges, of lengths e_i-1 and e_i, to either side:

    mean bends at i - 1, i, i + 1:    o / e_i-1,    -o / e_i-1 - o / e_i,    o / e_i

A body that is held bent is so smoothly, by a curvature that changes along it: a line is fitted, with and without such a
point, and Fisher's F tells whether one of the points is off. All that have a bend on either side are tried: one next to
an end makes the bends of a head, or a tail, that is held so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from serpenoid.measure.cells import Floats

ERROR = 0.01  # false alarms
HELD = 2  # numbers of a curvature that changes evenly along the body
LEAST = 0.05  # of an edge: less is where a tracker draws the line


class Beside(NamedTuple):
    """A point beside the midline: its number from the tail, and how far to the left, in the unit of the edges."""

    vertex: int
    left: float


def beside_midline(edges: Floats, bends: Floats) -> Beside | None:
    """The point that is beside the midline, of a body with edges (E,) and bends (F, E - 1) of its joints in time."""
    known = bends[np.isfinite(bends).all(axis=1)]
    count, free = bends.shape[1], bends.shape[1] - HELD - 1
    if free < 1 or count < 3 or not len(known):
        return None
    mean = np.median(known, axis=0)
    over = (edges[1:] + edges[:-1]) / 2
    arcs = np.cumsum(edges)[:-1] / edges.sum()
    held = np.column_stack([over, over * arcs])
    before = _left(held, mean)[0]
    tried = [_left(np.column_stack([held, _of_point(edges, i)]), mean) for i in range(2, count)]
    best = int(np.argmin([left for left, _ in tried]))
    left, offset = tried[best]
    if left <= 0 or abs(offset) < LEAST * float(np.median(edges)):
        return None
    chance = len(tried) * float(fdtrc(1, free, (before - left) / left * free))
    return Beside(best + 2, offset) if chance < ERROR else None


def said(found: Beside, edges: Floats) -> str:
    """What is said of it, with what to do."""
    side = "left" if found.left > 0 else "right"
    share = abs(found.left) / float(np.median(edges))
    return (
        f"its point {found.vertex + 1} from the tail stands {share:.0%} of an edge beside the midline of the others, "
        f"to the {side}, all the time: bends beside it are not the body's, and move what is fitted. Leave that point "
        "out, or mend the tracking"
    )


def _of_point(edges: Floats, vertex: int) -> Floats:
    """Mean bends (E - 1,) of a point that is 1 to the left."""
    turned = np.zeros(len(edges))
    turned[vertex - 1], turned[vertex] = 1 / edges[vertex - 1], -1 / edges[vertex]
    return np.asarray(np.diff(turned))


def _left(columns: Floats, values: Floats) -> tuple[float, float]:
    """Sum of squares that columns leave, and the last one's coefficient."""
    best = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(((values - columns @ best) ** 2).sum()), float(best[-1])
