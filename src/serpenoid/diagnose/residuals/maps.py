"""Where and when the motion's residuals are: along the phase, against speed and time, along the body, on the floor.

Residual velocity of a window: (measured - predicted displacement) / duration, in the frame of its first pose. That of
a vertex is the rigid motion's, r + omega x c, split along and across the body there. Marker noise enters both alike.

Legend: W usable windows of all trials, N vertices.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.shapes.geometry import placed, turn
from serpenoid.diagnose.data.used import length_unit
from serpenoid.diagnose.data.windows.windows import Prediction, Track

SPEEDS, TIMES = 8, 6  # bins
MOST_PHASES = 16
ACROSS, LEAST_VISITS = 20, 8  # squares of the floor, at most, along its longer side; vertices on one, at least


@dataclass(frozen=True)
class Windows:
    """Residual velocities before and after (W, 3) [m/s, m/s, rad/s], their noise (W, 3), and where and when.

    phase (W,): in cycles, 1 in pauses; time (W,) [s since t0]; speed (W,): RMS over the vertices [m/s]; frame (W, 3):
    first pose on the floor [m, m, rad], however cameras show it; points (W, N, 2) [m] in that frame and tangent (W, N)
    [rad] of the body there.
    length_unit: what stands here for m.
    """

    before: Floats
    after: Floats
    noise: Floats
    phase: Floats
    time: Floats
    speed: Floats
    frame: Floats
    points: Floats
    tangent: Floats
    length_unit: str = "m"

    @property
    def playing(self) -> np.ndarray:
        """(W,)."""
        return self.phase < 1

    @property
    def vertices(self) -> Floats:
        """Where the vertices are on the floor (W, N, 2) [m]."""
        return np.asarray(self.frame[:, None, :2] + turn(self.frame[:, None, 2], self.points))

    def at_vertices(self, residual: Floats) -> Floats:
        """Residual velocities (W, N, 2) [m/s] of the vertices, in the windows' frames."""
        c = self.points
        spin = residual[:, 2, None, None] * np.stack([-c[..., 1], c[..., 0]], axis=-1)
        return np.asarray(residual[:, None, :2] + spin)

    def along_body(self, residual: Floats) -> Floats:
        """RMS over the windows of play of each vertex's residual velocity (N, 2): along the body, across it."""
        own = turn(-self.tangent, self.at_vertices(residual))
        return np.asarray(np.sqrt((own[self.playing] ** 2).mean(axis=0)))

    def noise_at_vertices(self) -> Floats:
        """SD of residual velocities along the body and across it (W, N, 2) that the windows' noise makes."""
        c, s = np.cos(self.tangent)[..., None], np.sin(self.tangent)[..., None]
        x, y = self.points[..., :1], self.points[..., 1:]
        rows = np.concatenate([c, s, s * x - c * y], axis=-1), np.concatenate([-s, c, c * x + s * y], axis=-1)
        return np.sqrt(np.stack([((r * self.noise[:, None]) ** 2).sum(axis=-1) for r in rows], axis=-1))

    def noise_along_body(self) -> Floats:
        """What chance alone makes of `along_body` (N, 2)."""
        return np.asarray(np.sqrt((self.noise_at_vertices()[self.playing] ** 2).mean(axis=0)))


def windows(motion: Motion, before: Sequence[Prediction], after: Sequence[Prediction]) -> Windows:
    """All usable windows of all trials."""
    parts = [
        _of_track(track, motion.noise.of(track), one, two)
        for track, one, two in zip(motion.tracks, before, after, strict=True)
    ]
    columns: list[Any] = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return Windows(*[*columns, length_unit(motion.tracks)])


def _of_track(track: Track, noise: Floats, before: Prediction, after: Prediction) -> tuple[Floats, ...]:
    first, last = track.boundaries[:-1], track.boundaries[1:]
    duration, middle = track.duration[:, None], (first + last) // 2
    poses = track.on_floor
    world = placed(track.vertices, poses)
    speed = np.gradient(world, track.time, axis=0)
    size = np.sqrt((speed**2).sum(axis=2).mean(axis=1))
    pace = np.array([size[a:b].mean() for a, b in zip(first, last, strict=True)])
    points = turn(-poses[first, None, 2], world[middle] - poses[first, None, :2])
    edge = np.gradient(points, axis=1)
    columns = (
        *((track.displacement - p.displacement) / duration for p in (before, after)), noise / duration, track.phase,
        (track.time[first] + track.time[last]) / 2, pace,
        poses[first], points, np.arctan2(edge[..., 1], edge[..., 0]),
    )  # fmt: skip
    good = track.usable & np.isfinite(columns[0]).all(axis=1) & np.isfinite(columns[1]).all(axis=1)
    return tuple(c[good] for c in columns)


@dataclass(frozen=True)
class Bin:
    """Windows together: ends, number, mean residual velocity before and after (3,), noise of one window (3,)."""

    low: float
    high: float
    count: int
    before: Floats
    after: Floats
    noise: Floats

    @property
    def middle(self) -> float:
        return (self.low + self.high) / 2


def binned(w: Windows, values: Floats, edges: Floats) -> list[Bin]:
    """Bins [edge, next edge) of `values` (W,), the last one closed, empty ones left out."""
    found = []
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        mine = (values >= low) & ((values < high) | (high == edges[-1]))
        if mine.any():
            noise = np.sqrt((w.noise[mine] ** 2).mean(axis=0))
            means = w.before[mine].mean(axis=0), w.after[mine].mean(axis=0)
            found.append(Bin(float(low), float(high), int(mine.sum()), *means, noise))
    return found


def by_phase(w: Windows) -> list[Bin]:
    """Every window of the cycle (where they are alike in all trials), then the pauses at phase 1."""
    count = min(len(np.unique(w.phase[w.playing])), MOST_PHASES)
    return binned(w, w.phase, np.append(np.arange(count + 1) / count, 1 + 0.5 / count))


def by_speed(w: Windows) -> list[Bin]:
    """Equally many windows in each bin."""
    return binned(w, w.speed, np.quantile(w.speed, np.linspace(0, 1, SPEEDS + 1)))


def by_time(w: Windows) -> list[Bin]:
    """Equally long bins."""
    return binned(w, w.time, np.linspace(0, w.time.max(), TIMES + 1))


@dataclass(frozen=True)
class Cell:
    """Vertices on a square of the floor: its middle [m], how many; residual velocity [m/s]: mean (2,), RMS, noise."""

    x: float
    y: float
    count: int
    mean: Floats
    rms: float
    noise: float


def cell_side(w: Windows) -> float:
    """Side of a square [m]: the least of 1, 2, 5 times a power of ten of which ACROSS span the visited floor."""
    extent = float(np.ptp(w.vertices.reshape(-1, 2), axis=0).max())
    decade = 10.0 ** np.floor(np.log10(extent / ACROSS))
    return float(next(k * decade for k in (1, 2, 5, 10) if k * decade * ACROSS >= extent * (1 - 1e-12)))


def on_floor(w: Windows, residual: Floats) -> list[Cell]:
    """Residual velocities along the floor's axes, of the vertices on each square that enough of them visited."""
    moved = turn(w.frame[:, None, 2], w.at_vertices(residual)).reshape(-1, 2)
    chance = (w.noise_at_vertices() ** 2).sum(axis=2).ravel()
    side = cell_side(w)
    cells = np.floor(w.vertices.reshape(-1, 2) / side).astype(int)
    found = []
    for cell in np.unique(cells, axis=0):
        mine = (cells == cell).all(axis=1)
        if mine.sum() >= LEAST_VISITS:
            x, y = (cell + 0.5) * side
            rms = float(np.sqrt((moved[mine] ** 2).sum(axis=1).mean()))
            noise = float(np.sqrt(chance[mine].mean()))
            found.append(Cell(float(x), float(y), int(mine.sum()), moved[mine].mean(axis=0), rms, noise))
    return found


def residual_maps(motion: Motion, before: Sequence[Prediction], after: Sequence[Prediction]) -> dict[str, Any]:
    """Means for diagnosis.json: velocities forward, to the left [m/s], turning left [rad/s]."""
    w = windows(motion, before, after)
    body = np.stack([w.along_body(w.before), w.along_body(w.after), w.noise_along_body()])
    length, speed = w.length_unit, f"{w.length_unit}/s"
    return {
        "units": {"velocity": [speed, speed, "rad/s"], "phase": "cycles", "speed": speed, "time": "s", "floor": length},
        "along_phase": [_record(b, "phase") for b in by_phase(w)],
        "against_speed": [_record(b, "speed") for b in by_speed(w)],
        "against_time": [_record(b, "time") for b in by_time(w)],
        "along_body": [
            {"vertex": k, "before_rms": a, "after_rms": b, "noise_level": c}
            for k, (a, b, c) in enumerate(body.transpose(1, 0, 2).tolist())
        ],
        "on_floor": {
            name: [_square(c) for c in on_floor(w, r)] for name, r in (("before", w.before), ("after", w.after))
        },
    }


def _record(b: Bin, name: str) -> dict[str, Any]:
    means = {"before": b.before.tolist(), "after": b.after.tolist(), "noise_of_one": b.noise.tolist()}
    return {name: [b.low, b.high], "windows": b.count, **means}


def _square(c: Cell) -> dict[str, Any]:
    return {"x": c.x, "y": c.y, "vertices": c.count, "mean": c.mean.tolist(), "rms": c.rms, "noise": c.noise}
