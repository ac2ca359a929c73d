"""Joints that bend to one side only, or each by its own range: optima, starts, certificates, and what is refused."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.objectives import Criteria
from serpenoid.optimise.certify import gait_costs
from serpenoid.optimise.interrupt import STOOD, IterationCallback
from serpenoid.optimise.own import certify_table
from serpenoid.optimise.program.limits import path_limits, violations
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve, solve_from, starts_of
from serpenoid.optimise.starts import inside, random_gaits
from serpenoid.problem import Problem
from serpenoid.status import Status
from specimens import problem

HELD = 1e-9  # rad: what certificates ask of every row
SAME = 2e-6  # of the objective: which rows touch the limit depends on the phase, and each choice is an optimum
FAMILIES = "ellipse", "fourier", "fourier-joints", "spline", "table"
ONE_SIDED = "body.joint_limit_deg=[0, 60]"
EACH = "body.joint_limit_deg=[[0, 60], [-20, 40], [-50, 50], [-40, 0], [5, 30]]"


def robot(family: str, limit: str = ONE_SIDED, *more: str) -> Problem:
    """A robot of five joints, without the limits of speed that its file has."""
    sets = "body.vertices=7", f"gait.family={family}", "task.steps=40", "task.c=0.5", limit, *more
    return problem("reference-optimum", *sets)


QUICK = "ellipse", "fourier-joints", "table"


@lru_cache
def best(family: str, limit: str = ONE_SIDED) -> Solution:
    """The best of three starts, solved once in a process."""
    return solve(robot(family, limit), starts=3, seed=0).best


@pytest.mark.parametrize("family", [pytest.param(f, marks=[] if f in QUICK else pytest.mark.slow) for f in FAMILIES])
def test_optima_of_joints_to_one_side_keep_it_and_are_certified(family: str) -> None:
    found = best(family)
    assert found.status is Status.SOLVED
    assert found.polishing_gain is not None
    assert found.polishing_gain < 1e-6
    assert found.table.min() >= -HELD
    assert found.table.max() <= np.pi / 3 + HELD
    assert found.table.max() > 0.3  # it makes use of the side that there is
    assert found.trajectory.displacement > 0.05


@pytest.mark.parametrize("family", ["fourier-joints", "spline", "table"])
def test_each_joint_keeps_its_own_range(family: str) -> None:
    found = best(family, EACH)
    assert found.status is Status.SOLVED
    low, high = np.deg2rad([[0, -20, -50, -40, 5], [60, 40, 50, 0, 30]])
    assert (found.table >= low - HELD).all()
    assert (found.table <= high + HELD).all()
    reached = (found.table < low + 1e-3).any(axis=0) | (found.table > high - 1e-3).any(axis=0)
    assert reached.sum() >= 3  # the ranges bind where they are, not about zero


def test_the_limit_is_the_constraint_of_the_same_name_that_a_user_may_write() -> None:
    """Two routes to one optimum: rows exchanged, and rows of the user's own from the optimum of the first."""

    def one_side(of: Criteria) -> None:
        of.subject_to(of.joint_angles, 0, np.pi / 3)

    found = best("fourier-joints")
    free = robot("fourier-joints", "task.constraints.joint_limits=false")
    again = solve_from(free, found.gait, one_side)
    assert again.status is Status.SOLVED
    assert again.objective == pytest.approx(found.objective, abs=SAME)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("limit", [ONE_SIDED, "body.joint_limit_deg=[-30, 70]"])
def test_starts_are_drawn_inside_the_limits_and_move(family: str, limit: str) -> None:
    solver = solver_of(robot(family, limit, "body.joint_speed_limit_rpm=20", "task.cycle_duration_s=3.0"))
    starts = random_gaits(solver, 6, seed=4)
    assert float(solver.excess(solver.tables(starts)).max()) <= HELD
    lower, upper = solver.gait_bounds()
    assert (starts >= lower).all()
    assert (starts <= upper).all()
    assert np.ptp(solver.tables(starts), axis=1).max(axis=1).min() > 0.02
    np.testing.assert_array_equal(starts, random_gaits(solver, 6, seed=4))


def test_directions_that_move_a_gait_add_the_same_shape_to_every_row() -> None:
    for family in FAMILIES:
        solver = solver_of(robot(family))
        q = solver.family.sample(np.random.default_rng(0))
        for direction in solver.family.steady:
            moved = solver.tables(np.array([q, q + 0.1 * direction, q + 0.2 * direction]))
            once, twice = moved[1] - moved[0], moved[2] - moved[0]
            np.testing.assert_allclose(once, np.tile(once[0], (len(once), 1)), atol=1e-14)
            np.testing.assert_allclose(twice, 2 * once, atol=1e-14)
            assert np.abs(once).max() > 1e-3


def test_a_file_s_own_gait_is_the_first_start_as_it_is_where_it_keeps_the_range() -> None:
    kept = "gait.a=1.0", "gait.x_c=3.5", "gait.xi=0.5", "gait.theta=0.0"
    solver = solver_of(robot("ellipse", "body.joint_limit_deg=[-5, 60]", *kept))
    np.testing.assert_array_equal(starts_of(solver, 2, 0)[0], solver.own_start())
    broken = solver_of(robot("ellipse", "body.joint_limit_deg=[-5, 60]", "gait.a=5.0", "gait.xi=0.5"))
    own, moved = broken.own_start(), inside(broken, broken.own_start())
    assert moved is not None
    assert float(broken.excess(broken.table(moved)).max()) <= 0 < float(broken.excess(broken.table(own)).max())
    np.testing.assert_array_equal(moved[[0, 3, 5]], own[[0, 3, 5]])  # sigma, theta, xi: the same gait, elsewhere


def test_a_range_like_to_both_sides_is_the_number_to_the_last_bit() -> None:
    number, pair, each = (
        robot("ellipse", f"body.joint_limit_deg={limit}") for limit in ("45", "[-45, 45]", [[-45.0, 45]] * 5)
    )
    assert number.hash == pair.hash == each.hash
    assert number.joint_limit_deg == pair.joint_limit_deg == each.joint_limit_deg == 45.0
    starts = [random_gaits(solver_of(p), 4, seed=1) for p in (number, pair, each)]
    np.testing.assert_array_equal(starts[0], starts[1])
    np.testing.assert_array_equal(starts[0], starts[2])
    assert len({robot("ellipse").hash, robot("ellipse", EACH).hash, number.hash}) == 3


def test_polishing_pays_for_the_side_to_which_joints_do_not_bend() -> None:
    p = robot("table")
    solver = solver_of(p)
    level = np.full(solver.family.size, 0.2)
    lower, upper = (np.full(level.size, end) for end in (-2.0, 2.0))
    kept, below, above = (
        float(gait_costs(solver, q[None], 0.5, 10.0, (lower, upper))[0]) for q in (level, level - 0.3, level + 1.0)
    )
    assert below - kept == pytest.approx(10 * 0.1, abs=1e-6)
    assert above - kept == pytest.approx(10 * (1.2 - np.pi / 3), abs=1e-6)


def test_a_table_from_elsewhere_that_bends_to_the_wrong_side_is_infeasible() -> None:
    p = robot("table")
    table = best("table").table
    assert certify_table(p, table).limit_excess <= HELD
    mirrored = certify_table(p, -table)
    assert mirrored.status is Status.INFEASIBLE
    assert mirrored.limit_excess == pytest.approx(table.max())
    assert violations(-table, path_limits(p)).max() == pytest.approx(table.max())


def test_waves_that_cannot_keep_to_one_side_are_refused_before_the_work() -> None:
    with pytest.raises(InputError, match=r"joint_limit_deg: no gait of family `ellipse` .* 0 to 60 degrees"):
        solve(robot("ellipse", ONE_SIDED, "task.bounds.xi=[1.0, 2.0]"), starts=2)


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        ("[60, 0]", r"joint_limit_deg: needs -180 <= lower < upper <= 180"),
        ("[0, 200]", r"lower < upper <= 180"),
        ("[0, 30, 60]", r"needs \[lower, upper\], got .* Give one number, \[lower, upper\], or a list"),
        ("[[0, 60], [0, 50]]", r"`joint_limit_deg` needs 5 pairs \[lower, upper\], one per joint .* got 2"),
        ("[[0, 60], 3]", r"needs \[lower, upper\]"),
        ("[true, 60]", r"needs \[lower, upper\]"),
        ("-5", r"must be greater than 0, got -5"),
        ("[]", r"must be degrees, got .* Give one number"),
        ('"60"', r"must be degrees"),
    ],
)
def test_limits_that_mean_nothing_are_refused(limit: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        robot("ellipse", f"body.joint_limit_deg={limit}")


def test_a_search_that_stands_for_long_is_given_up_and_one_that_comes_away_is_not() -> None:
    """Where all starts break a constraint IPOPT shrinks the gait to rest, at the kink of the displacement."""
    told: list[float] = []
    callback = IterationCallback((5, 1, 1), told.append, poses=3)

    def stops(*poses: float) -> bool:
        result = np.zeros(1)
        callback.eval_buffer([np.array([*poses, 1.0, 2.0]), np.array([0.5])], [result])
        return bool(result[0])

    for _ in range(3):
        assert not any(stops(1e-6, 0.0, -1e-6) for _ in range(STOOD - 1))
        assert not stops(1e-6, 0.0, 1e-2)  # it turned
    assert [stops(0.0, 0.0, 0.0) for _ in range(STOOD)] == [False] * (STOOD - 1) + [True]
    assert callback.given_up
    assert len(told) == 4 * STOOD
    callback.poses, callback.stood = 0, 0
    assert not any(stops(0.0, 0.0, 0.0) for _ in range(2 * STOOD))


def test_a_range_is_refused_where_joints_pitch() -> None:
    with pytest.raises(InputError, match=r"\[lift\].*`joint_limit_deg` must be one number"):
        robot("ellipse", ONE_SIDED, "lift.height=0.01")
    assert robot("ellipse", "body.joint_limit_deg=60", "lift.height=0.01").lift is not None


def test_coefficients_are_not_taken_for_angles() -> None:
    with pytest.raises(InputError, match=r"angle.*bounds the coefficients .* joint_limit_deg = \[lower, upper\]"):
        robot("fourier-joints", ONE_SIDED, "task.bounds.angle=[0, 1.0472]")
    assert robot("spline", ONE_SIDED, "task.bounds.angle=[0, 1.0472]").task.bounds.family == "spline"


def test_a_shape_to_the_other_side_contradicts_the_limit() -> None:
    shape = 'task.demands=[{kind="shape", angles=[0.1, 0.1, -0.2, 0.1, 0.1]}]'
    with pytest.raises(InputError, match=r"joint_limit_deg and \S+ 1 \(shape\) contradict .* joint 3 at row 0"):
        robot("table", ONE_SIDED, shape)
    assert robot("table", "body.joint_limit_deg=[-20, 60]", shape).task.demands
