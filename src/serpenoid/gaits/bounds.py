"""Numbers of a gait: of what size they may be, and where the optimiser may look for them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from serpenoid.files.schema import Record

LARGEST = 1e5  # eps LARGEST = 2e-11 rad of rounding is far below the 1e-8 to which poses are confirmed


def _numbers(value: Any) -> Iterator[float]:
    if isinstance(value, tuple | list):
        for part in value:
            yield from _numbers(part)
    elif isinstance(value, int | float):
        yield value


def refuse_unordered(record: Record, *names: str) -> None:
    """Raise ValueError where one of a record's pairs is not [lower, upper]; those that are None are passed over."""
    for name in names:
        pair = getattr(record, name)
        if pair is not None and pair[0] > pair[1]:
            raise ValueError(f"`{name}` needs [lower, upper] with lower <= upper")


class GaitNumbers(Record):
    """Numbers that joint angles are made of: small enough for a sine of them to have digits."""

    @field_validator("*")
    @classmethod
    def _meaningful(cls, value: Any) -> Any:
        worst = max((abs(number) for number in _numbers(value)), default=0.0)
        if worst > LARGEST:
            raise ValueError(f"must be within +-{LARGEST:g}; joint angles of larger numbers are rounding alone")
        return value


class GaitBounds(GaitNumbers):
    """Where the optimiser may look; each family has its own, in `[task.bounds]`."""

    family: str

    def fixed(self, **pairs: tuple[float, float]) -> Self:
        """The same bounds with some of them replaced."""
        return self.model_copy(update=pairs)


class AngleBounds(GaitBounds):
    """Bounds of families whose parameters are joint angles, or numbers that these are made of linearly."""

    angle: tuple[float, float] = Field(default=(-np.pi, np.pi), description="every joint angle, or control point [rad]")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        refuse_unordered(self, "angle")
        return self
