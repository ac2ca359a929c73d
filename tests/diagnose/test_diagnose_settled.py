"""What a mesh gets wrong is put back as a model has it: tracks are made about the model that is fitted to them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, fit, fit_eps, fit_guided
from serpenoid.diagnose.inference.search.select import calibrated, settled
from serpenoid.diagnose.stages.motion.choose_motion import GUESS
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.model import Model

Retrack = Callable[[Model], tuple[Track, ...]]
SETTINGS = 1  # gaits, each at another duration, two trials of each


class Tracker:
    """Makes the tracks of a short campaign that hides an effect, and counts how often."""

    def __init__(self, folder: Path, hidden: Effect) -> None:
        write(make(5, [hidden], "short", COMBINATIONS[:SETTINGS]), folder)
        self.recordings, self.times = read_recordings(folder)[1], 0
        self.body = self.recordings[0].body

    def __call__(self, model: Model) -> tuple[Track, ...]:
        self.times += 1
        return make_tracks(self.recordings, Observation.neutral(self.body), model)

    def begun(self, name: str) -> tuple[Motion, Fit, Model]:
        """As a search has it: an effect fitted on tracks about a model that lacks it, and that model."""
        model = Model(self.body, Medium(anisotropy_ratio=0.2))
        labels = tuple(int(r.gait[-2:]) for r in self.recordings)
        motion = Motion(self(model), GUESS, labels)
        motion, null = calibrated(motion, fit_eps(motion, model))
        start = ActiveEffect.typical(name)
        x = np.concatenate([null.coordinates, start.coordinates[:-1]])
        return motion, fit(motion, model, [start], x, TO_THE_END), model


def anew(motion: Motion, found: Fit, track: Retrack) -> tuple[Motion, Fit]:
    motion = replace(motion, tracks=track(found.model))
    return calibrated(motion, fit_guided(motion, found))


def test_a_body_that_coasts_is_fitted_on_tracks_about_itself(tmp_path: Path) -> None:
    track = Tracker(tmp_path, Effect("added_mass", None, {"relaxation_time": 0.1}))
    motion, found, about = track.begun("added_mass")
    _, once = anew(motion, found, track)
    again, last = settled(replace(motion, tracks=track(found.model)), found, about, track)
    _, further = anew(again, last, track)
    assert found.away_from(found.model) == 0
    assert found.away_from(about) > 10  # what the model lacks is neutral there
    assert found.away_from(last.model) > 10  # standard deviations: what a massless mesh puts back is another error
    assert once.away_from(last.model) < found.away_from(last.model) / 10  # pauses have steps as short as cycles
    assert further.away_from(last.model) < 1
    (value,) = last.effects[0].parameters.values()
    assert value == pytest.approx(0.1, rel=0.015)  # 2.5 standard deviations


def test_what_drag_alone_does_needs_no_further_tracks(tmp_path: Path) -> None:
    track = Tracker(tmp_path, Effect("rolling_resistance", None, {"crossover_speed": 0.02}))
    motion, found, about = track.begun("rolling_resistance")
    before, track.times = replace(motion, tracks=track(found.model)), 0
    _, last = settled(before, found, about, track)
    assert track.times == 0
    assert last.chi2 < 1.3 * last.evidence.count.sum()
