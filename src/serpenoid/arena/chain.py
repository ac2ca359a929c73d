"""A chain of links for the arena: where its vertices, joints and wheel pairs stand, and what they weigh.

Legend: N vertices (0 tail .. N - 1 head), joints among the interior ones, one wheel pair under each vertex. Link k ends
at the k-th joint (0 next to the tail), the last one at the head.
"""

from __future__ import annotations

from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Body, Floats
from serpenoid.errors import InputError
from serpenoid.files.schema import Record

Positive = Annotated[float, Field(gt=0)]


class Chain(Record):
    """Edges, joints and masses of a body; `masses_kg` is what each vertex carries, wheels and servo included."""

    edges_m: tuple[Positive, ...] = Field(min_length=2, max_length=100, description="N - 1 lengths, tail to head")
    joints: tuple[int, ...] = Field(min_length=1, description="vertices that bend, `joint_1` first")
    masses_kg: tuple[Positive, ...] = Field(description="of each vertex: N numbers")

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        last = len(self.edges_m)
        if len(self.masses_kg) != last + 1:
            raise ValueError(f"`masses_kg` needs {last + 1} numbers for {last} edges, got {len(self.masses_kg)}")
        if sorted(set(self.joints)) != list(self.joints) or not 0 < self.joints[0] <= self.joints[-1] < last:
            raise ValueError(f"`joints` must be increasing vertex numbers between 1 and {last - 1}")
        return self

    @property
    def places_m(self) -> Floats:
        """Of the vertices along the straight chain, shape (N,)."""
        return np.concatenate([[0.0], np.cumsum(self.edges_m)])

    def begin(self, link: int) -> int:
        """The vertex at the tail end of a link."""
        return 0 if link == 0 else self.joints[link - 1]

    def end(self, link: int) -> int:
        """The vertex at the head end of a link."""
        return self.joints[link] if link < len(self.joints) else len(self.edges_m)

    def length_m(self, link: int) -> float:
        """From end to end of a link."""
        return float(self.places_m[self.end(link)] - self.places_m[self.begin(link)])

    def before(self, vertex: int) -> int:
        """The link whose head end a vertex is, or inside which it stands: it carries the wheels."""
        return sum(joint < vertex for joint in self.joints)

    def after(self, vertex: int) -> int:
        """The link whose tail end a vertex is, or inside which it stands: it carries the marker."""
        return sum(joint <= vertex for joint in self.joints)

    def place_m(self, vertex: int, link: int) -> float:
        """Of a vertex in a link's frame, which stands at the link's tail end."""
        return float(self.places_m[vertex] - self.places_m[self.begin(link)])


def chain_of(body: Body) -> Chain:
    """The chain of a problem file's body; raises InputError where it has no mass."""
    if body.mass_kg is None:
        raise InputError("[body] mass_kg: the arena needs the robot's mass. Add it to the problem file.")
    masses = body.vertex_weights * body.mass_kg
    return Chain(edges_m=tuple(body.edges_m), joints=body.joint_vertices, masses_kg=tuple(masses))
