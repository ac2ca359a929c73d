"""Residuals from command to motion, stage by stage: the error, the noise level, and what chance cannot explain.

    share above noise = 1 - (noise level / error)^2        (of the mean square error; 0 where the error is below)

    actuation     commanded against realised shape [rad]; noise level: scatter of the readings about local parabolas
    observation   realised shape against markers [m]; noise level: scatter of markers between neighbouring frames
    motion        realised shape against realised motion [m]; noise level: F, what repeats' residuals add up to
    whole         command against realised motion [m]; noise level: F

Every repeat is predicted from readings of its own, so F holds the noise of shapes, propagated, beside that of motion.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.paths import total
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import register
from serpenoid.diagnose.data.used import length_unit
from serpenoid.diagnose.inference.fits.finding import Stage
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.motion.choose_motion import MotionFinding
from serpenoid.diagnose.stages.observation.marker_evidence import sample
from serpenoid.diagnose.stages.whole import whole_errors


@dataclass(frozen=True)
class Error:
    """RMS of a misfit before and after the named effects, and its noise level, all in `unit`; doubt: what of the noise
    level is no noise, but how far any change may move what a reference's servos missed."""

    name: str
    unit: str
    before: float
    after: float
    noise_level: float
    doubt: float = 0.0

    def share_above(self, error: float) -> float:
        """Share of a mean square error that noise does not explain."""
        return max(0.0, 1 - (self.noise_level / error) ** 2) if error > 0 else 0.0

    def record(self) -> dict[str, Any]:
        """As it stands in diagnosis.json."""
        return {
            "name": self.name, "unit": self.unit, "before": self.before, "after": self.after,
            "noise_level": self.noise_level, "doubt": self.doubt,
            "share_above_noise_before": self.share_above(self.before),
            "share_above_noise_after": self.share_above(self.after),
        }  # fmt: skip


@dataclass(frozen=True)
class Step:
    """One stage of the ladder: what is compared, the error as a whole, and its parts (joints, markers, directions)."""

    compares: str
    error: Error
    parts: tuple[Error, ...]

    def record(self) -> dict[str, Any]:
        """As it stands in diagnosis.json."""
        stage = self.error.record()
        return {
            "stage": stage.pop("name"),
            "compares": self.compares,
            **stage,
            "parts": [p.record() for p in self.parts],
        }


Climbed = Callable[[Sequence[Step]], None]  # hears the steps from command to markers, before the motion is judged


def shape_steps(
    servos: Plays, recordings: Sequence[Recording], actuation: Stage, observation: Stage, seen: Observation
) -> tuple[Step, ...]:
    """From command to markers, as far as that was judged."""
    first = actuation_step(servos, actuation)
    return (first,) if observation.skipped else (first, observation_step(recordings, seen))


def motion_steps(
    servos: Plays, recordings: Sequence[Recording], stages: Sequence[Stage], seen: Observation, motion: MotionFinding
) -> tuple[Step, ...]:
    """From shape to motion, and the whole: all stages' named effects of servos are in it."""
    actuators = tuple(e for stage in stages for e in stage.acting if e.effect.site == "actuation")
    gone = tuple(e for stage in stages for e in stage.gone)
    before, after = whole_errors(recordings, seen, motion, servos.known, actuators, gone)
    whole = Error("whole", "m", before, after, motion.selection.noise_level_m)
    return motion_step(motion), Step("commanded shape against realised motion", whole, ())


def actuation_step(data: Plays, stage: Stage) -> Step:
    """Joint by joint [rad]."""
    sizes = [data.channels(data.realised(effects)) * data.noise for effects in (stage.gone, stage.acting)]
    doubt = np.broadcast_to(data.unsure, data.held_against.shape)
    parts = [
        Error(f"joint {j + 1}", "rad", float(a), float(b), float(data.held_against[j]), float(doubt[j]))
        for j, (a, b) in enumerate(zip(*sizes, strict=True))
    ]
    whole = Error("actuation", "rad", *(total(each) for each in (*sizes, data.held_against, doubt)))
    return Step("commanded against realised shape", whole, tuple(parts))


def observation_step(recordings: Sequence[Recording], seen: Observation) -> Step:
    """Marker by marker [m]: RMS of a coordinate, the chain laid rigidly over the markers seen."""
    data = sample(recordings)
    ever = data.seen.any(axis=(0, 2))
    sizes = []
    for now in (Observation.neutral(data.body), seen):
        _, left = register(now.seen(data.body, data.angles(now)), now.unstretched(data.markers))
        freedom = 1 - 3 / np.isfinite(left).sum(axis=(1, 2)).mean()  # three numbers of each frame are fitted
        sizes.append(np.sqrt(np.nanmean(left[:, ever] ** 2, axis=(0, 2)) / freedom))
    parts = [
        Error(f"vertex {k}", "m", float(a), float(b), data.noise)
        for k, a, b in zip(np.flatnonzero(ever), *sizes, strict=True)
    ]
    whole = Error("observation", "m", total(list(sizes[0])), total(list(sizes[1])), data.noise)
    return Step("realised shape against markers", whole, tuple(parts))


def motion_step(motion: MotionFinding) -> Step:
    """Path, and displacement of a window by direction [length, length, rad]."""
    found = motion.selection
    sizes = [_rms(residuals(found.motion.tracks, fit.predictions)) for fit in (found.null, found.best)]
    noise = _rms([found.motion.noise.of(t)[t.usable] for t in found.motion.tracks])
    length = length_unit(found.motion.tracks)
    names = (("forward", length), ("to the left", length), ("turn", "rad"))
    parts = [
        Error(f"{name}, per window", unit, *(float(x[i]) for x in (*sizes, noise)))
        for i, (name, unit) in enumerate(names)
    ]
    whole = Error("motion", length, motion.before_m, motion.after_m, found.noise_level_m)
    return Step("realised shape against realised motion", whole, tuple(parts))


def _rms(rows: Sequence[Floats]) -> Floats:
    return np.asarray(np.sqrt(np.nanmean(np.concatenate(rows) ** 2, axis=0)))
