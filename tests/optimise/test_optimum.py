"""Optimal gaits: KKT residuals, re-simulation, the oracle, limits on every row, many starts, warm starts."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from serpenoid.body import Body, Floats
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics.tables import joint_table
from serpenoid.optimise.certify import certify
from serpenoid.optimise.interrupt import StopFlag
from serpenoid.optimise.ipopt import Point
from serpenoid.optimise.motions import Costs
from serpenoid.optimise.multistart import solve_many
from serpenoid.optimise.program.limits import path_limits, violations
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import improve, solve, solve_from
from serpenoid.optimise.solver import GaitSolver, Run
from serpenoid.optimise.starts import random_gaits, within
from serpenoid.status import Status
from specimens import oracle_run, problem

# the project's own bounds for believing an optimum
KKT, RESIMULATION, GAIN = 1e-8, 1e-8, 1e-6
SAME_OPTIMUM = 1e-8  # the objective is flat at an optimum: KKT 1e-8 leaves a difference of its square over a curvature

VARIANTS = {
    "reference-optimum": ("reference-optimum",),
    "with dissipation": ("reference-optimum", "task.c=1.0"),
    "straight": ("reference-optimum", "task.constraints.straight=true"),
    "turning": ("reference-optimum", "task.constraints.heading_change_rad=0.5"),
    "fixed frequency": ("reference-optimum", "task.constraints.spatial_frequency=1.5"),
    "slow servos": (
        "reference-optimum",
        "body.joint_speed_limit_rpm=57.0",
        "task.cycle_duration_s=0.6",
        "task.constraints.joint_speed_limits=true",
    ),
    "stiff joints": ("reference-optimum", "body.joint_limit_deg=40.0"),
    "edges": ("reference-optimum", 'medium.dissipation="edge"'),
    "snake10": ("snake10",),
    "purcell": ("purcell",),
    "bounds alone": ("gait-b", "task.constraints.joint_limits=false", "task.constraints.joint_speed_limits=false"),
}
every_variant = pytest.mark.parametrize("name", VARIANTS)


@lru_cache
def optimum(name: str) -> Solution:
    """The best of three starts of a variant, solved once in a process."""
    return solve(problem(*VARIANTS[name]), starts=3, seed=1).best


@every_variant
def test_the_optimum_is_stationary_resimulated_and_beats_its_neighbours(name: str) -> None:
    s = optimum(name)
    assert s.status is Status.SOLVED
    assert s.residuals.largest <= KKT
    assert s.resimulation_error <= RESIMULATION
    assert s.polishing_gain is not None
    assert s.polishing_gain < GAIN


@every_variant
def test_the_oracle_finds_the_same_motion_and_cost(name: str) -> None:
    s = optimum(name)
    run = oracle_run(s.problem.model, s.table)
    # 1e-9: what the two integrators agree to on any gait
    np.testing.assert_allclose(s.trajectory.poses, run.poses, atol=1e-9)
    assert s.cost == pytest.approx(-run.displacement + s.c * run.dissipation, abs=1e-9)


@every_variant
def test_limits_and_bounds_hold_on_every_row_of_the_table(name: str) -> None:
    s = optimum(name)
    limits = path_limits(s.problem)
    if limits.any:
        finite = np.isfinite(limits.upper)
        assert violations(s.table, limits)[:, finite].max() <= 1e-9
    lower, upper = GaitSolver(s.problem).gait_bounds()
    q = s.gait.parameters
    assert (q >= lower - 1e-12).all()
    assert (q <= upper + 1e-12).all()


def test_joint_limits_bind_where_the_free_optimum_would_bend_farther() -> None:
    free, stiff = optimum("reference-optimum"), optimum("stiff joints")
    assert np.rad2deg(np.abs(free.table).max()) > 45  # the 60 degrees of the reference optimum do not bind
    # IPOPT stays inside by the barrier parameter over the multiplier: 1e-9 over 0.1
    assert np.abs(stiff.table).max() == pytest.approx(np.deg2rad(40), abs=2e-8)
    assert stiff.cost > free.cost + 0.005


@pytest.mark.parametrize(
    ("name", "limit"), [("snake10", 25.0), ("snake10", 35.0), ("unequal links", 40.0), ("unequal links", 45.0)]
)
def test_a_limit_holds_at_every_row_wherever_it_binds(name: str, limit: float) -> None:
    """Rows that bind come and go between two solutions of one problem: each that ever bound must stay."""
    own = {"vertices": 8, "edge_lengths": (0.05, 0.12, 0.1, 0.08, 0.1, 0.07, 0.06)}
    wanted = problem("snake10", f"body.joint_limit_deg={limit}", "task.c=1.0")
    if name == "unequal links":
        wanted = wanted.model_copy(update={"body": Body(joint_limit_deg=limit, **own)})
    found = solve(wanted, starts=1, seed=0).best
    assert found.status.ok, found.status.value
    assert np.abs(found.table).max() <= np.deg2rad(limit) + 1e-9
    assert np.abs(found.table).max() > np.deg2rad(limit) - 1e-6  # it binds


def test_limits_that_do_not_bind_change_nothing() -> None:
    free = solve(problem("reference-optimum", "task.constraints.joint_limits=false"), starts=3, seed=1).best
    assert free.cost == pytest.approx(optimum("reference-optimum").cost, abs=SAME_OPTIMUM)


def test_dissipation_in_the_objective_lowers_the_dissipation() -> None:
    far, cheap = optimum("reference-optimum"), optimum("with dissipation")
    assert cheap.trajectory.dissipation < far.trajectory.dissipation - 0.01
    assert cheap.trajectory.displacement < far.trajectory.displacement
    # each is the best for its own objective, so neither beats the other at the other's
    assert cheap.cost < -far.trajectory.displacement + far.trajectory.dissipation
    assert -far.trajectory.displacement < -cheap.trajectory.displacement


@pytest.mark.parametrize(("name", "turn"), [("straight", 0.0), ("turning", 0.5)])
def test_a_prescribed_heading_change_is_met(name: str, turn: float) -> None:
    s = optimum(name)
    assert s.trajectory.heading_change == pytest.approx(turn, abs=RESIMULATION)
    assert s.cost > optimum("reference-optimum").cost  # a constraint can only cost


def test_a_fixed_frequency_is_met_and_costs_distance() -> None:
    s = optimum("fixed frequency")
    assert s.gait.xi == pytest.approx(1.5, abs=1e-12)
    assert s.cost > optimum("reference-optimum").cost


def test_the_servo_speed_limit_binds_in_a_fast_cycle() -> None:
    s = optimum("slow servos")
    speed = np.abs(np.roll(s.table, -1, axis=0) - s.table).max() * s.problem.task.steps / 0.6
    assert speed == pytest.approx(57 * 2 * np.pi / 60, rel=1e-6)
    assert s.cost > optimum("reference-optimum").cost


def test_the_published_distance_of_the_reference_optimum() -> None:
    # problems/reference-optimum.toml; found there by a derivative-free search with another simulator
    assert optimum("reference-optimum").trajectory.displacement == pytest.approx(0.6125, abs=5e-5)


def test_mirror_image_and_half_a_turn_of_theta_are_the_same_optimum() -> None:
    from serpenoid.simulation import simulate_joint_angles

    s = optimum("reference-optimum")
    model, q = s.problem.model, s.gait.parameters
    mirror = q * [1, -1, -1, 1, 1, 1] + [0, 0, 0, np.pi, 0, 0]
    other = simulate_joint_angles(model, joint_table(model, mirror, s.problem.task.steps))
    assert other.displacement == pytest.approx(s.trajectory.displacement, abs=1e-10)


def multi_start(starts: int, seed: int):  # type: ignore[no-untyped-def]
    asked = problem("reference-optimum")
    solver = GaitSolver(asked)
    return solve_many(solver, random_gaits(solver, starts, seed), 0.0)


def test_twelve_random_starts_reach_one_optimum_without_a_failure() -> None:
    result = multi_start(12, seed=5)
    assert not result.failures
    assert [group.count for group in result.optima] == [12]


@pytest.mark.slow
def test_a_hundred_random_starts_reach_certified_optima_without_a_failure() -> None:
    result = multi_start(100, seed=6)
    assert not result.failures
    assert result.optima[0].count >= 50
    assert result.best.trajectory.displacement == pytest.approx(0.6125, abs=5e-5)
    assert sum(group.count for group in result.optima) == 100


def test_seeds_decide_the_starts_and_starts_respect_bounds_and_limits() -> None:
    solver = GaitSolver(problem("snake10"))
    gaits = random_gaits(solver, 20, seed=3)
    np.testing.assert_array_equal(gaits, random_gaits(solver, 20, seed=3))
    assert not np.array_equal(gaits, random_gaits(solver, 20, seed=4))
    lower, upper = solver.gait_bounds()
    assert (gaits >= lower).all()
    assert (gaits <= upper).all()
    finite = np.isfinite(solver.limits.upper)
    for q in gaits:
        table = joint_table(solver.model, q, solver.steps)
        assert violations(table, solver.limits)[:, finite].max() <= 0


def test_a_warm_start_from_the_answer_is_the_answer_in_a_few_iterations() -> None:
    asked = problem("reference-optimum", "task.c=1.0")
    solver = GaitSolver(asked)
    (start,) = random_gaits(solver, 1, seed=0)
    cold = solver.solve(start, 1.0)
    assert cold.outcome.status.ok
    warm = solver.solve(cold.outcome.point, 1.0, Run(carried=cold.carried))
    assert warm.outcome.status.ok
    assert warm.outcome.objective == pytest.approx(cold.outcome.objective, abs=SAME_OPTIMUM)
    assert warm.iterations <= 8
    assert warm.iterations < cold.iterations


def test_a_warm_start_at_another_c_is_the_cold_answer_there() -> None:
    solver = GaitSolver(problem("reference-optimum"))
    (start,) = random_gaits(solver, 1, seed=0)
    near = solver.solve(start, 1.0)
    warm, cold = solver.solve(near.outcome.point, 1.1, Run(carried=near.carried)), solver.solve(near.q, 1.1)
    assert warm.outcome.status.ok
    assert warm.outcome.objective == pytest.approx(cold.outcome.objective, abs=SAME_OPTIMUM)
    assert warm.outcome.residuals.largest <= KKT


def test_an_answer_that_the_simulation_does_not_confirm_is_refused() -> None:
    solver = GaitSolver(problem("reference-optimum"))
    (start,) = random_gaits(solver, 1, seed=0)
    answer = solver.solve(start, 0.0)
    assert certify(solver, answer, 0.0).status is Status.SOLVED
    point = answer.outcome.point
    moved = point.x.copy()
    moved[10] += 1e-7  # one pose, ten times the tolerance
    forged = replace(answer, outcome=replace(answer.outcome, point=Point(moved, point.lam_x, point.lam_g)))
    assert certify(solver, forged, 0.0).status is Status.RESIMULATION_DISAGREES


def test_a_gait_that_is_not_optimal_is_refused_however_it_was_called() -> None:
    solver = GaitSolver(problem("reference-optimum"))
    (start,) = random_gaits(solver, 1, seed=0)
    answer = solver.solve(start, 0.0)
    x = solver.start(start)
    point = replace(answer.outcome.point, x=x)
    _, ipopt = solver.prepared(answer.carried)
    parameters, bounds = solver.parameters(0.0, answer.carried.rows), solver.bounds(answer.carried)
    residuals = ipopt.residuals(point, parameters, bounds)
    forged = replace(answer, q=start, outcome=replace(answer.outcome, point=point, residuals=residuals))
    assert residuals.largest > KKT
    assert certify(solver, forged, 0.0).status is Status.NOT_STATIONARY
    hidden = replace(forged, outcome=replace(forged.outcome, residuals=answer.outcome.residuals))
    assert certify(solver, hidden, 0.0).status is Status.NOT_A_MINIMUM  # polishing finds it out


def test_constraints_that_cannot_be_met_are_a_status() -> None:
    impossible = problem(
        "reference-optimum", "task.constraints.heading_change_rad=3.0", "task.bounds.a=[0.0, 0.5]", "task.steps=20"
    )
    result = solve(impossible, starts=1)
    assert not result.best.status.ok
    assert result.best.status in (Status.INFEASIBLE, Status.NOT_CONVERGED)
    assert len(result.failures) == 1


def test_the_stop_flag_keeps_the_last_iterate() -> None:
    solver = GaitSolver(problem("reference-optimum"))
    (start,) = random_gaits(solver, 1, seed=0)
    flag, seen = StopFlag(), []

    def watch(objective: float) -> None:
        seen.append(objective)
        flag.stopped = len(seen) >= 5

    answer = solver.solve(start, 0.0, Run(flag=flag, watch=watch))
    assert answer.outcome.status is Status.STOPPED
    assert answer.iterations <= 6
    assert np.isfinite(answer.outcome.point.x).all()
    again = solver.solve(start, 0.0)  # the same solver goes on working
    assert again.outcome.status is Status.SOLVED


def test_an_exception_in_a_progress_callback_is_raised_and_not_swallowed() -> None:
    solver = GaitSolver(problem("reference-optimum"))
    (start,) = random_gaits(solver, 1, seed=0)

    def watch(_objective: float) -> None:
        raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        solver.solve(start, 0.0, Run(watch=watch))


def test_a_raised_flag_ends_a_multi_start_with_what_there_is() -> None:
    solver = GaitSolver(problem("reference-optimum"))
    flag = StopFlag()

    def progress(done: int, _best: Solution | None) -> None:
        flag.stopped = done >= 2

    result = solve_many(solver, random_gaits(solver, 5, seed=0), 0.0, flag, progress)
    assert len(result.solutions) == 2
    assert result.best.status.ok


def test_a_flag_that_is_raised_amid_polishing_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each distance is a batch of motions: of a body that keeps off itself minutes of them."""
    solver = GaitSolver(problem("reference-optimum"))
    flag, costs, polished = StopFlag(), solver.costs, []

    def interrupted(tables: Floats, gaits: Floats, c: float) -> Costs:
        if len(gaits) > 1:
            polished.append(len(gaits))
            flag.stopped = True
        return costs(tables, gaits, c)

    monkeypatch.setattr(solver, "costs", interrupted)
    found = solve_many(solver, random_gaits(solver, 1, seed=0), 0.0, flag)
    assert len(polished) == 1
    assert found.best.status.ok
    assert found.best.polishing_gain is None


def test_the_papers_set_improves_each_gait_within_its_own_neighbourhood() -> None:
    asked = problem("snake10")
    solver = GaitSolver(asked)
    pairs = improve(asked, count=4, fraction=0.3, seed=2)
    for pair in pairs:
        lower, upper = within(solver, pair.q, 0.3)
        assert pair.solution.status.ok
        assert pair.solution.trajectory.displacement >= pair.trajectory.displacement - 1e-9
        found = pair.solution.gait.parameters
        found[3] += 2 * np.pi * np.round((pair.q[3] - found[3]) / (2 * np.pi))  # theta is reported in (-pi, pi]
        assert (found >= lower - 1e-9).all()
        assert (found <= upper + 1e-9).all()
    distances = [pair.solution.trajectory.displacement for pair in pairs]
    assert np.ptp(distances) > 1e-3  # neighbourhoods keep them apart


def test_solving_from_a_gait_outside_the_bounds_starts_at_the_nearest_one_inside() -> None:
    asked = problem("reference-optimum", "task.bounds.a=[0.0, 5.0]")
    solution = solve_from(asked, EllipseGait(a=9.0))
    assert solution.status.ok
    assert solution.gait.a <= 5.0 + 1e-12


def test_a_flat_gait_is_the_scallop_and_no_failure_of_the_solver() -> None:
    still = problem("reference-optimum", "task.bounds.sigma=[0.0, 0.0]", "task.steps=20")
    result = solve(still, starts=2, seed=0)
    for solution in result.solutions:
        assert solution.trajectory.displacement < 1e-6
