"""What markers show of a joint beyond what its servo reads, trial by trial, and how much of it lasts.

Legend: F frames, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.smooth import AVERAGED_S
from serpenoid.diagnose.stages.observation.marker_evidence import angle_leverage, shown_otherwise
from serpenoid.measure.shapes.links import marker_angles


@dataclass(frozen=True)
class OfJoint:
    """At frames (F,) that show it [rad], and what was read there; frames: which of the trial's they are."""

    shown: Floats
    read: Floats
    frames: np.ndarray


@dataclass(frozen=True)
class Beyond:
    """Of all joints in one trial, on every frame (F, m) [rad]: angles that an observation model says, and what markers
    show beyond them, NaN hidden."""

    recording: Recording
    told: Floats
    shown: Floats

    def at(self, joint: int) -> OfJoint:
        """Of one joint (from 0), where it is shown while the trial is played."""
        r, shown = self.recording, self.shown[:, joint]
        known = np.flatnonzero(np.isfinite(shown) & (r.time > 0) & (r.time < r.end))
        return OfJoint(shown[known], self.told[known, joint], known)


def beyond(r: Recording, seen: Observation) -> Beyond:
    """Of a trial, beside an observation model."""
    told = seen.angles(r.angles, seen.begun(r.angles, marker_angles(r.body, seen.unstretched(r.markers))))
    return Beyond(r, told, shown_otherwise(r.body, r.markers, told, seen)[:, : told.shape[1]])


def lasting(parts: Sequence[Floats], trials: Sequence[OfJoint]) -> float:
    """Mean product of numbers (F,) of each trial and those of the frame before: their mean square, without white
    noise."""
    products = [(x[1:] * x[:-1])[np.diff(t.frames) == 1] for x, t in zip(parts, trials, strict=True)]
    return float(np.concatenate(products).mean()) if any(len(p) for p in products) else 0.0


def noise_level(trials: Sequence[Beyond], joint: int) -> float:
    """Of a joint's angle [rad] as averaged markers show it: what lasts and is smaller is not seen."""
    every = [t.recording for t in trials]
    levels = [r.marker_noise * angle_leverage(r.body)[joint] / np.sqrt(max(AVERAGED_S / r.frame_s, 1.0)) for r in every]
    return float(np.median(levels))
