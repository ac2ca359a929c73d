"""Second rung: do markers stand where the servos' shapes put them?

Every frame's chain (joint angles from the servos) is laid rigidly over the markers seen; what is left is white marker
noise, unless a joint's zero, a marker or the length scale is off, or a joint has play behind its servo. The columns of
these effects are derivatives of that chain, with the rigid motions projected out frame by frame.

Legend: F frames (of all trials), N vertices, C columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.evidence import Evidence
from serpenoid.diagnose.geometry import register, shapes, turn
from serpenoid.diagnose.observation import Observation, across, columns_of
from serpenoid.diagnose.recording import Recording
from serpenoid.measure.chain import marker_angles

FRAMES_PER_TRIAL = 250
LEAST_SEEN = 8
ANGLE_FLOOR = 2e-3  # rad: scatter of a smoothed marker angle
LINK_FLOOR = 0.2e-3 * np.sqrt(2) / np.sqrt(11)  # m: of a link's length over eleven frames
LEAST_PLAY = 5e-3  # rad: a gap that jitter of the readings does not cross; narrower ones are followed as this one is


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

    @cached_property
    def seen(self) -> np.ndarray:
        """Whether a marker was (F, N, 1)."""
        return np.isfinite(self.markers[..., 0])[..., None]

    @cached_property
    def gaits(self) -> list[np.ndarray]:
        """The frames of each gait, as flags (F,)."""
        return [self.labels == gait for gait in np.unique(self.labels)]

    @cached_property
    def counts(self) -> Floats:
        """Degrees of freedom of each gait: coordinates seen, less the frames' poses."""
        return np.array([2.0 * self.seen[mine].sum() - 3 * mine.sum() for mine in self.gaits])

    @property
    def count(self) -> float:
        """Of all gaits."""
        return float(self.counts.sum())

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


def misfit(data: Sample, now: Observation) -> float:
    """Chi squared of the sample at an observation model."""
    return float((_left_by(data, now, data.angles(now))[1] ** 2).sum())


def evidence(data: Sample, now: Observation, columns: Sequence[int] | None = None) -> Evidence:
    """Residuals and columns (all, or those given) of the sample at an observation model, in units of marker noise."""
    body, seen = data.body, data.seen
    chosen = range(columns_of(body, "loose_joint", body.joint_count)[0] + 1) if columns is None else columns
    angles = data.angles(now)
    base, rows = _left_by(data, now, angles)
    slopes = now.derivatives(body, angles, lambda joint: data.by_gap(now, joint), chosen)
    flat = np.where(seen, slopes, 0.0).reshape(len(chosen), *rows.shape) / data.noise
    rigid = _rigid(base, seen) @ np.moveaxis(flat, 0, -1)  # (F, 3, C): taken away below, frame by frame
    matrices, vectors, constants = [], [], []
    for mine in data.gaits:
        x, inside, r = flat[:, mine].reshape(len(chosen), -1), rigid[mine].reshape(-1, len(chosen)), rows[mine].ravel()
        matrices.append(x @ x.T - inside.T @ inside)
        vectors.append(x @ r)
        constants.append(r @ r)
    return Evidence(np.stack(matrices), np.stack(vectors), np.array(constants), data.counts)


def _left_by(data: Sample, now: Observation, angles: Floats) -> tuple[Floats, Floats]:
    """Chains (F, N, 2) in the body frame, and what they leave of the markers there (F, 2 N), in units of noise."""
    base = now.seen(data.body, angles)
    pose, left = register(base, data.markers)
    residual = np.where(data.seen, turn(-pose[:, None, 2], np.where(data.seen, left, 0.0)), 0.0)
    return base, residual.reshape(len(base), -1) / data.noise


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
