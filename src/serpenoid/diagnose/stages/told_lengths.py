"""Are markers beside their places, or edges of other lengths than told, or is a camera's scale another along x than y?

Every edge may be a little longer or shorter than `edge_lengths` says. Markers beside their places, or a scale, then
stand in for it, one after the other. So where any are found, edges that are all free are their rival, by the same
price: the Bayesian information criterion of prices.py. A marker beside its place bends what its neighbours show, and no
edges do.

A camera that is stretched (`stretched.py`) makes lengths and bends depend on the direction on the floor. On average
over headings that looks like other lengths. It is a rival of all of them, alone, beside what is named, and beside free
edges; it must take away more than is left beside it, or the law is another (a perspective, a lens).

Legend: N vertices.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.chance import SYSTEMATIC
from serpenoid.diagnose.data.observation import Observation
from serpenoid.diagnose.inference.finding import VISIBLE
from serpenoid.diagnose.inference.law_error import LAW_ERROR
from serpenoid.diagnose.inference.prices import Priced, cheapest, most_gained, outweighed
from serpenoid.diagnose.stages.looked import Key, Looked, solved
from serpenoid.diagnose.stages.marker_evidence import Sample, left_over, misfit, structure
from serpenoid.diagnose.stages.stretched import NUMBERS, Stretch, shown_by, strength, unstretched
from serpenoid.effects.catalogue import find
from serpenoid.wording import listed

MOVE = frozenset({"markers", "ahead", "scale", None})  # marks of what moves markers, by a law of its own, too
LONGER = 1e-3  # of an edge: a small step; markers are linear in it
ROUNDS = 12  # at most: numbers and effects are fitted in turn
SETTLED = 0.1  # standard errors: a step that no interval shows


@dataclass(frozen=True)
class OtherLengths:
    """Edges as the campaign states them and as markers show them [m], that explain markers for less than some effects,
    and these; differ: which differ beyond chance; turned: whether the told ones from head to tail do it for less still.
    told_alone: whether it is told where nothing is named, too.
    """

    told: Floats
    edges: Floats
    differ: np.ndarray
    instead_of: tuple[Key, ...]
    turned: bool = False
    visible: ClassVar[bool] = True
    told_alone: ClassVar[bool] = False

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
class OtherAxes:
    """A stretched camera that explains markers for less than effects do, and those of them of whose signature it may
    make as much as an error of their law may; visible: whether lengths or bends show it beyond the noise level, not
    only paths."""

    stretch: Stretch
    instead_of: tuple[Key, ...]
    visible: bool
    told_alone: ClassVar[bool] = True

    @property
    def words(self) -> str:
        """What is found."""
        return "distances that depend on the direction on the floor explain the markers better than what is named"

    @property
    def remedy(self) -> str:
        """What to do before the rest is believed."""
        return (
            f"distances between markers depend on their direction on the floor: {self.stretch.words}. Calibrate the "
            "camera (the scale of each axis, and whether they are square), and diagnose again: links of other lengths "
            "than told may only seem so"
        )


@dataclass(frozen=True)
class Refitted:
    """A sample with other edges, or of a camera that is not stretched, and what effects leave of it.

    own: columns of these; numbers: what else is fitted, with covariance; of a camera
    the last are t, a, b.
    """

    data: Sample
    now: Observation
    own: int
    numbers: Floats
    covariance: Floats

    @cached_property
    def priced(self) -> Priced:
        """What it leaves."""
        return Priced(misfit(self.data, self.now), self.own + len(self.numbers), self.data.count)

    @property
    def errors(self) -> Floats:
        """Standard errors of the numbers, in units of what is left."""
        return _deviations(self.covariance) * SYSTEMATIC * max(self.priced.spread, 1.0)

    @property
    def stretch(self) -> Stretch:
        """Of the camera."""
        return Stretch(self.numbers[-NUMBERS:], self.errors[1 - NUMBERS :])


def instead_of_effects(best: Looked) -> OtherLengths | OtherAxes | None:
    """What does for less what effects do; None: they do it for less, or there is nothing."""
    keys = tuple(k for k in best.keys if find(k[0]).marks in MOVE)
    rest = best
    for key in keys:
        rest = rest.without_one(rest.keys.index(key))
    axes = [(rest.priced, _fitted(rest, axes=True))]
    lengths = []
    if keys:
        free = _fitted(rest, edges=True)
        lengths = [free, _turned(rest, free)]
        axes += [(best.priced, _fitted(best, axes=True)), (free.priced, _fitted(rest, edges=True, axes=True))]
    axes = [(bare, fit) for bare, fit in axes if not outweighed(bare, fit.priced) or _leaves_less(fit)]
    fits = [*lengths, *(fit for _, fit in axes)]
    found = cheapest(best.priced, [f.priced for f in fits], len(fits))
    if found is not None and found >= len(lengths):
        fit = fits[found]
        by_shape, by_path = strength(fit.data, fit.now, fit.stretch)
        if max(by_shape, by_path) >= VISIBLE:
            done = float(np.sqrt(shown_by(fit.data, fit.now, fit.stretch.numbers).max()))
            doubted = tuple(k for k in best.keys if done > LAW_ERROR * best.strength(k))
            return OtherAxes(fit.stretch, doubted, by_shape >= VISIBLE)
        found = cheapest(best.priced, [f.priced for f in lengths], len(lengths))
    if found is None:
        return None
    told, edges = stated(best.data.body), lengths[0].numbers
    differ = ((edges - told) / lengths[0].errors) ** 2 > most_gained(1, len(edges))
    return OtherLengths(told, edges, differ, keys, found == 1)


def _leaves_less(fit: Refitted) -> bool:
    """Whether what lasts of what a stretch leaves is less than it does, where noise is more than that of markers."""
    done = shown_by(fit.data, fit.now, fit.stretch.directed)
    return bool(structure(fit.data, fit.now).sum() < done.sum())


def stated(body: Body) -> Floats:
    """Edges as they are written: of a body with vertices in their middles, both halves together."""
    return body.edges_m.reshape(-1, 2).sum(axis=1) if body.has_middles else body.edges_m


def _fitted(start: Looked, edges: bool = False, axes: bool = False) -> Refitted:
    """With edges that are free, or a camera that may be stretched: by steps of Gauss and Newton beside the effects."""
    told = stated(start.data.body)
    steps = LONGER * np.concatenate([told if edges else [], np.ones(NUMBERS if axes else 0)])
    numbers = np.concatenate([told if edges else [], np.zeros(NUMBERS if axes else 0)])
    lowest = np.where(np.arange(len(steps)) < (len(told) if edges else 0), numbers / 2, -np.inf)

    def made(x: Floats) -> Sample:
        data = _with_edges(start.data, x[: len(told)]) if edges else start.data
        return unstretched(data, x[-NUMBERS:]) if axes else data

    data, now = start.data, start.now
    for _ in range(ROUNDS):
        left = left_over(data, now)
        changed = [left_over(made(numbers + s), now) for s in np.diag(steps)]
        slopes = np.stack([(other - left) / s for other, s in zip(changed, steps, strict=True)], axis=1)
        step, covariance = np.linalg.lstsq(slopes, -left, rcond=None)[0], np.linalg.pinv(slopes.T @ slopes)
        numbers = np.maximum(numbers + step, lowest)
        data = made(numbers)
        now = solved(data, now, start.keys) if start.keys else now
        if (np.abs(step) < SETTLED * _deviations(covariance)).all():
            break
    return Refitted(data, now, len(start.own), numbers, covariance)


def _deviations(covariance: Floats) -> Floats:
    """Of numbers; of what no marker shows next to nothing, as it stays as told."""
    return np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny))


def _turned(rest: Looked, free: Refitted) -> Refitted:
    """With the edges as told, from head to tail."""
    back = _with_edges(rest.data, stated(rest.data.body)[::-1])
    now = solved(back, free.now, rest.keys) if rest.keys else free.now
    return Refitted(back, now, len(rest.own), np.zeros(0), np.zeros((0, 0)))


def _with_edges(data: Sample, written: Floats) -> Sample:
    edges = np.repeat(written / 2, 2) if data.body.has_middles else written
    return replace(data, body=data.body.changed(length_m=None, edge_lengths=tuple(edges.tolist())))
