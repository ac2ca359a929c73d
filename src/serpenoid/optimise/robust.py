"""Robust gaits: the best worst case, or the best mean, over several models that share one gait.

For the worst case over an interval of anisotropy ratios the NLP begins with the ends. Its answer is simulated at
CHECKS ratios of the interval, and about each peak among them; a ratio that is worse than every case so far becomes a
case, and the next NLP starts from there, until none is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import minimize_scalar

from serpenoid.body import Floats
from serpenoid.cases import Case, at_ratio, cases_of
from serpenoid.errors import InputError
from serpenoid.gaits import Gait
from serpenoid.model import Model
from serpenoid.objectives.self_clearance import SelfClearance
from serpenoid.optimise.apart_solver import ApartSolver
from serpenoid.optimise.asked import Customise
from serpenoid.optimise.ipopt import Bounds, Ipopt, Point
from serpenoid.optimise.motions import Costs, GaitBounds
from serpenoid.optimise.program.limits import PathLimits, path_limits
from serpenoid.optimise.program.prepared import Carried
from serpenoid.optimise.program.robust_nlp import RobustNLP
from serpenoid.optimise.program.transcription import GaitNLP
from serpenoid.optimise.solution import CaseOutcome
from serpenoid.optimise.solver import AS_ASKED, Answer, GaitSolver, Run
from serpenoid.optimise.step.motion_law import motion_law
from serpenoid.problem import Problem
from serpenoid.simulation.gaits import simulate_gaits
from serpenoid.simulation.mesh import MeshStudy
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory

CHECKS = 33  # ratios of an interval at which a worst case is looked for: it is smooth in the ratio, and mostly monotone
WORSE = 1e-6  # of the objective: what polishing may gain, too
ROUNDS = 8  # cases that may be added to the ends: a gait has a few ratios at which it is worst


def solver_of(problem: Problem, customise: Customise | None = None, gait: Gait | None = None) -> GaitSolver:
    """The solver of a problem: of one model, or of several cases together."""
    asked = [demand for demand in problem.task.demands if isinstance(demand, SelfClearance)]
    if asked and problem.task.robust is not None:
        raise InputError("[task.robust]: keeping off itself is proven for one model; leave one of the two out.")
    kind = ApartSolver if asked else GaitSolver if problem.task.robust is None else RobustSolver
    return kind(problem, customise, gait)


class RobustSolver(GaitSolver):
    """A GaitSolver whose NLP has one motion per case; `model` is the problem's own, of which nothing is asked."""

    def __init__(self, problem: Problem, customise: Customise | None = None, gait: Gait | None = None) -> None:
        alone = problem.model_copy(update={"task": problem.task.model_copy(update={"robust": None})})
        super().__init__(alone, customise, gait)
        if self.asked.criteria.clear_of:
            raise InputError("[task.robust]: obstacles are proven clear of for one model; leave one of the two out.")
        self.problem, self._customise, self._gait = problem, customise, gait
        self._easier = self._approach = None
        self._c = problem.task.c
        robust = problem.task.robust
        self.over, self.interval = (robust.over, robust.anisotropy_ratio) if robust else ("worst", None)
        self.cases: list[Case] = []
        self.each: list[GaitSolver] = []
        for case in cases_of(problem):
            self._add(case)
        each = [path_limits(case.problem) for case in self.cases]
        self.limits = PathLimits(
            np.max([own.lower for own in each], axis=0), np.min([own.upper for own in each], axis=0)
        )

    def _add(self, case: Case) -> None:
        self.cases.append(case)
        alone = GaitSolver(case.problem, self._customise, self._gait)
        alone._easier = alone._approach = None
        self.each.append(alone)

    def start(self, q: Floats) -> Floats:
        """The simulated motion of every case; the worst value."""
        size = self.family.size
        own = [solver.start(q)[:-size] for solver in self.each]
        worst = [[np.nan_to_num(max(self._values(q, self._c)))]] if self.over == "worst" else []
        return np.concatenate([*own, *worst, q])

    def solve(self, start: Floats | Point, c: float, run: Run = AS_ASKED) -> Answer:
        """As a GaitSolver's; over an interval until no ratio of it is worse than the cases."""
        self._c = c
        start = start.x[-self.family.size :] if isinstance(start, Point) else start  # cases may have been added since
        answer = super().solve(start, c, run)
        for left in reversed(range(ROUNDS + 1)):
            ratio = self._worse(answer.q, c) if answer.outcome.status.ok and not run.flag else None
            if ratio is None:
                break
            if not left:
                return replace(answer, outcome=replace(answer.outcome, status=Status.NOT_CONVERGED))
            self._add(at_ratio(self.problem, ratio))
            answer = super().solve(answer.q, c, replace(run, carried=None)).after(answer)
        return answer

    def prepared(self, carried: Carried, penalised: bool = True) -> tuple[RobustNLP, Ipopt]:  # type: ignore[override]
        """The NLP of all cases, and its solver."""
        key = len(carried.rows), penalised, len(self.cases)
        if key not in self._prepared:
            parts = self._parts(len(carried.rows), penalised)
            weights = None if self.over == "worst" else np.array([case.weight for case in self.cases])
            nlp = RobustNLP(parts, weights)
            poses = self.family.pose_size * self.steps  # of the first case: where the gait is still, all cases stand
            ipopt = Ipopt(nlp, self._kept(nlp, len(carried.rows)), poses=poses)
            self._prepared[key] = nlp, ipopt  # type: ignore[index, assignment]
        return self._prepared[key]  # type: ignore[index, return-value]

    def _parts(self, rows: int, penalised: bool) -> list[GaitNLP]:
        """The cases' NLPs; one for all that differ in numbers alone, which are parameters."""
        made: list[tuple[Model, GaitNLP]] = []
        parts = []
        for solver in self.each:
            model = solver.model
            same = (nlp for other, nlp in made if _alike(model, other))
            part = next(same, None)
            if part is None:
                part = GaitNLP(motion_law(model, self.family), solver.asked.criteria, rows, penalised=penalised)
                made.append((model, part))
            parts.append(part)
        return parts

    def _kept(self, nlp: RobustNLP, rows: int) -> np.ndarray:
        """Limits are the gait's: the first case carries them for all."""
        kept, begin = [], 0
        for k, part in enumerate(nlp.cases):
            motion, path, added = part.constraint_counts
            limited = motion + np.flatnonzero(np.tile(self._limited, rows)) if k == 0 else np.zeros(0, int)
            kept += [begin + np.concatenate([np.arange(motion), limited, motion + path + np.arange(added)]).astype(int)]
            begin += motion + path + added
        return np.concatenate([*kept, np.arange(begin, sum(nlp.constraint_counts))])

    def parameters(self, c: float, rows: tuple[int, ...]) -> Floats:
        """Numbers for the NLP's parameters."""
        shared = super().parameters(c, rows)[: -len(self.model.parameters)]
        return np.concatenate([shared, *(solver.model.parameters for solver in self.each)])

    def bounds(self, carried: Carried, gait_bounds: GaitBounds | None = None) -> Bounds:
        """Bounds of all variables and constraints."""
        lower, upper = gait_bounds or self.gait_bounds()
        nlp, _ = self.prepared(carried)
        own, turn = np.full(sum(nlp.own) + (self.over == "worst"), np.inf), self.heading_target()
        lbx, ubx = np.concatenate([-own, lower]), np.concatenate([own, upper])
        (below, above), (least, most) = self.limits.of_rows(len(carried.rows)), self.asked.bounds
        low: list[Floats] = []
        high: list[Floats] = []
        for part, begin in zip(nlp.cases, np.cumsum([0, *nlp.own]), strict=False):
            zero = np.zeros(part.constraint_counts[0])
            low, high = [*low, zero, below, least], [*high, zero, above, most]
            if turn is not None:
                last = begin + self.family.pose_size * (self.steps - 1) + 2  # the heading of the last pose
                lbx[last] = ubx[last] = turn
        epigraph = np.zeros(nlp.constraint_counts[-1])
        return Bounds(lbx, ubx, np.concatenate([*low, epigraph - np.inf]), np.concatenate([*high, epigraph]))

    def costs(self, tables: Floats, gaits: Floats, c: float) -> Costs:
        """The worst (or mean) objective of the cases, all their violations, and whether all could be simulated."""
        found = [solver.costs(tables, gaits, c) for solver in self.each]
        outside, sound = sum(f.outside for f in found), np.all([f.sound for f in found], axis=0)
        return Costs(self._together(np.array([f.value for f in found])), np.asarray(outside), sound)

    def pose_error(self, point: Point, trajectory: Trajectory) -> float:
        """Of the case that fares worst."""
        sizes = [solver.own for solver in self.each]
        begins = np.cumsum([0, *sizes])
        whole = begins[1:] <= point.x.size - self.family.size  # cases may have been added since
        parts = [Point(point.x[begin:], point.lam_x, point.lam_g) for begin in begins[:-1][whole]]
        q = point.x[-self.family.size :]
        return max(s.pose_error(p, s.simulate(q)) for s, p in zip(self.each, parts, strict=False))

    def value(self, q: Floats, table: Floats, trajectory: Trajectory, c: float) -> float:
        """Over all cases."""
        return float(self.costs(table[None], q[None], c).value[0])

    def mesh_studies(self, q: Floats, meshes: Sequence[Trajectory]) -> list[MeshStudy]:
        """In the problem's own medium, then of every case."""
        own = (study for solver in self.each for study in solver.mesh_studies(q, solver.on_meshes(q)))
        return [*super().mesh_studies(q, meshes), *own]

    def outcomes(self, q: Floats, c: float) -> tuple[CaseOutcome, ...]:
        """What gait q does in every case, re-simulated."""
        values = self._values(q, c)
        found = [
            CaseOutcome(case.name, case.weight, value, solver.simulate(q))
            for case, solver, value in zip(self.cases, self.each, values, strict=True)
        ]
        ratios = [solver.model.medium.anisotropy_ratio for solver in self.each]
        order = np.argsort(ratios) if self.interval else range(len(found))
        return tuple(found[i] for i in order)

    def _values(self, q: Floats, c: float) -> list[float]:
        table = self.table(q)[None]
        return [float(solver.costs(table, q[None], c).value[0]) for solver in self.each]

    def _together(self, values: Floats) -> Floats:
        weights = [case.weight for case in self.cases]
        return np.asarray(values.max(0) if self.over == "worst" else np.average(values, axis=0, weights=weights))

    def _worse(self, q: Floats, c: float) -> float | None:
        """The ratio of the interval that is worst, where it is worse than every case."""
        if self.interval is None or self.over != "worst":
            return None
        table, known = self.table(q)[None], self.costs(self.table(q)[None], q[None], c)

        def at(ratio: float) -> Floats:
            """Objective and violations there."""
            model = at_ratio(self.problem, ratio).problem.model
            batch = simulate_gaits(model, self.family, q[None], table)
            return np.array(self.asked.evaluate(batch, table, q[None], c))[:, 0]

        ratio, outside = _highest(lambda r: float(at(r)[1]), *self.interval)
        if outside > float(known.outside[0]) + WORSE:
            return ratio
        ratio, value = _highest(lambda r: float(at(r)[0]), *self.interval)
        return ratio if value > float(known.value[0]) + WORSE else None


def _alike(model: Model, other: Model) -> bool:
    """Whether two models differ in their media's ratios alone."""
    return (model.structure, model.body, model.effects) == (other.structure, other.body, other.effects)


def _highest(value: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    """Where a function of an interval is greatest, and how great: on a grid, and about each peak of the grid."""
    grid = np.linspace(low, high, CHECKS)
    values = np.array([value(x) for x in grid.tolist()])
    best = float(grid[values.argmax()]), float(values.max())
    inner = values[1:-1]
    for peak in 1 + np.flatnonzero((inner >= values[:-2]) & (inner >= values[2:])):
        bracket = grid[peak - 1], grid[peak + 1]
        found = minimize_scalar(lambda x: -value(float(x)), bounds=bracket, method="bounded")
        best = max(best, (float(found.x), -float(found.fun)), key=lambda pair: pair[1])
    return best
