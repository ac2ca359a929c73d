"""The body: a chain of vertices joined by edges; some interior vertices are joints, the others are rigid.

Vertices, edges and joints are numbered along the body from the tail (0) to the head.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from serpenoid.errors import InputError
from serpenoid.files.schema import Record
from serpenoid.joint_range import JointLimit, misfit, ranges_deg

Positive = Annotated[float, Field(gt=0)]
Floats = NDArray[np.float64]
LEAST = 1e-9  # of lengths and weights
LONGEST = 1e6  # of one edge
Length = Annotated[float, Field(ge=LEAST, le=LONGEST)]  # metres, or any unit: sums and ratios stay finite
Weight = Annotated[float, Field(ge=LEAST, le=1e9)]
BARE = 1e-6  # of the body's weight: a vertex that meets nothing, as a joint between two wheels
ANIMALS = ("swimmer", "crawler")
LONGEST_CYCLE_S = 600.0  # as robots are asked to play at most; what goes slower is asked about its unit
# metres; sperm and bacteria to blue whales, nematodes to pythons; who is longer or shorter is asked about the unit
PLAUSIBLE_M: dict[str | None, tuple[float, float]] = {
    "wheeled robot": (0.02, 20.0), "crawling robot": (0.02, 20.0), "swimming robot": (0.02, 20.0),
    "swimmer": (5e-6, 40.0), "crawler": (5e-5, 20.0), None: (5e-6, 40.0),
}  # fmt: skip
SMALLER = {"millimetres": 1e-3, "centimetres": 1e-2, "micrometres": 1e-6}  # the likeliest slip first
DENSEST = 1000.0 / 3**2  # kilograms per cubed metre of length: water, three times as long as wide and high
# degrees, all joints at their limits to one side. Half a wave bends by 2 / pi of half of it, which tilts the body by
# t = 4 degrees; drag that is five times as large sideways carries it by at most (5 - 1) t^2 / 2 = 1 % of a wave a cycle
HARDLY_BENT = 25.0
MOST_VERTICES = 1000  # compiling takes minutes beyond
CUT = "Cut links into more edges (`vertices`, `joints`; n a link leave out 1 / n^2 of it)"
WHOLE_LINKS = "every link is one edge"
SPARSE = 0.02  # of a straight body's resistance to turning: ten equal edges, as in the paper, leave out 0.01
Kind = Literal["wheeled robot", "crawling robot", "swimming robot", "swimmer", "crawler"]
Part = Literal["servos", "wheels", "skin", "ground", "water"]  # skin: what meets the ground where no wheels do
PARTS: dict[Kind, frozenset[Part]] = {
    "wheeled robot": frozenset({"servos", "wheels", "ground"}),
    "crawling robot": frozenset({"servos", "skin", "ground"}),  # on scales, on a skin, through sand
    "swimming robot": frozenset({"servos", "water"}),
    "swimmer": frozenset({"water"}),
    "crawler": frozenset({"skin", "ground"}),
}


class Body(Record):
    """A chain of N vertices. Lengths in metres (or any unit, if no hardware is meant), weights on any scale."""

    kind: Kind | None = Field(
        default=None,
        description="wheeled, crawling or swimming robot, swimmer, crawler: words, default weights, effects on offer",
    )
    vertices: int = Field(
        ge=3, le=MOST_VERTICES, description="N: head marker, joint axes, tail marker, counted together"
    )
    length_m: Length | None = Field(default=None, description="body length, for equal edges; default 1")
    edge_lengths: tuple[Length, ...] | None = Field(default=None, description="N - 1 lengths [m], tail to head")
    weights: tuple[Weight, ...] | None = Field(
        default=None, description="N dissipation weights; default equal, with `edge` dissipation uniform per length"
    )
    joints: tuple[int, ...] | None = Field(default=None, description="vertices that bend; default all interior ones")
    mass_kg: Positive | None = Field(default=None, description="for the cost of transport")
    joint_limit_deg: JointLimit | None = Field(
        default=None, description="|joint angle|, or [lower, upper], or [lower, upper] of each joint, tail to head"
    )
    joint_speed_limit_rpm: Positive | None = Field(default=None, description="XL430 at 11.1 V: 57")

    @model_validator(mode="before")
    @classmethod
    def _counted(cls, data: object) -> object:
        edges = data.get("edge_lengths") if isinstance(data, dict) and "vertices" not in data else None
        if isinstance(edges, list | tuple) and edges:
            count = len(edges) + 1
            raise ValueError(
                f"`vertices` is required and not there; {count - 1} edges join {count}: `vertices = {count}`"
            )
        return data

    @field_validator("vertices", mode="before")
    @classmethod
    def _bends(cls, value: object) -> object:
        if value in (1, 2) and not isinstance(value, bool):
            raise ValueError("3 are the least, as a joint between two edges bends: add a point between head and tail")
        return value

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        n = self.vertices
        if self.length_m is not None and self.edge_lengths is not None:
            raise ValueError("give `length_m` (equal edges) or `edge_lengths`, not both")
        if self.edge_lengths is not None and len(self.edge_lengths) != n - 1:
            raise ValueError(f"`edge_lengths` needs {n - 1} numbers for {n} vertices, got {len(self.edge_lengths)}")
        if self.weights is not None and len(self.weights) != n:
            raise ValueError(f"`weights` needs {n} numbers for {n} vertices, got {len(self.weights)}")
        if self.joints is not None:
            inside = all(0 < j < n - 1 for j in self.joints)
            if not self.joints or not inside or sorted(set(self.joints)) != list(self.joints):
                raise ValueError(f"`joints` must be increasing vertex numbers between 1 and {n - 2}, got {self.joints}")
        if (said := misfit(self.joint_limit_deg, self.joint_count)) is not None:
            raise ValueError(said)
        return self

    @cached_property
    def edges_m(self) -> Floats:
        """Edge lengths, shape (N - 1,) [m]."""
        if self.edge_lengths is not None:
            return np.array(self.edge_lengths)
        return np.full(self.vertices - 1, (self.length_m or 1.0) / (self.vertices - 1))

    @cached_property
    def total_length_m(self) -> float:
        """Body length = sum of the edges [m]."""
        return float(self.edges_m.sum())

    @property
    def pose_units(self) -> Floats:
        """What a pose in body lengths and radians is multiplied by for metres and radians, shape (3,) [m, m, 1]."""
        return np.array([self.total_length_m, self.total_length_m, 1.0])

    @property
    def told_length_m(self) -> float | None:
        """Body length [m], None where nobody said it."""
        return self.total_length_m if self.length_m or self.edge_lengths else None

    @property
    def odd_length(self) -> str | None:
        """A sentence where no such body is as long or as short, with the unit that may be meant."""
        (low, high), length = PLAUSIBLE_M[self.kind], self.total_length_m
        if low <= length <= high:
            return None
        meant = next((unit for unit, metre in SMALLER.items() if low <= length * metre <= high), None)
        unit = f" Lengths are in metres: were they given in {meant}?" if length > high and meant else ""
        return f"the body is {length:.4g} m long, where {low:g} to {high:g} m is plausible.{unit}"

    @property
    def odd_limit(self) -> str | None:
        """A sentence where joints bend so little that radians may be meant: see HARDLY_BENT."""
        if self.joint_limit_deg is None:
            return None
        largest = np.abs(ranges_deg(self.joint_limit_deg, self.joint_count)).max(axis=1)
        if largest.max() > np.pi or largest.sum() > HARDLY_BENT:
            return None
        return (
            f"with `joint_limit_deg` as small as {largest.max():.4g} the whole body bends by no more than "
            f"{largest.sum():.3g} degrees, and hardly moves. Angles are in degrees: was it given in radians?"
        )

    @property
    def odd_mass(self) -> str | None:
        """A sentence where no body of this length weighs as much."""
        length = self.told_length_m
        if self.mass_kg is None or length is None or self.odd_length or self.mass_kg <= (most := DENSEST * length**3):
            return None
        return (
            f"with `mass_kg` = {self.mass_kg:g} a body {length:.4g} m long weighs more than {most:.3g} kg, as much as "
            "water of its length and a third of that across. Masses are in kilograms: was it given in grams?"
        )

    @property
    def odd_units(self) -> tuple[str, ...]:
        """What looks to be told in another unit, as sentences."""
        return tuple(said for said in (self.odd_length, self.odd_limit, self.odd_mass) if said)

    @property
    def sparse_edges(self) -> str | None:
        """A sentence where drag at the middles of the edges is not that of a smooth body.

        An edge does not resist its own turning: of a straight body's resistance sum (edge / length)^3 is left out.
        """
        left_out = self._turning_left_out
        if self.kind == "wheeled robot" or left_out <= SPARSE:
            return None
        return (
            f"drag in the middles of edges lacks {left_out:.1%} of what a smooth straight body resists turning by: "
            f"turns come out wrong, a diagnosis finds causes that are not there. {CUT}, or say "
            'kind = "wheeled robot" if wheels are there'
        )

    @property
    def whole_links(self) -> str | None:
        """A sentence for when drag at the middles of the edges misses something and every link is one edge."""
        if self.kind == "wheeled robot" or self.sparse_edges or self.joint_count < self.vertices - 2:
            return None
        return (
            f"{WHOLE_LINKS}, with drag in its middle alone, so that a link does not resist its own turning "
            f"({self._turning_left_out:.1%} of what the straight body resists): what is left may be that. {CUT}, with "
            "`vertices` in [motion] for those that have a marker"
        )

    @property
    def _turning_left_out(self) -> float:
        return float((self.edges**3).sum())

    @cached_property
    def edges(self) -> Floats:
        """Edge lengths in body lengths, shape (N - 1,), sum 1."""
        return self.edges_m / self.total_length_m

    @cached_property
    def vertex_weights(self) -> Floats:
        """Normalised weights, shape (N,), sum 1."""
        w = np.array(self.weights) if self.weights is not None else np.ones(self.vertices)
        return w / w.sum()

    @property
    def edge_weights(self) -> Floats:
        """What dissipation at edges weighs, shape (N - 1,): each vertex gives to its edges in proportion to length."""
        around = np.concatenate([self.edges[:1], self.edges[1:] + self.edges[:-1], self.edges[-1:]])
        share = self.vertex_weights / around
        return np.asarray(self.edges * (share[1:] + share[:-1]))

    @property
    def corners(self) -> list[int]:
        """Vertices (m + 2) where links end: tail, joints, head."""
        return [0, *self.joint_vertices, self.vertices - 1]

    @property
    def is_animal(self) -> bool:
        """Whether it has no wheels, servos or mounted weights."""
        return self.kind in ANIMALS

    @property
    def parts(self) -> frozenset[Part]:
        """What it has, and what is around it: where nobody says, everything that goes with wheels."""
        return frozenset(get_args(Part)) - {"skin"} if self.kind is None else PARTS[self.kind]

    @property
    def other_surface(self) -> Part:
        """What it does not meet the ground with: what is a worn wheel of one body is a rough skin of another."""
        return "wheels" if "skin" in self.parts else "skin"

    def uniform(self) -> Body:
        """The same body with its weight spread evenly along its length, half an edge's at either end of it."""
        ends = np.concatenate([[0.0], self.edges, [0.0]])
        return self.changed(weights=tuple(np.maximum((ends[1:] + ends[:-1]) / 2, LEAST).tolist()))

    def changed(self, **fields: object) -> Body:
        """The same body with other fields; a copy would keep what is cached of the old ones."""
        return Body.model_validate(self.model_dump() | fields)

    def with_middles(self, pieces: int = 1) -> Body:
        """The same body with a rigid vertex in the middle of every edge: 2 k is vertex k, 2 k + 1 the middle of edge k.
        Of edges in several pieces, a vertex in the middle of each: (pieces + 1) k is vertex k.

        The middles carry what dissipation at edges weighs, the others next to nothing (`BARE`): drag at these vertices
        is the drag of this body's edges. A weight so small that its half is none any more stays the least there is.
        """
        if self.edges_m.min() < 2 * LEAST:
            raise InputError(
                f"[body] an edge of {self.edges_m.min():g} m is too short to have a middle: give lengths in metres, "
                f"each {2 * LEAST:g} or more."
            )
        edges, each = self.edge_weights if self.weights is not None else self.edges, pieces + 1
        weights = np.full(each * (self.vertices - 1) + 1, BARE)
        shares = np.repeat(np.maximum(edges / edges.sum() / pieces, LEAST), pieces)
        weights[np.arange(len(weights)) % each > 0] = shares
        steps = np.array([0.5, *[1.0] * (pieces - 1), 0.5]) / pieces
        return self.changed(
            vertices=len(weights),
            joints=tuple(each * j for j in self.joint_vertices),
            length_m=None,
            edge_lengths=tuple(np.outer(self.edges_m, steps).ravel().tolist()),
            weights=tuple(weights.tolist()),
        )

    @property
    def pieces(self) -> int:
        """Of each edge, in whose middles `with_middles` has put vertices; 0: none has."""
        bare = [i for i, w in enumerate(self.weights or ()) if w == BARE]
        each = bare[1] if len(bare) > 1 else 1
        return each - 1 if bare == list(range(0, self.vertices, each)) else 0

    @cached_property
    def joint_vertices(self) -> tuple[int, ...]:
        """The vertices that bend, `joint_1` (next to the tail) first."""
        return self.joints if self.joints is not None else tuple(range(1, self.vertices - 1))

    @property
    def joint_count(self) -> int:
        """m."""
        return len(self.joint_vertices)
