"""What the optimiser knows of a family of gaits: parameters p (n,) and the symbolic shape of every row of the table.

    row t:  p[indices[t]] (k), data[t] (d)  --at-->  shape coordinates (s)

A family whose rows depend on all parameters has k = n; one whose rows depend on a few (splines, free tables) keeps the
NLP sparse. Adding a family is adding one file beside this one: a `Gait` record, its bounds and its `GaitFamily`.

Legend: n parameters, R rows (T of a closed gait, T + 1 of a transient), m joints.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar, Literal, Self

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.gaits.bounds import AngleBounds, GaitBounds, GaitNumbers

LONGEST = 200  # characters of a gait that is printed whole
Coordinates = Literal["serpenoid", "joints", "lifted"]


class Gait(GaitNumbers):
    """One gait as a problem file gives it, and as a solution reports it."""

    Bounds: ClassVar[type[GaitBounds]]
    named: ClassVar[bool] = True  # in files, by its `family`
    family: str

    def __repr__(self) -> str:
        text = super().__repr__()
        return text if len(text) <= LONGEST else f"<{type(self).__name__} {self.words}>"

    __str__ = __repr__

    @property
    def rotations(self) -> dict[str, float]:
        """Angles [rad] by their names that turn it over as often as they are large."""
        return {}

    @abstractmethod
    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> GaitFamily:
        """The family of this gait for a body of `joints` joints and a table of `rows` rows."""

    def misfit(self, joints: int, steps: int) -> str | None:
        """Why it is no gait of a body with so many joints and a cycle of so many steps; None: it is."""
        return None

    def misstated(self, joints: int, rows: int) -> str | None:
        """What of it no file of such a body and so many rows may state, though it can be played by itself."""
        return None

    def curve(self, phases: Floats) -> Floats | None:
        """(w1, w2) at `phases` [cycles], shape (n,) -> (n, 2), if the gait is a curve in that space."""
        return None

    @property
    def words(self) -> str:
        """One line for people."""
        fields = self.model_dump(exclude={"family"})
        return ", ".join(f"{name} {value:z.4f}" for name, value in fields.items() if isinstance(value, float))

    def document(self) -> dict[str, Any]:
        """What a results folder keeps beside the joint table."""
        return self.model_dump(mode="json")


@dataclass(frozen=True)
class GaitFamily:
    """A family of gaits for one body and one table. Hashable: compiled functions are kept per family.

    bounds: the file's. closed: whether the row after the last is the first again. coordinates: `serpenoid` (w1, w2, xi)
    or `joints` (m angles [rad]), or `lifted` (bending and lifting). linear: whether the coordinates are linear in the
    parameters. dimension: of the motion, 2 in the plane, 3 in space.
    """

    like: Gait
    joints: int
    rows: int
    bounds: GaitBounds
    closed: bool = True

    coordinates: ClassVar[Coordinates] = "joints"
    linear: ClassVar[bool] = True
    dimension: ClassVar[int] = 2

    @property
    @abstractmethod
    def names(self) -> tuple[str, ...]:
        """Names of the parameters (n)."""

    @property
    @abstractmethod
    def units(self) -> tuple[str, ...]:
        """Units of the parameters (n)."""

    @property
    @abstractmethod
    def limits(self) -> tuple[Floats, Floats]:
        """Lower and upper bound of every parameter, shape (n,) each; infinite where it is free."""

    def ended_at(self, name: str, end: float) -> str | None:
        """What a parameter is called where the file bounds it by `end`; None where no file may allow more."""
        return name

    @property
    @abstractmethod
    def widths(self) -> Floats:
        """A few per cent of every parameter's usual range, shape (n,): the scale of derivative-free searches."""

    @cached_property
    def data(self) -> Floats:
        """Numbers (R, d) that tell one row from another; default its phase [cycles]."""
        return np.arange(self.rows)[:, None] / (self.rows - (not self.closed))

    @cached_property
    def indices(self) -> np.ndarray:
        """Parameters that each row depends on, shape (R, k); default all."""
        return np.tile(np.arange(self.size), (self.rows, 1))

    @abstractmethod
    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        """Shape coordinates (s) of a row from its parameters (k) and data (d)."""

    @abstractmethod
    def start(self) -> Floats:
        """Parameters of the gait that the family was made from, shape (n,)."""

    @abstractmethod
    def sample(self, rng: np.random.Generator) -> Floats:
        """A random start within the limits, shape (n,)."""

    @abstractmethod
    def scaled(self, p: Floats, factor: float) -> Floats:
        """The gait p with all joint angles `factor` times as large."""

    @property
    def steady(self) -> Floats:
        """Directions (k, n) in the parameters that add the same joint angles to every row, linearly; default none."""
        return np.zeros((0, self.size))

    @abstractmethod
    def gait(self, p: Floats) -> Gait:
        """The gait with parameters p."""

    def refined(self, factor: int) -> Self:
        """The same family on a table with `factor` times as many steps."""
        rows = factor * self.rows if self.closed else factor * (self.rows - 1) + 1
        return replace(self, rows=rows)

    def on_finer_rows(self, p: Floats, factor: int) -> Floats:
        """Parameters of the gait p in the refined family; default: they do not know the table."""
        return p

    def moves(self, p: Floats) -> bool:
        """Whether a gait is worth starting from."""
        return True

    def opened(self, p: Floats) -> Floats:
        """A gait near p that moves, for a search that ended at one that does not."""
        return p

    def resolved(self, p: Floats) -> Floats:
        """A gait near p whose rows follow its motion; p itself where they do."""
        return p

    @property
    def modes(self) -> int:
        """How many triples (w1, w2, xi) the coordinates of a `serpenoid` family are."""
        return 1

    @property
    def size(self) -> int:
        """n."""
        return len(self.names)

    @property
    def pose_size(self) -> int:
        """Numbers of a pose: (x, y, heading), in space with (z, pitch, roll) after them."""
        return 3 * (self.dimension - 1)

    @property
    def sparse(self) -> bool:
        """Whether a row depends on a few of the parameters only."""
        return self.indices.shape[1] < self.size

    @property
    def harmonic(self) -> bool:
        """Whether every joint moves in a sine about its mean, and `data` is the phase [cycles]."""
        return False

    @property
    def free(self) -> bool:
        """Whether the parameters are the joint angles themselves."""
        return False


class AngleFamily(GaitFamily):
    """A family whose parameters are joint angles, or coefficients of them."""

    @property
    def units(self) -> tuple[str, ...]:
        return ("rad",) * self.size

    @property
    def limits(self) -> tuple[Floats, Floats]:
        bounds = self.bounds if isinstance(self.bounds, AngleBounds) else AngleBounds(family=self.like.family)
        low, high = bounds.angle
        return np.full(self.size, low), np.full(self.size, high)

    @property
    def widths(self) -> Floats:
        return np.full(self.size, 0.02)

    def scaled(self, p: Floats, factor: float) -> Floats:
        return p * factor


def as_rows(values: np.ndarray) -> tuple[tuple[float, ...], ...]:
    """An array (k, l) as files and records have it."""
    return tuple(tuple(row) for row in values.tolist())
