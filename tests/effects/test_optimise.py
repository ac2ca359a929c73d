"""Gaits optimised under extended models: exact derivatives, certified by the forward simulation."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import serpenoid as sp
from effects.conftest import extended, medium_for, place_of, typical
from serpenoid.effects import ActiveEffect, catalogue, find
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics.tables import joint_table
from serpenoid.media import DEFAULT
from serpenoid.model import Model
from serpenoid.optimise.step.extended import realised_angles
from serpenoid.problem import Problem, Robust
from serpenoid.results import write_simulation
from serpenoid.simulation.servos import realise_gait
from serpenoid.table_file import read_table
from specimens import nlp_of

OPTIMISED = [n for n, e in catalogue().items() if e.applies_to("nlp")]
SERVOS = ("servo_lag", "backlash", "gain_loss", "zero_offset")
MIXED = ("inertia", "slope", "worn_wheel", "servo_lag", "zero_offset", "grip_saturation")


@pytest.fixture(scope="module")
def start(problem: Problem) -> EllipseGait:
    """The baseline's optimum."""
    return sp.solve_from(wanted(problem), EllipseGait(a=6)).gait


def wanted(problem: Problem, *effects: ActiveEffect) -> Problem:
    """Joint limits, some price of dissipation, 30 steps: quick; dry friction moves farther, by a finer mesh."""
    medium = medium_for(problem.medium, *effects)
    task = problem.task.model_copy(update={"c": 0.5, "steps": 30 if medium.law == DEFAULT else 60})
    return problem.model_copy(update={"task": task, "effects": effects, "medium": medium})


# one of each kind always: of servos, shapes, one vertex, directions, the floor, the law, time
ALWAYS = ("servo_lag", "backlash", "zero_offset", "worn_wheel", "left_right_asymmetry", "slope", "friction_patch",
          "dry_friction", "grip_saturation", "anisotropy_drift", "inertia")  # fmt: skip


@pytest.mark.parametrize("name", [pytest.param(n, marks=[] if n in ALWAYS else pytest.mark.slow) for n in OPTIMISED])
def test_optimum_with_an_effect_is_certified_and_no_worse_than_the_baselines(
    name: str, problem: Problem, start: EllipseGait
) -> None:
    changed = wanted(problem, typical(name))
    solution = sp.solve_from(changed, start)
    assert solution.status.ok, solution.status.value
    assert solution.resimulation_error < 1e-8
    assert solution.polishing_gain is not None
    assert solution.polishing_gain < 1e-6
    if not getattr(find(name), "limits", False):  # there the baseline's gait is forbidden
        table = joint_table(changed.model, start.parameters, changed.task.steps)
        old = sp.simulate_joint_angles(changed.model, table)
        assert solution.cost <= -old.displacement + 0.5 * old.dissipation + 1e-9


@pytest.mark.parametrize("width", [0.03, 0.15, 0.4, 1.5])
def test_play_in_a_joint_is_optimised_up_to_a_joint_that_never_moves(
    width: float, problem: Problem, start: EllipseGait
) -> None:
    """The motion has kinks in the gait parameters where a row begins to follow; optima lie between them."""
    changed = wanted(problem, ActiveEffect.of("backlash", 5, width=width))
    solution = sp.solve_from(changed, start)
    assert solution.status.ok, solution.status.value


@pytest.mark.parametrize("healthy", [False, True])
def test_a_stuck_joint_is_told_to_stay_unless_a_case_is_served_in_which_it_moves(
    healthy: bool, problem: Problem, tmp_path: Path
) -> None:
    stuck = 'effects = [{ name = "stuck_joint", place = 3, angle = 0.3 }]'
    for name, effects in (("one", stuck), ("other", "" if healthy else stuck)):
        (tmp_path / f"{name}.toml").write_text(f"{effects}\n[medium]\nanisotropy_ratio = 0.2\n")
    robust = Robust(models=tuple(str(tmp_path / f"{name}.toml") for name in ("one", "other")))
    task = problem.task.model_copy(update={"robust": robust, "steps": 20})
    played = sp.simulate(problem.model_copy(update={"effects": (ActiveEffect.of("stuck_joint", 3, angle=0.3),)}))
    shown = replace(played, problem=played.problem.model_copy(update={"task": task}))
    write_simulation(tmp_path / "results", shown, figures=False)
    told = read_table(tmp_path / "results" / "joint_table.csv")
    assert (told[:, 2] == 0.3).all() == (not healthy)
    np.testing.assert_array_equal(np.delete(told, 2, 1), np.delete(played.table, 2, 1))
    motion = sp.simulate_joint_angles(played.problem.model, told)
    np.testing.assert_allclose(motion.poses, played.trajectory.poses, atol=1e-14)  # rounding of a + (b - a)


@pytest.mark.parametrize("steps", [12, 50])
@pytest.mark.parametrize(
    "names",
    [
        ("servo_delay",),
        ("servo_lag",),
        ("servo_inertia",),
        ("backlash",),
        ("gain_loss",),
        ("stuck_joint",),
        ("zero_offset",),
        SERVOS,
        ("servo_delay", *SERVOS),
    ],
)
def test_formula_of_the_steady_state_is_where_playing_again_and_again_ends(
    names: tuple[str, ...], steps: int, problem: Problem
) -> None:
    model = extended(problem, *(typical(n) for n in names))
    q, edges = problem.gait.parameters, model.body.edges  # type: ignore[union-attr]
    played = realise_gait(model, joint_table(model, q, steps))
    row, family = ca.SX.sym("row"), problem.gait.of(model.body.joint_count, steps)
    angles = realised_angles(model, family, ca.SX(q), row / steps, ca.SX(edges), steps)
    formula = ca.Function("formula", [row], [angles])
    found = np.array([formula(i).full()[:, 0] for i in range(steps + 1)])
    np.testing.assert_allclose(found, np.concatenate([played, played[:1]]), atol=1e-12)


def test_cameras_do_not_change_the_optimum(problem: Problem, start: EllipseGait) -> None:
    solution = sp.solve_from(wanted(problem, typical("marker_offset")), start)
    np.testing.assert_allclose(solution.gait.parameters, start.parameters, atol=1e-5)


def test_a_gait_for_saturating_servos_stays_below_their_speed(problem: Problem, start: EllipseGait) -> None:
    slow = ActiveEffect.of("speed_saturation", max_speed=0.4)
    solution = sp.solve_from(wanted(problem, slow), start)
    assert solution.status.ok
    speed = np.abs(np.diff(solution.table, axis=0, append=solution.table[:1])).max() * len(solution.table) / 5.0
    assert speed == pytest.approx(0.4, rel=1e-6)


@pytest.mark.parametrize("present", [("worn_wheel",), MIXED])
def test_derivatives_of_the_nlp_are_those_of_its_values(present: tuple[str, ...], problem: Problem) -> None:
    model = extended(problem, *(ActiveEffect.typical(n, place_of(n)) for n in present))
    functions = nlp_of(model, 8).functions()
    rng = np.random.default_rng(0)
    q = problem.gait.parameters  # type: ignore[union-attr]
    motion = sp.simulate_joint_angles(model, joint_table(model, q, 8))
    x = np.concatenate([(motion.poses[1:] - motion.poses[0]).ravel(), q]) + 1e-3 * rng.standard_normal(30)
    p = np.concatenate([[0.7], model.parameters])
    direction, multipliers, h = rng.standard_normal(30), rng.standard_normal(24), 1e-6
    up, down = x + h * direction, x - h * direction
    g, jacobian = functions["jac_g"](x, p)
    change = (functions["g"](up, p) - functions["g"](down, p)).full()[:, 0] / (2 * h)
    np.testing.assert_allclose((jacobian @ direction).full()[:, 0], change, atol=1e-6)
    upper = functions["hess_lag"](x, p, 1.3, multipliers).full()
    hessian = upper + np.triu(upper, 1).T

    def slope(at: np.ndarray) -> np.ndarray:
        gradient, rows = functions["grad_f"](at, p)[1], functions["jac_g"](at, p)[1]
        return (1.3 * gradient + rows.T @ multipliers).full()[:, 0]

    np.testing.assert_allclose(hessian @ direction, (slope(up) - slope(down)) / (2 * h), atol=2e-5)


@pytest.mark.parametrize(
    ("present", "dissipation"),
    [(("inertia",), "vertex"), (("slope", "servo_lag", "gain_loss"), "vertex"), (("servo_lag", "stuck_joint"), "edge")],
)
def test_simulated_motion_satisfies_the_nlps_equations(
    present: tuple[str, ...], dissipation: str, problem: Problem
) -> None:
    medium = problem.medium.model_copy(update={"dissipation": dissipation})
    model = Model(problem.body, medium, tuple(typical(n) for n in present), 5.0)
    q = problem.gait.parameters  # type: ignore[union-attr]
    motion = sp.simulate_joint_angles(model, joint_table(model, q, 20))
    x = np.concatenate([(motion.poses[1:] - motion.poses[0]).ravel(), q])
    residual = nlp_of(model, 20).functions()["g"](x, np.concatenate([[0.0], model.parameters]))
    assert np.abs(residual.full()).max() < 1e-10
