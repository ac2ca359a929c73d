"""The medium: how a displacement of the body dissipates energy in its surroundings."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, field_validator

from serpenoid.schema import Record


class Medium(Record):
    """Anisotropic local dissipation, D = w (I + (eps - 1) T T^t), at the vertices (the paper's) or at edge midpoints.

    A fitted `anisotropy_ratio` holds for one of the two only.
    """

    anisotropy_ratio: Annotated[float, Field(description="eps in (0, 1]: tangential over normal dissipation")]
    dissipation: Literal["vertex", "edge"] = Field(default="vertex", description="where the dissipation elements sit")

    @field_validator("anisotropy_ratio")
    @classmethod
    def _in_range(cls, value: float) -> float:
        if not 0 < value <= 1:
            remedy = "swap tangential and normal coefficients?" if value > 1 else "use a small positive number."
            raise ValueError(f"`anisotropy_ratio` must be in (0, 1]; {remedy}")
        return value
