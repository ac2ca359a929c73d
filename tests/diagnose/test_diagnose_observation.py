"""The observation model's play is the law of `loose_joint`; a loose joint is named alone, its interval covers it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.body import Body
from serpenoid.diagnose.choose_observation import choose_observation
from serpenoid.diagnose.observation import Observation, across
from serpenoid.diagnose.recording import read_recordings
from serpenoid.effects.active import ActiveEffect
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.servos import realise


@pytest.fixture
def readings() -> np.ndarray:
    time = np.linspace(0, 9, 400)
    return 0.4 * np.sin(np.outer(time, [1.0, 2.0, 3.1]) + [0.0, 1.0, 2.0])


def test_angles_of_a_loose_joint_are_those_of_the_effect(readings: np.ndarray) -> None:
    body = Body(vertices=5, edge_lengths=(0.1,) * 4)
    gaps, zeros = np.array([0.0, 0.13, 0.0]), np.array([0.02, 0.0, 0.0])
    seen = replace(Observation.neutral(body), gaps=gaps, zeros=zeros)
    effects = (ActiveEffect.of("loose_joint", 2, width=0.13), ActiveEffect.of("zero_offset", 1, offset=0.02))
    model = Model(body, Medium(anisotropy_ratio=0.2), effects)
    np.testing.assert_allclose(
        seen.angles(readings), realise(model, readings, np.linspace(0, 9, 400)).angles, atol=1e-14
    )


def test_the_slope_of_play_is_its_difference(readings: np.ndarray) -> None:
    link, slope = across(readings[:, 1], 0.13)
    wider, _ = across(readings[:, 1], 0.13 + 1e-7)
    np.testing.assert_allclose((wider - link) / 1e-7, slope, atol=1e-6)
    assert set(np.unique(slope)) == {-0.5, 0.0, 0.5}


@pytest.mark.parametrize(("seed", "place", "width"), [(61, 4, 0.02), (62, 10, 0.09), (63, 1, 0.15)])
def test_a_loose_joint_is_named_alone_and_its_interval_covers_it(
    seed: int, place: int, width: float, tmp_path: Path
) -> None:
    write(make(seed, [Effect("loose_joint", place, {"width": width})], combinations=COMBINATIONS[:3]), tmp_path)
    recordings = read_recordings(tmp_path)[1]
    rung, _ = choose_observation(recordings, Observation.neutral(recordings[0].body))
    assert [(n.effect.name, n.effect.place) for n in rung.named] == [("loose_joint", place)]
    assert rung.settled
    assert not rung.rivals
    low, high = rung.named[0].intervals["width"]
    assert low is not None
    assert high is not None
    assert low < width < high
