"""A gait given as a joint table, R rows of m joint angles: read from a file, or every angle free for the optimiser.

The row after the last is the first again, unless the task is a transient.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.gaits.bounds import AngleBounds, GaitBounds
from serpenoid.gaits.family import AngleFamily, Gait, as_rows

HARMONICS = 3  # of a random start: a smooth table
SPREAD = 0.3  # rad: standard deviation of a random start's first harmonic


class TableBounds(AngleBounds):
    """Where the optimiser may look: every joint angle, beside the body's own limits."""

    family: Literal["table"] = "table"


class TableGait(Gait):
    """Joint angles from a CSV file (header joint_1,...,joint_m; radians) or as rows; neither: a straight body."""

    Bounds: ClassVar[type[GaitBounds]] = TableBounds

    family: Literal["table"] = "table"
    path: str | None = Field(default=None, description="CSV file, relative to the problem file")
    angles: tuple[tuple[float, ...], ...] | None = Field(default=None, description="rows of m angles [rad]")

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        if self.path is not None and self.angles is not None:
            raise ValueError("give `path` or `angles`, not both")
        return self

    @classmethod
    def from_angles(cls, angles: Floats) -> TableGait:
        """The gait of a joint table (R, m) [rad]."""
        return cls(angles=as_rows(np.asarray(angles)))

    def misstated(self, joints: int, rows: int) -> str | None:
        """Rows of other joints, or more or fewer of them; they are not resampled: which motion lies between them is for
        the user to say."""
        angles = self.angles or ()
        widths = sorted({len(row) for row in angles})
        if self.angles is None or (len(angles) == rows and widths == [joints]):
            return None
        return (
            f"`angles` of a table needs {rows} rows of {joints} joint angles, got {len(angles)} of "
            f"{' and '.join(map(str, widths))}. Set task.steps to its number of rows (one less if transient), or "
            "resample it"
        )

    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> TableFamily:
        """Free tables of `rows` rows."""
        return TableFamily(self, joints, rows, bounds or TableBounds(), closed)

    @property
    def words(self) -> str:
        """One line for people."""
        return "every joint angle of every row is free: see joint_table.csv"

    def document(self) -> dict[str, Any]:
        """The table itself stands in joint_table.csv."""
        return {"family": "table", "path": self.path or "joint_table.csv"}


class TableFamily(AngleFamily):
    """Every joint angle of every row is a parameter: row t depends on m of them."""

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(f"joint_{j + 1}[{t}]" for t in range(self.rows) for j in range(self.joints))

    @cached_property
    def indices(self) -> np.ndarray:
        return np.arange(self.size).reshape(self.rows, self.joints)

    @property
    def size(self) -> int:
        return self.rows * self.joints

    @property
    def free(self) -> bool:
        return True

    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        """The angles themselves."""
        return p

    def start(self) -> Floats:
        if not isinstance(self.like, TableGait) or self.like.angles is None:
            return np.zeros(self.size)
        if (said := self.like.misstated(self.joints, self.rows)) is not None:
            raise InputError(f"{said}.")
        return np.array(self.like.angles).ravel()

    def sample(self, rng: np.random.Generator) -> Floats:
        """A mean and a few harmonics per joint."""
        phase = 2 * np.pi * self.data
        table = 0.5 * SPREAD * rng.normal(size=self.joints) * np.ones((self.rows, 1))
        for k in range(1, HARMONICS + 1):
            table = table + SPREAD / k * rng.normal(size=self.joints) * np.cos(
                k * phase + rng.uniform(0, 2 * np.pi, self.joints)
            )
        return np.clip(table.ravel(), *self.limits)

    def on_finer_rows(self, p: Floats, factor: int) -> Floats:
        """Straight lines between the rows, as a robot plays them."""
        table = p.reshape(self.rows, self.joints)
        following, share = np.roll(table, -1, axis=0), np.arange(factor)[:, None] / factor
        finer = ((1 - share) * table[:, None] + share * following[:, None]).reshape(-1, self.joints)
        return finer.ravel() if self.closed else finer[: factor * (self.rows - 1) + 1].ravel()

    def moves(self, p: Floats) -> bool:
        """Not where all rows are the same."""
        return bool(np.ptp(p.reshape(self.rows, self.joints), axis=0).any())

    def resolved(self, p: Floats) -> Floats:
        """A cycle that leaps is averaged over an eighth of it.

        A leap is a change between two rows of more than half the range of all angles: a wave that does so has fewer
        than 2 pi rows a period, and what it moves is the mesh's doing.
        """
        table, reach = p.reshape(self.rows, self.joints), self.rows // 16
        steps = np.roll(table, -1, axis=0) - table
        if not self.closed or not reach or np.abs(steps).max() <= np.ptp(table, axis=0).max() / 2:
            return p
        return np.mean([np.roll(table, k, axis=0) for k in range(-reach, reach + 1)], axis=0).ravel()

    @property
    def steady(self) -> Floats:
        """All rows of a joint."""
        return np.tile(np.eye(self.joints), self.rows)

    def gait(self, p: Floats) -> TableGait:
        return TableGait.from_angles(p.reshape(self.rows, self.joints))
