"""A body that is moving already: the second half of a motion is what the first half makes of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import serpenoid as sp
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.simulation.path import path_sensitivities

ROOT = Path(__file__).parents[2]
TIMES = 0.05 * np.arange(61)
CUT = 30


@pytest.fixture(scope="module")
def whole() -> tuple[Model, np.ndarray, np.ndarray]:
    """A model with both kinds of momentum, its shapes, and its path from rest."""
    problem = sp.load(ROOT / "problems" / "reference.toml")
    effects = (ActiveEffect.of("inertia", relaxation_time=0.3), ActiveEffect.of("added_mass", relaxation_time=0.4))
    model = Model(problem.body, problem.medium, effects)
    shapes = np.concatenate([sp.simulate(problem).trajectory.vertices] * 2)[: len(TIMES)]
    motion = sp.simulate_vertices(model, shapes, np.array([0.1, 0.2, 0.3]), TIMES)
    assert motion.status.ok
    return model, shapes, motion.poses


def test_it_goes_on_as_it_would_have(whole: tuple) -> None:
    model, shapes, poses = whole
    rest = sp.simulate_vertices(model, shapes[CUT:], poses[CUT : CUT + 3], TIMES[CUT:])
    np.testing.assert_allclose(rest.poses, poses[CUT:], atol=1e-10)  # roots are found to 1e-12


def test_begun_at_rest_it_does_not(whole: tuple) -> None:
    model, shapes, poses = whole
    rest = sp.simulate_vertices(model, shapes[CUT:], poses[CUT], TIMES[CUT:])
    assert np.abs(rest.poses - poses[CUT:]).max() > 1e-3


def test_no_parameter_changes_the_poses_it_begins_with(whole: tuple) -> None:
    model, shapes, poses = whole
    first = poses[CUT : CUT + 3]
    found = path_sensitivities(model, shapes[CUT:], TIMES[CUT:], first)
    assert np.abs(found.jacobian[:3]).max() == 0
    step = 1e-5
    for i, column in enumerate(found.columns[1:], start=1):
        ends = []
        for sign in (step, -step):
            effects = [e.with_coordinates([e.coordinates[0] + sign * (e.name == column.effect)]) for e in model.effects]
            changed = Model(model.body, model.medium, tuple(effects))
            ends.append(sp.simulate_vertices(changed, shapes[CUT:], first, TIMES[CUT:]).poses)
        np.testing.assert_allclose(found.jacobian[..., i], (ends[0] - ends[1]) / (2 * step), atol=1e-6)
