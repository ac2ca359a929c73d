"""The family of optimal gaits over the dissipation coefficient c, continued from both ends.

Each end starts from random gaits; each distinct optimum that they find there begins a branch, on which every c is
solved warm from its neighbour's answer: what is best at an end need not lead to what is best amid. At every c the
lowest cost is taken. Branches that meet are one, which is not followed twice; so are two of either end where neither of
two neighbours' gaits is better at the other's c. Every point is written when it is solved, so that a killed sweep goes
on where it stopped. `refine`: the best answer at every c is solved again with more steps, as `solve --refine` does.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.files.writing import CHAIN
from serpenoid.optimise.chain_store import ChainStore
from serpenoid.optimise.interrupt import StopFlag, catch_interrupt
from serpenoid.optimise.multistart import as_solution
from serpenoid.optimise.refine import kept_in, refine
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solver import Answer, GaitSolver, Run
from serpenoid.optimise.starts import random_gaits
from serpenoid.optimise.weights import check_weights
from serpenoid.problem import MOST_C, Problem
from serpenoid.shown import Shown
from serpenoid.simulation.callers import folder_of, problem_of, whole
from serpenoid.wording import counted

Progress = Callable[[int, str], None]
NOT_REACHED = "not reached"
SAME = 1e-8  # of costs: as near as optima are stationary; mirror images and half turns of theta cost the same


@dataclass(frozen=True)
class SweepPoint:
    """One value of c: the best certified answer of all branches; None where all failed, with the reason."""

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


@dataclass(frozen=True, repr=False, eq=False)
class Sweep(Shown):
    """Points in increasing c; `complete` is False after Ctrl-C; kept: how many of them an earlier run had solved;
    starts: how many random gaits either end began from."""

    problem: Problem
    points: tuple[SweepPoint, ...]
    complete: bool
    starts: int
    kept: int = 0

    def summary(self) -> str:
        """How many points, from how many starts, and what they span."""
        said = f"{self.problem.name}: {len(self.solved)} of {counted(len(self.points), 'point')} solved"
        said += f" from {counted(self.starts, 'start')}{' (more may find a better optimum)' * (self.starts == 1)}"
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
    refined: bool = False,
) -> Sweep:
    """Optimal gaits of a problem, or of its file, for every c in `values`.

    With `folder`, solved chain points are kept there and not solved again. `refined`: each optimum is solved again with
    more steps until the error of its displacement is below 0.1 %.
    """
    problem, ordered, folder = problem_of(problem), _in_order(values), folder_of(folder)
    check_weights(problem, ordered)
    solver = solver_of(problem)
    gaits = random_gaits(solver, whole("starts", starts, 1), whole("seed", seed, 0))
    solver.prepare(gaits[0])
    found: dict[str, dict[float, Answer]] = {}
    with catch_interrupt() as flag:
        done = 0
        for end, values_from in (("up", ordered), ("down", ordered[::-1])):
            stores = [_store(folder, end, i) for i in range(starts)]
            known = list(found.values())
            for c, answers in _branches(solver, values_from, gaits, stores, known, flag):
                done += 1
                for i, answer in answers.items():
                    found.setdefault(_name(end, i), {})[c] = answer
                if progress is not None:
                    least = min(answers.values(), key=_order).outcome.objective
                    progress(done, f"c = {c:g}: {least:.6f}")
        points = []
        for c in ordered.tolist():
            points.append(_better(solver, c, found, _Certified(polish, refined, folder), flag))
            if refined and progress is not None and not flag:
                done += 1
                progress(done, f"c = {c:g}: refined")
    kept = sum(any(chain[c].kept for chain in found.values() if c in chain) for c in ordered.tolist())
    return Sweep(problem, tuple(points), not flag, starts, kept)


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


def _name(end: str, branch: int) -> str:
    return f"{end}-{branch + 1}" if branch else end


def _store(folder: str | Path | None, end: str, branch: int) -> ChainStore | None:
    return None if folder is None else ChainStore(Path(folder) / CHAIN, _name(end, branch))


def _order(answer: Answer) -> tuple[bool, float]:
    """Solved ones first, the cheapest of them first."""
    return not answer.outcome.status.ok, answer.outcome.objective


def _branches(
    solver: GaitSolver,
    values: Floats,
    gaits: Floats,
    stores: list[ChainStore | None],
    known: list[dict[float, Answer]],
    flag: StopFlag,
) -> Iterator[tuple[float, dict[int, Answer]]]:
    """c and the answers of the branches that are followed there, by number."""
    last: dict[int, tuple[float, Answer]] = {}
    for c in values.tolist():
        if flag:
            return
        if last:
            found = {i: _next(solver, c, at, stores[i], known, flag) for i, at in last.items() if not flag}
        else:
            found = _begun(solver, c, gaits, stores, flag)
        if flag:  # amid this point, or amid the starts that are compared at it: what is not solved is not reached
            found = {i: answer for i, answer in found.items() if answer.outcome.status.ok and last}
            if not found:
                return
        solved = {i: answer for i, answer in found.items() if answer.outcome.status.ok}
        distinct = _distinct(solved)
        last = {i: at for i, at in last.items() if i not in solved} | {i: (c, a) for i, a in distinct.items()}
        yield c, found


def _begun(
    solver: GaitSolver, c: float, gaits: Floats, stores: list[ChainStore | None], flag: StopFlag
) -> dict[int, Answer]:
    """The distinct optima of all starts, the best first; a failure where there is none."""
    held = {i: store.load(c, solver) for i, store in enumerate(stores) if store is not None}
    if held.get(0) is not None:  # written last: all are there
        return {i: answer for i, answer in held.items() if answer is not None}
    answers = [solver.solve(q, c, Run(flag=flag)) for q in gaits if not flag]
    ordered = sorted(answers, key=_order)
    good = _distinct({i: answer for i, answer in enumerate(ordered) if answer.outcome.status.ok})
    found = dict(enumerate(good.values())) or dict(enumerate(ordered[:1]))
    for i in reversed(range(len(good))):
        _keep(stores[i], c, found[i], flag)
    return found


def _distinct(answers: dict[int, Answer]) -> dict[int, Answer]:
    """Of those that cost the same the first."""
    found: dict[int, Answer] = {}
    for i, answer in answers.items():
        if all(abs(answer.outcome.objective - other.outcome.objective) > SAME for other in found.values()):
            found[i] = answer
    return found


def _keep(store: ChainStore | None, c: float, answer: Answer, flag: StopFlag) -> None:
    if store is not None and answer.outcome.status.ok and not flag:
        store.save(c, answer)


def _met(solver: GaitSolver, c: float, last: tuple[float, Answer], known: dict[float, Answer]) -> Answer | None:
    """The other chain's answer at c, where both came to the same cost at the last value, on one branch with it."""
    if last[0] not in known or c not in known:
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


def _next(
    solver: GaitSolver,
    c: float,
    last: tuple[float, Answer],
    store: ChainStore | None,
    known: list[dict[float, Answer]],
    flag: StopFlag,
) -> Answer:
    """Known of another branch, or stored; warm from the neighbour; cold from its gait where that fails."""
    there = next((found for chain in known if (found := _met(solver, c, last, chain)) is not None), None)
    if there is None and store is not None:
        there = store.load(c, solver)
    if there is not None:
        return there
    before = last[1]
    answer = solver.solve(before.outcome.point, c, Run(carried=before.carried, flag=flag))
    if not (answer.outcome.status.ok or flag):
        answer = solver.solve(before.q, c, Run(flag=flag))
    if store is not None and answer.outcome.status.ok:
        store.save(c, answer)
    return answer


@dataclass(frozen=True)
class _Certified:
    """How the answers are certified, and whether they are refined; folder: where finer ones are kept."""

    polish: bool
    refined: bool
    folder: str | Path | None

    def __call__(self, solver: GaitSolver, name: str, c: float, answer: Answer, flag: StopFlag) -> Solution:
        """The answer of the branch `name` at c."""
        solution = as_solution(solver, answer, c, self.polish and not flag, flag=flag)
        if not self.refined or flag:
            return solution
        kept_at = None if self.folder is None else kept_in(self.folder, name)
        return refine(solution, flag=flag, kept_at=kept_at, polish=self.polish).solution


def _better(
    solver: GaitSolver, c: float, found: dict[str, dict[float, Answer]], certified: _Certified, flag: StopFlag
) -> SweepPoint:
    candidates = [(name, chain[c]) for name, chain in found.items() if c in chain]
    candidates.sort(key=lambda pair: _order(pair[1]))
    reasons: dict[str, list[str]] = {}
    for name, answer in candidates:
        solution = certified(solver, name, c, answer, flag)
        if solution.status.ok:
            return SweepPoint(c, solution, name, solution.message)
        reasons.setdefault(solution.message, []).append(name)
    said = "; ".join(f"{' and '.join(sorted(names))}: {message}" for message, names in reasons.items())
    return SweepPoint(c, None, "", said or NOT_REACHED)
