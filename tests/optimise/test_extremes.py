"""Radii near nothing, and weights far from one: an optimum, or words that say what to change."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.objectives.criteria import Criteria
from serpenoid.objectives.obstacles import HalfPlane
from serpenoid.optimise.solve import improve, solve, solve_from
from serpenoid.optimise.weights import LIGHTEST
from serpenoid.parallel import Workers
from serpenoid.status import Status
from serpenoid.studies.many_starts import solve_starts
from serpenoid.studies.sweep import sweep
from specimens import PROBLEMS, problem

SMALL = "reference-optimum", "body.vertices=6", "task.steps=40"
PLACE = 'task.demands=[{kind="reach",target=[0.187,0.034],radius=RADIUS}]'


def weighing(weight: float, c: float = 0.0) -> tuple[str, ...]:
    """Farthest, with a weight, at a price of dissipation."""
    return *SMALL, f"task.c={c}", f'task.objectives=[{{kind="displacement",weight={weight}}}]'


@pytest.mark.parametrize("radius", [1e-300, 1e-9, 1e-7, 1e-6, 1e-5])
def test_a_place_however_small_is_reached(radius: float) -> None:
    asked = problem(*SMALL, "body.vertices=8", "task.c=2", PLACE.replace("RADIUS", str(radius)))
    found = solve(asked, starts=2)
    assert [solution.status for solution in found.solutions] == [Status.SOLVED] * 2
    assert np.hypot(*(found.best.trajectory.poses[-1, :2] - [0.187, 0.034])) < radius + 1e-8
    itself = solve(problem(*SMALL, "body.vertices=8", "task.c=2", PLACE.replace("RADIUS", "0")), starts=2)
    assert found.best.cost == pytest.approx(itself.best.cost, abs=2 * radius + 1e-8)  # its multiplier is 1.3


def test_a_gait_does_not_depend_on_the_factor_of_all_weights() -> None:
    one, light, heavy = (solve(problem(*weighing(f, 0.5 * f)), starts=3).best for f in (1.0, LIGHTEST, 10.0))
    for other in (light, heavy):  # stationary to 1e-8 of a gradient of LIGHTEST: to 1e-5 of itself
        assert other.status is Status.SOLVED
        assert other.trajectory.displacement == pytest.approx(one.trajectory.displacement, abs=1e-5)


def test_an_objective_too_light_for_the_tolerances_is_refused_however_it_is_solved() -> None:
    light = problem(*weighing(1e-6))
    ways = (
        lambda: solve(light, starts=1),
        lambda: solve_from(light, light.gait),
        lambda: improve(light, 1),
        lambda: solve_starts(light, 1, 0, Workers(2, None)),
        lambda: sweep(problem(*weighing(1e-6, 1.0)), [0.0, 1.0]),
    )
    for way in ways:
        with pytest.raises(InputError, match=r"weight: .* at least 0.001, got 1e-06 at c = 0. Multiply"):
            way()


def test_a_light_term_beside_a_heavy_one_is_no_matter() -> None:
    terms = 'task.objectives=[{kind="displacement"},{kind="bending",weight=1e-9}]'
    assert solve(problem(*SMALL, terms), starts=1).best.status is Status.SOLVED

    def own(of: Criteria) -> None:
        of.minimise(-of.displacement)

    assert solve(problem(*weighing(1e-6)), starts=1, customise=own).best.status is Status.SOLVED


def test_a_weight_beyond_what_the_optimiser_can_scale_is_refused() -> None:
    with pytest.raises(InputError, match=r"objectives.* weight: .*less than or equal to 1000000"):
        problem(*weighing(1e9))


def test_a_search_that_heavy_weights_keep_from_its_optimum_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    terms = ("--set", "task.objectives=[{kind='displacement',weight=1e6}]", "--set", "task.c=5e5")
    words = ["solve", str(PROBLEMS / "reference-optimum.toml"), *terms, "--starts", "1", "--no-figures"]
    assert main([*words, "--out", str(tmp_path)]) == 1
    assert "the largest of the weights and c is 1e+06" in capsys.readouterr().err


@pytest.mark.parametrize("length", [5e-324, 1e-200, 1.0, 1e200, 1e308])
def test_a_walls_normal_may_have_any_length(length: float) -> None:
    gaps = HalfPlane(point=(0.0, -0.5), normal=(0.0, length)).gap(np.array([[3.0, 0.25]]))
    assert gaps == pytest.approx([0.75], rel=1e-15)


@pytest.mark.parametrize(
    ("goal", "said"),
    [
        ('demands=[{kind="disc",centre=[1e300,0],radius=1}]', "centre, entry 1: .* 1000000, got 1e"),
        ('demands=[{kind="reach",target=[0.3,0],radius=1e300}]', "radius: .* 1000000, got 1e"),
        ('demands=[{kind="reach",target=[0.3,0],cycles=1000000000}]', "cycles: .* 1000, got 1000000000"),
        ('objectives=[{kind="position",target=[0.3,-1e7]}]', "target, entry 2: .* -1000000, got -1"),
        ('objectives=[{kind="position",target=[1,0],cycles=1000000000}]', "cycles: .* 1000, got 1000000000"),
        ('objectives=[{kind="heading",target_rad=1e300}]', "target_rad: .* 1000000, got 1e"),
        ('demands=[{kind="self",distance=0.01,between=1000}]', "no two of the body's 11 edges have 1000 between them"),
    ],
)
def test_what_no_number_of_the_search_can_hold_is_refused_as_the_file_is_read(goal: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        problem("reference-optimum", f"task.{goal}")


def test_rest_that_misses_a_demand_is_not_as_good_however_dear_the_motion_is() -> None:
    dear = 'task.objectives=[{kind="bending",weight=10.0}]'
    found = solve(problem(*SMALL, dear, PLACE.replace("RADIUS", "0.01")), starts=1).best
    assert found.status is Status.SOLVED
    assert found.cost > 1.0  # more than rest misses
    assert found.note is None
    assert solve(problem(*SMALL, dear), starts=1).best.note is not None
