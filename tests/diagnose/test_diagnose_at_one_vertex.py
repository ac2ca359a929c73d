"""A law of the whole body beside the same law at one vertex: where something acts at one place, the place is said."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind import outside
from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect, World
from blind.folder import write
from blind.ground import Ground
from blind.snake import Floats, Robot
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.recordings.recording import held_out_labels
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.inference.doubt.at_one_vertex import at_one_vertex, words_of
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, fit, fit_eps
from serpenoid.diagnose.inference.search.select import Selection, calibrated
from serpenoid.diagnose.stages.baseline import Baseline
from serpenoid.diagnose.stages.motion.choose_motion import GUESS
from serpenoid.diagnose.start import baseline
from serpenoid.effects.active import ActiveEffect

PULLED, PULL = 8, np.array([2e-3, -1e-3])  # [m/s times the drag level]
SLOPE = Effect("slope", None, {"pull_x": 0.004, "pull_y": -0.002})
GRIP = Effect("grip_saturation", None, {"saturation_speed": 0.04})


def pulled(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    """A cable: one vertex is pulled, always the same way."""

    def force(p: Floats, time: Floats) -> Floats:
        f = np.zeros_like(p)
        f[:, PULLED] = PULL
        return f

    return Effect("cable", PULLED, {}), World(Ground(0.2, robot, external=(force,)))


def selected(folder: Path, hide: str | Sequence[Effect], named: str, base: Sequence[Effect] = ()) -> Selection:
    """One name, fitted to two gaits, whatever it is worth."""
    write(make(31, hide, "one", COMBINATIONS[:2], base=base), folder)
    file, recordings = read_recordings(folder)
    known = Baseline(baseline(None, file, file.body))
    tracks = make_tracks(recordings, known.observation(), known.model)
    motion = Motion(tracks, GUESS, held_out_labels(recordings), (), np.zeros(3), frozenset(), None)
    motion, null = calibrated(motion, fit_eps(motion, known.model))
    effect = ActiveEffect.neutral(named)
    start = np.append(null.coordinates, effect.coordinates[:-1])
    best = fit(motion, null.model, [effect], start, TO_THE_END, null.predictions)
    return Selection(best, (null,), best, (), (), motion, null, 1.0, ())


@pytest.mark.slow
def test_a_pull_at_one_vertex_is_no_slope_and_the_vertex_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(outside.OUTSIDE, "cable", pulled)
    (found,) = at_one_vertex(selected(tmp_path, "cable", "slope"))
    assert (found.effect.name, found.vertex) == ("slope", PULLED)
    assert found.share < 0.5
    both = words_of([found, replace(found, effect=ActiveEffect.neutral("inertia"))])
    assert len(both) == 1
    assert f"at vertex {PULLED} alone" in both[0]
    assert "inertia" in both[0]


@pytest.mark.parametrize(
    "base",
    [pytest.param([], id="known floor", marks=pytest.mark.slow), pytest.param([GRIP], id="a law that is missing")],
)
def test_a_slope_pulls_at_every_vertex(base: list[Effect], tmp_path: Path) -> None:
    assert not at_one_vertex(selected(tmp_path, [SLOPE], "slope", base))
