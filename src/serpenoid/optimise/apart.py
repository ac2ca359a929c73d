"""How near a body comes to itself: distances of its edges, at rows and proven between them; constraints on pairs.

Between rows the joints turn at constant rates. Seen from edge i, a point of edge j > i moves no faster than
L = sum_{e = i + 1 .. j} length_e |d (phi_e - phi_i)|, so a distance d in the middle of an interval of half width h
is at least d - L h in all of it; intervals are halved until that is enough. Edges that cross have the distance zero.

Legend: R rows, T steps, N vertices, n edges, P pairs of edges, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.self_clearance import SelfClearance
from serpenoid.objectives.term import Demand
from serpenoid.optimise.between import Between
from serpenoid.optimise.clearance import MOST, RESOLUTION, Clearance
from serpenoid.self_contact import crosses
from serpenoid.simulation.servos import realise_gait

SHARES = (0.0, 0.5)  # of a step, where pairs that come near are looked for
TINY = 1e-18


class Near(NamedTuple):
    """Vertex `vertex` near edge `edge` at `share` of `step`."""

    share: float
    step: int
    vertex: int
    edge: int


@dataclass(frozen=True)
class Pairs:
    """Pairs of edges of a body with `between` or more edges between them."""

    model: Model
    between: int

    @property
    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """First and second edge of every pair (P), first < second."""
        first, second = np.triu_indices(self.model.structure.vertices - 1, k=self.between + 1)
        return first, second

    def chains(self, angles: Floats, step: np.ndarray, share: Floats) -> Floats:
        """Vertices (I, N, 2) at times: joint angles (T + 1, m) between rows."""
        path = self._path(angles)
        late = share[:, None]
        phi = (1 - late) * path.phi[0, step] + late * path.phi[0, step + 1]
        unit = np.stack([np.cos(phi), np.sin(phi)], -1)
        return np.asarray(np.einsum("ve,ieq->ivq", path.levers, unit))

    def distances(self, chains: Floats) -> tuple[Floats, np.ndarray, np.ndarray]:
        """Of every pair (I, P), and which vertex is nearest to which edge, (I, P) each."""
        first, second = self.edges
        options = [(first, second), (first + 1, second), (second, first), (second + 1, first)]
        found = np.stack([_to_edge(chains, vertex, edge) for vertex, edge in options])
        best = found.argmin(0)
        vertex, edge = (np.stack([np.broadcast_to(o[k], best.shape) for o in options]) for k in (0, 1))
        at = best[None]
        pick = [np.take_along_axis(x, at, 0)[0] for x in (found, vertex, edge)]
        touching = crosses(chains, first, second)
        return np.where(touching, 0.0, pick[0]), pick[1], pick[2]

    def realised(self, table: Floats, closed: bool) -> Floats:
        """Joint angles that the body has at rows 0 .. T of a commanded table."""
        if not closed:
            return table
        angles = realise_gait(self.model, table)
        return np.concatenate([angles, angles[:1]])

    def least(self, tables: Floats) -> Floats:
        """Smallest distance of closed or open tables (B, T + 1, m), at rows: (B,)."""
        found = []
        for angles in tables:
            rows = np.arange(len(angles) - 1)
            found.append(self.distances(self.chains(angles, rows, np.zeros(len(rows))))[0].min(initial=np.inf))
        return np.array(found)

    def near(self, angles: Floats, distance: float) -> list[Near]:
        """Vertices that come nearer to an edge than `distance`, each when it is nearest; all four where edges cross."""
        steps = np.repeat(np.arange(len(angles) - 1), len(SHARES))
        shares = np.tile(SHARES, len(angles) - 1)
        value, vertex, edge = self.distances(self.chains(angles, steps, shares))
        lowest = (value <= np.roll(value, 1, 0)) & (value <= np.roll(value, -1, 0)) & (value < distance)
        found = []
        for i, p in np.argwhere(lowest):
            a, b = int(self.edges[0][p]), int(self.edges[1][p])
            ends = (
                [(int(vertex[i, p]), int(edge[i, p]))] if value[i, p] > 0 else [(a, b), (a + 1, b), (b, a), (b + 1, a)]
            )
            found += [Near(float(shares[i]), int(steps[i]), v, e) for v, e in ends]
        return found

    def clearance(self, angles: Floats, wanted: float) -> Clearance:
        """Least distance found, and a proven lower bound, which says no more than `wanted` where it is that."""
        path, (first, second) = self._path(angles), self.edges
        steps = np.arange(len(angles) - 1)
        turned = np.diff(path.phi[0], axis=0)
        lengths = np.asarray(self.model.body.edges)
        rates = np.array([
            (lengths[i + 1 : j + 1] * np.abs(turned[:, i + 1 : j + 1] - turned[:, i : i + 1])).sum(1)
            for i, j in zip(first, second, strict=True)
        ])  # fmt: skip
        step, pair = (x.ravel() for x in np.meshgrid(steps, np.arange(len(first)), indexing="ij"))
        middle, half = np.full(step.size, 0.5), np.full(step.size, 0.5)
        least, proven, seen = np.inf, np.inf, 0
        while step.size:
            value = self._of(path, step, middle, pair)
            fall, seen = rates[pair, step] * half, seen + step.size
            least = min(least, float(value.min()))
            bound = value - fall
            open_ = (bound < min(wanted, least - RESOLUTION)) & (fall > RESOLUTION) & (seen <= MOST)
            proven = min(proven, float(bound[~open_].min(initial=np.inf)))
            step, pair = np.repeat(step[open_], 2), np.repeat(pair[open_], 2)
            quarter = half[open_] / 2
            middle = np.stack([middle[open_] - quarter, middle[open_] + quarter], -1).ravel()
            half = np.repeat(quarter, 2)
        return Clearance(least, min(proven, least))

    def _of(self, path: Between, step: np.ndarray, share: Floats, pair: np.ndarray) -> Floats:
        """Distance of one pair at each time, (I,)."""
        first, second = (edges[pair] for edges in self.edges)
        late = share[:, None]
        phi = (1 - late) * path.phi[0, step] + late * path.phi[0, step + 1]
        chains = np.einsum("ve,ieq->ivq", path.levers, np.stack([np.cos(phi), np.sin(phi)], -1))
        rows = np.arange(len(step))
        ends = [chains[rows, k] for k in (first, first + 1, second, second + 1)]
        a, b, c, d = ends
        value = np.min([_distance(a, c, d), _distance(b, c, d), _distance(c, a, b), _distance(d, a, b)], axis=0)
        four = np.stack(ends, 1)
        touching = crosses(four, np.array([0]), np.array([2]))[:, 0]
        return np.where(touching, 0.0, value)

    def _path(self, angles: Floats) -> Between:
        return Between(self.model, np.zeros((1, len(angles), 3)), angles[None])


def pairs_of(model: Model, demands: Sequence[Demand]) -> tuple[Pairs, float] | None:
    """Pairs of edges that demands keep apart, and the distance that suits all of them; None where no demand does."""
    asked = [d for d in demands if isinstance(d, SelfClearance)]
    return (Pairs(model, min(d.between for d in asked)), max(d.distance for d in asked)) if asked else None


def keep_apart(of: Criteria, watched: tuple[Near, ...], distance: float) -> None:
    """Constraints: the watched vertices keep their distance from the watched edges."""
    for near in watched:
        row, following = near.step % of.rows, (near.step + 1) % of.rows
        angles = (1 - near.share) * of.joint_angles[:, row] + near.share * of.joint_angles[:, following]
        chain = of.body(angles)
        point, begin = chain[:, near.vertex], chain[:, near.edge]
        along = chain[:, near.edge + 1] - begin
        away = point - begin
        share = ca.fmin(ca.fmax(ca.dot(away, along) / ca.sumsqr(along), 0), 1)
        gap = ca.sqrt(ca.sumsqr(away - share * along) + TINY)
        of.subject_to(gap, distance, ca.inf)


def _to_edge(chains: Floats, vertex: np.ndarray, edge: np.ndarray) -> Floats:
    return _distance(chains[:, vertex], chains[:, edge], chains[:, edge + 1])


def _distance(point: Floats, begin: Floats, end: Floats) -> Floats:
    """Of points from pieces of lines, shape (...)."""
    along, away = end - begin, point - begin
    share = np.clip((away * along).sum(-1) / (along * along).sum(-1), 0, 1)
    return np.asarray(np.linalg.norm(away - share[..., None] * along, axis=-1))
