"""A gait of one's own beside a family of optimal ones: how far they go for as much, and what they take to go as far.

An animal's mean beat, or what a robot plays today, is one point; the family is a curve over c. Between solved gaits
the curve is `performance.between`, which obeys what minimisers obey.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.performance import between, moving
from serpenoid.problem import Problem, load
from serpenoid.simulation.problem import simulate
from serpenoid.studies.sweep import Sweep

SAMPLES = 4001  # of c: a curve of 26 gaits bends little between them


@dataclass(frozen=True)
class Beside:
    """A simulated gait: its file's name, displacement [body lengths] and normalised dissipation of a cycle."""

    name: str
    displacement: float
    dissipation: float

    def against(self, result: Sweep) -> dict[str, Any]:
        """This gait; the family's most displacement for as much, and least dissipation for as far (null: beyond it)."""
        told = {"gait": self.name, "displacement": self.displacement, "dissipation": self.dissipation}
        move = moving(result.displacement)
        if move.sum() < 2:
            return told | {"most_displacement": None, "least_dissipation": None}
        c, went, spent = result.c[move], result.displacement[move], result.dissipation[move]
        far, much = between(c, went, spent, np.union1d(c, np.linspace(c[0], c[-1], SAMPLES)))
        return told | {
            "most_displacement": _at(self.dissipation, much, far),
            "least_dissipation": _at(self.displacement, far, much),
        }


def beside_of(problem: Problem, path: str | Path, assigned: Sequence[str] = (), model: str | None = None) -> Beside:
    """The gait of the problem file `path`, simulated; InputError where it moves another body, or in another medium.

    assigned: `section.key=value`, of which those of the gait and where to look for it are left out.
    """
    others = [one for one in assigned if not one.strip().startswith(("gait.", "task.bounds"))]
    other = load(path, [*others, "task.cycles=1"], model)
    mine, theirs = problem.model, other.model
    same = mine.structure == theirs.structure and np.allclose(mine.parameters, theirs.parameters, rtol=1e-9, atol=0)
    if not same or mine.effects != theirs.effects:
        raise InputError(
            f"--beside {path}: has another body, medium or effects than {problem.name}: compare gaits of the same "
            "body on the same ground. --set and --model act on both files."
        )
    if problem.task.transient or other.task.transient:
        raise InputError(f"--beside {path}: transients are not compared. Leave --beside out.")
    moved = simulate(other).trajectory
    if not moved.status.ok:
        raise InputError(f"--beside {path}: {moved.status.value}.")
    return Beside(other.name, moved.displacement, moved.dissipation)


def _at(value: float, rising: Floats, of: Floats) -> float | None:
    """`of` where `rising` has a value; None where no gait has."""
    order = np.argsort(rising, kind="stable")
    if not rising[order[0]] <= value <= rising[order[-1]]:
        return None
    return float(np.interp(value, rising[order], of[order]))
