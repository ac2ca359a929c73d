"""Are markers beside their places, or edges of other lengths than told?

Every edge may be a little longer or shorter than `edge_lengths` says. Markers beside their places, or a scale, then
stand in for it, one after the other. So where any are found, edges that are all free are their rival, beside all other
effects and by the same price: the Bayesian information criterion of prices.py. A marker beside its place bends what its
neighbours show, and no edges do. A scale may be there, too: then the few edges that are another share off than most are
free beside it. A stretched camera makes edges depend on their direction: they are tried beside it, and in its stead.

Legend: N vertices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.chance import SYSTEMATIC
from serpenoid.diagnose.inference.fits.prices import Priced, cheapest, most_gained
from serpenoid.diagnose.stages.observation.looked import Key, Looked, solved
from serpenoid.diagnose.stages.observation.marker_evidence import Sample, left_over, misfit
from serpenoid.effects.catalogue import find
from serpenoid.wording import listed

MOVE = frozenset({"markers", "ahead", "scale", None})  # marks of what moves markers, by a law of its own, too
LONGER = 1e-3  # of an edge, and of an effect's number in its unit: a small step; markers are linear in it
ROUNDS = 12  # at most: edges and effects are fitted together
SETTLED = 0.1  # standard errors: a step that no interval shows
TINY = float(np.finfo(float).tiny)  # of what no marker shows: it stays as told


@dataclass(frozen=True)
class OtherLengths:
    """Edges as the campaign states them and as markers show them [m], that explain markers for less than some effects,
    and these; differ: which differ beyond chance; turned: whether the told ones from head to tail do it for less still.
    beside: all other effects, fitted to these edges.
    """

    told: Floats
    edges: Floats
    differ: np.ndarray
    instead_of: tuple[Key, ...]
    beside: Looked
    turned: bool = False

    @property
    def words(self) -> str:
        """What is found."""
        told = "`edge_lengths`, read from head to tail," if self.turned else "edges of other lengths than told"
        return f"{told} explain the markers better than markers beside their places, or a camera of other scales"

    @property
    def remedy(self) -> str:
        """What to do before the rest is believed."""
        if self.turned:
            return (
                "`edge_lengths` run from head to tail, and should from tail to head: turn them round, or see whether "
                "`markers` begin at the tail; then diagnose again"
            )
        which = self.differ if self.differ.any() else np.ones(len(self.edges), bool)
        each = [
            f"entry {k + 1} is {1e3 * self.edges[k]:.4g} mm, not {1e3 * self.told[k]:.4g} "
            f"({100 * (self.edges[k] / self.told[k] - 1):+.2g} %)"
            for k in np.flatnonzero(which)
        ]
        return (
            f"lengths of links are not those in `edge_lengths`: by the markers {listed(each)}"
            f"{'' if which.all() else '; the others are as told'}. Measure the links, mend `edge_lengths`, and "
            "diagnose again"
        )


@dataclass(frozen=True)
class Refitted:
    """A sample with other edges [m], and what effects leave of it; own: columns of these; deviations: standard
    errors of the edges [m] beside the effects, by noise alone; numbers: how many edges are free."""

    data: Sample
    now: Observation
    own: int
    edges: Floats
    deviations: Floats
    numbers: int

    @cached_property
    def priced(self) -> Priced:
        """What it leaves."""
        return Priced(misfit(self.data, self.now), self.own + self.numbers, self.data.count)

    @property
    def errors(self) -> Floats:
        """Standard errors of the edges [m], by what is left."""
        return self.deviations * SYSTEMATIC * max(self.priced.spread, 1.0)


@dataclass(frozen=True)
class Tried:
    """Other edges instead of some effects. rest: without these, by the edges as told; turned: see `OtherLengths`."""

    rest: Looked
    fit: Refitted
    instead_of: tuple[Key, ...]
    turned: bool = False


def instead_of_effects(best: Looked) -> OtherLengths | None:
    """What does for less what effects do; None: they do it for less, or there is nothing."""
    move, every = (tuple(k for k in best.keys if find(k[0]).marks in marks) for marks in (MOVE, MOVE | {"axes"}))
    tries = [t for keys in dict.fromkeys((move, every)) if keys for t in _instead_of(best, keys)]
    found = cheapest(best.priced, [t.fit.priced for t in tries], len(tries))
    if found is None:
        return None
    one, told = tries[found], stated(best.data.body)
    beside = replace(one.rest, data=one.fit.data, now=one.fit.now)
    return OtherLengths(told, one.fit.edges, _apart(one.fit, told), one.instead_of, beside, one.turned)


def _instead_of(best: Looked, keys: tuple[Key, ...]) -> list[Tried]:
    """Edges instead of these effects: all free, or turned round, or few beside the scale that is found: those that are
    another share off than most."""
    rest, told = _without(best, keys), stated(best.data.body)
    free = _freed(rest)
    tries = [Tried(rest, free, keys), Tried(rest, _turned(rest, free), keys, turned=True)]
    others = tuple(k for k in keys if find(k[0]).marks != "scale")
    few = _apart(free, told * float(np.median(free.edges / told)))
    if len(others) < len(keys) and 0 < 2 * few.sum() < len(told):
        rest = _without(best, others)
        tries.append(Tried(rest, _freed(rest, few), others))
    return tries


def _apart(fit: Refitted, told: Floats) -> np.ndarray:
    """Which edges differ from these beyond chance."""
    return np.asarray(((fit.edges - told) / fit.errors) ** 2 > most_gained(1, len(told)))


def _without(best: Looked, keys: Sequence[Key]) -> Looked:
    """Without these effects, the others fitted again."""
    for key in keys:
        best = best.without_one(best.keys.index(key))
    return best


def stated(body: Body) -> Floats:
    """Edges as they are written: of a body with vertices amid them, all parts of each together."""
    return body.edges_m.reshape(-1, body.pieces + 1).sum(axis=1)


def _freed(start: Looked, which: np.ndarray | None = None) -> Refitted:
    """With edges, all or which, free beside the effects: by steps of Gauss and Newton in all of these numbers."""
    told, own = stated(start.data.body), start.own
    free = np.flatnonzero(np.ones(len(told), bool) if which is None else which)
    edges, data, now, deviations = told.copy(), start.data, start.now, np.full(len(told), TINY)
    longer = LONGER * np.diag(told)[free]
    steps = np.concatenate([longer.sum(axis=1), np.full(len(own), LONGER)])
    for _ in range(ROUNDS):
        left = left_over(data, now)
        changed = [left_over(_with_edges(data, edges + s), now) for s in longer]
        changed += [left_over(data, now.with_column(c, LONGER)) for c in own]
        slopes = np.stack([(other - left) / s for other, s in zip(changed, steps, strict=True)], axis=1)
        step, covariance = np.linalg.lstsq(slopes, -left, rcond=None)[0], np.linalg.pinv(slopes.T @ slopes)
        edges[free] = np.maximum(edges[free] + step[: len(free)], told[free] / 2)
        data = _with_edges(start.data, edges)
        for column, amount in zip(own, step[len(free) :], strict=True):
            now = now.with_column(column, float(amount))
        sure = np.sqrt(np.maximum(np.diag(covariance), TINY))
        deviations[free] = sure[: len(free)]
        if (np.abs(step) < SETTLED * sure).all():
            break
    return Refitted(data, now, len(own), edges, deviations, len(free))


def _turned(rest: Looked, free: Refitted) -> Refitted:
    """With the edges as told, from head to tail."""
    back = _with_edges(rest.data, stated(rest.data.body)[::-1])
    now = solved(back, free.now, rest.keys)
    return Refitted(back, now, len(rest.own), free.edges, free.deviations, 0)


def _with_edges(data: Sample, written: Floats) -> Sample:
    parts = data.body.edges_m.reshape(len(written), -1)
    edges = (written[:, None] * parts / parts.sum(axis=1, keepdims=True)).ravel()
    return replace(data, body=data.body.changed(length_m=None, edge_lengths=tuple(edges.tolist())))
