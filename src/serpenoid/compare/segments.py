"""A trial's passages as segments for the likelihood: the recording's own rows, between long gaps and jumps."""

from __future__ import annotations

import numpy as np

from serpenoid.compare.likelihood import Segment
from serpenoid.errors import InputError
from serpenoid.measure.cells import clock
from serpenoid.measure.trial import Motion, Trial
from serpenoid.measure.usage import whole_pieces
from serpenoid.simulation.steps import SUSPICIOUS_TURN
from serpenoid.wording import percent

UNRESOLVED = (
    0.5  # of the steps; points at random have more, a body that is filmed too slowly for its quickest turns less
)


def trial_segments(trial: Trial, like: Trial | None = None) -> tuple[Segment, ...]:
    """Every stretch of every passage that has no hole in it; like: the trial that says which stretches these are."""
    motion = trial.motion
    if motion is None:
        raise InputError(f"trial `{trial.name}` has no motion file: nothing to fit.")
    holes = motion if like is None or like.motion is None else like.motion
    pieces = [piece for passage in trial.passages for piece in whole_pieces(holes, passage)]
    if not pieces:
        raise InputError(f"trial `{trial.name}`: no cycle lies wholly in the recording. {' '.join(trial.notes)}")
    segments = tuple(_segment(trial, motion, piece) for piece in pieces)
    if like is None:
        _refuse_unresolved(trial, motion, segments)
    return segments


def _refuse_unresolved(trial: Trial, motion: Motion, segments: tuple[Segment, ...]) -> None:
    """Where the body is turned at random from frame to frame, no shape leads to the next: each step of a model there
    takes a search for a root, and what a fit of all of them would end in is no estimate."""
    turns = np.concatenate([np.diff(segment.smooth_poses[:, 2]) for segment in segments])
    far = float(np.mean(np.abs(np.angle(np.exp(1j * turns))) > SUSPICIOUS_TURN))
    if far <= UNRESOLVED:
        return
    edge, noise = 1 / (motion.points.shape[1] - 1), motion.marker_sd
    raise InputError(
        f"trial `{trial.name}`: these points show no motion of a body: from one frame to the next it turns by more "
        f"than {np.rad2deg(SUSPICIOUS_TURN):.0f} degrees in {percent(far)} of the frames, and the noise of its points "
        f"is {percent(noise / edge)} of the distance between them. Are they points along one body, in that order, in "
        "all frames, and are there enough frames a second? If not, leave this trial out."
    )


def _segment(trial: Trial, motion: Motion, rows: slice) -> Segment:
    time = motion.time_s[rows]
    phase = trial.schedule.phase(time) if trial.schedule is not None and trial.start_source != "none" else None
    known = np.isfinite(motion.smooth_angles[rows]).all(axis=1) & np.isfinite(motion.covariance[rows]).all(axis=(1, 2))
    if not known.all():
        at = time[int(np.argmin(known))]
        raise InputError(
            f"trial `{trial.name}`: its markers show no shape at {clock(at)} s. Were points exchanged, or are some "
            "wrong? Leave that part out: `from_s` and `to_s`."
        )
    return Segment(
        time, motion.joint_angles[rows], motion.poses[rows], motion.covariance[rows],
        motion.smooth_angles[rows], motion.smooth_poses[rows], trial.body.vertex_weights, trial.name, phase,
        motion.points[rows], motion.marker_sd,
    )  # fmt: skip
