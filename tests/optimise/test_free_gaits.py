"""Free joint tables: exact derivatives, agreement with the ellipse, certified optima, invariants."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from serpenoid.body import Body, Floats
from serpenoid.gaits import EllipseGait, Gait, TableGait
from serpenoid.gaits.fourier import FourierGait
from serpenoid.gaits.fourier_joints import JointSeriesGait
from serpenoid.gaits.spline import SplineGait
from serpenoid.mechanics.tables import family_tables, joint_table
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.objectives import Criteria, demands, terms
from serpenoid.optimise.clear.apart import Near, keep_apart
from serpenoid.optimise.program.transcription import GaitNLP
from serpenoid.optimise.solve import solve, solve_from
from serpenoid.problem import Task
from serpenoid.simulation import simulate_joint_angles
from serpenoid.status import Status
from specimens import nlp_of, oracle_run, phases_of_rows, problem, uneven

STEPS = 6
Q = np.array([0.6, 0.5, -0.8, 0.3, 4.0, 1.1])
# problems/reach.toml, w = 10 and w = 100: all of 20 seeds (results/benchmarks/published.md)
REACHED, REACHED_DEARLY = 0.0041234, 0.0408990

EFFORT = Task.model_validate({"c": 0.6, "objectives": [{"kind": "position", "target": (0.3, 0.1), "weight": 2.0}]})
BENDING = Task.model_validate({"objectives": [{"kind": "bending"}, {"kind": "displacement"}, {"kind": "effort"}]})
DEMANDS = Task.model_validate(
    {
        "demands": [
            {"kind": "reach", "target": (0.2, 0.0), "cycles": 3, "heading_rad": 0.1},
            {"kind": "travel", "least": 0.1},
        ]
    }
)
WORLD = Task.model_validate(
    {
        "demands": [
            {"kind": "disc", "centre": (0.9, 0.4), "radius": 0.2},
            {"kind": "box", "half_widths": (2.0, 1.5), "inside": True, "angle_rad": 0.3},
            {"kind": "half_plane", "point": (0.0, -1.0), "normal": (0.1, 2.0)},
        ]
    }
)
LINE = ((-0.3, 0.0), (0.1, 0.1), (0.5, -0.2))
WAYS = Task.model_validate(
    {
        "objectives": [
            {"kind": "path", "line": LINE, "cycles": 2},
            {"kind": "path", "line": LINE, "point": "head", "weight": 0.7},
        ],
        "demands": [{"kind": "shape", "at": 0.5, "still": True}, {"kind": "swing"}],
    }
)
RATES = Task.model_validate(
    {
        "objectives": [
            {"kind": "efficiency"},
            {"kind": "transport", "idle": 0.4, "weight": 0.1},
            {"kind": "heading", "target_rad": 0.3, "cycles": 2},
        ],
        "demands": [{"kind": "self", "distance": 0.1}],
    }
)
NEAR = Near(share=0.3, step=2, vertex=0, begin=4, end=5), Near(share=0.8, step=5, vertex=7, begin=2, end=3)
CORRIDOR = Task.model_validate(
    {"demands": [{"kind": "corridor", "line": ((-2.0, 0.1), (1.0, -0.2), (2.0, 0.3)), "half_width": 1.5}]}
)
TASKS = {
    "rates": RATES,
    "ways": WAYS,
    "obstacles": WORLD,
    "position and dissipation": EFFORT,
    "bending and effort": BENDING,
    "demands": DEMANDS,
}
GAITS: dict[str, Gait] = {
    "table": TableGait(),
    "ellipse": EllipseGait(),
    "fourier": FourierGait(orders=(1, 3)),
    "two modes": FourierGait(orders=(1,), xi=(0.8, 1.7)),
    "fourier-joints": JointSeriesGait(orders=(1, 2)),
    "spline": SplineGait(points=5),
}


def own(of: Criteria) -> None:
    """Not linear in the dissipation, which becomes a variable; pairs that keep off each other, as `self` adds them."""
    of.also_minimise((0.1 + of.dissipation) / (1 + of.displacement))
    of.subject_to(of.dissipation * of.joint_angles[0, 0], -1.0, 1.0)
    keep_apart(of, uneven("vertex"), NEAR, 0.1)


def differences(nlp: GaitNLP, x: Floats, p: Floats, seed: int) -> None:
    """Jacobian, gradient and Hessian against central differences of values and of the Lagrangian's slope."""
    made, h = nlp.functions(), 1e-6
    rng = np.random.default_rng(seed)
    direction, multipliers = rng.normal(size=x.size), rng.normal(size=sum(nlp.constraint_counts))
    up, down = x + h * direction, x - h * direction
    change = (made["g"](up, p) - made["g"](down, p)).full()[:, 0] / (2 * h)
    np.testing.assert_allclose((made["jac_g"](x, p)[1] @ direction).full()[:, 0], change, atol=2e-7)
    fall = float(made["f"](up, p) - made["f"](down, p)) / (2 * h)
    assert float(made["grad_f"](x, p)[1].T @ direction) == pytest.approx(fall, abs=2e-7)

    def slope(at: Floats) -> Floats:
        return (1.3 * made["grad_f"](at, p)[1] + made["jac_g"](at, p)[1].T @ multipliers).full()[:, 0]

    upper = ca.densify(made["hess_lag"](x, p, 1.3, multipliers)).full()
    assert np.abs(np.tril(upper, -1)).max() == 0
    hessian = upper + np.triu(upper, 1).T
    # truncation h^2 times third derivatives (1e5 with T^2), cancellation 1e-13 / h
    np.testing.assert_allclose(hessian @ direction, (slope(up) - slope(down)) / (2 * h), atol=5e-6)


@pytest.mark.usefixtures("virtual_machine")
@pytest.mark.parametrize("dissipation", ["vertex", "edge"])
@pytest.mark.parametrize("gait", GAITS)
@pytest.mark.parametrize("task", TASKS)
def test_derivatives_are_differences_for_every_family_and_criterion(task: str, gait: str, dissipation: str) -> None:
    check(task, gait, dissipation)


@pytest.mark.usefixtures("virtual_machine")
def test_derivatives_are_differences_in_a_corridor_with_a_bend() -> None:
    check("corridor", "table", "edge")


def check(task: str, gait: str, dissipation: str) -> None:
    """Derivatives of the NLP of a task and a family at a random point."""
    model = uneven(dissipation)
    rows = 2 if gait in ("ellipse", "fourier") else 0
    nlp = nlp_of(
        model, STEPS, rows, GAITS[gait], own if task == "rates" else None, (TASKS | {"corridor": CORRIDOR})[task]
    )
    rng = np.random.default_rng(5)
    parameters = (
        nlp.family.start() + 0.3 * rng.normal(size=nlp.family.size)
        if rows
        else 0.4 + 0.3 * rng.normal(size=nlp.family.size)
    )
    priced = [0.4] if nlp.priced else []
    x = np.concatenate([0.2 * rng.normal(size=3 * STEPS), priced, parameters])
    if task == "rates":
        x[3 * STEPS - 3] = 0.8  # away from rest: what is divided by the way is steep there
    differences(nlp, x, np.concatenate([[0.7], phases_of_rows([0.1, 0.4][:rows], STEPS), model.parameters]), seed=6)


def test_no_objective_or_demand_is_left_out() -> None:
    parts = [part for task in (*TASKS.values(), CORRIDOR) for part in (*task.objectives, *task.demands)]
    assert {part.kind for part in parts} == {kind.model_fields["kind"].default for kind in (*terms(), *demands())}


@pytest.mark.usefixtures("virtual_machine")
@pytest.mark.parametrize("dissipation", ["vertex", "edge"])
def test_an_ellipse_as_a_table_has_the_same_residuals_up_to_the_frame_and_the_same_gradient(dissipation: str) -> None:
    model = uneven(dissipation)
    ellipse, table = nlp_of(model, STEPS), nlp_of(model, STEPS, gait=TableGait())
    angles = joint_table(model, Q, STEPS)
    motion = simulate_joint_angles(model, angles)
    p, poses = np.concatenate([[0.7], model.parameters]), motion.poses[1:].ravel()
    first, second = np.concatenate([poses, Q]), np.concatenate([poses, angles.ravel()])
    for nlp, x in ((ellipse, first), (table, second)):
        assert np.abs(nlp.functions()["g"](x, p).full()).max() < 1e-10
    one, other = (reduced_gradient(nlp, x, p) for nlp, x in ((ellipse, first), (table, second)))
    chain = slopes(lambda q: joint_table(model, q, STEPS).ravel(), Q)
    np.testing.assert_allclose(chain @ other, one, atol=1e-9)


@pytest.mark.usefixtures("virtual_machine")
@pytest.mark.parametrize("dissipation", ["vertex", "edge"])
def test_every_family_that_holds_the_ellipse_gives_its_table_motion_and_gradient(dissipation: str) -> None:
    model, ellipse = uneven(dissipation), EllipseGait.from_parameters(Q)
    table = joint_table(model, Q, STEPS)
    larger = [FourierGait.from_ellipse(ellipse, (1, 2)), FourierGait.from_ellipse(ellipse, (1,), modes=2)]
    series, splines = JointSeriesGait.from_table(table, (1,)), SplineGait.from_table(table, STEPS)
    p = np.concatenate([[0.7], model.parameters])
    steps = 3 * STEPS
    free = nlp_of(model, STEPS, gait=TableGait())
    poses = simulate_joint_angles(model, table).poses[1:].ravel()
    at_table = np.concatenate([poses, table.ravel()])
    by_angles, value = reduced_gradient(free, at_table, p), float(free.functions()["f"](at_table, p))
    for gait in (*larger, series, splines):
        nlp = nlp_of(model, STEPS, gait=gait)
        q, family = nlp.family.start(), nlp.family
        np.testing.assert_allclose(family_tables(model, family, q[None])[0], table, atol=1e-12)
        assert np.abs(nlp.functions()["g"](np.concatenate([poses, q]), p).full()[:steps]).max() < 1e-10
        x = np.concatenate([poses, q])
        assert float(nlp.functions()["f"](x, p)) == pytest.approx(value, abs=1e-12)
        chain = slopes(lambda at, family=family: family_tables(model, family, at[None]).ravel(), q)
        np.testing.assert_allclose(chain @ by_angles, reduced_gradient(nlp, x, p), atol=1e-9)


def slopes(function: Callable[[Floats], Floats], q: Floats) -> Floats:
    """Derivatives (n, K) by central differences of three widths, extrapolated: errors of order h^6, 1e-12."""
    widths = 0.02 / 2.0 ** np.arange(3)
    d1, d2, d3 = (
        np.array([function(q + h * e) - function(q - h * e) for e in np.eye(q.size)]) / (2 * h) for h in widths
    )
    once, again = (4 * d2 - d1) / 3, (4 * d3 - d2) / 3
    return (16 * again - once) / 15


def reduced_gradient(nlp: GaitNLP, x: Floats, p: Floats) -> Floats:
    """Derivative of the objective by the gait parameters along the motions: the poses follow."""
    n, made = 3 * nlp.steps, nlp.functions()
    slope, jacobian = made["grad_f"](x, p)[1].full()[:, 0], made["jac_g"](x, p)[1].full()
    return slope[n:] - jacobian[:, n:].T @ np.linalg.solve(jacobian[:, :n].T, slope[:n])


@pytest.mark.parametrize(("c", "reached", "starts"), [(0.125, REACHED, 2), (1.25, REACHED_DEARLY, 1)])
def test_the_reach_problem_is_solved_certified_and_confirmed_by_the_oracle(
    c: float, reached: float, starts: int
) -> None:
    result = solve(problem("reach", f"task.c={c}"), starts, seed=3)
    best = result.best
    assert not result.failures
    assert len(result.optima) == 1
    assert best.status is Status.SOLVED
    assert best.cost == pytest.approx(reached, abs=5e-8)
    run = oracle_run(best.problem.model, best.table)
    goal = 5 * np.sum((run.poses[-1, :2] - [1, 0]) ** 2) + c * run.dissipation
    assert goal == pytest.approx(best.cost, abs=1e-9)
    assert np.abs(best.table).max() <= np.deg2rad(63) + 1e-9


def test_a_free_table_is_at_least_as_good_as_the_ellipse_it_starts_from() -> None:
    asked = problem("reference-optimum", "task.steps=24", "task.c=0.3", "body.vertices=7")
    ellipse = solve_from(asked, EllipseGait(sigma=0.6, a=5.0, xi=1.0))
    bent = asked.task.model_copy(update={"objectives": (*asked.task.objectives,)})
    table = solve_from(asked.model_copy(update={"task": bent}), TableGait.from_angles(ellipse.table))
    assert ellipse.residuals.largest <= 1e-8
    assert table.residuals.largest <= 1e-8
    assert table.resimulation_error <= 1e-8
    assert table.cost <= ellipse.cost + 1e-9
    assert np.abs(table.table).max() <= np.deg2rad(60) + 1e-9


@pytest.mark.usefixtures("virtual_machine")
def test_one_joint_goes_nowhere_with_a_free_gait_on_a_fine_mesh() -> None:
    model = Model(Body(vertices=3), Medium(anisotropy_ratio=0.3))
    rng, phase = np.random.default_rng(2), 2 * np.pi * np.arange(400)[:, None] / 400
    table = sum(0.2 * rng.normal() * np.cos(k * phase + rng.uniform(0, 6)) for k in (1, 2, 3))
    assert simulate_joint_angles(model, table).displacement < 1e-4  # second order in the step: 1e-2 at 40 steps


def test_a_cycle_whose_joints_leap_between_rows_is_spread_over_rows_and_a_resolved_wave_is_left_alone() -> None:
    phase = 2 * np.pi * np.arange(40)[:, None] / 40
    wave = np.cos(phase + np.array([0.0, 1.0, 2.0]))
    leap = np.sign(wave)  # from limit to limit in one step
    for table, same in ((wave, True), (leap, False)):
        family = TableGait.from_angles(table).of(3, 40)
        found = family.resolved(table.ravel()).reshape(40, 3)
        assert np.array_equal(found, table) is same
        # a moving mean keeps the mean and stays within the angles it is of
        assert found.mean(0) == pytest.approx(table.mean(0), abs=1e-12)
        assert np.abs(found).max() <= 1.0
    assert np.abs(np.roll(found, -1, axis=0) - found).max() < 1.0
