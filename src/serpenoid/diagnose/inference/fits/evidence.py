"""Least squares in summary: what the data say about a set of linear parameters, gait by gait.

    chi2_g(theta) = c_g - 2 b_g theta + theta A_g theta        (g: gaits; residuals in units of their noise)

Any candidate is a few of the columns; all of them are scored from the same sums. What decides is how well a gait is
predicted by a fit to the others. Where the others say nothing about a parameter (how wheels roll backward, without the
only gait that goes tail first), it stays near the value that changes nothing: as if that had been seen once, with an
error as large as the parameter in the fit to all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Floats

RIDGE = 1e-9
SILENT = 1e-9


@dataclass(frozen=True)
class Evidence:
    """Sums over each gait: matrices A (G, P, P), vectors b (G, P), constants c (G,), numbers of residuals (G,).

    neutral, certainty (P): values that change nothing and the inverse square of their error, for fits without a gait.
    """

    matrix: Floats
    vector: Floats
    constant: Floats
    count: Floats
    neutral: Floats | None = None
    certainty: Floats | None = None

    @classmethod
    def of(cls, residuals: Floats, columns: Floats, labels: np.ndarray) -> Evidence:
        """From white residuals (R,), columns (R, P) and gait labels (R,)."""
        if not len(residuals):
            zero = np.zeros((1, columns.shape[1], columns.shape[1]))
            return cls(zero, zero[:, 0], np.zeros(1), np.zeros(1))
        kinds = np.unique(labels)
        parts = [(residuals[labels == k], columns[labels == k]) for k in kinds]
        return cls(
            np.stack([x.T @ x for _, x in parts]),
            np.stack([x.T @ r for r, x in parts]),
            np.array([r @ r for r, _ in parts]),
            np.array([float(len(r)) for r, _ in parts]),
        )

    def of_columns(self, chosen: Sequence[int]) -> Evidence:
        """The same sums of some columns, in their order."""
        index = list(chosen)
        return replace(self, matrix=self.matrix[:, index][:, :, index], vector=self.vector[:, index])

    def about(self, away: Floats) -> Evidence:
        """The same sums about values from which these are `away` (P,)."""
        moved = self.matrix @ away
        return Evidence(self.matrix, self.vector + moved, self.constant + (2 * self.vector + moved) @ away, self.count)

    def without(self, column: int) -> Evidence:
        """The same sums with a column that says nothing."""
        matrix, vector = self.matrix.copy(), self.vector.copy()
        matrix[:, column], matrix[:, :, column], vector[:, column] = 0.0, 0.0, 0.0
        return replace(self, matrix=matrix, vector=vector)

    def solve(self, chosen: Sequence[int], without: int | None = None) -> tuple[Floats, Floats]:
        """Best values of the chosen columns and their covariance, perhaps without one gait."""
        index = list(chosen)
        matrix, vector = self._sums(index, without)
        if without is not None and self.neutral is not None and self.certainty is not None:
            matrix = matrix + np.diag(self.certainty[index])
            vector = vector + self.certainty[index] * self.neutral[index]
        inverse = inverted(matrix)
        return inverse @ vector, inverse

    def _sums(self, index: list[int], without: int | None) -> tuple[Floats, Floats]:
        """Of the gaits, perhaps without one; picked before summed: P is many, a choice few."""
        own = np.array(index, dtype=int)
        matrix, vector = self.matrix[:, own[:, None], own], self.vector[:, own]
        if without is not None:
            matrix, vector = np.delete(matrix, without, axis=0), np.delete(vector, without, axis=0)
        return matrix.sum(axis=0), vector.sum(axis=0)

    def gains(self, own: Sequence[int], groups: Sequence[Sequence[int]]) -> list[tuple[float, Floats]]:
        """Chi squared that each group of further columns gains beside `own`, and best values of these and those; all
        groups of one size at once."""
        before, sizes = self.chi2(own), np.array([len(group) for group in groups])
        found: dict[int, tuple[float, Floats]] = {}
        for size in np.unique(sizes):
            which = np.flatnonzero(sizes == size)
            index = np.array([[*own, *groups[int(i)]] for i in which], dtype=int)
            left, values = self._best(index)
            found |= {int(i): (before - float(x), v) for i, x, v in zip(which, left, values, strict=True)}
        return [found[i] for i in range(len(groups))]

    def _best(self, index: np.ndarray) -> tuple[Floats, Floats]:
        """Chi squared (K,) after the best fit of each row of columns (K, C), and their values (K, C)."""
        matrix, vector = self._total[0][index[:, :, None], index[:, None]], self._total[1][index]
        inverse = inverted(matrix)
        values = (inverse @ vector[..., None])[..., 0]
        moved = (matrix @ values[..., None])[..., 0]
        return float(self.constant.sum()) + (values * (moved - 2 * vector)).sum(axis=1), values

    @cached_property
    def _total(self) -> tuple[Floats, Floats]:
        return self.matrix.sum(axis=0), self.vector.sum(axis=0)

    def covariance(self, chosen: Sequence[int], spread: float = 1.0) -> Floats:
        """Of a fit's columns (C, C), at the fit: curvature times spread^2, and no less than what gaits disagree about.

        Each gait pulls by its own score g; A^-1 sum(g g^T) A^-1 G / (G - 1) is what parameters scatter by if every gait
        has an error of its own along their directions (Liang and Zeger, Biometrika 73, 13, 1986).
        """
        index, gaits = list(chosen), len(self.constant)
        _, curvature = self.solve(index)
        pulls = self.vector[:, index] @ curvature
        scatter = (pulls**2).sum(axis=0) * gaits / max(gaits - 1, 1)
        wider = np.sqrt(np.maximum(spread**2, scatter / np.diag(curvature)))
        return np.asarray(curvature * np.outer(wider, wider))

    def shrinking(self, columns: Sequence[int], values: Floats, neutral: Floats) -> Evidence:
        """With what a fit without a gait takes the columns for: `neutral`, give or take their distance to `values`.

        NaN: nothing is known of that column. One that says nothing (held at a bound) stays where it is.
        """
        empty = np.zeros(self.matrix.shape[1])
        mean = empty.copy() if self.neutral is None else self.neutral.copy()
        certainty = empty if self.certainty is None else self.certainty.copy()
        away = values - neutral
        index = list(columns)
        speaks = self.matrix[:, index, index].sum(axis=0) > SILENT
        told = np.isfinite(away) & (away != 0) & speaks
        mean[list(columns)] = np.where(told, neutral, 0.0)
        certainty[list(columns)] = np.where(told, 1 / np.where(told, away, 1.0) ** 2, 0.0)
        return replace(self, neutral=mean, certainty=certainty)

    def chi2(self, chosen: Sequence[int]) -> float:
        """Chi squared after the best fit of the chosen columns."""
        index = list(chosen)
        if not index:
            return float(self.constant.sum())
        values, _ = self.solve(index)
        return self._left(index, values, range(len(self.constant)))

    def toll(self, columns: int) -> float:
        """Chi squared that columns must gain to be worth having (Schwarz, Annals of Statistics 6, 461, 1978)."""
        return columns * float(np.log(max(self.count.sum(), 2.0)))

    def held_out(self, chosen: Sequence[int]) -> float:
        """Chi squared of every gait predicted by a fit to the others, summed."""
        index = list(chosen)
        if not index:
            return float(self.constant.sum())
        gaits = range(len(self.constant))
        return sum(self._left(index, self.solve(index, without=g)[0], [g]) for g in gaits)

    def _left(self, index: list[int], values: Floats, gaits: Sequence[int] | range) -> float:
        total = 0.0
        for g in gaits:
            a, b = self.matrix[g][np.ix_(index, index)], self.vector[g][index]
            total += float(self.constant[g] - 2 * b @ values + values @ a @ values)
        return total


def inverted(matrix: Floats) -> Floats:
    """Inverse of sums (..., C, C), in units of their columns: of a silent one rounding leaves less than nothing, and it
    stays at zero."""
    scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=-2, axis2=-1), 0.0))
    scale = np.where(scale > SILENT, scale, 1.0)
    outer = scale[..., :, None] * scale[..., None, :]
    return np.asarray(np.linalg.inv(matrix / outer + RIDGE * np.eye(matrix.shape[-1])) / outer)
