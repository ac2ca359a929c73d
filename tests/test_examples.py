"""The examples in problems/: they run, and what they show holds."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
from pathlib import Path
from types import ModuleType

import casadi as ca
import numpy as np
import pytest

import serpenoid as sp

PROBLEMS = Path(__file__).parents[1] / "problems"


def example(name: str) -> ModuleType:
    """An example file as a module."""
    spec = importlib.util.spec_from_file_location(name, PROBLEMS / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_own_constraint_binds_and_own_term_counts() -> None:
    own = example("own_objective")
    problem = sp.load(own.PROBLEM, set=["task.c=0.5"])
    plain, gentle = sp.solve(problem, starts=1).best, sp.solve(problem, starts=1, customise=own.gentle).best
    assert gentle.status.ok
    assert np.mean(plain.table**2) > own.CAP
    assert np.mean(gentle.table**2) <= own.CAP + 1e-9  # IPOPT's constraint tolerance is 1e-10
    offset = own.OFFSET_PRICE * (gentle.gait.x_c**2 + gentle.gait.y_c**2)
    built_in = -gentle.trajectory.displacement + 0.5 * gentle.trajectory.dissipation
    assert gentle.cost == pytest.approx(built_in + offset, abs=1e-9)
    assert gentle.objective == pytest.approx(gentle.cost, abs=1e-9)  # poses agree to 1e-8, in fact to 1e-13
    assert gentle.polishing_gain is not None
    assert plain.objective == pytest.approx(plain.cost, abs=1e-9)


def test_own_objective_chooses_the_best_start() -> None:
    own = example("own_objective")
    result = sp.solve(sp.load(own.PROBLEM), starts=2, customise=own.thrifty)
    price = [s.trajectory.dissipation / s.trajectory.displacement for s in result.solutions]
    assert result.best.objective == pytest.approx(min(price), abs=1e-7)
    assert result.best.trajectory.displacement >= 0.2 - 1e-9


def test_functions_survive_saving_and_momentum_vanishes_on_the_motion(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    symbols = example("open_symbols")
    symbols.main(tmp_path)
    assert "gait_nlp_hessian: x (156, 1)" in capsys.readouterr().out
    problem = sp.load(symbols.PROBLEM)
    assert symbols.largest_momentum(problem) <= 1e-12  # the simulation's own tolerance per step
    rng = np.random.default_rng(0)
    for number, function in enumerate(symbols.open_functions(problem)):
        loaded = ca.Function.load(str(tmp_path / f"{number:02d}-{function.name()}.casadi"))
        inputs = [rng.uniform(0.2, 1.0, function.size_in(i)) for i in range(function.n_in())]
        for mine, theirs in zip(function.call(inputs), loaded.call(inputs), strict=True):
            np.testing.assert_array_equal(mine.full(), theirs.full())


@pytest.mark.slow
def test_torques_of_the_opened_nlp_do_the_work_that_is_dissipated_and_the_least_peak_is_certified() -> None:
    own = example("own_solver")
    problem = sp.load(own.PROBLEM, [*own.SET, "task.steps=80"])
    nlp = sp.gait_nlp(problem, portable=True)
    simulated = sp.simulate(problem)
    x = np.append(simulated.trajectory.poses[1:].ravel(), problem.gait.parameters)
    at = ca.Function("at", [nlp.variables, nlp.parameters], [own.torques(problem, nlp), nlp.joint_angles, nlp.poses])
    torques, angles, poses = (value.full() for value in at(x, sp.nlp_arguments(problem)["p"]))
    np.testing.assert_allclose(angles.T, simulated.table, atol=1e-12)
    np.testing.assert_allclose(poses.T, simulated.trajectory.poses, atol=1e-12)
    work = (torques * (np.roll(angles, -1, axis=1) - angles)).sum()
    assert work == pytest.approx(2 * simulated.trajectory.dissipation, rel=2e-3)  # steps are of second order
    problem = sp.load(own.PROBLEM, own.SET)
    found = own.least_peak(problem)
    assert found["status"] == "Solve_Succeeded"
    assert found["peak"] < 0.5 * found["first"]
    assert found["curvature"] > 0
    assert found["certificate"].status.ok
    assert found["certificate"].trajectory.displacement >= 0.3 - 1e-8
    again = own.least_peak(problem, found["gait"])  # from an earlier answer
    assert again["peak"] == pytest.approx(found["peak"], abs=1e-8)


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_portable_nlp_stands_alone_as_c(tmp_path: Path) -> None:
    symbols = example("open_symbols")
    problem = sp.load(symbols.PROBLEM)
    nlp = sp.gait_nlp(sp.load(symbols.PROBLEM, ["task.steps=10"]), portable=True)
    constraints = nlp.functions()["g"]
    source, library = tmp_path / "g.c", tmp_path / "g.so"
    source.write_text(symbols.generate_c([constraints]), encoding="utf-8")
    subprocess.run(["cc", "-shared", "-fPIC", str(source), "-o", str(library), "-lm"], check=True)
    q = problem.gait.parameters
    x = np.concatenate([np.random.default_rng(1).normal(size=30), q])
    p = np.concatenate([[0.0], problem.model.parameters])
    outside = ca.external(constraints.name(), str(library))(x, p).full()
    np.testing.assert_allclose(outside, constraints(x, p).full(), rtol=0, atol=1e-12)
