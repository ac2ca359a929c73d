"""One gait optimisation: from a start gait to a primal-dual answer. No certificate yet.

Legend: T steps, m joints, K path rows, q gait parameters (n,).
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect
from serpenoid.gaits import Gait
from serpenoid.optimise.asked import Customise
from serpenoid.optimise.clear.clearance import RESOLUTION, Clearance
from serpenoid.optimise.easier import easier
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.ipopt import ROUGH, Outcome, Point
from serpenoid.optimise.motions import GaitBounds
from serpenoid.optimise.program.limits import BINDING, TOLERANCE, exchange
from serpenoid.optimise.program.prepared import Carried, PreparedNLPs
from serpenoid.problem import Problem
from serpenoid.status import Status

log = logging.getLogger(__name__)

EXCHANGES = 16  # of limit rows and watched points, and recoveries
LAST = 2  # of them: all rows carry limits, which no phase of a gait can slip through
RECOVERIES = 2
# a search in a medium with kinks that takes longer has gone astray; it begins at the optimum of the next softer one,
# which a large barrier would leave: of the starts of a body with unequal links none came back
KINKED = {"ipopt.max_iter": 200, "ipopt.mu_init": 1e-4}
SLIPPED = 1e-3  # far above the tolerance of the poses (1e-8), far below another root (some tenths of a radian)


@dataclass(frozen=True)
class Answer:
    """IPOPT's outcome with the gait it found, total iterations over all exchanges, and what the last NLP carried.

    clearance: what is proven of obstacles. kept: whether an earlier run found it.
    """

    outcome: Outcome
    q: Floats
    iterations: int
    seconds: float = field(compare=False)
    carried: Carried
    clearance: Clearance | None = None
    kept: bool = False

    def after(self, before: Answer) -> Answer:
        """With the iterations and seconds of the search before, too."""
        return replace(self, iterations=before.iterations + self.iterations, seconds=before.seconds + self.seconds)


@dataclass(frozen=True)
class Run:
    """How one gait is searched for.

    gait_bounds: of its parameters (None: the problem's). carried: what the first NLP carries (None: what the start
    brings near); a start that is a Point needs that of its own NLP. flag: ends the search where it is raised.
    `watch(objective)` is called at each iteration.
    """

    gait_bounds: GaitBounds | None = None
    carried: Carried | None = None
    flag: StopFlag | None = None
    watch: Callable[[float], None] | None = None


AS_ASKED = Run()


class GaitSolver(PreparedNLPs):
    """Prepared once per problem (structure, family, criteria); bounds and c may change per solve.

    gait: one of the family to optimise in; default the problem's own. rough: the answer is a start for another search.
    """

    def __init__(
        self, problem: Problem, customise: Customise | None = None, gait: Gait | None = None, rough: bool = False
    ) -> None:
        found = easier(problem, problem.family_of(gait), customise is not None or gait is not None)
        kinked = KINKED if found is not None and found.exact else {}
        super().__init__(problem, customise, gait, kinked | (ROUGH if rough else {}))
        self._rough, self._easier = rough, found
        self._approach = None if found is None else GaitSolver(found.problem, customise, gait, not found.exact)

    def prepare(self, q: Floats) -> None:
        """Compile what solving from gait q calls: done before Ctrl-C is caught, so that it ends a compile at once."""
        self.start(q)
        self.prepared(self.first())
        if self._easier is not None and self._approach is not None:
            self._approach.prepare(self._easier.to(q, self.family))

    def solve(self, start: Floats | Point, c: float, run: Run = AS_ASKED) -> Answer:
        """Optimise from gait parameters (n,) or warm from a Point of an NLP that had `run.carried`.

        Where the easier problem's optimum leads to what cannot be met, the start itself may not.
        """
        if isinstance(start, Point):
            return self._search(start, c, run)

        def found_from(q: Floats) -> Answer:
            return self._search(self.start(q), c, replace(run, carried=run.carried or self.about(q)))

        begin, before = self._approached(start, c, run)
        answer = found_from(begin)
        answer = answer if before is None else answer.after(before)
        if answer.outcome.status is not Status.INFEASIBLE or begin is start or run.flag:
            return answer
        again = found_from(start).after(answer)
        return answer if again.outcome.status is Status.INFEASIBLE else again

    def _search(self, current: Floats | Point, c: float, run: Run) -> Answer:
        """Search from a point of the NLP, exchanging what it carries."""
        iterations, seconds = 0, 0.0
        carried, recoveries, clear = replace(run.carried or self.first(), staying=frozenset()), RECOVERIES, None
        penalised = c > 0 or self.asked.always_dissipation
        for left in reversed(range(EXCHANGES)):
            _, ipopt = self.prepared(carried, penalised)
            given = self.parameters(c, carried.rows), self.bounds(carried, run.gait_bounds)
            outcome = ipopt.solve(current, *given, run.flag, run.watch)
            iterations, seconds = iterations + outcome.iterations, seconds + outcome.timing["total"]
            q = outcome.point.x[-self.family.size :]
            again = self._recovery(outcome, run.gait_bounds)
            if again is None and recoveries and outcome.status.ok:
                again = self._spread(q, run.gait_bounds)
            if again is not None and recoveries:
                recoveries, current = recoveries - 1, again
                log.info("%s after %d iterations: the search begins again", outcome.ipopt_status, outcome.iterations)
                continue
            if again is not None or not outcome.status.ok or self._rough:
                break
            following, clear = self._exchanged(carried, q)
            if following == carried:
                break
            if following.rows != carried.rows and left <= LAST:
                following = self.on_every_row(following)
            same_rows = carried.rows == following.rows
            current = self._moved(outcome.point, carried, following) if same_rows else outcome.point.x
            carried = following
        return Answer(outcome, q, iterations, seconds, carried, clear)

    def _approached(self, start: Floats, c: float, run: Run) -> tuple[Floats, Answer | None]:
        """Where the search begins: the easier problem's optimum, if it is found; the search for it."""
        solver, way = self._approach, self._easier
        if solver is None or way is None or (run.gait_bounds is not None and way.fewer > 1):
            return start, None
        price = c if solver.model.law.degree == self.model.law.degree else 0.0  # drag has another scale
        found = solver.solve(way.to(start, self.family), price, Run(run.gait_bounds, flag=run.flag))
        if found.outcome.status.ok:
            start = np.clip(way.back(found.q, solver.family), *(run.gait_bounds or self.gait_bounds()))
        return start, found

    def about(self, start: Floats, good: bool = False) -> Carried:
        """What the first NLP from a gait carries: of the points to watch those that it brings near.

        good: the gait is nearly optimal, and where a limit holds it all rows carry limits: no exchange leads away.
        """
        carried = self.first()
        if good and carried.rows and float(self.excess(self.table(start)).max()) > BINDING:
            carried = self.on_every_row(carried)
        if self._rough or not carried.watch.points:
            return carried
        table = self.table(start)
        return replace(carried, watch=self.obstacles.near(self.simulate(start).poses, table))

    def _moved(self, point: Point, before: Carried, after: Carried) -> Point:
        """The point with multipliers for the next NLP, whose watched points are others."""
        size = self.model.structure.vertices, self.obstacles.columns
        old, new = before.watch.places(*size), after.watch.places(*size)
        first = point.lam_g.size - before.watch.count(*size)
        lam_g = np.concatenate([point.lam_g[:first], np.zeros(after.watch.count(*size))])
        for watched in old.keys() & new.keys():
            lam_g[first + new[watched]] = point.lam_g[first + old[watched]]
        return Point(point.x, point.lam_x, lam_g)

    def _exchanged(self, carried: Carried, q: Floats) -> tuple[Carried, Clearance | None]:
        """What the next NLP must carry, the same where gait q keeps all limits and clear of obstacles, as is proven."""
        table = self.table(q)
        excess = self.excess(table)
        if not self.family.sparse and float(excess.max()) > TOLERANCE:
            rows, staying = exchange(carried.rows, carried.staying, excess)
            return replace(carried, rows=tuple(rows), staying=staying), None
        if not self.obstacles.gaps:
            return carried, None
        poses = self.simulate(q).poses
        watch = self.obstacles.after(carried.watch, poses, table)
        if set(watch.points) - set(carried.watch.points):
            return replace(carried, watch=watch), None
        clear = self.obstacles.clearance(poses, table)
        if clear is None or clear.proven >= 0:
            return carried, clear
        return replace(carried, watch=watch, margin=carried.margin - clear.proven + RESOLUTION), clear

    def _saturated(self, q: Floats) -> bool:
        """Whether a servo is too slow for a gait."""
        slow = any(isinstance(e.effect, ActuationEffect) and e.effect.limits for e in self.model.actuation_effects)
        return slow and float(self.excess(self.table(q)).max()) > TOLERANCE

    def _spread(self, q: Floats, gait_bounds: GaitBounds | None) -> Floats | None:
        """A new start where joints leap between rows, which only coarse steps reward: the motion spread over rows."""
        resolved = self.family.resolved(q)
        if np.array_equal(resolved, q):
            return None
        return self.start(np.clip(resolved, *(gait_bounds or self.gait_bounds())))

    def _recovery(self, outcome: Outcome, gait_bounds: GaitBounds | None) -> Floats | None:
        """A new start where IPOPT went astray, else None.

        A pose may have slipped to another root of its step (an energy maximum, say): the gait is simulated anew, unless
        it differs because servos saturate in rows that carry no limit yet. Or the search ended at a gait that does not
        move, where the displacement has a kink: it is opened.
        """
        q = outcome.point.x[-self.family.size :]
        if not np.isfinite(q).all() or outcome.status not in (Status.SOLVED, Status.NOT_CONVERGED):
            return None
        simulated = self.start(q)
        if np.abs(simulated - outcome.point.x).max() > SLIPPED and not self._saturated(q):
            return simulated
        if outcome.status is Status.NOT_CONVERGED:
            opened = np.clip(self.family.opened(q), *(gait_bounds or self.gait_bounds()))
            return None if (opened == q).all() else self.start(opened)
        return None
