"""When shapes were, beside where the body was: clocks that play draws aside, and paths between the steps of a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, Campaign, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.recordings.relaid import relaid
from serpenoid.diagnose.data.windows import meshes, tracks
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.stages.observation.choose_observation import choose_observation
from serpenoid.effects.active import ActiveEffect
from serpenoid.group import relative
from serpenoid.medium import Medium
from serpenoid.model import Model

WIDTH = 0.12  # rad


def read(folder: Path, hidden: Sequence[Effect], gaits: int = 1) -> tuple[Campaign, tuple[Recording, ...]]:
    made = make(77, hidden, combinations=COMBINATIONS[:gaits])
    write(made, folder)
    return made, read_recordings(folder)[1]


def off(made: Campaign, recordings: Sequence[Recording]) -> float:
    """By how much films are laid too late beside their logs [s], the mean of all."""
    filmed = {t.name: t.film.time for t in made.trials}
    return float(np.mean([(r.time - filmed[r.name]).mean() for r in recordings]))


@pytest.mark.slow
def test_play_does_not_draw_clocks_aside_once_it_is_known(tmp_path: Path) -> None:
    made, recordings = read(tmp_path, [Effect("loose_joint", 4, {"width": WIDTH})], gaits=3)
    _, seen = choose_observation(recordings, Observation.neutral(recordings[0].body))
    again, moved = relaid(recordings, seen)
    assert moved
    assert abs(off(made, recordings)) > 4e-4
    assert abs(off(made, again)) < abs(off(made, recordings)) / 4
    assert not relaid(again, choose_observation(again, Observation.neutral(recordings[0].body))[1])[1]


def test_clocks_of_a_healthy_robot_stay_as_they_are(tmp_path: Path) -> None:
    made, recordings = read(tmp_path, [])
    again, _ = relaid(recordings, Observation.neutral(recordings[0].body))
    assert abs(off(made, again) - off(made, recordings)) < 1e-4


def test_poses_at_window_ends_do_not_depend_on_the_mesh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Momentum that lasts no longer than a step of the fits is followed between frames all the same."""
    added = ActiveEffect(name="added_mass", parameters={"relaxation_time": 0.03})
    _, recordings = read(tmp_path, [Effect("added_mass", None, {"relaxation_time": 0.03})])
    model = Model(recordings[0].body, Medium(anisotropy_ratio=0.2), (added,))

    def apart(one: Sequence[Track], other: Sequence[Track]) -> float:
        return max(
            float(np.abs(relative(a.measured, b.measured)[:, :2]).max()) for a, b in zip(one, other, strict=True)
        )

    def made(finer: int) -> tuple[Track, ...]:
        for name, value in (("COARSER", finer), ("STEPS_PER_WINDOW", 9 * finer), ("LEAST_PER_HALF", 4 * finer)):
            monkeypatch.setattr(meshes, name, value)
        monkeypatch.setattr(tracks, "COARSER", finer)
        return tracks.make_tracks(recordings, Observation.neutral(recordings[0].body), model)

    usual, exact = made(meshes.COARSER), made(32)
    noise = float(np.median([r.marker_noise for r in recordings]))
    assert apart(usual, exact) < noise / 20
    assert apart(made(2), exact) > 4 * apart(usual, exact)
