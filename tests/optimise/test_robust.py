"""Robust gaits: worst and mean cases over ratios, model files and what a diagnosis left open; by independent routes."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from serpenoid.body import Floats
from serpenoid.cases import cases_of
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.optimise.program.prepared import Carried
from serpenoid.optimise.robust import RobustSolver
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve, solve_from
from serpenoid.plot.figures import motion_figure
from serpenoid.problem import Problem
from serpenoid.results import write_solution
from serpenoid.status import Status
from specimens import oracle_run, problem

SMALL = "body.vertices=6", "task.steps=24", "task.c=0.5"
WORST = 'task.robust={over="worst", anisotropy_ratio=[0.1, 0.4]}'
MEAN = 'task.robust={over="mean", anisotropy_ratio=[0.1, 0.4]}'


def small(*changes: str) -> Problem:
    return problem("reference-optimum", *SMALL, *changes)


def value(found: Solution, ratio: float) -> float:
    """The objective of a gait on a floor, by the independent simulator."""
    model = found.problem.model
    run = oracle_run(replace(model, medium=model.medium.with_ratio(ratio)), found.table)
    return float(-run.displacement + 0.5 * run.dissipation)


@pytest.fixture(scope="module")
def plain() -> Solution:
    return solve(small(), starts=1, seed=1).best


@pytest.fixture(scope="module")
def worst() -> Solution:
    return solve(small(WORST), starts=1, seed=1).best


def test_the_best_worst_case_is_better_in_the_worst_case_and_no_better_elsewhere(
    plain: Solution, worst: Solution
) -> None:
    assert worst.status is Status.SOLVED
    grid = np.linspace(0.1, 0.4, 4)
    least = max(value(worst, ratio) for ratio in grid)
    assert worst.cost == pytest.approx(least, abs=1e-9)
    assert least < max(value(plain, ratio) for ratio in grid) - 1e-3
    assert value(worst, 0.1865) >= plain.cost - 1e-8


def test_the_headline_says_in_which_medium_it_is_and_whether_that_is_a_case(
    worst: Solution, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    said = "in the problem's own medium (anisotropy ratio 0.1865), which is none of the cases"
    assert worst.headline_note == said
    assert f"displacement {said}" in worst.summary()
    record = write_solution(tmp_path, worst, figures=False)
    assert record["robust"]["headline"] == said
    assert main(["show", str(tmp_path)]) == 0
    out = capsys.readouterr().out
    assert f"{worst.trajectory.displacement:.6g} body lengths in 1 cycle {said}" in out
    for case in worst.cases:
        assert f"{case.name:18}objective {case.value:.6g}, {case.trajectory.displacement:.6g} body lengths" in out
    same = replace(worst, trajectory=worst.cases[0].trajectory)
    assert same.headline_note is not None
    assert same.headline_note.endswith(", the case eps 0.1")
    title = motion_figure(worst.trajectory, worst.problem).axes[0].get_title(loc="left")
    assert "in the problem's own medium; each case: cases.png" in title


def test_one_model_alone_has_no_words_of_cases(plain: Solution) -> None:
    assert plain.headline_note is None
    assert "medium" not in motion_figure(plain.trajectory, plain.problem).axes[0].get_title(loc="left")


def test_where_one_floor_is_always_the_worst_its_own_optimum_is_the_answer(worst: Solution) -> None:
    own = solve_from(small("medium.anisotropy_ratio=0.4"), worst.gait)
    assert own.cost == pytest.approx(worst.cost, abs=1e-7)


def test_the_mean_is_the_integral_over_the_interval() -> None:
    found = solve(small(MEAN), starts=1).best
    assert found.status is Status.SOLVED
    grid = np.linspace(0.1, 0.4, 11)
    mean = np.trapezoid([value(found, ratio) for ratio in grid], grid) / 0.3
    assert found.cost == pytest.approx(mean, abs=3e-3)  # three nodes, 11 trapezoids
    assert sum(case.weight for case in found.cases) == pytest.approx(1.0)


def test_a_floor_inside_the_interval_that_is_worse_becomes_a_case() -> None:
    place = 'task.objectives=[{kind="position",target=[0.25,0.0],weight=5.0}]'
    found = solve(problem("reach", "body.vertices=6", "task.steps=16", "task.c=0.1", place,
                          "task.robust={anisotropy_ratio=[0.03, 0.2]}"), starts=1).best  # fmt: skip
    assert found.residuals.largest <= 1e-8
    assert found.resimulation_error <= 1e-8
    assert len(found.cases) > 2
    model = found.problem.model

    def objective(ratio: float) -> float:
        run = oracle_run(replace(model, medium=Medium(anisotropy_ratio=ratio, dissipation="edge")), found.table)
        return float(5 * np.sum((run.poses[-1, :2] - [0.25, 0]) ** 2) + 0.1 * run.dissipation)

    assert max(objective(ratio) for ratio in np.linspace(0.03, 0.2, 12)) <= found.cost + 1e-6


@pytest.mark.parametrize("robust", [WORST, MEAN])
def test_derivatives_of_all_cases_together_are_those_of_differences(robust: str) -> None:
    solver = RobustSolver(problem("reference-optimum", "body.vertices=4", "task.steps=4", "task.c=0.5", robust))
    carried = Carried((0, 2))
    nlp, _ = solver.prepared(carried)
    functions, p = nlp.functions(), solver.parameters(0.5, carried.rows)
    rng = np.random.default_rng(3)
    x = solver.start(solver.own_start()) + 0.01 * rng.normal(size=nlp.variables.numel())
    lam = rng.normal(size=sum(nlp.constraint_counts))

    def lagrangian(z: Floats) -> Floats:
        """Gradient of 0.7 f + lam . g."""
        _, slope = functions["grad_f"](z, p)
        _, jacobian = functions["jac_g"](z, p)
        return np.asarray((0.7 * slope + jacobian.T @ ca.DM(lam)).full()[:, 0])

    def values(z: Floats) -> float:
        return float(0.7 * functions["f"](z, p) + ca.dot(ca.DM(lam), functions["g"](z, p)))

    upper = functions["hess_lag"](x, p, 0.7, lam).full()
    hessian = upper + np.triu(upper, 1).T
    for _ in range(3):
        way, h = rng.normal(size=x.size), 1e-5
        slope = (values(x + h * way) - values(x - h * way)) / (2 * h)
        assert slope == pytest.approx(lagrangian(x) @ way, rel=1e-6, abs=1e-6)  # differences of second order
        bend = (lagrangian(x + h * way) - lagrangian(x - h * way)) / (2 * h)
        np.testing.assert_allclose(bend, hessian @ way, rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("robust", [WORST, MEAN])
def test_a_robust_search_watches_whether_the_body_of_its_first_case_stands(robust: str) -> None:
    solver = RobustSolver(problem("reference-optimum", "body.vertices=4", "task.steps=4", robust))
    _, ipopt = solver.prepared(solver.first())
    q = solver.own_start()
    first = solver.each[0].simulate(q).poses[1:].ravel()
    np.testing.assert_array_equal(solver.start(q)[: ipopt._callback.poses], first)


MODEL = '[medium]\nanisotropy_ratio = 0.2\n\n[[effects]]\nname = "gain_loss"\nplace = 2\nloss = 0.3\n'


def diagnosed(folder: Path, alternatives: object) -> Problem:
    (folder / "extended-model.toml").write_text(MODEL)
    (folder / "diagnosis.json").write_text(json.dumps({"alternatives": alternatives}))
    return small(f'task.robust={{diagnosis="{folder}"}}')


def test_what_a_diagnosis_left_open_is_served_together(tmp_path: Path) -> None:
    rival = {"name": "gain_loss", "place": 3, "parameters": {"loss": 0.4},
             "instead_of": {"name": "gain_loss", "place": 2}}  # fmt: skip
    wanted = diagnosed(tmp_path, [rival])
    places = [[e.place for e in case.problem.effects] for case in cases_of(wanted)]
    assert places == [[2], [3]]
    found = solve(wanted, starts=1).best
    assert found.status is Status.SOLVED
    for case, (place, loss) in zip(found.cases, [(2, 0.3), (3, 0.4)], strict=True):
        table = found.table * np.where(np.arange(4) == place - 1, 1 - loss, 1.0)
        run = oracle_run(Model(wanted.body, Medium(anisotropy_ratio=0.2)), table)
        assert case.value == pytest.approx(-run.displacement + 0.5 * run.dissipation, abs=1e-9)
    assert found.cost == max(case.value for case in found.cases)


def test_model_files_stand_beside_the_problem(tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(MODEL)
    (tmp_path / "b.toml").write_text("[medium]\nanisotropy_ratio = 0.4\n")
    wanted = small(f'task.robust={{models=["{tmp_path}/a.toml", "{tmp_path}/b.toml"], over="mean"}}')
    assert [(case.name, case.weight) for case in cases_of(wanted)] == [("a", 0.5), ("b", 0.5)]
    asked = wanted.hash
    (tmp_path / "b.toml").write_text("[body]\nvertices = 9\n[medium]\nanisotropy_ratio = 0.4\n")
    assert wanted.hash != asked  # no answer for other models is taken for this one's
    with pytest.raises(InputError, match="7 joints, the problem 4"):
        cases_of(wanted)


@pytest.mark.parametrize(("robust", "message"), [
    ("{anisotropy_ratio=[0.4, 0.1]}", r"needs \[lower, upper\]"),
    ("{}", "give one of"),
    ('{anisotropy_ratio=[0.1, 0.4], models=["a.toml"]}', "give one of"),
    ('{anisotropy_ratio=[0.1, 0.4], over="best"}', "over"),
])  # fmt: skip
def test_faults_in_cases_are_named(robust: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        small(f"task.robust={robust}")


def test_a_damaged_diagnosis_and_obstacles_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="alternatives"):
        cases_of(diagnosed(tmp_path, None))
    with pytest.raises(InputError, match="alternatives"):
        cases_of(diagnosed(tmp_path, [{"name": "gain_loss"}]))
    with pytest.raises(InputError, match="obstacles"):
        RobustSolver(small(WORST, 'task.demands=[{kind="disc",centre=[5.0,0.0],radius=0.1}]'))
