"""What is otherwise than in an earlier campaign, whatever the model: joint angles and paths of the same gaits.

Trials of one setting are compared boundary by boundary of their windows, each path from its own first pose. So are
repeats within the earlier campaign, in which nothing has changed, or within the later one where that has none. Nothing
is fitted and nothing is judged: a change that no effect explains is here, too.

Legend: B boundaries, m joints.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.repeats import by_setting
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.reference import Reference
from serpenoid.group import relative


@dataclass(frozen=True)
class Apart:
    """Sums over the boundaries of some pairs of trials: of squares of differences of joint angles (m,) [rad^2] and how
    many; of squared distances between paths [m^2] and how many."""

    angles: Floats
    read: int
    paths: float
    seen: int

    @classmethod
    def of(cls, pairs: Iterable[tuple[Track, Track]], joints: int) -> Apart:
        """Of all pairs."""
        angles, read, paths, seen = np.zeros(joints), 0, 0.0, 0
        for one, other in pairs:
            turned, away = _angles_apart(one, other), _paths_apart(one, other)
            angles, read = angles + (turned**2).sum(axis=0), read + len(turned)
            paths, seen = paths + float((away**2).sum()), seen + len(away)
        return cls(angles, read, paths, seen)

    @classmethod
    def together(cls, parts: Sequence[Apart]) -> Apart:
        """Of the pairs of several, one at least."""
        return cls(*(sum(each) for each in zip(*((p.angles, p.read, p.paths, p.seen) for p in parts), strict=True)))

    @property
    def joints_rad(self) -> Floats | None:
        """RMS (m,), None where nothing was compared."""
        return np.asarray(np.sqrt(self.angles / self.read)) if self.read else None

    @property
    def path_m(self) -> float | None:
        """RMS, None where nothing was compared."""
        return float(np.sqrt(self.paths / self.seen)) if self.seen else None


def since_reference(d: Diagnosis) -> dict[str, Any] | None:
    """What `apart` says of a diagnosis beside a reference."""
    return apart(d.motion.selection.motion.tracks, d.baseline.tracks) if isinstance(d.baseline, Reference) else None


def apart(now: Sequence[Track], then: Sequence[Track]) -> dict[str, Any] | None:
    """RMS differences from the earlier trials of the same settings [m, rad], and those of repeats (null: nothing was
    played twice); None where no setting is in both."""
    before, after = by_setting(then), by_setting(now)
    both = [s for s in after if s in before]
    if not both:
        return None
    joints = now[0].recording.body.joint_count
    across = [Apart.of([(now[a], then[b]) for a, b in product(after[s], before[s])], joints) for s in both]
    again = [Apart.of(_repeats(then, before[s]) or _repeats(now, after[s]), joints) for s in both]
    gaits = [
        {"gait": gait, "cycle_duration_s": cycle_s, "path_m": changed.path_m, "repeats_m": repeated.path_m}
        for (gait, cycle_s), changed, repeated in zip(both, across, again, strict=True)
    ]
    changed, repeated = Apart.together(across), Apart.together(again)
    turned, chance = changed.joints_rad, repeated.joints_rad
    return {
        "path_m": changed.path_m, "repeats_m": repeated.path_m, "gaits": gaits,
        "joints_rad": None if turned is None else turned.tolist(),
        "joints_repeats_rad": None if chance is None else chance.tolist(),
    }  # fmt: skip


def _repeats(tracks: Sequence[Track], some: Sequence[int]) -> list[tuple[Track, Track]]:
    return [(tracks[a], tracks[b]) for a, b in combinations(some, 2)]


def _angles_apart(one: Track, other: Track) -> Floats:
    """Differences (B, m) [rad] of joint angles at the boundaries of both."""
    angles = [r.angles_at(t.time[t.boundaries]) for t in (one, other) if isinstance(r := t.recording, Recording)]
    count = min(map(len, angles), default=0)
    return np.asarray(angles[0][:count] - angles[1][:count])


def _paths_apart(one: Track, other: Track) -> Floats:
    """Distances (B,) [m] between paths that are laid over each other at the first boundary at which both are seen."""
    count = min(len(one.measured), len(other.measured))
    seen = np.isfinite(one.measured[:count, 0]) & np.isfinite(other.measured[:count, 0])
    if seen.sum() < 2:
        return np.zeros(0)
    a, b = (relative(poses[seen][:1], poses[seen][1:]) for poses in (one.measured[:count], other.measured[:count]))
    return np.hypot(*(a - b)[:, :2].T)
