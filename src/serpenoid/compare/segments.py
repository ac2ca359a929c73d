"""A trial's passages as segments for the likelihood: the recording's own rows, between long gaps and jumps."""

from __future__ import annotations

import numpy as np

from serpenoid.compare.likelihood import Segment
from serpenoid.errors import InputError
from serpenoid.measure.cells import clock
from serpenoid.measure.trial import Motion, Trial
from serpenoid.measure.usage import whole_pieces


def trial_segments(trial: Trial, like: Trial | None = None) -> tuple[Segment, ...]:
    """Every stretch of every passage that has no hole in it; like: the trial that says which stretches these are."""
    motion = trial.motion
    if motion is None:
        raise InputError(f"trial `{trial.name}` has no motion file: nothing to fit.")
    holes = motion if like is None or like.motion is None else like.motion
    pieces = [piece for passage in trial.passages for piece in whole_pieces(holes, passage)]
    if not pieces:
        raise InputError(f"trial `{trial.name}`: no cycle lies wholly in the recording. {' '.join(trial.notes)}")
    return tuple(_segment(trial, motion, piece) for piece in pieces)


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
