"""First and second derivatives by other variables, and symmetric matrices by their upper halves."""

from __future__ import annotations

from collections.abc import Sequence

import casadi as ca

from serpenoid.mechanics.functions import CSE


def upper(n: int) -> list[tuple[int, int]]:
    """Index pairs (i, j), i <= j, column by column."""
    return [(i, j) for j in range(n) for i in range(j + 1)]


def packed(matrix: ca.SX) -> ca.SX:
    """The upper half of a symmetric matrix (n, n), column by column."""
    return ca.vertcat(*(matrix[i, j] for i, j in upper(matrix.size1())))


def composed(name: str, outer: Sequence[ca.SX], z: ca.SX) -> ca.Function:
    """(outer.., gradient (n) and packed Hessian by z (n)) -> gradient and Hessian by the outer variables."""
    n, every = z.numel(), ca.vertcat(*outer)
    slope, half, inner = ca.SX.sym("slope", n), ca.SX.sym("packed", len(upper(n))), ca.SX.zeros(n, n)
    for (i, j), value in zip(upper(n), ca.vertsplit(half), strict=True):
        inner[i, j] = inner[j, i] = value
    sensitivity = ca.jacobian(z, every)
    total = sensitivity.T @ inner @ sensitivity + ca.hessian(ca.dot(slope, z), every)[0]
    outputs = [ca.densify(sensitivity.T @ slope), ca.densify(total)]
    return ca.Function(name, [*outer, slope, half], outputs, CSE)
