"""Second stage, the model: where markers appear when zeros, play, displaced markers, a length scale or axes of a camera
lie in between.

Legend: F frames, N vertices, m joints, C columns.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.cameras import axes, views
from serpenoid.diagnose.data.cameras.columns import all_keys, columns_of, first_columns, sizes
from serpenoid.diagnose.data.shapes.geometry import shapes, turn
from serpenoid.effects.active import ActiveEffect
from serpenoid.measure.shapes.links import link_of_edge

PLACES = 41  # in a gap, at which a link is tried; nearer than one of them to an end it lies against it
TINY = 1e-6  # rad: of angles without noise


@dataclass(frozen=True)
class Observation:
    """What lies between the chain and the data; all zero: nothing does.

    zeros (m,) [rad], markers (N, 2) along and left of the links behind them [m], gaps (m,) of joints with play [rad],
    ahead (m, 2): as markers, of those at joints that ride on the links ahead; scale error; views (V,): coordinates of
    effects of observation that have none of these marks, and show what their own law (`on_view`) says. axes (A,): how
    distances depend on their direction on the floor; no chain shows it, so markers are mended instead (`unstretched`).
    """

    zeros: Floats
    markers: Floats
    gaps: Floats
    ahead: Floats
    scale: float = 0.0
    views: Floats = field(default_factory=lambda: np.zeros(0))
    axes: Floats = field(default_factory=axes.resting)

    @classmethod
    def neutral(cls, body: Body) -> Observation:
        joints, markers = body.joint_count, np.zeros((body.vertices, 2))
        return cls(np.zeros(joints), markers, np.zeros(joints), np.zeros((joints, 2)), views=views.resting(body))

    @classmethod
    def of(cls, body: Body, effects: Sequence[ActiveEffect]) -> Observation:
        """What these effects do; those that leave no mark here change nothing."""
        now, known = cls.neutral(body), all_keys(body)
        for effect in (e for e in effects if e.key in known):
            columns, was = columns_of(body, *effect.key), values_of(body, now, *effect.key)
            numbers = effect.coordinates if effect.effect.marks is None else list(effect.parameters.values())
            for column, number, before in zip(columns, numbers, was, strict=False):
                now = now.with_column(column, number - before)
        return now

    @property
    def corrects(self) -> bool:
        """Whether shapes are anything else than what servos read, or markers stand elsewhere."""
        return bool(np.any(self.numbers))

    @property
    def numbers(self) -> Floats:
        """One for each column: zeros, markers (along, left by vertex), scale, gaps, markers ahead, axes, views."""
        parts = self.zeros, self.markers.ravel(), [self.scale], self.gaps, self.ahead.ravel(), self.axes, self.views
        return np.concatenate(parts)

    def unstretched(self, markers: Floats) -> Floats:
        """Markers (.., 2) as a camera would show them for which all directions are alike."""
        return markers @ np.linalg.inv(axes.map_of(self.axes)) if self.axes.any() else markers

    def stretched(self, points: Floats) -> Floats:
        """Points (.., 2) on the floor as this camera shows them."""
        return points @ axes.map_of(self.axes) if self.axes.any() else points

    def with_middles(self, pieces: int = 1) -> Observation:
        """The same of a body with vertices in the middles of its edges: see `Body`."""
        markers = np.zeros(((pieces + 1) * (len(self.markers) - 1) + 1, 2))
        markers[:: pieces + 1] = self.markers
        return replace(self, markers=markers)

    def angles(self, readings: Floats, begun: Floats | None = None) -> Floats:
        """True joint angles of one trial's servo readings (F, m), in order of time; begun (m,): see `begun`."""
        true = readings + self.zeros
        for joint in np.flatnonzero(self.gaps):
            true[:, joint] = across(true[:, joint], self.gaps[joint], 0.0 if begun is None else begun[joint])[0]
        return true

    def begun(self, readings: Floats, shown: Floats) -> Floats:
        """Where links lie in their joints' gaps when a trial begins (m,) [rad], from the middle: readings (F, m) do not
        say it, markers show joints bent (F, m), NaN hidden."""
        found = np.zeros(len(self.zeros))
        for joint in np.flatnonzero(self.gaps):
            true = readings[:, joint] + self.zeros[joint]
            found[joint] = lying(true, shown[:, joint], self.gaps[joint])
        return found

    def seen(self, body: Body, angles: Floats) -> Floats:
        """Where the markers appear, in the body frame (F, N, 2), of true joint angles."""
        points = shapes(body, angles)
        markers = self._displaced(body, points, *directions(points))
        return views.seen(body, markers, points, self.views) * (1 + self.scale)

    def derivatives(
        self,
        body: Body,
        angles: Floats,
        by_gap: Callable[[int], Floats],
        columns: Sequence[int],
        headings: Floats,
    ) -> Floats:
        """Of `seen` by the given columns (C, F, N, 2); by_gap: of a joint's angle (F,) by its gap; headings (F,): of
        the bodies on the floor, where markers that are not mended by a column move against the chain as much."""
        m, n = body.joint_count, body.vertices
        points = shapes(body, angles)
        along, left = directions(points)
        gaps, ahead, directed, others = (first_columns(body)[mark] for mark in ("gaps", "ahead", "axes", None))
        bent = self._by_angles(body, left, along, {c % gaps for c in columns if c < m or gaps <= c < ahead})
        found = np.zeros((len(columns), len(angles), n, 2))
        for slot, column in enumerate(columns):
            if column < m:
                found[slot] = bent[column]
            elif column < m + 2 * n:
                vertex, side = divmod(column - m, 2)
                found[slot, :, vertex] = (along, left)[side][:, vertex]
            elif column == m + 2 * n:
                found[slot] = self._displaced(body, points, along, left) / (1 + self.scale)
            elif column < ahead:
                joint = column - gaps
                found[slot] = by_gap(joint)[:, None, None] * bent[joint]
            elif column < directed:
                joint, side = divmod(column - ahead, 2)
                vertex = body.joint_vertices[joint]
                found[slot, :, vertex] = (along, left)[side][:, vertex + 1]
            elif column < others:
                found[slot] = self._longer(self._displaced(body, points, along, left), headings, column - directed)
            else:
                found[slot] = views.derivative(body, points, column - others)
        found *= 1 + self.scale
        return found

    def _longer(self, there: Floats, headings: Floats, number: int) -> Floats:
        """By what markers (F, N, 2) in the body frame are farther apart with one number of the axes."""
        more = axes.slope(self.axes, number) @ np.linalg.inv(axes.map_of(self.axes))
        return turn(-headings[:, None], turn(headings[:, None], there) @ more)

    def _displaced(self, body: Body, points: Floats, along: Floats, left: Floats) -> Floats:
        """Markers about the vertices (F, N, 2), before the scale."""
        ahead, aside = (np.repeat(number[:, None], 2, axis=1) for number in self.markers.T)  # arrays as long as points'
        there = points + ahead * along + aside * left
        at = np.array(body.joint_vertices)
        if self.ahead.any():
            there[:, at] += self.ahead[:, :1] * along[:, at + 1] + self.ahead[:, 1:] * left[:, at + 1]
        return there

    def _by_angles(self, body: Body, left: Floats, along: Floats, joints: Iterable[int]) -> dict[int, Floats]:
        """By which points and displaced markers move with each joint's angle (F, N, 2), before the scale."""
        link = link_of_edge(body)
        reached = np.tri(body.vertices, body.vertices - 1, -1)  # edges between vertex 0 and each vertex
        reached = (reached - body.vertex_weights @ reached) * body.edges_m
        at = np.array(body.joint_vertices)
        moved = -self.markers[:, 1:] * along + self.markers[:, :1] * left
        leading = -self.ahead[:, 1:] * along[:, at + 1] + self.ahead[:, :1] * left[:, at + 1]
        displaced = np.any(self.markers) or np.any(self.ahead)
        ahead, moved, leading = (np.ascontiguousarray(x.swapaxes(1, 2)) for x in (left[:, 1:], moved, leading))

        def bent(joint: int) -> Floats:
            turned = (link > joint) - np.mean(link > joint)
            points = ahead @ (reached * turned).T  # (F, 2, N)
            if displaced:
                points += np.concatenate([turned[:1], turned]) * moved
                points[:, :, at] += turned[at] * leading
            return points.swapaxes(1, 2)

        return {joint: bent(joint) for joint in joints}

    def with_column(self, column: int, amount: float) -> Observation:
        """One number changed, in the order of `numbers`; gaps are none below zero."""
        numbers = self.numbers
        numbers[column] += amount
        m, n = len(self.zeros), len(self.markers)
        zeros, markers, scale, gaps, ahead, directed, others = np.split(numbers, np.cumsum(list(sizes(m, n).values())))
        return Observation(
            zeros, markers.reshape(n, 2), np.maximum(gaps, 0.0), ahead.reshape(m, 2), float(scale[0]), others, directed
        )


def directions(points: Floats) -> tuple[Floats, Floats]:
    """Unit vectors along each vertex's edge on the tail side (vertex 0: edge 0) and to its left (F, N, 2)."""
    edge = np.diff(points, axis=1)
    edge /= np.sqrt(edge[..., :1] ** 2 + edge[..., 1:] ** 2)
    edge = np.concatenate([edge[:, :1], edge], axis=1)
    return edge, np.stack([-edge[..., 1], edge[..., 0]], axis=2)


def across(reading: Floats, gap: float, begun: float = 0.0) -> tuple[Floats, Floats]:
    """A link (F,) that follows a reading (F,) across a gap [rad], and its derivative by the gap.

    It stays until the reading has crossed the gap, from where it lies at the beginning: `begun` from the middle, and
    where it touches an end, at that end of a wider one. `simulation.servos.realise` plays the same law (tested to be
    equal), and takes ten times as long, which every diagnosis would pay.
    """
    half, link = gap / 2, float(reading[0]) + begun
    slope = float(np.sign(begun)) / 2 if abs(begun) > half - gap / (PLACES - 1) else 0.0
    links, slopes = [], []
    for angle in reading.tolist():
        if link < angle - half:
            link, slope = angle - half, -0.5
        elif link > angle + half:
            link, slope = angle + half, 0.5
        links.append(link)
        slopes.append(slope)
    return np.array(links), np.array(slopes)


def lying(reading: Floats, shown: Floats, gap: float) -> float:
    """Where a link is expected in its gap at a trial's beginning [rad], from the middle, if anywhere is as likely: by
    angles that markers show (F,), NaN hidden, until the reading (F,) has crossed the gap and nothing tells of it."""
    highest, lowest = np.maximum.accumulate(reading), np.minimum.accumulate(reading)
    crossed = highest - lowest >= gap
    rows = int(crossed.argmax()) if crossed.any() else len(reading)
    begun = np.linspace(-gap / 2, gap / 2, PLACES)
    known = np.flatnonzero(np.isfinite(shown[:rows]))
    if len(known) < 2:
        return 0.0
    links = np.clip(reading[0] + begun, highest[known, None] - gap / 2, lowest[known, None] + gap / 2)
    squares = ((shown[known, None] - links) ** 2).sum(axis=0)
    noise = max(float(squares.min()) / (len(known) - 1), TINY**2)
    likely = np.exp((squares.min() - squares) / (2 * noise))
    return float(likely @ begun / likely.sum())


def values_of(body: Body, now: Observation, name: str, place: int | None) -> list[float]:
    """Parameters of one effect in an observation model."""
    numbers = now.numbers
    return [float(numbers[column]) for column in columns_of(body, name, place)]
