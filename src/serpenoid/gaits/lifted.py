"""Two waves along the body: one of bending, of a family over (w1, w2, xi), and one of lifting parts off the floor.

    contact at s  1 / (1 + exp(-sharpness (cos 2 pi (xi s + t - phase) + bias))),    t in cycles

1 where the body rests, 0 where it is lifted highest. Both waves have the same length. The template of sidewinding
snakes (Astley et al., 2015, PNAS 112, 6200), whose phase between the waves is found here.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, ClassVar, Literal, Self

import casadi as ca
import numpy as np
from pydantic import Field, model_validator

from serpenoid.body import Floats
from serpenoid.gaits.bounds import GaitNumbers, refuse_unordered
from serpenoid.gaits.ellipse import EllipseBounds, EllipseGait
from serpenoid.gaits.family import Coordinates, Gait, GaitBounds, GaitFamily
from serpenoid.gaits.fourier import FourierGait

OWN = "phase", "bias"  # parameters beside those of the bending
WIDTHS = 0.01, 0.02  # of phase and bias


class Lift(GaitNumbers):
    """Parts of the body are lifted in a wave, so that contact weights vary over the cycle: gaits in space."""

    height: Annotated[float, Field(ge=0, le=0.5, description="of what is lifted highest [body lengths]")] = 0.03
    sharpness: Annotated[float, Field(gt=0, le=50, description="of the change from lifted to resting")] = 6.0
    air: Annotated[
        float, Field(gt=0, le=1, description="share of its weight that a lifted part keeps on the ground")
    ] = 0.01
    phase: tuple[float, float] = Field(
        default=(-1.0, 1.0), description="of the contact wave behind the bending [cycles]"
    )
    bias: tuple[float, float] = Field(default=(0.0, 0.5), description="0: half of the body rests; above: more")

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        refuse_unordered(self, "phase", "bias")
        return self

    def contact(self, crest: Floats) -> Floats:
        """Of the cosine of the wave and the bias together."""
        return np.asarray(1 / (1 + np.exp(-self.sharpness * crest)))


class LiftedGait(Gait):
    """A gait of bending whose body is lifted in a wave; made from `[gait]` and `[lift]`, not named in files."""

    Bounds: ClassVar[type[GaitBounds]] = EllipseBounds
    named: ClassVar[bool] = False

    family: Literal["lifted"] = "lifted"
    bend: EllipseGait | FourierGait = Field(discriminator="family")
    phase: float
    bias: float
    lift: Lift

    def misfit(self, joints: int, steps: int) -> str | None:
        """Of the bending."""
        return self.bend.misfit(joints, steps)

    def of(self, joints: int, rows: int, bounds: GaitBounds | None = None, closed: bool = True) -> LiftedFamily:
        """Both waves, for a body of `joints` joints that turn and as many that pitch; bounds: of the bending."""
        return LiftedFamily(self, 2 * joints, rows, bounds or self.bend.Bounds(family=self.bend.family), closed)

    @property
    def words(self) -> str:
        """One line for people."""
        return f"{self.bend.words}, lifted {self.phase:+z.4f} cycles behind, bias {self.bias:+z.4f}"


def lifted(gait: Gait, lift: Lift) -> LiftedGait:
    """A gait of bending, lifted in the middle of what `[lift]` allows."""
    if isinstance(gait, LiftedGait):
        return gait
    bend = gait.model_dump()
    phase, bias = (sum(pair) / 2 for pair in (lift.phase, lift.bias))
    return LiftedGait.model_validate({"bend": bend, "phase": phase, "bias": bias, "lift": lift})


class LiftedFamily(GaitFamily):
    """Parameters: those of the bending, then phase and bias. A row's coordinates: (w1, w2, xi), t - phase, bias."""

    coordinates: ClassVar[Coordinates] = "lifted"
    linear: ClassVar[bool] = False
    dimension: ClassVar[int] = 3

    @property
    def _gait(self) -> LiftedGait:
        return self.like if isinstance(self.like, LiftedGait) else lifted(self.like, Lift())

    @property
    def lift(self) -> Lift:
        """How parts are lifted."""
        return self._gait.lift

    @cached_property
    def bend(self) -> GaitFamily:
        """The bending alone, in the plane."""
        return self._gait.bend.of(self.joints // 2, self.rows, self.bounds, self.closed)

    @property
    def names(self) -> tuple[str, ...]:
        return (*self.bend.names, *OWN)

    @property
    def units(self) -> tuple[str, ...]:
        return (*self.bend.units, "cycles", "1")

    @property
    def limits(self) -> tuple[Floats, Floats]:
        pairs = zip(self.bend.limits, zip(self.lift.phase, self.lift.bias, strict=True), strict=True)
        lower, upper = (np.append(bend, own) for bend, own in pairs)
        return lower, upper

    def ended_at(self, name: str, end: float) -> str | None:
        """Bending is bounded in [task.bounds], what is lifted in [lift]."""
        return f"lift.{name}" if name in OWN else self.bend.ended_at(name, end)

    @property
    def widths(self) -> Floats:
        return np.append(self.bend.widths, WIDTHS)

    @cached_property
    def data(self) -> Floats:
        phases = np.arange(self.rows) / (self.rows - (not self.closed))
        return np.column_stack([self.bend.data, phases])

    def at(self, p: ca.SX, data: ca.SX) -> ca.SX:
        """(w1, w2, xi, t - phase, bias)."""
        return ca.vertcat(self.bend.at(p[:-2], data[:-1]), data[-1] - p[-2], p[-1])

    def start(self) -> Floats:
        return np.append(self.bend.start(), [self._gait.phase, self._gait.bias])

    def sample(self, rng: np.random.Generator) -> Floats:
        return np.append(self.bend.sample(rng), [rng.uniform(*pair) for pair in (self.lift.phase, self.lift.bias)])

    def scaled(self, p: Floats, factor: float) -> Floats:
        """Of the bending; how the body is lifted stays."""
        return np.append(self.bend.scaled(p[:-2], factor), p[-2:])

    def gait(self, p: Floats) -> LiftedGait:
        bend = self.bend.gait(p[:-2])
        return self._gait.model_copy(update={"bend": bend, "phase": float(p[-2]), "bias": float(p[-1])})

    def moves(self, p: Floats) -> bool:
        return self.bend.moves(p[:-2])

    def opened(self, p: Floats) -> Floats:
        return np.append(self.bend.opened(p[:-2]), p[-2:])

    @property
    def modes(self) -> int:
        return self.bend.modes
