"""From gait parameters to what depends on rows of the table, with derivatives: the chain rule of every family.

    value_i = f(p[indices_i], data_i, shared)      i = 1 .. K       slope: sparse (K s, n)     curvature: sparse (n, n)

Legend: n parameters, k that a row depends on, d numbers of its data, s values per row, K rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import casadi as ca
import numpy as np

from serpenoid.mechanics.functions import CSE
from serpenoid.mechanics.wide import Columns, over_columns
from serpenoid.optimise.step.assembly import Scatter


@dataclass(frozen=True)
class RowFunctions:
    """f (p (k), data (d), shared) -> (s); its Jacobian (s, k); the Hessian of multipliers (s) . f, or None: linear."""

    value: Columns
    slope: Columns
    curvature: Columns | None = None


def over_rows(made: Sequence[ca.Function], portable: bool) -> RowFunctions:
    """Value, slope and, unless it vanishes, curvature over rows, compiled unless portable."""
    return RowFunctions(*over_columns(made, shared=2, portable=portable))


def row_functions(name: str, function: ca.Function, portable: bool) -> RowFunctions:
    """RowFunctions of an SX function by automatic differentiation, compiled unless portable."""
    inputs = function.sx_in()
    (value,) = function.call(inputs)
    p, multipliers = inputs[0], ca.SX.sym("multipliers", value.numel())
    slope = ca.jacobian(value, p)
    made = [
        ca.Function(f"{name}_value", inputs, [ca.densify(value)], CSE),
        ca.Function(f"{name}_slope", inputs, [slope], CSE),
    ]
    if not slope_is_constant(slope, p):
        curvature = ca.hessian(ca.dot(multipliers, value), p)[0]
        made.append(ca.Function(f"{name}_curvature", [*inputs, multipliers], [curvature], CSE))
    return over_rows(made, portable)


def slope_is_constant(slope: ca.SX, p: ca.SX) -> bool:
    """Whether a derivative does not depend on what it was taken by."""
    return slope.nnz() == 0 or not any(ca.which_depends(ca.vertcat(*slope.nonzeros()), p, 1, True))


@dataclass(frozen=True)
class Layer:
    """`functions` at K rows of a table; indices (K, k), shared between solves; data may be NLP parameters."""

    functions: RowFunctions
    indices: np.ndarray
    size: int

    def value(self, p: ca.MX, data: ca.MX, shared: ca.MX) -> ca.MX:
        """Values (s, K) from parameters (n), data (d, K)."""
        return self._over(self.functions.value, p, data, shared)

    def slope(self, p: ca.MX, data: ca.MX, shared: ca.MX) -> ca.MX:
        """Derivatives (s K, n)."""
        values = self._over(self.functions.slope, p, data, shared)
        return self._slope_places(values.nz[:])

    def curvature(self, p: ca.MX, data: ca.MX, shared: ca.MX, multipliers: ca.MX) -> ca.MX:
        """Hessian (n, n), both triangles, of the sum over rows of multipliers (s, K) times values."""
        if self.functions.curvature is None:
            return ca.MX(self.size, self.size)
        values = self._over(self.functions.curvature, p, data, shared, multipliers)
        return self._curvature_places(values.nz[:])

    def _over(self, function: Columns, p: ca.MX, data: ca.MX, shared: ca.MX, *more: ca.MX) -> ca.MX:
        count = len(self.indices)
        gathered = ca.reshape(p[self.indices.ravel().tolist()], -1, count)
        return function(count, gathered, data, shared, *more)

    @cached_property
    def _slope_places(self) -> Scatter:
        slope = self.functions.slope.function
        s = slope.size1_out(0)
        rows, columns = (np.array(x, int) for x in slope.sparsity_out(0).get_triplet())
        each = np.arange(len(self.indices))[:, None]
        return _plain(each * s + rows, self.indices[:, columns], (s * len(self.indices), self.size))

    @cached_property
    def _curvature_places(self) -> Scatter:
        if self.functions.curvature is None:
            raise ValueError("a linear layer has no curvature")
        pattern = self.functions.curvature.function.sparsity_out(0)
        rows, columns = (np.array(x, int) for x in pattern.get_triplet())
        return _plain(self.indices[:, rows], self.indices[:, columns], (self.size, self.size))


def _plain(rows: np.ndarray, columns: np.ndarray, shape: tuple[int, int]) -> Scatter:
    return Scatter(rows.ravel(), columns.ravel(), np.arange(rows.size), shape, rows.size)
