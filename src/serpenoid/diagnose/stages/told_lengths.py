"""Are markers beside their places, or edges of other lengths than told?

Every edge may be a little longer or shorter than `edge_lengths` says. Markers beside their places, or a scale, then
stand in for it, one after the other. So where any are found, edges that are all free are their rival, by the same
price: the Bayesian information criterion of prices.py. A marker beside its place bends what its neighbours show, and no
edges do.

Legend: N vertices.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.inference.prices import Priced, cheapest
from serpenoid.diagnose.stages.looked import Key, Looked, solved
from serpenoid.diagnose.stages.marker_evidence import Sample, left_over, misfit
from serpenoid.effects.catalogue import find

MOVE = frozenset({"markers", "ahead", "scale", None})  # marks of what moves markers, by a law of its own, too
LONGER = 1e-3  # of an edge: a small step; markers are linear in it
ROUNDS = 3


@dataclass(frozen=True)
class OtherLengths:
    """Edges (N - 1,) [m] that explain markers for less than some effects, and these; turned: whether the told ones from
    head to tail do it for less still."""

    edges: Floats
    instead_of: tuple[Key, ...]
    turned: bool = False

    @property
    def words(self) -> str:
        """What is found."""
        told = "`edge_lengths`, read from head to tail," if self.turned else "edges of other lengths than told"
        return f"{told} explain the markers better than markers beside their places or a scale"

    @property
    def remedy(self) -> str:
        """What to do before the rest is believed."""
        if self.turned:
            return (
                "`edge_lengths` run from head to tail, and should from tail to head: turn them round, or see whether "
                "`markers` begin at the tail; then diagnose again"
            )
        lengths = ", ".join(f"{1e3 * e:.4g}" for e in self.edges)
        return (
            f"lengths of links are not those in `edge_lengths`: by the markers [{lengths}] mm. Measure the links, mend "
            "`edge_lengths`, and diagnose again"
        )


def other_lengths(best: Looked) -> OtherLengths | None:
    """Edges that do for less what effects along the body do; None: the effects do it for less, or there are none."""
    keys = tuple(k for k in best.keys if find(k[0]).marks in MOVE)
    if not keys:
        return None
    rest = best
    for key in keys:
        rest = rest.without_one(rest.keys.index(key))
    data, now = rest.data, rest.now
    for _ in range(ROUNDS):
        data = _lengthened(replace(rest, data=data, now=now))
        now = solved(data, now, rest.keys) if rest.keys else now
    free = Priced(misfit(data, now), len(rest.own) + len(data.body.edges_m), data.count)
    back = _with_edges(data, best.data.body.edges_m[::-1])
    turned = Priced(misfit(back, solved(back, now, rest.keys) if rest.keys else now), len(rest.own), data.count)
    found = cheapest(best.priced, [free, turned], 2)
    return None if found is None else OtherLengths(data.body.edges_m, keys, found == 1)


def _lengthened(found: Looked) -> Sample:
    """The sample of a body with the edges that leave least of it, one step of Gauss and Newton."""
    data, edges = found.data, found.data.body.edges_m
    steps = LONGER * edges
    left = left_over(data, found.now)
    longer = [left_over(_with_edges(data, edges + s), found.now) for s in np.diag(steps)]
    slopes = np.stack([(other - left) / s for other, s in zip(longer, steps, strict=True)], axis=1)
    change = np.linalg.lstsq(slopes, -left, rcond=None)[0]
    return _with_edges(data, np.maximum(edges + change, edges / 2))


def _with_edges(data: Sample, edges: Floats) -> Sample:
    return replace(data, body=data.body.changed(length_m=None, edge_lengths=tuple(edges.tolist())))
