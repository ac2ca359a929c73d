"""Every effect of the catalogue, one by one: declared, neutral, and doing something."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

import serpenoid as sp
from effects.conftest import extended, place_of, typical
from serpenoid.effects import ActiveEffect, ActuationEffect, catalogue, find
from serpenoid.effects.base import MediumEffect, Parameter, Symbols
from serpenoid.effects.element import Element
from serpenoid.effects.view import View
from serpenoid.errors import InputError
from serpenoid.mechanics.extended import SETTING, wrench
from serpenoid.media import LAWS
from serpenoid.model import Model
from serpenoid.problem import Problem
from serpenoid.simulation.servos import realise
from serpenoid.status import Status

NAMES = list(catalogue())
MOVING = [n for n in NAMES if find(n).site != "observation"]
SEEN = [n for n in NAMES if find(n).site == "observation"]
HAVE_NEUTRAL = [n for n in NAMES if any(p.neutral is not None for p in find(n).parameters)]


def test_catalogue_has_the_agreed_names() -> None:
    agreed = (Path(__file__).parents[1] / "blind" / "EFFECTS.md").read_text(encoding="utf-8")
    named = {line.split("`")[1] for line in agreed.splitlines() if line.startswith("| `")}
    assert named == set(NAMES)


@pytest.mark.parametrize("name", NAMES)
def test_effect_is_declared_in_full(name: str) -> None:
    effect = find(name)
    assert effect.parameters
    assert effect.looks_like
    assert effect.what_to_do
    for p in effect.parameters:
        assert p.unit
        assert p.meaning
        assert p.lower < p.upper
        assert p.lower <= p.typical <= p.upper
        assert p.neutral is None or p.lower <= p.neutral <= p.upper
        assert math.isfinite(p.resting)
        assert p.value(p.coordinate(p.typical)) == pytest.approx(p.typical, rel=1e-14)


@pytest.mark.parametrize("name", [n for n in NAMES if find(n).applies_to("diagnose")])
def test_a_diagnosis_can_look_for_the_effect_as_its_file_says(name: str, problem: Problem) -> None:
    effect = find(name)
    if isinstance(effect, ActuationEffect):
        assert effect.shown or effect.marks in ("zeros", "gaps")
    if effect.scan is None:
        return
    strength, *others = effect.parameters
    assert effect.place is None
    assert strength.neutral is not None
    assert all(p.neutral is None for p in others)
    assert find(effect.scan.made_of).place == "vertex"
    for grid in effect.scan.grids(np.array([-0.1, 0.2]), np.array([0.3, 0.4]), problem.body.total_length_m):
        assert all(set(values) == {p.name for p in others} for values in grid.values)
        assert len({values[effect.scan.size] for values in grid.values}) == 1
        first, second = grid.felt(np.zeros((5, 3, 2)))
        assert first.shape[-1] * second.shape[-1] == len(grid.values)


@pytest.mark.parametrize("name", HAVE_NEUTRAL)
def test_neutral_effect_is_the_baseline_to_the_last_bit(name: str, problem: Problem, table: np.ndarray) -> None:
    there = ActiveEffect.neutral(name, place_of(name))
    model, baseline = extended(problem, there), extended(problem, asked=[there])
    assert model == baseline
    motion, plain = (sp.simulate_joint_angles(m, table, 2) for m in (model, baseline))
    assert motion.poses.tobytes() == plain.poses.tobytes()
    assert motion.step_energy.tobytes() == plain.step_energy.tobytes()


@pytest.mark.parametrize("name", MOVING)
def test_moderate_strength_changes_the_motion(name: str, problem: Problem, table: np.ndarray) -> None:
    there = [typical(name)]
    motion, plain = (sp.simulate_joint_angles(extended(problem, *e, asked=there), table) for e in (there, []))
    assert motion.status.ok
    assert np.abs(motion.poses - plain.poses)[:, :2].max() > 1e-3  # body lengths, about 1 mm


@pytest.mark.parametrize("name", SEEN)
def test_observation_changes_what_is_seen_and_not_the_motion(name: str, problem: Problem, table: np.ndarray) -> None:
    active = typical(name)
    motion, plain = (sp.simulate_joint_angles(extended(problem, *e), table) for e in ([active], []))
    assert motion.poses.tobytes() == plain.poses.tobytes()
    true = View.true(plain.vertices * problem.body.total_length_m, np.linspace(0, 5, 51), [2.0], [0.3])
    seen = active.effect.on_view(true, active.place, active.parameters)
    changed = max(np.abs(seen.markers - true.markers).max(), np.abs(seen.servo_times - true.servo_times).max())
    assert changed > 1e-3  # m or s


@pytest.mark.parametrize("name", MOVING)
def test_speed_is_asked_for_where_it_matters(name: str, problem: Problem) -> None:
    effect = find(name)
    if not effect.needs_seconds:  # type: ignore[attr-defined]
        assert extended(problem, typical(name), duration=None).step_duration(50) == 1 / 50  # one second a cycle
        return
    with pytest.raises(InputError, match=f"cycle_duration_s: `{name}` knows speed"):
        extended(problem, typical(name), duration=None).step_duration(50)


@pytest.mark.parametrize(
    ("name", "place", "values", "message"),
    [
        ("worn_weel", 4, {}, "did you mean `worn_wheel`"),
        ("worn_wheel", 4, {"seizur": 1.0}, "did you mean `seizure`"),
        ("worn_wheel", None, {"seizure": 1.0}, "give `place`, the number of a vertex"),
        ("worn_wheel", 4, {"seizure": 1.5}, r"must be in \[0, 1\], got 1.5"),
        ("slope", 4, {"pull_x": 0.0, "pull_y": 0.1}, "has no `place`"),
        ("slope", None, {"pull_x": 0.0}, "needs `pull_y`"),
    ],
)
def test_bad_effects_are_refused(name: str, place: int | None, values: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ActiveEffect.of(name, place, **values)


def test_effects_that_do_not_fit_the_body_are_refused(problem: Problem) -> None:
    with pytest.raises(InputError, match="vertex from 0 to 11"):
        extended(problem, ActiveEffect.of("worn_wheel", 12, seizure=0.5))
    with pytest.raises(InputError, match="contact is lost"):
        extended(problem, ActiveEffect.of("load", 4, share=-0.5))
    with pytest.raises(InputError, match="twice"):
        extended(problem, typical("toe"), typical("toe"))


def test_zero_offset_is_not_shown_by_the_servo(problem: Problem, table: np.ndarray) -> None:
    times = np.arange(50) * 0.1
    realised = realise(extended(problem, ActiveEffect.of("zero_offset", 3, offset=0.05)), table, times)
    np.testing.assert_array_equal(realised.readings, table)
    np.testing.assert_allclose((realised.angles - table)[:, 2], 0.05, atol=1e-15)


def test_a_loose_joint_is_backlash_that_the_servo_does_not_show(problem: Problem, table: np.ndarray) -> None:
    times = np.arange(50) * 0.1
    loose, played = (
        realise(extended(problem, ActiveEffect.of(name, 3, width=0.1)), table, times)
        for name in ("loose_joint", "backlash")
    )
    np.testing.assert_array_equal(loose.readings, table)
    np.testing.assert_array_equal(loose.angles, played.angles)
    assert np.abs((loose.angles - table)[:, 2]).max() == pytest.approx(0.05, abs=1e-12)


def test_bounds_of_coordinates_are_those_of_values(problem: Problem) -> None:
    (low, high) = find("grip_saturation").coordinate_bounds(problem.body, None)[0]
    assert (low, high) == (0.0, 1e6)  # 1 / speed^2 of infinity and of 1 mm/s
    (low, _) = find("load").coordinate_bounds(problem.body, 4)[0]
    assert low == -problem.body.vertex_weights[4]


def test_medium_effects_need_vertices(problem: Problem) -> None:
    edges = problem.medium.model_copy(update={"dissipation": "edge"})
    with pytest.raises(InputError, match='set it to "vertex"'):
        Model(problem.body, edges, (typical("slope"),))


def test_a_body_that_touches_nothing_is_unsolved_and_not_an_exception(problem: Problem, table: np.ndarray) -> None:
    weights = problem.body.vertex_weights
    floating = [ActiveEffect.of("load", k, share=-float(w)) for k, w in enumerate(weights)]
    for others in ([], [typical("slope")]):
        motion = sp.simulate_joint_angles(extended(problem, *floating, *others), table)
        assert motion.status is Status.STEP_UNSOLVED


def test_a_floor_is_flat(problem: Problem) -> None:
    shapes = np.zeros((3, 12, 3))
    shapes[..., 0] = np.linspace(0, 1, 12)
    with pytest.raises(InputError, match="simulate in the plane"):
        sp.simulate_in_space(extended(problem, typical("toe")), shapes)


class _Spread(MediumEffect):
    """A number where a force has two parts."""

    def on_element(self, element: Element, p: Symbols) -> Element:
        return replace(element, push=p.strength * element.weight)


class _Forgetful(MediumEffect):
    def on_element(self, element: Element, p: Symbols) -> Element:
        replace(element, push=p.strength * element.velocity)  # type: ignore[return]


@pytest.mark.parametrize(
    ("broken", "said"),
    [
        (_Spread, r"effect `broken`: `push` must have the shape \(2, 1\), got \(1, 1\)"),
        (_Forgetful, "effect `broken`: must give back its Element, got NoneType. Does it lack a `return`"),
    ],
)
def test_an_effect_whose_file_is_wrong_is_refused_by_its_own_name(broken: type[MediumEffect], said: str) -> None:
    effect = broken("broken", None, (Parameter("strength", "1", 0.0, 1.0, 0.0, 0.1, "of it"),), "nothing", "nothing")
    sizes = (6, 6, 6, 2, SETTING, 2)
    with pytest.raises(TypeError, match=said):
        wrench((effect,), LAWS["viscous"], *(ca.SX.sym("s", size) for size in sizes))


STRENGTH = Parameter("strength", "1", 0.0, 1.0, 0.0, 0.1, "of it")
WHOLE = {"name": "whole", "place": None, "parameters": (STRENGTH,), "looks_like": "nothing", "what_to_do": "nothing"}


class _Misspelt(MediumEffect):
    """Its law has another name than the one that is called."""

    def on_elements(self, element: Element, p: Symbols) -> Element:
        return element


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"knows": frozenset({"speed", "plaze"})}, "`knows` must be of speed, clock, place, history, got `plaze`"),
        ({"needs": frozenset({"wheelz"})}, "`needs` must be of servos, .*, got `wheelz`"),
        ({"place": "joints"}, "`place` must be of None, vertex, joint, got `joints`"),
        ({"marks": "zero"}, "`marks` must be of None, zeros, .*, got `zero`"),
        ({"reasons": {"NLP": "why not"}}, "`reasons` must be of simulate, nlp, fit, diagnose, got `NLP`"),
        ({"parameters": STRENGTH}, "`parameters` must be a tuple of Parameter, got Parameter"),
    ],
)
def test_a_word_of_an_effect_that_nothing_looks_for_is_refused(change: dict[str, Any], said: str) -> None:
    """Each was an effect that did less than its file says: moved otherwise, was never on offer, or was nowhere."""
    with pytest.raises(InputError, match=f"effect `whole`: {said}"):
        _Spread(**WHOLE | change)


def test_an_effect_whose_law_is_misspelt_is_refused() -> None:
    with pytest.raises(InputError, match="_Misspelt must have a method `on_element` or `on_drag`, got none"):
        _Misspelt(**WHOLE)
    with pytest.raises(InputError, match="ActuationEffect must have a method `respond`"):
        ActuationEffect(**WHOLE)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"lower": 1.0, "upper": 0.0}, "`lower` must be below `upper`, got 1 and 0"),
        ({"neutral": 5.0}, r"`neutral` must be in \[0, 1\], its own bounds, got 5"),
        ({"typical": 5.0}, r"`typical` must be in \[0, 1\], its own bounds, got 5"),
        ({"typical": 0.0}, "`typical` must be another value than `neutral`, got 0 twice"),
        ({"neutral": math.nan}, "`neutral` must be in"),
    ],
)
def test_a_parameter_whose_numbers_contradict_each_other_is_refused(change: dict[str, float], said: str) -> None:
    with pytest.raises(InputError, match=f"`strength`: {said}"):
        replace(STRENGTH, **change)


@pytest.mark.parametrize(
    ("site", "effect", "said"),
    [
        ("medium", None, "must make one effect, `EFFECT = ...`, got NoneType"),
        ("medium", _Spread(**WHOLE), "`name` of its EFFECT must be that of the file, got `whole`"),
        (
            "actuation",
            _Spread(**WHOLE | {"name": "slow_joint"}),
            "must stand in effects/medium, the folder of its site",
        ),
    ],
)
def test_a_file_without_its_effect_is_named(
    site: str, effect: object, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = {"medium": "slope", "actuation": "slow_joint"}[site]
    monkeypatch.setattr(f"serpenoid.effects.{site}.{name}.EFFECT", effect)
    with pytest.raises(InputError, match=rf"serpenoid\.effects\.{site}\.{name}: {said}"):
        catalogue.__wrapped__()
