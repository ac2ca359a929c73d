"""How near a body comes to itself: distances of its edges, at rows and proven between them; constraints on pairs.

Edges of one rigid link lie on a line: all edges of a link that are asked to keep off the same edges of another are one
piece, so pairs are few, however finely links are cut. Those of one link keep their distance whatever the gait.

Between rows the joints turn at constant rates. Seen from a piece that ends with edge i, a point of one that ends with
edge j > i moves no faster than L = sum_{e = i + 1 .. j} length_e |d (phi_e - phi_i)|, so a distance d in the middle of
an interval of half width h is at least d - L h in all of it; intervals are halved until that is enough. Pieces that
cross have the distance zero.

Legend: R rows, T steps, N vertices, n edges, P pairs of pieces, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.self_clearance import SelfClearance
from serpenoid.objectives.term import Demand
from serpenoid.optimise.asked import refuse_other_angles
from serpenoid.optimise.clear.between import Between
from serpenoid.optimise.clear.clearance import MOST, RESOLUTION, Clearance
from serpenoid.optimise.clear.pair_rows import PairRows
from serpenoid.self_contact import crosses
from serpenoid.simulation.servos import realise_gait

SHARES = (0.0, 0.5)  # of a step, where pairs that come near are looked for


class Near(NamedTuple):
    """Vertex `vertex` near the piece from vertex `begin` to `end` at `share` of `step`."""

    share: float
    step: int
    vertex: int
    begin: int
    end: int


@dataclass(frozen=True)
class Pairs:
    """Pairs of edges of a body with `between` or more edges between them."""

    model: Model
    between: int

    @cached_property
    def ends(self) -> np.ndarray:
        """Vertices at which the two pieces of every pair begin and end: a, b before c, d, shape (4, P)."""
        links = [(group[0], group[-1]) for group in self.model.structure.links]
        found = [
            (first, i + 1, max(i + self.between + 1, begin), last + 1)
            for k, (first, end) in enumerate(links)
            for begin, last in links[k + 1 :]
            for i in self._until(first, end, begin, last)
        ]
        return np.array(found, int).reshape(-1, 4).T

    def _until(self, first: int, end: int, begin: int, last: int) -> range:
        """Edges with which pieces of the link of edges first .. end may end beside one of edges begin .. last: as far
        as the whole other link is far enough along the body, and every edge from there on."""
        most = min(end, last - self.between - 1)
        return range(min(max(first, begin - self.between - 1), most), most + 1) if most >= first else range(0)

    def chains(self, angles: Floats, step: np.ndarray, share: Floats) -> Floats:
        """Vertices (I, N, 2) at times: joint angles (T + 1, m) between rows."""
        path = self._path(angles)
        late = share[:, None]
        phi = (1 - late) * path.phi[0, step] + late * path.phi[0, step + 1]
        unit = np.stack([np.cos(phi), np.sin(phi)], -1)
        return np.asarray(np.einsum("ve,ieq->ivq", path.levers, unit))

    def distances(self, chains: Floats) -> tuple[Floats, np.ndarray]:
        """Of every pair (I, P), and which of `_options` is the nearest (I, P)."""
        found = np.stack([_to_piece(chains, *option) for option in self._options])
        touching = crosses(*(chains[:, k] for k in self.ends))
        return np.where(touching, 0.0, found.min(0)), found.argmin(0)

    @property
    def _options(self) -> np.ndarray:
        """A vertex of every pair, and where the other piece begins and ends, four times (4, 3, P)."""
        a, b, c, d = self.ends
        return np.array([(a, c, d), (b, c, d), (c, a, b), (d, a, b)])

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
        """Vertices that come nearer to a piece than `distance`, each when nearest; all four where pieces cross."""
        steps = np.repeat(np.arange(len(angles) - 1), len(SHARES))
        shares = np.tile(SHARES, len(angles) - 1)
        value, nearest = self.distances(self.chains(angles, steps, shares))
        lowest = (value <= np.roll(value, 1, 0)) & (value <= np.roll(value, -1, 0)) & (value < distance)
        options = self._options
        found = []
        for i, p in np.argwhere(lowest):
            close = [nearest[i, p]] if value[i, p] > 0 else range(len(options))
            found += [Near(float(shares[i]), int(steps[i]), *map(int, options[k, :, p])) for k in close]
        return found

    def clearance(self, angles: Floats, wanted: float) -> Clearance:
        """Least distance found, and a proven lower bound, which says no more than `wanted` where it is that."""
        path = self._path(angles)
        steps = np.arange(len(angles) - 1)
        turned = np.diff(path.phi[0], axis=0)
        lengths = np.asarray(self.model.body.edges)
        rates = np.array(
            [(lengths[i:j] * np.abs(turned[:, i:j] - turned[:, i - 1 : i])).sum(1) for _, i, _, j in self.ends.T]
        ).reshape(-1, len(steps))
        step, pair = (x.ravel() for x in np.meshgrid(steps, np.arange(len(rates)), indexing="ij"))
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
        times, at = np.unique(step + share, return_inverse=True)
        whole = times.astype(int)
        late = (times - whole)[:, None]
        phi = (1 - late) * path.phi[0, whole] + late * path.phi[0, whole + 1]
        chains = np.einsum("ve,ieq->ivq", path.levers, np.stack([np.cos(phi), np.sin(phi)], -1))
        a, b, c, d = (chains[at, k[pair]] for k in self.ends)
        value = np.min([_distance(a, c, d), _distance(b, c, d), _distance(c, a, b), _distance(d, a, b)], axis=0)
        return np.where(crosses(a, b, c, d), 0.0, value)

    def _path(self, angles: Floats) -> Between:
        return Between(self.model, np.zeros((1, len(angles), 3)), angles[None])


def pairs_of(model: Model, demands: Sequence[Demand]) -> tuple[Pairs, float] | None:
    """Pairs of edges that demands keep apart, and the distance that suits all of them; None where no demand does."""
    asked = [d for d in demands if isinstance(d, SelfClearance)]
    return (Pairs(model, min(d.between for d in asked)), max(d.distance for d in asked)) if asked else None


def keep_apart(of: Criteria, model: Model, watched: tuple[Near, ...], distance: float) -> None:
    """Constraints: the watched vertices keep their distance from the watched pieces."""
    if not watched:
        return
    refuse_other_angles(model)
    _, step, vertex, begin, end = (np.array(x, int) for x in zip(*watched, strict=True))
    shares = np.array([near.share for near in watched])
    reach = np.vstack([np.zeros(model.structure.vertices - 1), np.tri(model.structure.vertices - 1)])
    reach = reach * np.asarray(model.body.edges)  # vertex k lies behind edges 0 .. k - 1
    ways = np.hstack([reach[vertex] - reach[begin], reach[end] - reach[begin]]).T
    of.keep_apart(PairRows(model.structure, of.rows, step, shares, ways, distance))


def _to_piece(chains: Floats, vertex: np.ndarray, begin: np.ndarray, end: np.ndarray) -> Floats:
    return _distance(chains[:, vertex], chains[:, begin], chains[:, end])


def _distance(point: Floats, begin: Floats, end: Floats) -> Floats:
    """Of points from pieces of lines, shape (...)."""
    (x, y), (along_x, along_y) = (np.moveaxis(vector, -1, 0) for vector in (point - begin, end - begin))
    share = np.clip((x * along_x + y * along_y) / (along_x**2 + along_y**2), 0, 1)
    return np.sqrt((x - share * along_x) ** 2 + (y - share * along_y) ** 2)
