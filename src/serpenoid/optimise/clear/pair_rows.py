"""Gaps between parts of the body with their derivatives by the joint angles, one instant at a time.

    v = (point - begin, end - begin) = sum_e (A_e, B_e) u(psi_e),    psi = P angles,    gap = h(v)

A joint turns what lies beyond it, s_j = sum over those edges of (A, B) u: dv / d angle_j is s_j turned by a quarter,
and d2v / d angle_j d angle_k = -s_max(j, k). So an instant costs m^2 numbers, and symbols do not grow with the number
of instants: all of them in one expression took 20 s to derive for a body of a hundred joints.

Legend: n edges, m joints, K instants, R rows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.model import Structure

TINY = 1e-18


@dataclass(frozen=True)
class PairRows:
    """Gaps (K,) that stay above `least`, at joint angles between row `steps` (K,) and the next by `shares` (K,).

    ways (2 n, K): lengths, with signs, of the edges that lead from where a piece begins to the point, and to its end.
    """

    structure: Structure
    rows: int
    steps: np.ndarray
    shares: Floats
    ways: Floats
    least: float

    @property
    def count(self) -> int:
        """K."""
        return len(self.steps)

    def value(self, table: ca.MX) -> ca.MX:
        """Gaps (K) of a joint table (m R)."""
        return ca.vec(self._over("value", table))

    def jacobian(self, table: ca.MX) -> ca.MX:
        """Their derivatives (K, m R)."""
        return self._blocks(self._over("slope", table)) @ self._mixing

    def hessian(self, table: ca.MX, multipliers: ca.MX) -> ca.MX:
        """Second derivatives (m R, m R) of multipliers (K) . gaps."""
        return self._mixing.T @ (self._blocks(self._over("curvature", table, multipliers.T)) @ self._mixing)

    def _over(self, name: str, table: ca.MX, *more: ca.MX) -> ca.MX:
        angles = ca.reshape(self._mixing @ table, -1, self.count)
        function = pair_functions(self.structure)[name].map(self.count)
        return function(angles, ca.MX(ca.DM(self.ways)), *more)

    def _blocks(self, side_by_side: ca.MX) -> ca.MX:
        return ca.diagcat(*ca.horzsplit(side_by_side, len(self.structure.joints)))

    @cached_property
    def _mixing(self) -> ca.DM:
        """From a joint table (m R) to the angles at the instants (m K)."""
        m = len(self.structure.joints)
        size, place = (m * self.count, m * self.rows), np.arange(m * self.count)
        mixing = ca.DM(*size)
        for late, share in ((0, 1 - self.shares), (1, self.shares)):
            columns = ((self.steps + late) % self.rows)[:, None] * m + np.arange(m)
            some = np.repeat(share != 0, m)
            where = ca.Sparsity.triplet(*size, place[some].tolist(), columns.ravel()[some].tolist())
            order = np.argsort(columns.ravel()[some], kind="stable")  # numbers of a pattern are column by column
            mixing += ca.DM(where, np.repeat(share, m)[some][order])
        return mixing


@lru_cache(maxsize=16)
def pair_functions(structure: Structure) -> dict[str, ca.Function]:
    """(angles (m), ways (2 n)) -> value, slope (1, m); with a multiplier -> curvature (m, m)."""
    m, n = len(structure.joints), structure.vertices - 1
    angles, ways, multiplier = ca.MX.sym("angles", m), ca.MX.sym("ways", 2 * n), ca.MX.sym("multiplier")
    link = np.repeat(np.arange(m + 1), [len(edges) for edges in structure.links])
    turned = ca.sparsify(ca.DM((link[:, None] > np.arange(m)).astype(float)))
    psi = turned @ angles
    unit = ca.horzcat(ca.cos(psi), ca.sin(psi)).T
    edges = ca.vertcat(*(unit * ca.repmat(way.T, 2, 1) for way in ca.vertsplit(ways, n)))
    gap, gradient, hessian = _gap()(ca.sum2(edges))
    beyond = edges @ turned
    by = ca.vertcat(-beyond[1, :], beyond[0, :], -beyond[3, :], beyond[2, :])
    pull = -gradient.T @ beyond
    later = np.maximum(*np.meshgrid(np.arange(m), np.arange(m))).ravel()
    curvature = by.T @ hessian @ by + ca.reshape(pull[later.tolist()], m, m)
    return {
        "value": ca.Function("pair_value", [angles, ways], [gap]),
        "slope": ca.Function("pair_slope", [angles, ways], [gradient.T @ by]),
        "curvature": ca.Function("pair_curvature", [angles, ways, multiplier], [multiplier * curvature]),
    }


def _gap() -> ca.Function:
    """v (4) -> distance of a point from a piece, its gradient (4) and Hessian (4, 4)."""
    v = ca.SX.sym("v", 4)
    away, along = v[:2], v[2:]
    share = ca.fmin(ca.fmax(ca.dot(away, along) / ca.sumsqr(along), 0), 1)
    gap = ca.sqrt(ca.sumsqr(away - share * along) + TINY)
    hessian, gradient = ca.hessian(gap, v)
    return ca.Function("pair_gap", [v], [gap, ca.densify(gradient), ca.densify(hessian)])
