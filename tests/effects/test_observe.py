"""What cameras see, against the generator's cameras."""

from __future__ import annotations

import numpy as np
import pytest

from blind import catalogue as hidden
from blind.cameras import seen_markers
from blind.snake import vertices
from effects.conftest import extended, typical
from serpenoid.body import Floats
from serpenoid.effects import ActiveEffect, catalogue, find, places
from serpenoid.effects.active import seen
from serpenoid.effects.view import View
from serpenoid.model import Model
from serpenoid.problem import Problem

SEEN = [n for n, e in catalogue().items() if e.site == "observation"]
TIMES = np.linspace(0, 5, 60)
GAP, DIRECTION = 2.0, 0.7  # when it ends [s]; where a jump across it goes [rad]


def observe(model: Model, vertices_m: Floats) -> View:
    """As seen at TIMES, with one gap of all markers and one direction of a jump across it."""
    return seen(View.true(vertices_m, TIMES, [GAP], [DIRECTION]), model.observation_effects)


@pytest.mark.parametrize("names", [*((n,) for n in SEEN), tuple(SEEN)])
def test_markers_are_seen_where_the_generator_sees_them(names: tuple[str, ...], problem: Problem) -> None:
    rng = np.random.default_rng(0)
    phi, pose = rng.uniform(-0.7, 0.7, (60, 10)), rng.uniform(-1, 1, (60, 3))
    effects = [typical(name) for name in names]
    world = hidden.world(0.2, [hidden.Effect(e.name, e.place, dict(e.parameters)) for e in effects])
    jump = world.cameras.jump * np.array([np.cos(DIRECTION), np.sin(DIRECTION)])
    jumps = (GAP <= TIMES)[:, None] * jump
    view = observe(extended(problem, *effects), vertices(phi, pose))
    np.testing.assert_allclose(view.markers, seen_markers(world.cameras, phi, pose, TIMES, jumps), atol=1e-14)
    np.testing.assert_allclose(view.servo_times, (1 + world.cameras.clock_rate) * TIMES, atol=1e-14)


@pytest.mark.parametrize("name", SEEN)
def test_what_is_seen_is_linear_in_every_parameter(name: str, problem: Problem) -> None:
    points = np.random.default_rng(1).uniform(-0.3, 0.3, (60, 12, 2))
    active = typical(name)
    for p in active.effect.parameters:
        views = []
        for factor in (1.0, 2.0, 3.0):
            values = active.parameters | {p.name: factor * p.typical}
            model = extended(problem, ActiveEffect.of(name, active.place, **values))
            views.append(observe(model, points))
        for a, b, c in ([v.markers for v in views], [v.servo_times for v in views]):
            np.testing.assert_allclose(c - b, b - a, atol=1e-14)


def test_places_are_those_of_the_body(problem: Problem) -> None:
    assert places(find("worn_wheel"), problem.body) == list(range(12))
    assert places(find("backlash"), problem.body) == list(range(1, 11))
    assert places(find("slope"), problem.body) == [None]
