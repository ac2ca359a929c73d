"""Windows of a campaign that was written, for tests of what is made of them."""

from __future__ import annotations

from pathlib import Path

from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.stages.motion.choose_motion import GUESS
from serpenoid.medium import Medium
from serpenoid.model import Model


def windows(folder: Path, eps: float) -> tuple[Motion, Model]:
    """About drag alone, its model, and the noise guessed; gaits are held out by their numbers."""
    recordings = read_recordings(folder)[1]
    model = Model(recordings[0].body, Medium(anisotropy_ratio=eps))
    tracks = make_tracks(recordings, Observation.neutral(model.body), model)
    return Motion(tracks, GUESS, tuple(int(r.gait[-2:]) for r in recordings)), model
