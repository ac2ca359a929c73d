"""The mesh certificate: is the displacement of an optimum the gait's, or the time mesh's?

An optimum is one of the discrete problem, and coarse steps can move what cannot move: one joint "swims" at T = 3,
though by the scallop theorem it returns. So each optimum is simulated again with 2 T and 4 T steps. The step is of
second order (docs/theory.md), hence with values D1, D2, D4 of a quantity

    limit = D4 + (D4 - D2) / 3,    doubt = |limit - (D2 + (D2 - D1) / 3)|,    error = |D1 - limit| + doubt

doubt: what the two extrapolations differ by; it is large where the meshes are too coarse for their order to show.
Rule: an optimum is converged if the error of its motion is at most 5 % of the limit (or below what a polishing search
can tell, 1e-6 body lengths); motion is the displacement, and the turn by how far it carries the body's points. Curves
are evaluated at the finer mesh's own phases; a table of joint angles is refined by straight lines between its rows, as
the robot plays it (`GaitFamily.on_finer_rows`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from serpenoid.status import Status
from serpenoid.wording import percent

TOLERANCE = 0.05  # of the limit; the paper's 50 steps are 0.5 % (its gait of amplitude 6) to 1.2 % (the optimum) off
GYRATION = 12**-0.5  # body lengths: a turn of a straight uniform body counts as its points' root mean square way
RESOLVED = 1e-6  # body lengths: as much as polishing may still gain
FACTORS = (1, 2, 4)
FINER = FACTORS[-1]


@dataclass(frozen=True)
class MeshStudy:
    """Displacements [body lengths], dissipations, turns [rad] of a gait with T, 2 T, 4 T steps; NaN: it failed."""

    steps: int
    displacements: tuple[float, float, float]
    dissipations: tuple[float, float, float]
    turns: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def displacement(self) -> float:
        """Extrapolated displacement [body lengths]."""
        return _limit(self.displacements[1:])

    @property
    def dissipation(self) -> float:
        """Extrapolated dissipation T * E."""
        return _limit(self.dissipations[1:])

    @property
    def turn(self) -> float:
        """Extrapolated turn [rad]."""
        return _limit(self.turns[1:])

    @property
    def error(self) -> float:
        """Bound on the discretisation error of the displacement with T steps [body lengths]."""
        return _error(self.displacements)

    @property
    def dissipation_error(self) -> float:
        """The same of the dissipation."""
        return _error(self.dissipations)

    @property
    def turn_error(self) -> float:
        """The same of the turn [rad]."""
        return _error(self.turns)

    @property
    def converged(self) -> bool:
        """Whether the rule holds."""
        return self.within(TOLERANCE)

    @property
    def too_coarse(self) -> str:
        """A sentence where the rule does not hold; none where finer meshes could not be simulated."""
        if not np.isfinite(self.error) or self.converged:
            return ""
        return f"{self.steps} steps are too coarse for this gait: what it does is off by more than {percent(TOLERANCE)}"

    def within(self, share: float) -> bool:
        """Whether the error is at most `share` of the extrapolated motion: displacement and turn together."""
        error = self.error + GYRATION * self.turn_error
        return bool(error <= max(share * (abs(self.displacement) + GYRATION * abs(self.turn)), RESOLVED))

    def meshes(self, share: float, most: int) -> list[int]:
        """Steps of the meshes, each of twice as many, that bring the error to `share` of the motion; second order."""
        motion = max(abs(self.displacement) + GYRATION * abs(self.turn), RESOLVED / share)
        over = (self.error + GYRATION * self.turn_error) / (share * motion)
        count = most if not np.isfinite(over) else int(np.clip(np.ceil(0.5 * np.log2(max(over, 1.0))), 1, most))
        return [2**k * self.steps for k in range(1, count + 1)]

    @property
    def words(self) -> str:
        """One line: limit and error of the gait, held fixed; an optimum of more steps may be another gait."""
        if not np.isfinite(self.error):
            return f"{self.steps} steps: a finer mesh could not be simulated"
        way, arc = abs(self.displacement), GYRATION * abs(self.turn)
        least = TOLERANCE * (way + arc)
        return "; ".join([
            f"the same gait with many steps: {self.displacement:z.6f} body lengths; error of {self.steps} steps "
            f"{_error_words(self.error, self.displacement, way > least)}",
            *([f"turn {self.turn:.6f} rad, error {_error_words(self.turn_error, self.turn, arc > least)}"]
              if arc > RESOLVED else []),
            f"dissipation {self.dissipation:z.6f}, error {_error_words(self.dissipation_error, self.dissipation)}",
        ])  # fmt: skip

    @property
    def record(self) -> dict[str, object]:
        """What solution.json holds."""
        known = bool(np.isfinite(self.error))
        return {
            "steps": [factor * self.steps for factor in FACTORS],
            "displacements": list(self.displacements) if known else None,
            "extrapolated_displacement_body_lengths": self.displacement if known else None,
            "extrapolated_dissipation": self.dissipation if known else None,
            "displacement_error": self.error if known else None,
            "dissipation_error": self.dissipation_error if known else None,
            "extrapolated_turn_rad": self.turn if known else None,
            "turn_error_rad": self.turn_error if known else None,
            "converged": self.converged,
        }


class Cycle(Protocol):
    """A simulated cycle, in the plane or in space."""

    @property
    def status(self) -> Status:
        """Whether it could be simulated."""

    @property
    def displacement(self) -> float:
        """[body lengths]."""

    @property
    def dissipation(self) -> float:
        """T * E."""

    @property
    def heading_change(self) -> float:
        """[rad]."""


def study_mesh(meshes: Sequence[Cycle], steps: int) -> MeshStudy:
    """Compare one cycle of a gait on three meshes: its simulations with FACTORS times as many steps."""
    found = [(r.displacement, r.dissipation, r.heading_change) if r.status.ok else (np.nan,) * 3 for r in meshes]
    (d1, e1, h1), (d2, e2, h2), (d4, e4, h4) = found
    return MeshStudy(steps, (d1, d2, d4), (e1, e2, e4), (h1, h2, h4))


def _error(values: tuple[float, float, float]) -> float:
    """|D1 - limit| + doubt."""
    limit = _limit(values[1:])
    return abs(values[0] - limit) + abs(limit - _limit(values[:2]))


def _error_words(error: float, whole: float, moves: bool = True) -> str:
    """With its share of the whole, but of what is about zero: as good as nothing, or of little of the motion."""
    if abs(whole) <= RESOLVED or not moves:
        return f"{error:.1e}"
    return f"{error:.1e} ({percent(error / abs(whole))})"


def _limit(pair: tuple[float, ...]) -> float:
    coarse, fine = pair
    return fine + (fine - coarse) / 3
