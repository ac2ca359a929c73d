"""One NLP of several cases: a copy of the motion's variables per case, one gait that all of them share.

    variables    u_1 .. u_K (poses, [dissipation] of each case), [s], gait parameters p
    minimise     s  (worst case)                        or    sum_k weight_k f_k  (mean)
    subject to   g_k(u_k, p) within bounds, and for the worst case f_k(u_k, p) - s <= 0

Derivatives are those of the single cases' NLPs, put in place. Legend: K cases, n gait parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.optimise.program.transcription import GaitNLP


class RobustNLP:
    """Take its Functions, as those of a GaitNLP; weights (K) of a mean, None: the worst case.

    parameters: c, the data of the path rows, then each case's model parameters.
    """

    def __init__(self, cases: Sequence[GaitNLP], weights: Floats | None) -> None:
        self.cases, self.weights = tuple(cases), weights
        first = self.cases[0]
        self.size = first.family.size
        self.own = [nlp.variables.numel() - self.size for nlp in self.cases]
        total = sum(self.own) + (weights is None) + self.size
        self.variables = ca.MX.sym("variables", total)
        self.models = [nlp.model_parameters.numel() for nlp in self.cases]
        self.shared = first.parameters.numel() - self.models[0]
        self.parameters = ca.MX.sym("parameters", self.shared + sum(self.models))

    @cached_property
    def columns(self) -> list[np.ndarray]:
        """Where each case's variables stand, in order."""
        begins = np.cumsum([0, *self.own])
        gait = np.arange(self.variables.numel() - self.size, self.variables.numel())
        return [np.concatenate([np.arange(a, a + n), gait]) for a, n in zip(begins, self.own, strict=False)]

    @cached_property
    def counts(self) -> list[int]:
        """Numbers of each case's constraints."""
        return [sum(nlp.constraint_counts) for nlp in self.cases]

    @property
    def constraint_counts(self) -> tuple[int, ...]:
        """Numbers of constraints: case by case, then of the bound on all of them."""
        return (*self.counts, len(self.cases) if self.weights is None else 0)

    def functions(self) -> dict[str, ca.Function]:
        """As `GaitNLP.functions`."""
        x, p = self.variables, self.parameters
        made = {id(nlp): nlp for nlp in self.cases}  # cases that differ in numbers share theirs
        functions = {key: nlp.functions() for key, nlp in made.items()}
        each = [functions[id(nlp)] for nlp in self.cases]
        at = list(zip(each, self._points, strict=True))
        values = [f["f"](*point) for f, point in at]
        slopes = [spread @ f["grad_f"](*point)[1] for (f, point), spread in zip(at, self._spreads, strict=True)]
        g = ca.vertcat(*(f["g"](*point) for f, point in at), *self._bound(values))
        rows = [f["jac_g"](*point)[1] @ spread.T for (f, point), spread in zip(at, self._spreads, strict=True)]
        if self.weights is None:
            objective, gradient = self._worst, ca.MX(self._unit)
            rows += [slope.T - self._unit.T for slope in slopes]
        else:
            parts = list(zip(self.weights.tolist(), values, slopes, strict=True))
            objective = sum((w * f for w, f, _ in parts), ca.MX(0))
            gradient = sum((w * slope for w, _, slope in parts), ca.MX(x.numel(), 1))
        factor, multipliers = ca.MX.sym("factor"), ca.MX.sym("multipliers", sum(self.constraint_counts))
        hessian = self._hessian(each, factor, multipliers)
        return {
            "f": ca.Function("robust_objective", [x, p], [objective], ["x", "p"], ["f"]),
            "g": ca.Function("robust_constraints", [x, p], [g], ["x", "p"], ["g"]),
            "grad_f": ca.Function(
                "robust_gradient", [x, p], [objective, ca.densify(gradient)], ["x", "p"], ["f", "grad_f_x"]
            ),
            "jac_g": ca.Function("robust_jacobian", [x, p], [g, ca.vertcat(*rows)], ["x", "p"], ["g", "jac_g_x"]),
            "hess_lag": ca.Function(
                "robust_hessian", [x, p, factor, multipliers], [hessian], ["x", "p", "lam_f", "lam_g"],
                ["triu_hess_gamma_x_x"],
            ),
        }  # fmt: skip

    @property
    def _worst(self) -> ca.MX:
        return self.variables[sum(self.own)]

    @property
    def _unit(self) -> ca.DM:
        return ca.DM(ca.Sparsity.triplet(self.variables.numel(), 1, [sum(self.own)], [0]), 1.0)

    @cached_property
    def _points(self) -> list[tuple[ca.MX, ca.MX]]:
        shared, *models = ca.vertsplit(self.parameters, np.cumsum([0, self.shared, *self.models]).tolist())
        return [
            (self.variables[columns.tolist()], ca.vertcat(shared, model))
            for columns, model in zip(self.columns, models, strict=True)
        ]

    @cached_property
    def _spreads(self) -> list[ca.DM]:
        """From each case's variables to all of them."""
        total = self.variables.numel()
        return [ca.DM(ca.Sparsity.triplet(total, c.size, c.tolist(), list(range(c.size))), 1.0) for c in self.columns]

    def _bound(self, values: list[ca.MX]) -> list[ca.MX]:
        return [value - self._worst for value in values] if self.weights is None else []

    def _hessian(self, each: list[dict[str, ca.Function]], factor: ca.MX, multipliers: ca.MX) -> ca.MX:
        """Columns keep their order, so that upper triangles stay upper."""
        ends = np.cumsum([0, *self.constraint_counts]).tolist()
        *on_cases, on_bound = ca.vertsplit(multipliers, ends) if ends[-1] > ends[-2] else (
            *ca.vertsplit(multipliers, ends[:-1]), None
        )  # fmt: skip
        total = ca.MX(self.variables.numel(), self.variables.numel())
        for k, (functions, on_case) in enumerate(zip(each, on_cases, strict=True)):
            share = on_bound[k] if self.weights is None else factor * float(self.weights[k])
            block = functions["hess_lag"](*self._points[k], share, on_case)
            total += self._spreads[k] @ block @ self._spreads[k].T
        return total
