"""Where on the floor a body is: a frame that drifts or jumps shows it elsewhere, what lies on the floor stays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from blind.cameras import resample
from blind.campaign import COMBINATIONS, Campaign, make
from blind.catalogue import Effect
from blind.folder import write
from blind.windows import windows
from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras import frame
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.paths import path_error
from serpenoid.diagnose.data.shapes.geometry import shapes, turn
from serpenoid.diagnose.data.windows.meshes import COARSER
from serpenoid.diagnose.data.windows.tracks import _mesh_error
from serpenoid.diagnose.data.windows.windows import begun_anew, predicted_path
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, fit
from serpenoid.diagnose.inference.fits.places import placed
from serpenoid.diagnose.inference.search.room import chance
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.report.animate import predicted
from serpenoid.diagnose.stages.motion.left_over import strayed
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from specimens import reference, serpenoid_table

PATCH = Effect("friction_patch", None, {"strength": -0.7, "x": 0.1, "y": 0.05, "radius": 0.14})
JUMPS = Effect("position_jumps", None, {"size": 0.035})
DRIFT = Effect("frame_drift", None, {"velocity_x": 3e-3, "velocity_y": -3e-3})


def fitted(folder: Path, *hidden: Effect, gaits: int = 2) -> tuple[Campaign, Motion, Fit]:
    """A short campaign, and a fit of what moves windows in it, from the truth on."""
    campaign = make(5, hidden, "short", COMBINATIONS[:gaits])
    write(campaign, folder)
    motion, model = windows(folder, campaign.eps)
    effects = [ActiveEffect.of(e.name, e.place, **e.parameters) for e in hidden if e != JUMPS]
    x = np.array([campaign.eps, *(c for e in effects for c in e.coordinates[:-1])])
    found = fit(motion, model, effects, x, TO_THE_END)
    return campaign, motion, found


@pytest.mark.parametrize(
    "hidden", [pytest.param(JUMPS, id=JUMPS.name, marks=pytest.mark.slow), pytest.param(DRIFT, id=DRIFT.name)]
)
def test_a_patch_stays_where_it_is_however_cameras_show_the_body(hidden: Effect, tmp_path: Path) -> None:
    campaign, motion, found = fitted(tmp_path, PATCH, hidden, gaits=4)
    again = placed(motion, found)
    for trial, track in zip(campaign.trials, again.tracks, strict=True):
        away = resample(track.time, trial.film.time, trial.film.jumps)
        away = away + track.time[:, None] * np.array(campaign.world.cameras.drift)
        missed = np.hypot(*(track.shifted[:, :2] - away).T)
        assert np.median(missed) < 3e-3 < 5e-3 < np.hypot(*away.T).max()
    x = found.coordinates
    better = fit(again, found.model, list(found.effects), x, TO_THE_END)
    assert better.chi2 < 0.7 * found.chi2
    (patch,) = [e for e in better.effects if e.name == PATCH.name]
    assert patch.parameters["x"] == pytest.approx(PATCH.parameters["x"], abs=4e-3)


def test_places_are_as_they_are_seen_where_the_frame_stays(tmp_path: Path) -> None:
    _, motion, found = fitted(tmp_path, PATCH)
    quiet = Motion(motion.tracks, chance(motion, found), motion.labels)
    assert placed(quiet, found) is quiet


def test_a_pose_is_where_its_view_came_from() -> None:
    """A frame that has turned by 0.4 rad and drifted: seen by the law, and found again from what is seen."""

    def seen(markers: Floats, time: Floats) -> Floats:
        return turn(0.01 * time[:, None], markers) + 0.002 * time[:, None, None]

    true, time = np.random.default_rng(6).normal(size=(40, 3)), np.linspace(0, 40, 40)
    effect = cast(ActiveEffect, SimpleNamespace())
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(frame, "seen", lambda view, effects: replace(view, markers=seen(view.markers, view.times)))
        poses = frame._seen_poses([effect], true, time)
        found = poses - frame.shifted([effect], poses, time)
    assert np.abs(poses - true).max() > 0.3
    np.testing.assert_allclose(found, true, atol=1e-3)


def test_what_a_mesh_misses_of_windows_is_not_what_it_misses_of_a_run() -> None:
    """On a patch a run that has strayed by its mesh meets another floor; windows begin where the body is."""
    patch = ActiveEffect.of("friction_patch", strength=-0.87, x=0.3, y=0.0, radius=0.3)
    begun = reference()
    model = Model(begun.body, begun.medium, (patch,))
    rows, finest = 8 * 18, 8
    table = serpenoid_table(model, finest * rows)
    every = shapes(model.body, np.concatenate([table] * 4 + [table[:1]]))
    time = np.linspace(0, 16, len(every))
    path = predicted_path(model, every, time, np.array([0.1, 0.1, 0.5]))
    bounds = 18 * np.arange(4 * 8 + 1)
    some = slice(None, None, finest)
    guess = predicted_path(model, every[some], time[some], path[0])
    run, windows = _mesh_error(model, every[some], time[some], guess, path[some], bounds)
    true = begun_anew(model, every, time, path, finest * bounds)
    coarse = begun_anew(model, every[some][::COARSER], time[some][::COARSER], path[some][::COARSER], bounds // COARSER)
    missed = [np.abs(true - coarse - more).max() for more in (windows, run, 0.0)]
    assert missed[0] < 0.1 * min(missed[1:])


def test_the_path_is_that_of_all_that_is_there_with_steps_across_gaps_where_they_are_named(tmp_path: Path) -> None:
    _, motion, found = fitted(tmp_path, PATCH, JUMPS)
    bare = fit(motion, found.model, [], found.coordinates[:1], TO_THE_END)
    chosen = cast("Selection", SimpleNamespace(motion=motion, best=bare, settled=found))
    assert strayed(chosen, None, mend=True) == path_error(motion, found.predictions, mend=True)
    assert strayed(chosen, None, mend=True) < strayed(chosen, None, mend=False) == path_error(motion, found.predictions)
    for track, p in zip(motion.tracks, found.predictions, strict=True):
        shown, alone = (np.hypot(*(predicted(track, p, m) - track.poses)[-1, :2]) for m in (True, False))
        if track.gap_windows.any():
            assert shown < 0.01 < alone  # the film goes on where it jumped to, and so does what is shown beside it
