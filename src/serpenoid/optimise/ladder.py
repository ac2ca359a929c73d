"""Up the ladder of families, each one started from the optimum of the one before, which it contains.

    ellipse -> Fourier series in serpenoid space -> Fourier series per joint -> every joint angle free

What a larger family gains is fair only at equal limits and equal dissipation: above the ellipse no gait may dissipate
more than the ellipse's optimum does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait, Gait, TableGait
from serpenoid.gaits.fourier import FourierGait
from serpenoid.gaits.fourier_joints import JointSeriesGait
from serpenoid.objectives import Criteria
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve, solve_from
from serpenoid.problem import Problem
from serpenoid.status import Status
from serpenoid.wording import listed

ORDERS = (1, 2)
FAMILIES = 4
Progress = Callable[[int, str], None]


@dataclass(frozen=True)
class Step:
    """The optimum of one family, with a name for people; or a failure, as its status says."""

    name: str
    solution: Solution

    @property
    def ok(self) -> bool:
        """Whether it is an optimum."""
        return self.solution.status.ok

    @property
    def undulations(self) -> int:
        """How often the body undulates in a cycle: the harmonic of the joint table (T, m) that moves joints most."""
        moving = np.abs(np.fft.rfft(self.solution.table, axis=0))[1:]
        return 1 + int(np.square(moving).sum(axis=1).argmax())


def unlike_cycles(steps: Sequence[Step]) -> str | None:
    """A sentence where cycles of some optima have more undulations than those of others; None: all have as many."""
    families: dict[int, list[str]] = {}
    for step in steps:
        families.setdefault(step.undulations, []).append(step.name)
    if len(families) < 2:
        return None
    counts = ", ".join(f"{n} in {listed([f'`{name}`' for name in names])}" for n, names in sorted(families.items()))
    return f"undulations in a cycle: {counts}; who undulates more often may go farther per cycle, not per undulation"


def climb(problem: Problem, starts: int = 12, seed: int = 0, progress: Progress | None = None) -> tuple[Step, ...]:
    """The optimum of every family of the ladder, or how it failed; each starts from the last good one.

    Ctrl-C ends the climb with the steps there are.

    `problem` asks for ellipses; its objective and limits hold on every step.
    """
    if not isinstance(problem.gait, EllipseGait):
        raise InputError(f"[gait] family: the ladder begins with an ellipse, got `{problem.gait.family}`.")
    if problem.lift is not None:
        raise InputError("[lift]: --ladder leads to joint tables, which do not say what is lifted; leave it out.")
    started = solve(problem, starts, seed)
    first = started.best
    steps = [Step("ellipse", first)]
    if not first.status.ok or len(started.solutions) < starts or any(_stopped(o.solution) for o in started.optima):
        return tuple(steps)
    budget = first.trajectory.dissipation

    def no_more(of: Criteria) -> None:
        of.subject_to(of.dissipation, -np.inf, budget)

    climbs: tuple[tuple[str, Callable[[Solution], Gait]], ...] = (
        ("Fourier, serpenoid", _series),
        ("Fourier, per joint", lambda last: JointSeriesGait.from_table(last.table, ORDERS)),
        ("free table", lambda last: TableGait.from_angles(last.table)),
    )
    good = first
    for number, (name, begin) in enumerate(climbs, start=1):
        if progress is not None:
            progress(number, name)
        found = solve_from(problem, begin(good), no_more)
        if _stopped(found):
            break
        steps.append(Step(name, found))
        good = found if found.status.ok else good
    return tuple(steps)


def was_stopped(steps: Sequence[Step]) -> bool:
    """Whether Ctrl-C ended a climb: of itself it ends early at an ellipse that fails, and nowhere else."""
    first = steps[0].solution.status
    return len(steps) < FAMILIES and (first.ok or first is Status.STOPPED)


def _stopped(found: Solution) -> bool:
    """Whether Ctrl-C ended its search, or the polishing of what was found."""
    return found.status is Status.STOPPED or (found.status.ok and found.polishing_gain is None)


def _series(last: Solution) -> Gait:
    if not isinstance(last.gait, EllipseGait):
        raise InputError("a Fourier series in serpenoid space starts from an ellipse.")
    return FourierGait.from_ellipse(last.gait, ORDERS)
