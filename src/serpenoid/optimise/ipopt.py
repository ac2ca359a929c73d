"""IPOPT on a GaitNLP: options measured for these problems, a stop flag, and the KKT residuals of what came back."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.optimise.interrupt import IterationCallback, StopFlag
from serpenoid.status import Status

OPTIONS = {
    "ipopt.tol": 1e-9,
    "ipopt.constr_viol_tol": 1e-10,
    "ipopt.dual_inf_tol": 1e-9,
    "ipopt.compl_inf_tol": 1e-9,
    "ipopt.acceptable_iter": 0,
    "ipopt.mu_init": 1e-2,  # the start satisfies the momentum equations already
    "ipopt.mu_linear_decrease_factor": 0.1,
    "ipopt.mu_superlinear_decrease_power": 1.7,
    "ipopt.bound_relax_factor": 0.0,  # a limit is a limit
    "ipopt.mumps_pivot_order": 0,  # AMD: METIS takes longer to order these banded systems than to factor them
    "ipopt.mumps_permuting_scaling": 0,
    "ipopt.mumps_scaling": 0,
    "ipopt.min_refinement_steps": 0,  # a solution is refined where its residual asks for it, not always
    # the phase of a closed free gait is a curved valley, nearly level: a long step along it comes back within ten
    # iterations, where halved ones creep (results/benchmarks/approach.md, benchmarks/approach.py)
    "ipopt.watchdog_trial_iter_max": 10,
    "ipopt.max_iter": 500,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": False,
    "show_eval_warnings": False,  # a trial point that cannot be evaluated is not taken: nothing for a terminal
    "calc_lam_p": False,
    "no_nlp_grad": True,
}
WARM = {  # of 26 values of c continued from both ends: 203 iterations; with ten times these numbers 243
    "ipopt.warm_start_init_point": "yes",
    "ipopt.mu_init": 1e-7,
    "ipopt.warm_start_bound_push": 1e-9,
    "ipopt.warm_start_slack_bound_push": 1e-9,
    "ipopt.warm_start_mult_bound_push": 1e-9,
}
BESIDE_OBSTACLES = {"ipopt.mu_strategy": "adaptive"}  # a fixed barrier bends a body that touches along its length
ROUGH = {  # of answers that are starts
    "ipopt.tol": 1e-5,
    "ipopt.constr_viol_tol": 1e-6,
    "ipopt.dual_inf_tol": 1e-5,
    "ipopt.compl_inf_tol": 1e-5,
}
OUTCOMES = {
    "Solve_Succeeded": Status.SOLVED,
    "User_Requested_Stop": Status.STOPPED,
    "Infeasible_Problem_Detected": Status.INFEASIBLE,
}


@dataclass(frozen=True)
class Point:
    """A primal-dual point of the NLP."""

    x: Floats
    lam_x: Floats
    lam_g: Floats


@dataclass(frozen=True)
class Bounds:
    """lower and upper bounds of variables and constraints."""

    lbx: Floats
    ubx: Floats
    lbg: Floats
    ubg: Floats


@dataclass(frozen=True)
class Residuals:
    """KKT residuals, unscaled, largest absolute value of each."""

    stationarity: float
    feasibility: float
    complementarity: float

    @property
    def largest(self) -> float:
        """The largest of the three; NaN where one of them is none, which Python's own `max` may pass over."""
        return float(np.max([self.stationarity, self.feasibility, self.complementarity]))


@dataclass(frozen=True)
class Outcome:
    """What IPOPT returned; `timing` in seconds, by part."""

    status: Status
    ipopt_status: str
    point: Point
    objective: float
    residuals: Residuals
    iterations: int
    timing: dict[str, float] = field(compare=False)


class NLP(Protocol):
    """What is solved: variables, parameters, numbers of constraints, and Functions as those of a GaitNLP."""

    variables: ca.MX
    parameters: ca.MX

    @property
    def constraint_counts(self) -> tuple[int, ...]:
        """How many constraints of each kind there are."""

    def functions(self) -> dict[str, ca.Function]:
        """As `GaitNLP.functions`."""


class Ipopt:
    """A prepared solver for one NLP; bounds, start and parameters are given per solve.

    `kept` names the constraints that IPOPT sees (default all): rows that nothing limits would only cost time.
    Points, bounds and residuals always have all constraints; a row left out has the multiplier zero. poses: how many of
    the variables, the first ones, are poses (0: a search may stand as long as it likes).
    """

    def __init__(self, nlp: NLP, kept: np.ndarray | None = None, options: dict | None = None, poses: int = 0) -> None:
        self.functions = nlp.functions()
        nx, np_, ng = nlp.variables.numel(), nlp.parameters.numel(), sum(nlp.constraint_counts)
        self._kept = np.arange(ng) if kept is None else kept
        self._callback = IterationCallback((nx, self._kept.size, np_), self._observe, poses)
        self._watcher: Callable[[float], None] | None = None
        x, p = nlp.variables, nlp.parameters
        seen = self._seen(nlp)
        problem = {"x": x, "p": p, "f": self.functions["f"](x, p), "g": seen["g"](x, p)}
        given = {"jac_g": seen["jac_g"], "grad_f": _alone(self.functions["grad_f"], x, p)}
        given |= {"hess_lag": seen["hess_lag"], "iteration_callback": self._callback}
        # a fresh barrier and a warm one are two configurations of the same problem
        self._arguments = {
            "cold": (problem, OPTIONS | given | (options or {})),
            "warm": (problem, OPTIONS | given | WARM | (options or {})),
        }
        self._solvers: dict[str, ca.Function] = {}

    def solve(
        self,
        start: Point | Floats,
        parameters: Floats,
        bounds: Bounds,
        flag: StopFlag | None = None,
        watch: Callable[[float], None] | None = None,
    ) -> Outcome:
        """Solve from a primal start (array) or warm from a primal-dual Point."""
        if isinstance(start, Point):
            multipliers = {"lam_x0": start.lam_x, "lam_g0": start.lam_g[self._kept]}
            solver, arguments = self._solver("warm"), {"x0": start.x} | multipliers
        else:
            solver, arguments = self._solver("cold"), {"x0": start}
        self._callback.flag, self._callback.error, self._watcher = flag, None, watch
        self._callback.stood = 0
        begin = time.perf_counter()
        limits = {"lbg": bounds.lbg[self._kept], "ubg": bounds.ubg[self._kept]}
        result = solver(p=parameters, lbx=bounds.lbx, ubx=bounds.ubx, **limits, **arguments)
        wall = time.perf_counter() - begin
        if self._callback.error is not None:
            raise self._callback.error
        stats = solver.stats()
        lam_g = np.zeros(bounds.lbg.size)
        lam_g[self._kept] = result["lam_g"].full()[:, 0]
        point = Point(result["x"].full()[:, 0], result["lam_x"].full()[:, 0], lam_g)
        status = OUTCOMES.get(stats["return_status"], Status.NOT_CONVERGED)
        if status is Status.STOPPED and self._callback.given_up and not flag:
            status = Status.NOT_CONVERGED
        residuals = self.residuals(point, parameters, bounds)
        evaluation = sum(value for key, value in stats.items() if key.startswith("t_wall_nlp"))
        timing = {"total": wall, "function_evaluation": evaluation, "linear_algebra_and_ipopt": wall - evaluation}
        objective = float(result["f"])
        return Outcome(status, stats["return_status"], point, objective, residuals, stats["iter_count"], timing)

    def residuals(self, point: Point, parameters: Floats, bounds: Bounds) -> Residuals:
        """KKT residuals of a point, from the NLP's own functions and not from IPOPT's report."""
        _, gradient = self.functions["grad_f"](point.x, parameters)
        g, jacobian = self.functions["jac_g"](point.x, parameters)
        slope = (gradient + jacobian.T @ ca.DM(point.lam_g)).full()[:, 0] + point.lam_x
        value = g.full()[:, 0]
        violation = [bounds.lbg - value, value - bounds.ubg, bounds.lbx - point.x, point.x - bounds.ubx]
        feasibility = float(np.max([np.max(v, initial=0.0) for v in violation]))
        pairs = [(point.lam_x, point.x, bounds.lbx, bounds.ubx), (point.lam_g, value, bounds.lbg, bounds.ubg)]
        complementarity = float(np.max([_complementarity(*pair) for pair in pairs]))
        return Residuals(float(np.max(np.abs(slope), initial=0.0)), feasibility, complementarity)

    def _seen(self, nlp: NLP) -> dict[str, ca.Function]:
        """The constraint Functions restricted to the kept rows."""
        total = sum(nlp.constraint_counts)
        names = {key: self.functions[key] for key in ("g", "jac_g", "hess_lag")}
        x, p, rows = nlp.variables, nlp.parameters, self._kept.tolist()
        if self._kept.size == total:
            return names | {"jac_g": _alone(names["jac_g"], x, p)}
        factor, multipliers = ca.MX.sym("factor"), ca.MX.sym("multipliers", self._kept.size)
        spread = ca.DM(ca.Sparsity.triplet(total, len(rows), rows, list(range(len(rows)))), 1.0)
        hessian = names["hess_lag"](x, p, factor, spread @ multipliers)
        lagrange = (["x", "p", "lam_f", "lam_g"], ["triu_hess_gamma_x_x"])
        return {
            "g": ca.Function("kept_g", [x, p], [names["g"](x, p)[rows]], ["x", "p"], ["g"]),
            "jac_g": _alone(names["jac_g"], x, p, rows),
            "hess_lag": ca.Function("kept_hess", [x, p, factor, multipliers], [hessian], *lagrange),
        }

    def _solver(self, kind: str) -> ca.Function:
        if kind not in self._solvers:
            self._solvers[kind] = ca.nlpsol(kind, "ipopt", *self._arguments[kind])
        return self._solvers[kind]

    def _observe(self, objective: float) -> None:
        if self._watcher is not None:
            self._watcher(objective)


def _alone(function: ca.Function, x: ca.MX, p: ca.MX, rows: list[int] | None = None) -> ca.Function:
    """A derivative (of `rows`) without the value, which IPOPT asks for elsewhere: here it is not a number."""
    value, slope = function.call([x, p], True, False)
    if rows is not None:
        value, slope = value[rows], slope[rows, :]
    outputs = [ca.MX(ca.DM.nan(value.sparsity())), slope]
    return ca.Function(f"{function.name()}_alone", [x, p], outputs, function.name_in(), function.name_out())


def _complementarity(multiplier: Floats, value: Floats, lower: Floats, upper: Floats) -> float:
    """Largest |multiplier * distance to its bound| (positive: upper, negative: lower; equalities: none)."""
    free = lower < upper
    gap = np.where(multiplier > 0, upper - value, value - lower)
    gap = np.where(np.isfinite(gap), gap, 1.0)
    return float(np.max(np.abs(multiplier * gap)[free], initial=0.0))
