"""Second rung: do markers stand where the servos' shapes put them?

Every frame's chain (joint angles from the servos) is laid rigidly over the markers seen; what is left is white marker
noise, unless a joint's zero, a marker or the length scale is off, or a joint has play behind its servo. The columns of
these effects are derivatives of that chain, with the rigid motions projected out frame by frame.

Legend: F frames (of all trials), N vertices, P columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.evidence import Evidence
from serpenoid.diagnose.geometry import marker_angles, register, shapes, turn
from serpenoid.diagnose.recording import Recording

FRAMES_PER_TRIAL = 250
LEAST_SEEN = 8
ANGLE_FLOOR = 2e-3  # rad: scatter of a smoothed marker angle
LINK_FLOOR = 0.2e-3 * np.sqrt(2) / np.sqrt(11)  # m: of a link's length over eleven frames
STEP = 1e-5
LEAST_PLAY = 5e-3  # rad: a gap that jitter of the readings does not cross; narrower ones are followed as this one is


@dataclass(frozen=True)
class Observation:
    """What lies between the chain and the data; all zero: nothing does.

    zeros (m,) [rad], markers (N, 2) along and left [m], gaps (m,) of joints with play [rad], scale error, clock rate.
    """

    zeros: Floats
    markers: Floats
    gaps: Floats
    scale: float = 0.0
    rate: float = 0.0

    @classmethod
    def neutral(cls, body: Body) -> Observation:
        return cls(np.zeros(body.joint_count), np.zeros((body.vertices, 2)), np.zeros(body.joint_count))

    @property
    def corrects(self) -> bool:
        """Whether shapes are anything else than what servos read, or markers stand elsewhere."""
        return bool(np.any(self.zeros) or np.any(self.markers) or np.any(self.gaps) or self.scale)

    def angles(self, readings: Floats) -> Floats:
        """True joint angles of one trial's servo readings (F, m), in order of time."""
        true = readings + self.zeros
        for joint in np.flatnonzero(self.gaps):
            true[:, joint] = across(true[:, joint], self.gaps[joint])[0]
        return true

    def seen(self, body: Body, angles: Floats) -> Floats:
        """Where the markers appear, in the body frame (F, N, 2), of true joint angles."""
        points = shapes(body, angles)
        edge = np.diff(points, axis=1)
        edge = edge / np.linalg.norm(edge, axis=2, keepdims=True)
        edge = np.concatenate([edge[:, :1], edge], axis=1)  # the edge on the tail side; vertex 0: edge 0
        sideways = np.stack([-edge[..., 1], edge[..., 0]], axis=2)
        moved = points + self.markers[:, :1] * edge + self.markers[:, 1:] * sideways
        return np.asarray(moved * (1 + self.scale))

    def with_column(self, column: int, amount: float) -> Observation:
        """One number changed: zeros, then markers (along, left by vertex), scale, then gaps (none below zero)."""
        zeros, markers, gaps = self.zeros.copy(), self.markers.copy(), self.gaps.copy()
        m, n = len(zeros), len(markers)
        if column < m:
            zeros[column] += amount
        elif column < m + 2 * n:
            markers[(column - m) // 2, (column - m) % 2] += amount
        elif column == m + 2 * n:
            return replace(self, scale=self.scale + amount)
        else:
            gap = column - m - 2 * n - 1
            gaps[gap] = max(gaps[gap] + amount, 0.0)
        return replace(self, zeros=zeros, markers=markers, gaps=gaps)


def across(reading: Floats, gap: float) -> tuple[Floats, Floats]:
    """A link (F,) that follows a reading (F,) across a gap [rad], and its derivative by the gap.

    It stays until the reading has crossed the gap, from the middle at the beginning. `simulation.servos.realise` plays
    the same law of `loose_joint` (tested to be equal), and takes ten times as long, which every diagnosis would pay.
    """
    half, link, slope = gap / 2, float(reading[0]), 0.0
    links, slopes = [], []
    for angle in reading.tolist():
        if link < angle - half:
            link, slope = angle - half, -0.5
        elif link > angle + half:
            link, slope = angle + half, 0.5
        links.append(link)
        slopes.append(slope)
    return np.array(links), np.array(slopes)


def columns_of(body: Body, name: str, place: int | None) -> list[int]:
    """Column numbers of an observation effect (or of what servos do not read: `zero_offset`, `loose_joint`)."""
    m, n = body.joint_count, body.vertices
    if name == "zero_offset":
        return [int(place or 1) - 1]
    if name == "marker_offset":
        return [m + 2 * int(place or 0), m + 2 * int(place or 0) + 1]
    if name == "loose_joint":
        return [m + 2 * n + int(place or 1)]
    return [m + 2 * n]


@dataclass(frozen=True)
class Sample:
    """Frames of all trials, thinned: markers (F, N, 2), readings (F, m), labels (F,) of gaits, noise [m].

    trials: all readings of each trial (frames, m), and which of them were taken.
    """

    body: Body
    markers: Floats
    readings: Floats
    labels: np.ndarray
    noise: float
    trials: tuple[tuple[Floats, np.ndarray], ...]

    def angles(self, now: Observation) -> Floats:
        """True joint angles (F, m)."""
        if not now.gaps.any():
            return self.readings + now.zeros
        return np.concatenate([now.angles(readings)[taken] for readings, taken in self.trials])

    def by_gap(self, now: Observation, joint: int) -> Floats:
        """What a joint's angle (F,) changes by with its gap."""
        gap = float(now.gaps[joint])
        return self._narrow[:, joint] if gap <= LEAST_PLAY else self._following(joint, gap)

    @cached_property
    def _narrow(self) -> Floats:
        return np.stack([self._following(j, LEAST_PLAY) for j in range(self.body.joint_count)], axis=1)

    def _following(self, joint: int, gap: float) -> Floats:
        return np.concatenate([across(readings[:, joint], gap)[1][taken] for readings, taken in self.trials])


def sample(recordings: Sequence[Recording]) -> Sample:
    """Thin the recordings; the noise comes from neighbouring frames."""
    body = recordings[0].body
    markers, readings, labels, squares, trials = [], [], [], [], []
    gaits = {name: i for i, name in enumerate(dict.fromkeys(r.gait for r in recordings))}
    for r in recordings:
        inside = np.flatnonzero((np.isfinite(r.markers[..., 0]).sum(axis=1) >= LEAST_SEEN) & (r.time < r.end))
        some = inside[:: max(len(inside) // FRAMES_PER_TRIAL, 1)]
        markers.append(r.markers[some])
        readings.append(r.angles[some])
        trials.append((r.angles, some))
        labels.append(np.full(len(some), gaits[r.gait]))
        left = register(shapes(body, r.angles), r.markers)[1]
        squares.append(np.nanmedian(np.abs(np.diff(left, axis=0))))
    noise = 1.4826 * float(np.median(squares)) / np.sqrt(2) * np.sqrt(24 / 21)
    return Sample(
        body, np.concatenate(markers), np.concatenate(readings), np.concatenate(labels), noise, tuple(trials)
    )  # fmt: skip


def evidence(data: Sample, now: Observation) -> Evidence:
    """Residuals and columns of the sample at an observation model, in units of marker noise."""
    body = data.body
    (first_gap,) = columns_of(body, "loose_joint", 1)
    count = first_gap + body.joint_count
    angles = data.angles(now)
    base = now.seen(body, angles)
    pose, left = register(base, data.markers)
    seen = np.isfinite(data.markers[..., 0])[..., None]
    residual = np.where(seen, turn(-pose[:, None, 2], np.where(seen, left, 0.0)), 0.0)
    columns = np.empty((count, *residual.shape))
    for c in range(count):
        moved, bent = now, angles.copy()
        if c < body.joint_count:
            bent[:, c] += STEP
        elif c < first_gap:
            moved = now.with_column(c, STEP)
        else:
            bent[:, c - first_gap] += STEP * data.by_gap(now, c - first_gap)
        columns[c] = np.where(seen, (moved.seen(body, bent) - base) / STEP, 0.0)
    basis = _rigid(base, seen)
    flat = columns.reshape(count, len(base), -1)
    inside = np.einsum("fri,cfi->cfr", basis, flat)
    flat = flat - np.einsum("fri,cfr->cfi", basis, inside)
    rows = residual.reshape(len(base), -1) / data.noise
    matrices, vectors, constants, counts = [], [], [], []
    for gait in np.unique(data.labels):
        mine = data.labels == gait
        x = flat[:, mine].reshape(count, -1) / data.noise
        r = rows[mine].ravel()
        matrices.append(x @ x.T)
        vectors.append(x @ r)
        constants.append(r @ r)
        counts.append(2.0 * seen[mine].sum() - 3 * mine.sum())
    return Evidence(np.stack(matrices), np.stack(vectors), np.array(constants), np.array(counts))


def _rigid(points: Floats, seen: np.ndarray) -> Floats:
    """Orthonormal rigid motions of the visible points, (F, 3, 2 N)."""
    one, zero = np.ones(points.shape[:2]), np.zeros(points.shape[:2])
    motions = [np.stack(x, axis=2) for x in ((one, zero), (zero, one), (-points[..., 1], points[..., 0]))]
    stacked = np.stack([np.where(seen, m, 0.0).reshape(len(points), -1) for m in motions], axis=2)
    return np.swapaxes(np.linalg.qr(stacked)[0], 1, 2)


def signature(data: Sample, effect: Observation) -> Floats:
    """RMS of what an observation model changes: marker angles over readings and link lengths, in floors (2 m + 1,)."""
    return np.sqrt((_shown(data, effect) ** 2).mean(axis=0))


def apart(data: Sample, one: Observation, other: Observation) -> float:
    """How far two observation models' data differ: the worst joint's or link's RMS, in floors."""
    return float(np.sqrt(((_shown(data, one) - _shown(data, other)) ** 2).mean(axis=0)).max())


def _shown(data: Sample, effect: Observation) -> Floats:
    """Marker angles minus readings, and link lengths minus known ones, in floors (F, 2 m + 1)."""
    body = data.body
    seen = effect.seen(body, data.angles(effect))
    angle = marker_angles(body, seen) - data.readings
    length = np.linalg.norm(np.diff(seen, axis=1), axis=2) - body.edges_m
    return np.concatenate([angle / ANGLE_FLOOR, length / LINK_FLOOR], axis=1)
