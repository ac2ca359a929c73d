"""Exact derivatives of every recorded step, against differences of the predictions themselves."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest

import serpenoid as sp
from effects.conftest import extended, medium_for, place_of, typical
from serpenoid.effects import ActiveEffect, catalogue, find
from serpenoid.media import DEFAULT
from serpenoid.model import Model
from serpenoid.problem import Problem
from serpenoid.simulation.path import path_sensitivities
from serpenoid.simulation.sensitivity import Column, StepSensitivities, step_sensitivities

MEDIUM = [name for name, effect in catalogue().items() if effect.site == "medium"]
TIMES = np.linspace(0, 5, 51)
STEP, SMALL_STEP = 1e-5, 2e-8  # the second: m^2, beside the square of a creep of 1 mm in a second
SQUARES = ("grip_saturation", "track_width", "creep")  # coordinates that are not negative
OF_LAWS = [name for name in MEDIUM if not find(name).acts_in(DEFAULT)]


@pytest.fixture(scope="module")
def recording(problem: Problem, table: np.ndarray) -> np.ndarray:
    """A motion (51, N, 2) that is nobody's prediction: it has inertia, a slope and a worn wheel."""
    truth = extended(problem, typical("inertia"), typical("slope"), ActiveEffect.of("worn_wheel", 7, seizure=0.6))
    return sp.simulate_joint_angles(truth, table, start=np.array([0.1, 0.2, 0.3])).vertices


def moved(
    problem: Problem,
    effects: tuple[ActiveEffect, ...],
    column: Column,
    change: float,
    asked: tuple[ActiveEffect, ...] = (),
) -> Model:
    """The model with one column's coordinate changed."""
    if column.effect is None:
        eps = problem.medium.anisotropy_ratio + change
        body, medium = problem.body, medium_for(problem.medium, *effects, *asked)
        return Model(body, medium.model_copy(update={"anisotropy_ratio": eps}), effects, 5.0)
    resting = ActiveEffect.neutral(column.effect, column.place)
    old = next((e for e in effects if (e.name, e.place) == (column.effect, column.place)), resting)
    coordinates = np.array(old.coordinates[:-1])
    coordinates[[p.name for p in old.effect.parameters].index(column.parameter)] += change
    pairs = zip(old.effect.parameters, coordinates, strict=True)
    values = {p.name: p.value(float(c)) for p, c in pairs}  # not clipped: differences look to both sides
    new = ActiveEffect.model_construct(name=old.name, place=old.place, parameters=values)
    return extended(problem, *(e for e in effects if e is not old), new, asked=asked)


@pytest.mark.parametrize("present", [(), ("dry_friction", "inertia")])
@pytest.mark.parametrize("name", [n for n in MEDIUM if find(n).place is None])
def test_what_a_law_of_the_whole_body_does_is_the_sum_of_what_it_does_at_each_vertex(
    name: str, present: tuple[str, ...], problem: Problem, recording: np.ndarray
) -> None:
    if name in present or name in OF_LAWS:
        return  # a number of a law is of all vertices
    every = [None, *range(problem.body.vertices)]
    asked = [ActiveEffect.neutral(name, place) for place in every]
    found = step_sensitivities(extended(problem, *map(typical, present)), recording, TIMES, candidates=asked)
    for parameter in find(name).parameters:
        whole, *alone = (
            found.jacobian[..., found.columns.index(Column(name, place, parameter.name))] for place in every
        )
        np.testing.assert_allclose(sum(alone), whole, rtol=1e-4, atol=1e-4 * np.abs(whole).max())


@pytest.mark.parametrize("present", [(), ("dry_friction", "inertia"), ("grip_saturation", "toe", "load")])
@pytest.mark.parametrize("name", MEDIUM)
def test_derivatives_are_those_of_the_prediction(
    name: str, present: tuple[str, ...], problem: Problem, recording: np.ndarray
) -> None:
    effects = tuple(typical(other) for other in present if name not in OF_LAWS or find(other).of_degree is None)
    asked = ActiveEffect.neutral(name, place_of(name))
    found = step_sensitivities(extended(problem, *effects, asked=[asked]), recording, TIMES, candidates=[asked])
    assert found.sound.all()
    for i, column in enumerate(found.columns):
        if column.effect not in (name, None):
            continue
        one_sided = name in SQUARES and name not in present
        shifts, weights = ((0, 1, 2), (-1.5, 2, -0.5)) if one_sided else ((-1, 1), (-0.5, 0.5))
        step = SMALL_STEP if column.effect == "track_width" else STEP
        values = [predicted(moved(problem, effects, column, x * step, (asked,)), recording) for x in shifts]
        change = sum(w * v for w, v in zip(weights, values, strict=True)) / step
        size = np.abs(found.jacobian[..., i]).max()
        np.testing.assert_allclose(found.jacobian[..., i], change, atol=1e-8 + 1e-4 * size, rtol=0)


def predicted(model: Model, recording: np.ndarray) -> np.ndarray:
    return step_sensitivities(model, recording, TIMES).relative


@pytest.mark.parametrize("name", [n for n in MEDIUM if find(n).scan])
def test_what_is_scanned_is_to_first_order_what_it_is_made_of_where_it_is_felt(
    name: str, problem: Problem, table: np.ndarray
) -> None:
    scan, length, weights = find(name).scan, problem.body.total_length_m, problem.body.vertex_weights
    each = weights if scan.by_weight else np.ones_like(weights)
    model = extended(problem)
    motion = sp.simulate_joint_angles(model, table, start=np.array([0.1, 0.2, 0.3])).vertices
    places = length * (motion[1:] + motion[:-1]) / 2
    parts = [ActiveEffect.neutral(scan.made_of, k) for k in range(problem.body.vertices)]
    for grid in scan.grids(places.min(axis=(0, 1)), places.max(axis=(0, 1)), length):
        first, second = grid.felt(places)
        middle = (first.shape[-1] // 2) * second.shape[-1] + second.shape[-1] // 2
        felt = first[..., first.shape[-1] // 2] * second[..., second.shape[-1] // 2]
        whole = ActiveEffect.neutral(name, None, **grid.values[middle])
        found = step_sensitivities(model, motion, TIMES, candidates=[whole, *parts])
        by = {(c.effect, c.place, c.parameter): found.jacobian[..., i] for i, c in enumerate(found.columns)}
        own = by[name, None, whole.effect.parameters[0].name]
        made = sum(by[p.name, p.place, p.effect.parameters[0].name] * (w * felt[:, k])[:, None]
                   for k, (p, w) in enumerate(zip(parts, each, strict=True)))  # fmt: skip
        np.testing.assert_allclose(made, own, atol=1e-9 * np.abs(own).max())  # roots are solved to 1e-12


def test_prediction_of_the_baseline_is_the_simulations(problem: Problem, recording: np.ndarray) -> None:
    found = step_sensitivities(extended(problem), recording, TIMES)
    motion = sp.simulate_vertices(extended(problem), recording)
    plain = sp.simulate_vertices(extended(problem), motion.vertices)
    np.testing.assert_allclose(step_sensitivities(extended(problem), motion.vertices, TIMES).relative, found.relative)
    np.testing.assert_allclose(plain.poses - plain.poses[0], motion.poses - motion.poses[0], atol=1e-12)


def test_a_model_predicts_its_own_motion_step_by_step(problem: Problem, table: np.ndarray) -> None:
    """With memory too: the momentum of the steps before is that of the recording."""
    model = extended(problem, typical("inertia"), typical("friction_patch"), typical("anisotropy_drift"))
    motion = sp.simulate_joint_angles(model, table, start=np.array([0.1, 0.2, 0.3]))
    found = step_sensitivities(model, motion.vertices, TIMES, motion.poses)
    c, s = np.cos(motion.poses[:-1, 2]), np.sin(motion.poses[:-1, 2])
    d = np.diff(motion.poses, axis=0)
    own = np.column_stack([c * d[:, 0] + s * d[:, 1], c * d[:, 1] - s * d[:, 0], d[:, 2]])
    np.testing.assert_allclose(found.relative, own, atol=1e-11)


def everything(problem: Problem, recording: np.ndarray, rows: int) -> StepSensitivities:
    places = {None: [None], "vertex": range(12)}
    candidates = [ActiveEffect.neutral(name, place) for name in MEDIUM for place in places[find(name).place]]
    shapes = np.tile(recording[:-1], (math.ceil(rows / 50), 1, 1))[:rows]
    return step_sensitivities(extended(problem), shapes, np.arange(rows) / 120, candidates=candidates)


def test_ten_thousand_steps_by_all_effects_at_all_places_take_about_a_second(
    problem: Problem, recording: np.ndarray
) -> None:
    everything(problem, recording, 2001)  # compiles
    begin = time.process_time()
    found = everything(problem, recording, 10_001)
    seconds = time.process_time() - begin
    assert found.jacobian.shape == (10_000, 3, 1 + 25 + 2 + 48)
    assert seconds < 5  # 1 s on an idle core of 2020; processor time


@pytest.mark.parametrize("present", [(), ("dry_friction", "toe"), ("inertia", "slope", "added_mass")])
def test_derivatives_of_a_path_are_those_of_the_simulation(
    present: tuple[str, ...], problem: Problem, recording: np.ndarray
) -> None:
    effects, start = tuple(typical(name) for name in present), np.array([0.1, 0.2, 0.3])
    candidates = [ActiveEffect.neutral(name, place_of(name)) for name in MEDIUM if name not in (*present, *OF_LAWS)]
    found = path_sensitivities(extended(problem, *effects), recording, TIMES, start, candidates)

    def path(model: Model, first: np.ndarray = start) -> np.ndarray:
        motion = sp.simulate_vertices(model, recording, first, TIMES)
        assert motion.status.ok
        return motion.poses

    np.testing.assert_array_equal(found.poses, path(extended(problem, *effects)))
    for i in range(3):
        high, low = (path(extended(problem, *effects), start + x * np.eye(3)[i]) for x in (STEP, -STEP))
        np.testing.assert_allclose(found.by_start[..., i], (high - low) / (2 * STEP), atol=1e-6)
    for i, column in enumerate(found.columns):
        high, low = (path(moved(problem, effects, column, x)) for x in (STEP, 0.0))
        size = np.abs(found.jacobian[..., i]).max()
        np.testing.assert_allclose(found.jacobian[..., i], (high - low) / STEP, atol=1e-6 + 2e-3 * size)
