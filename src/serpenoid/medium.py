"""The medium: how a displacement of the body dissipates energy in its surroundings."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, PlainValidator, WithJsonSchema, field_validator, model_validator
from pydantic_core import PydanticKnownError

from serpenoid.files.schema import Record
from serpenoid.media import DEFAULT, LAWS

FIRST_GUESS = 0.2  # of eps, where nothing states it
MOST = 100.0  # eps: that of a straight body which all but cannot be pulled lengthwise
# eps: the reference gait goes as far as without any drag lengthwise to 4e-9 body lengths (linear drag; dry friction
# nearer, quadratic drag to 4e-6)
LEAST = 1e-9
# eps: of three starts of problems/reference-optimum.toml all end in one optimum at 0.01, two at 0.001, and at 1e-4 one
# converges
SLIPPERY = 1e-3

SOFTENED = ", ".join(law.name for law in LAWS.values() if law.softened)

Site = Literal["vertex", "edge"]


def known_law(name: Any) -> str:
    """The name of a law; raises what pydantic says of a word that is none of several."""
    if not isinstance(name, str) or name not in LAWS:
        *others, last = map(repr, LAWS)
        raise PydanticKnownError("literal_error", {"expected": f"{', '.join(others)} or {last}"})
    return name


Law = Annotated[
    str,
    PlainValidator(known_law),
    WithJsonSchema({"enum": list(LAWS), "type": "string"}),
    Field(description=", or ".join(law.title for law in LAWS.values())),
]


class Medium(Record):
    """Anisotropic local dissipation at the vertices (the paper's) or at edge midpoints; `law`: see serpenoid.media.

    eps is the force on a straight body lengthwise over that sideways, at one speed: of linear drag, where the
    dissipation is D = w (I + (eps - 1) T T^t), the ratio of drag coefficients; of dry friction, a friction ellipse, the
    ratio of friction coefficients.

    A fitted `anisotropy_ratio` holds for one law only. `anisotropy_ratio_bounds` is what physics allows: a
    slender body in water has a drag ratio K = 1/eps of at most 2, so [0.5, 1]. Fits and diagnoses stay inside.
    eps above 1 (bristles, parapodia: the body moves the way its bends run) needs bounds that hold it: without
    them it is far more often K, written in the place of eps.
    """

    anisotropy_ratio: Annotated[
        float,
        Field(description="eps: tangential over normal dissipation; above 1 only within stated bounds"),
    ]
    dissipation: Site = Field(default="vertex", description="where the dissipation elements sit")
    law: Law = DEFAULT
    # less changes no digit of a motion, and takes longer to solve; more is another law, linear drag in the end
    softening: Annotated[float, Field(ge=1e-6, le=1)] = Field(
        default=0.01,
        description=f"{SOFTENED}: slip below which forces give way, over the element's way in the body frame",
    )
    anisotropy_ratio_bounds: tuple[float, float] | None = Field(
        default=None, description="[lower, upper] of what physics allows, for fits; in water [0.5, 1]"
    )

    @field_validator("anisotropy_ratio")
    @classmethod
    def _in_range(cls, value: float) -> float:
        if not LEAST <= value <= MOST:
            nearly = f"use a small positive number: {LEAST:g} is next to no drag lengthwise."
            remedy = "swap tangential and normal coefficients?" if value > MOST else nearly
            raise ValueError(f"`anisotropy_ratio` must be from {LEAST:g} to {MOST:g}; {remedy}")
        return value

    @model_validator(mode="after")
    def _within_bounds(self) -> Self:
        pair, ratio = self.anisotropy_ratio_bounds, self.anisotropy_ratio
        if pair is not None and not 0 < pair[0] < pair[1] <= MOST:
            raise ValueError(f"`anisotropy_ratio_bounds` needs 0 < lower < upper <= {MOST:g}, got {list(pair)}")
        if pair is None and ratio > 1:
            raise ValueError(
                f"`anisotropy_ratio` must be in (0, 1], got {ratio:g}: it is lengthwise drag over sideways. K, "
                f"sideways over lengthwise, of {ratio:g} is {1 / ratio:.4g} here. A body that slips more easily "
                f"sideways (bristles, parapodia) says so: `anisotropy_ratio_bounds = [1, {min(2 * ratio, MOST):.3g}]`"
            )
        if pair is not None and not pair[0] <= self.anisotropy_ratio <= pair[1]:
            raise ValueError(f"`anisotropy_ratio` must be within `anisotropy_ratio_bounds` {list(pair)}")
        return self

    @property
    def odd_ratio(self) -> str | None:
        """A sentence where a body slips lengthwise more easily than any, and no bounds say that this is meant."""
        ratio = self.anisotropy_ratio
        if ratio >= SLIPPERY or self.anisotropy_ratio_bounds is not None:
            return None
        return (
            f"with `anisotropy_ratio` = {ratio:g} drag sideways is {1 / ratio:.3g} times "
            "that lengthwise (about 5 times on wheels, 2 of slender swimmers), and searches for gaits hardly end in an "
            "optimum. A slip?"
        )

    def with_ratio(self, anisotropy_ratio: float) -> Medium:
        """The same medium with another anisotropy ratio (its bounds are for fits to respect)."""
        return self.model_copy(update={"anisotropy_ratio": float(anisotropy_ratio)})

    def within(self, lower: float, upper: float) -> Medium:
        """The same medium with other bounds of its ratio, for fits to respect."""
        return self.model_copy(update={"anisotropy_ratio_bounds": (lower, upper)})

    @property
    def limited_by_physics(self) -> bool:
        """Whether stated bounds are those of water, say. Bounds that reach beyond 1 let fits look for a surface that
        holds lengthwise (bristles), and no physics limits what a surface does."""
        return self.anisotropy_ratio_bounds is not None and self.anisotropy_ratio_bounds[1] <= 1

    def limits(self, least: float, most: float) -> tuple[float, float]:
        """Bounds of a fit that looks between `least` and `most`: what is stated here goes first."""
        return self.anisotropy_ratio_bounds or (least, most)


class OpenMedium(Record):
    """The medium of a campaign, where fits find the anisotropy ratio: it may be left out. Else as `Medium`."""

    anisotropy_ratio: float | None = Field(default=None, description="eps; left out: what fits find")
    dissipation: Site = Field(default="vertex", description="where the dissipation elements sit")
    law: Law = DEFAULT
    softening: float | None = Field(default=None, description=f"{SOFTENED}: as in a problem file")
    anisotropy_ratio_bounds: tuple[float, float] | None = Field(
        default=None, description="[lower, upper] of what physics allows, for fits; in water [0.5, 1]"
    )

    @model_validator(mode="after")
    def _as_a_medium(self) -> Self:
        self.guessed()
        return self

    def guessed(self) -> Medium:
        """The medium, with a first guess within the bounds where the ratio is left out."""
        stated = {key: value for key, value in self.model_dump().items() if value is not None}
        lower, upper = self.anisotropy_ratio_bounds or (FIRST_GUESS, FIRST_GUESS)
        guess = FIRST_GUESS if lower < 1 else 1 / FIRST_GUESS
        return Medium.model_validate({"anisotropy_ratio": min(max(guess, lower), upper)} | stated)
