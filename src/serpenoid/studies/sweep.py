"""The family of optimal gaits over the dissipation coefficient c, continued from both ends.

Each end starts from random gaits; from there every c is solved warm from its neighbour's answer. Where the two chains
disagree the lower cost is taken: a family that folds back is followed on its better branch. Where they meet, and
neither of two neighbours' gaits is better at the other's c, they are one branch, which is not followed twice. Every
point is written when it is solved, so that a killed sweep goes on where it stopped.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.optimise.chain_store import CHAIN, ChainStore
from serpenoid.optimise.interrupt import StopFlag, catch_interrupt
from serpenoid.optimise.multistart import as_solution
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solver import Answer, GaitSolver
from serpenoid.optimise.starts import random_gaits
from serpenoid.optimise.weights import check_weights
from serpenoid.problem import MOST_C, Problem
from serpenoid.shown import Shown
from serpenoid.simulation.callers import problem_of, whole

Progress = Callable[[int, str], None]
NOT_REACHED = "not reached"
SAME = 1e-8  # of costs: as near as optima are stationary; mirror images and half turns of theta cost the same


@dataclass(frozen=True)
class SweepPoint:
    """One value of c: the better certified answer of the two chains; None where both failed, with the reason."""

    c: float
    solution: Solution | None
    chain: str
    message: str

    @property
    def reached(self) -> bool:
        """False where Ctrl-C came before this point."""
        return self.solution is not None or self.message != NOT_REACHED

    @property
    def failed(self) -> bool:
        """Whether it was tried in vain."""
        return self.solution is None and self.reached


@dataclass(frozen=True, repr=False)
class Sweep(Shown):
    """Points in increasing c; `complete` is False after Ctrl-C; kept: how many of them an earlier run had solved."""

    problem: Problem
    points: tuple[SweepPoint, ...]
    complete: bool
    kept: int = 0

    def summary(self) -> str:
        """How many points, and what they span."""
        said = f"{self.problem.name}: {len(self.solved)} of {len(self.points)} point(s) solved"
        if not self.solved:
            return said
        far = self.displacement
        return f"{said}, c = {self.c[0]:g} .. {self.c[-1]:g}, {far.min():.6f} .. {far.max():.6f} body lengths"

    @property
    def solved(self) -> list[Solution]:
        """The solved points' solutions."""
        return [p.solution for p in self.points if p.solution is not None]

    @property
    def c(self) -> Floats:
        """c of the solved points."""
        return np.array([s.c for s in self.solved])

    @property
    def displacement(self) -> Floats:
        """Displacement of the solved points [body lengths]."""
        return np.array([s.trajectory.displacement for s in self.solved])

    @property
    def dissipation(self) -> Floats:
        """Normalised dissipation T * E of the solved points."""
        return np.array([s.trajectory.dissipation for s in self.solved])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the gait parameters, as the problem's family calls them."""
        return self.problem.family_of().names

    @property
    def gaits(self) -> Floats:
        """Gait parameters of the solved points, shape (n, k)."""
        return np.array([s.q for s in self.solved]).reshape(-1, len(self.names))


def sweep(
    problem: Problem | str | Path,
    values: Sequence[float] | Floats,
    starts: int = 4,
    seed: int = 0,
    folder: str | Path | None = None,
    polish: bool = True,
    progress: Progress | None = None,
) -> Sweep:
    """Optimal gaits of a problem, or of its file, for every c in `values`.

    With `folder`, solved chain points are kept there and not solved again.
    """
    problem, ordered = problem_of(problem), _in_order(values)
    check_weights(problem, ordered)
    solver = solver_of(problem)
    gaits = random_gaits(solver, whole("starts", starts, 1), whole("seed", seed, 0))
    solver.prepare(gaits[0])
    found: dict[str, dict[float, Answer]] = {}
    with catch_interrupt() as flag:
        for name, chain_values in (("up", ordered), ("down", ordered[::-1])):
            store = ChainStore(Path(folder) / CHAIN, name) if folder is not None else None
            known, found[name] = found.get("up", {}), {}
            for c, answer in _chain(solver, chain_values, gaits, store, known, flag):
                found[name][c] = answer
                if progress is not None:
                    progress(sum(map(len, found.values())), f"c = {c:g}: {answer.outcome.objective:.6f}")
        points = tuple(_better(solver, c, found, polish, flag) for c in ordered.tolist())
    kept = sum(any(chain[c].kept for chain in found.values() if c in chain) for c in ordered.tolist())
    return Sweep(problem, points, complete=not flag, kept=kept)


def _in_order(values: Sequence[float] | Floats) -> Floats:
    """c, from the least on."""
    try:
        ordered = np.unique(np.asarray(values, float))
    except (TypeError, ValueError):
        ordered = np.zeros(0)
    if not ordered.size or not np.isfinite(ordered).all() or ordered[0] < 0 or ordered[-1] > MOST_C:
        raise InputError(
            f"`values` must be one c or more, none of them negative or above {MOST_C:g}, got {values!r}. "
            "np.linspace(0, 2, 9)?"
        )
    return ordered


def _chain(
    solver: GaitSolver,
    values: Floats,
    gaits: Floats,
    store: ChainStore | None,
    known: dict[float, Answer],
    flag: StopFlag,
) -> Iterator[tuple[float, Answer]]:
    last: tuple[float, Answer] | None = None
    for c in values.tolist():
        if flag:
            return
        answer = _met(solver, c, last, known) or (store.load(c, solver) if store is not None else None)
        if answer is None:
            answer = _next(solver, c, None if last is None else last[1], gaits, flag)
            if flag and (last is None or not answer.outcome.status.ok):
                return  # Ctrl-C amid this point, or amid the starts that are compared at it: it is not reached
            if store is not None and answer.outcome.status.ok:
                store.save(c, answer)
        if answer.outcome.status.ok:
            last = c, answer
        yield c, answer


def _met(solver: GaitSolver, c: float, last: tuple[float, Answer] | None, known: dict[float, Answer]) -> Answer | None:
    """The other chain's answer at c, where both came to the same cost at the last value, on one branch with it."""
    if last is None or last[0] not in known or c not in known:
        return None
    (before, here), there, wanted = last, known[last[0]], known[c]
    if not (there.outcome.status.ok and wanted.outcome.status.ok):
        return None
    if abs(here.outcome.objective - there.outcome.objective) > SAME:
        return None
    better = _cost(solver, wanted, before) < there.outcome.objective - SAME
    better |= _cost(solver, there, c) < wanted.outcome.objective - SAME
    return None if better else wanted


def _cost(solver: GaitSolver, answer: Answer, c: float) -> float:
    """What the answer's gait costs at another c."""
    gait = answer.q[None]
    return float(solver.costs(solver.tables(gait), gait, c).value[0])


def _next(solver: GaitSolver, c: float, last: Answer | None, gaits: Floats, flag: StopFlag) -> Answer:
    """Warm from the neighbour; cold from its gait where that fails; from random gaits at the end of the chain."""
    if last is not None:
        answer = solver.solve(last.outcome.point, c, carried=last.carried, flag=flag)
        return answer if answer.outcome.status.ok or flag else solver.solve(last.q, c, flag=flag)
    answers = [solver.solve(q, c, flag=flag) for q in gaits]
    good = [a for a in answers if a.outcome.status.ok]
    return min(good, key=lambda a: a.outcome.objective) if good else answers[0]


def _better(
    solver: GaitSolver, c: float, found: dict[str, dict[float, Answer]], polish: bool, flag: StopFlag
) -> SweepPoint:
    candidates = [(name, chain[c]) for name, chain in found.items() if c in chain]
    candidates.sort(key=lambda pair: (not pair[1].outcome.status.ok, pair[1].outcome.objective))
    reasons: dict[str, list[str]] = {}
    for name, answer in candidates:
        solution = as_solution(solver, answer, c, polish and not flag, flag=flag)
        if solution.status.ok:
            return SweepPoint(c, solution, name, solution.message)
        reasons.setdefault(solution.message, []).append(name)
    said = "; ".join(f"{' and '.join(sorted(names))}: {message}" for message, names in reasons.items())
    return SweepPoint(c, None, "", said or NOT_REACHED)
