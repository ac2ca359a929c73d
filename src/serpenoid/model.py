"""The model: a body in a medium, as the numbers that the symbolic mechanics takes.

Legend: N vertices, m joints, M dissipation elements (M = N at vertices, N - 1 at edges).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.medium import Medium


@dataclass(frozen=True)
class Structure:
    """What fixes the shape of the equations; everything else is a number given to the compiled functions."""

    vertices: int
    joints: tuple[int, ...]
    dissipation: str

    @property
    def elements(self) -> int:
        """M."""
        return self.vertices if self.dissipation == "vertex" else self.vertices - 1

    @property
    def links(self) -> tuple[tuple[int, ...], ...]:
        """Edges of each rigid link, tail to head: m + 1 groups."""
        cuts = (0, *self.joints, self.vertices - 1)
        return tuple(tuple(range(a, b)) for a, b in zip(cuts[:-1], cuts[1:], strict=True))


@dataclass(frozen=True)
class Model:
    """A body in a medium; dimensionless inside (body length = 1, total weight = 1)."""

    body: Body
    medium: Medium

    @cached_property
    def structure(self) -> Structure:
        """The part of the model that compiled functions depend on."""
        return Structure(self.body.vertices, self.body.joint_vertices, self.medium.dissipation)

    @cached_property
    def parameters(self) -> Floats:
        """Edge lengths (N - 1), vertex weights (N) and anisotropy ratio, in this order: shape (2 N,)."""
        return np.concatenate([self.body.edges, self.body.vertex_weights, [self.medium.anisotropy_ratio]])
