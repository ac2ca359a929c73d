"""What the body must keep clear of: discs, boxes, half-planes; and walls that it must stay within.

Each demand is a signed distance, positive where the body may be; it never grows faster than the point moves and is a
convex function of it, so what holds at some points and times holds around them (`optimise/clear/clearance.py`). Several
demands are a union.
Coordinates: body lengths, in the frame of the first row (origin: centroid; x: mean edge direction).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from typing import Annotated, ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Floats
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.term import FAR, Demand, Number, Played, Point, told

Positive = Annotated[float, Field(gt=0, le=FAR)]
DEEP = 1e-6  # body lengths: less is what the optimiser leaves of a constraint
BEND = 1.0  # body lengths: no point of the body is farther from its centroid
TINY = 1e-18  # keeps the derivative of a distance defined where it is zero


class Obstacle(Demand):
    """A region that no point of the body may enter, at any time."""

    kind: str
    flat: ClassVar[str] = "a distance from obstacles is proven for bodies that lie flat"
    clearance: Annotated[float, Field(ge=0, le=FAR, description="distance to keep: half the body's width, say")] = 0.0

    @property
    def room(self) -> float:
        """How deep inside the centroid may be [body lengths]: a body may bend round an obstacle, not out of a room."""
        return BEND

    @abstractmethod
    def distances(self, points: ca.SX) -> ca.SX:
        """Signed distances of points (2, K), shape (walls, K); each positive where the body may be."""

    def gap(self, points: Floats) -> Floats:
        """Smallest signed distance of points (K, 2): shape (K,)."""
        place = ca.SX.sym("place", 2)
        function = ca.Function("gap", [place], [ca.mmin(ca.vec(self.distances(place)))])
        return np.asarray(function.map(len(points))(points.T).full()[0], np.float64)

    def require(self, of: Criteria) -> None:
        """At every time and place; distances to convex things (and to straight walls) are convex."""
        of.keep_clear(lambda points: ca.vec(self.distances(points)) - self.clearance, convex=True)

    def outcome(self, played: Played) -> str:
        """Whether vertices keep clear at all steps, or how deep one comes into what it should keep clear of."""
        points, words = np.asarray(played.vertices), f"clearance of {self.kind}"
        gaps = self.gap(points.reshape(-1, 2)).reshape(points.shape[:2]) - self.clearance
        if gaps.min() >= -DEEP:
            return f"{words} met at every vertex and step"
        step, vertex = np.unravel_index(gaps.argmin(), gaps.shape)
        return f"{told(words, -gaps.min())} at vertex {vertex}, step {step}"


class Disc(Obstacle):
    """A disc to go round."""

    kind: Literal["disc"] = "disc"
    centre: Point
    radius: Positive

    def distances(self, points: ca.SX) -> ca.SX:
        """Distance to the centre less the radius."""
        away = points - ca.repmat(ca.DM(self.centre), 1, points.size2())
        return ca.sqrt(ca.sum1(away**2) + TINY) - self.radius


class Box(Obstacle):
    """A box to go round, or (`inside`) a room not to leave; sides along `angle_rad`."""

    kind: Literal["box"] = "box"
    centre: Point = (0.0, 0.0)
    half_widths: tuple[Positive, Positive]
    angle_rad: Number = 0.0
    inside: bool = Field(default=False, description="stay in it instead of outside")

    @property
    def room(self) -> float:
        """The inside of a box is convex: the centroid is there, too."""
        return 0.0 if self.inside else BEND

    def distances(self, points: ca.SX) -> ca.SX:
        """Inside: to each of the four walls. Outside: to the box."""
        c, s = ca.cos(self.angle_rad), ca.sin(self.angle_rad)
        turned = ca.vertcat(ca.horzcat(c, s), ca.horzcat(-s, c))
        local = turned @ (points - ca.repmat(ca.DM(self.centre), 1, points.size2()))
        half = ca.repmat(ca.DM(self.half_widths), 1, points.size2())
        if self.inside:
            return ca.vertcat(half - local, half + local)
        beyond = ca.fabs(local) - half
        outer = ca.sqrt(ca.sum1(ca.fmax(beyond, 0) ** 2) + TINY)
        return outer + ca.fmin(ca.fmax(beyond[0, :], beyond[1, :]), 0)


class HalfPlane(Obstacle):
    """A wall: the body stays on the side that `normal` points to."""

    kind: Literal["half_plane"] = "half_plane"
    point: Point
    normal: tuple[float, float]

    @property
    def room(self) -> float:
        """A half-plane is convex: the centroid is there, too."""
        return 0.0

    @model_validator(mode="after")
    def _direction(self) -> Self:
        if self.normal == (0.0, 0.0):
            raise ValueError("`normal` must not be zero; it points to where the body may be")
        return self

    def distances(self, points: ca.SX) -> ca.SX:
        """Along the normal."""
        exponent = math.frexp(max(map(abs, self.normal)))[1]
        normal = ca.DM([math.ldexp(part, -exponent) for part in self.normal])  # whose square is a number
        normal /= ca.norm_2(normal)
        return normal.T @ (points - ca.repmat(ca.DM(self.point), 1, points.size2()))
