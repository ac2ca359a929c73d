"""A camera whose scale is another along x than along y, or whose axes are not square.

    seen = (1 + E) true,    E = t + a (1 0, 0 -1) + b (0 1, 1 0)        (b: shear; a turn of all changes no distance)

A link of heading phi looks longer by t + a cos 2 phi + b sin 2 phi, as a share; joints seem bent otherwise, and paths
are stretched as links are. t is the scale of all, which no direction tells. a and b are told by links that turn.

Legend: F frames, N vertices.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, floor

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import NORMAL
from serpenoid.diagnose.data.geometry import placed, register
from serpenoid.diagnose.data.observation import Observation
from serpenoid.diagnose.stages.marker_evidence import Sample
from serpenoid.measure.links import marker_angles

NUMBERS = 3  # t, a, b
BASE = np.array([[[1.0, 0.0], [0.0, 1.0]], [[1.0, 0.0], [0.0, -1.0]], [[0.0, 1.0], [1.0, 0.0]]])


@dataclass(frozen=True)
class Stretch:
    """t, a, b (3,), and standard errors of a and b (2,)."""

    numbers: Floats
    errors: Floats

    @property
    def directed(self) -> Floats:
        """Without what is alike in all directions."""
        return np.array([0.0, *self.numbers[1:]])

    @property
    def longer(self) -> float:
        """By which share the direction of the longest is longer than the one across."""
        return 2 * float(np.hypot(*self.numbers[1:]))

    @property
    def turned(self) -> float:
        """That direction, from x towards y [degrees], -90 .. 90."""
        return float(np.degrees(np.arctan2(self.numbers[2], self.numbers[1]) / 2))

    @property
    def words(self) -> str:
        """How much longer along which direction."""
        half = 2 * NORMAL * float(self.errors.max())
        unsure = max(np.degrees(half / max(self.longer, half) / 2), 0.5)  # it is said to a degree
        along, across = f"at {self.turned:.0f} degrees from x towards y", "across"
        if abs(self.turned) <= unsure:
            along, across = "along x", "along y"
        elif 90 - abs(self.turned) <= unsure:
            along, across = "along y", "along x"
        low = floor(1e4 * max(self.longer - half, 0.0)) / 100  # as two digits hold it
        high = ceil(1e4 * (self.longer + half)) / 100
        return f"{100 * self.longer:.2f} % (95 %: {low:.2f} .. {high:.2f}) longer {along} than {across}"


def unstretched(data: Sample, numbers: Floats) -> Sample:
    """The sample as a camera would see it that is not stretched."""
    back = np.linalg.inv(np.eye(2) + _matrix(numbers))
    return replace(data, markers=data.markers @ back)


def shown_by(data: Sample, now: Observation, numbers: Floats) -> Floats:
    """Mean squares of what t, a and b do to bends and lengths, in units of noise (m + N - 1,)."""
    there = _there(data, now)
    seen = there + there @ _matrix(numbers)
    angle = np.mod(marker_angles(data.body, seen) - marker_angles(data.body, there) + np.pi, 2 * np.pi) - np.pi
    longer = np.linalg.norm(np.diff(seen, axis=1), axis=2) - np.linalg.norm(np.diff(there, axis=1), axis=2)
    return np.asarray(((np.concatenate([angle, longer], axis=1) / data.levels) ** 2).mean(axis=0))


def strength(data: Sample, now: Observation, stretch: Stretch) -> tuple[float, float]:
    """What a and b do over the noise level: RMS of the worst channel of bends and lengths, and of paths of trials."""
    ends = np.cumsum([len(taken) for *_, taken in data.trials])
    middle = _there(data, now).mean(axis=1)
    paths = (middle[ends - 1] - middle[np.concatenate([[0], ends[:-1]])]) @ _matrix(stretch.directed)
    level = data.levels[-1] / np.sqrt(data.body.vertices)
    by_path = np.sqrt((paths**2).sum(axis=1).mean()) / level
    return float(np.sqrt(shown_by(data, now, stretch.directed).max())), float(by_path)


def _matrix(numbers: Floats) -> Floats:
    return np.asarray(np.tensordot(numbers, BASE, axes=1))


def _there(data: Sample, now: Observation) -> Floats:
    """Markers (F, N, 2) as an observation model puts them on the floor."""
    points = now.seen(data.body, data.angles(now))
    return placed(points, register(points, data.markers)[0])
