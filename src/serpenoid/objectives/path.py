"""Along a way: the mean squared distance of the centre, or of the head, from a line of straight pieces, and a corridor.

The distance from a line says nothing about how far to go along it; add a place to reach, or a displacement.
"""

from __future__ import annotations

from typing import Annotated, Literal

import casadi as ca
import numpy as np
from pydantic import Field

from serpenoid.body import Floats
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.frames import placed
from serpenoid.objectives.obstacles import TINY, Obstacle
from serpenoid.objectives.term import FAR, Played, Point, Term, after, places

CORNERS = 1000  # every piece is a symbolic distance of every point and row: more are a drawing, not a line to follow
Line = Annotated[
    tuple[Point, ...],
    Field(min_length=2, max_length=CORNERS, description="corners x, y [body lengths], frame of row 0"),
]


class Path(Term):
    """Mean over the rows of `cycles` cycles of the squared distance from the line [body lengths squared]."""

    kind: Literal["path"] = "path"
    line: Line
    point: Literal["centre", "head"] = "centre"
    cycles: int = Field(default=1, ge=1, le=100, description="the cycle is played so often along the line")

    def expression(self, of: Criteria) -> ca.SX:
        """Zero where every row is on the line."""
        rows = range(1, of.steps + 1)
        local = [of.centre(t) if self.point == "centre" else of.vertices(t)[:, -1] for t in rows]
        total = ca.SX(0)
        for cycle in range(self.cycles):
            begin = of.after(cycle)
            total += sum((_squared(self.line, placed(begin, point)[:2]) for point in local), ca.SX(0))
        return total / (self.cycles * of.steps)

    def outcome(self, played: Played) -> str:
        """The root mean square and the largest distance."""
        local = places(played.poses[1:]) if self.point == "centre" else played.vertices[1:, -1]
        parts = []
        for cycle in range(self.cycles):
            begin = ca.DM(after(played.poses, cycle))
            parts.append(np.asarray(placed(begin, ca.DM(local.T)).full()[:2].T))
        apart = np.sqrt(_numbers(self.line, np.concatenate(parts)))
        rms, most = np.sqrt(np.mean(apart**2)), apart.max()
        return f"{self.point} off the line by {rms:.4f} (rms), {most:.4f} (most) body lengths"


class Corridor(Obstacle):
    """Every point of the body stays within `half_width` of the line, at every time."""

    kind: Literal["corridor"] = "corridor"
    line: Line
    half_width: Annotated[float, Field(gt=0, le=FAR, description="body lengths")]

    def distances(self, points: ca.SX) -> ca.SX:
        """Half the width less the distance from the line: not convex, but never steeper than the point moves."""
        apart = [ca.sqrt(_squared(self.line, point) + TINY) for point in ca.horzsplit(points)]
        return self.half_width - ca.horzcat(*apart)

    def require(self, of: Criteria) -> None:
        """At every time and place."""
        of.keep_clear(lambda points: ca.vec(self.distances(points)) - self.clearance)


def _squared(line: tuple[Point, ...], point: ca.SX) -> ca.SX:
    """Squared distance of a point (2) from the nearest piece of the line."""
    found = ca.SX.inf()
    for begin, end in zip(line[:-1], line[1:], strict=True):
        along, away = ca.DM(end) - ca.DM(begin), point - ca.DM(begin)
        share = ca.fmin(ca.fmax(ca.dot(away, along) / float(ca.sumsqr(along) + TINY), 0), 1)
        found = ca.fmin(found, ca.sumsqr(away - share * along))
    return found


def _numbers(line: tuple[Point, ...], points: Floats) -> Floats:
    """The same of points (K, 2) in numbers, shape (K,)."""
    point = ca.SX.sym("point", 2)
    function = ca.Function("distance", [point], [_squared(line, point)])
    return np.asarray(function.map(len(points))(points.T).full()[0], np.float64)
