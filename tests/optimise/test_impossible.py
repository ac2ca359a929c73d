"""What cannot be: contradictions are told before the work, all else by a status and the nearest that was found."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.media import LAWS
from serpenoid.objectives.term import Played, miss
from serpenoid.objectives.travel import Travel
from serpenoid.optimise.ipopt import Residuals
from serpenoid.optimise.multistart import MultiStart, solve_one
from serpenoid.optimise.nearest import with_nearest
from serpenoid.optimise.robust import solver_of
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve
from serpenoid.optimise.unmoved import rest_note, there_and_back, why_unmoved
from serpenoid.results import solution_record, write_solution
from serpenoid.simulation import simulate_batch
from serpenoid.simulation.problem import simulate
from serpenoid.status import Status
from specimens import problem

EFFICIENT = ('task.objectives=[{kind="efficiency"}]',)
SMALL = "body.vertices=5", "task.steps=16"


def nearest(*demands: str) -> tuple[Solution, list[str]]:
    """What a solve ends with, and what it says of each demand."""
    found = solve(problem("reach", *SMALL, f"task.demands=[{','.join(demands)}]"), starts=1).best
    played = Played(found.trajectory.poses, found.trajectory.vertices, found.table)
    return found, [demand.outcome(played) for demand in found.problem.task.demands]


def missed(words: str) -> float:
    """The number that follows `missed by`; nothing where it is met."""
    if words.endswith("met"):
        return 0.0
    found = re.search(r"missed by (\S+)", words)
    assert found is not None
    return float(found[1])


def test_of_a_place_out_of_reach_the_nearest_is_found() -> None:
    found, (words,) = nearest('{kind="reach",target=[3.0,0.0]}')
    assert found.status is Status.INFEASIBLE
    end = found.trajectory.poses[-1, :2]
    assert missed(words) == pytest.approx(np.hypot(*(end - [3, 0])), abs=1e-4)
    limit, rng = np.deg2rad(63), np.random.default_rng(0)
    around = np.clip(found.table + 0.01 * rng.normal(size=(40, *found.table.shape)), -limit, limit)
    ends = simulate_batch(found.problem.model, around).poses[:, -1, :2]
    assert np.hypot(*(ends - [3, 0]).T).min() > missed(words) - 1e-4  # no gait nearby comes nearer


FAR = '{kind="reach",target=[3.0,0.0]}', '{kind="travel",least=5.0}'


@pytest.mark.parametrize("demand", [pytest.param(FAR[0], marks=pytest.mark.slow), FAR[1]])
def test_what_is_out_of_reach_is_missed_by_less_than_by_the_files_own_gait(demand: str) -> None:
    """A start that ends at rest, infeasible or not converged, is not the nearest where the file's gait comes nearer."""
    asked = problem("reference", "body.vertices=6", "medium.anisotropy_ratio=0.3", f"task.demands=[{demand}]")
    found = solve(asked, starts=1).best
    (goal,) = asked.task.demands
    own = simulate(asked).trajectory
    played = [Played(motion.poses, motion.vertices, found.table) for motion in (found.trajectory, own)]
    nearest, file = (missed(goal.outcome(motion)) for motion in played)
    assert found.status is Status.INFEASIBLE
    assert nearest < file - 0.1


WALLED = (  # a table whose optimum without obstacles leads to what cannot be met
    "reach", "body.vertices=8", "body.joint_limit_deg=80", "body.joint_speed_limit_rpm=30", "task.steps=60",
    "task.c=0.05", "task.cycle_duration_s=6", "medium.anisotropy_ratio=0.1",
    'task.objectives=[{kind="position",target=[0.6,0.0]}]',
    'task.demands=[{kind="disc",centre=[0.9,0.05],radius=0.2},'
    '{kind="half_plane",point=[0.0,-0.15],normal=[0.0,1.0]}]',
)  # fmt: skip


def test_a_turn_in_place_is_found_though_the_displacement_has_a_kink_there() -> None:
    """Beside the default objective, minus the displacement, which is zero where the demand holds."""
    turn = '{kind="reach",target=[0.0,0.0]}'
    fixed = f"task.demands=[{turn}]", "task.constraints.heading_change_rad=0.5", "task.c=0.01"
    found = solve(problem("reference-optimum", *fixed, 'gait.family="fourier-joints"', "task.steps=30"), starts=4)
    assert found.best.status is Status.SOLVED
    assert found.best.trajectory.displacement < 1e-7
    assert found.best.trajectory.heading_change == pytest.approx(0.5, abs=1e-8)
    assert not [s for s in found.solutions if s.ipopt_status == "Invalid_Number_Detected"]


def test_a_failure_whose_residuals_are_no_numbers_is_written_and_shown(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found, _ = nearest(FAR[1])
    failed = replace(found, residuals=Residuals(0.0, 0.0, np.nan), polishing_gain=np.nan, resimulation_error=1.0)
    assert np.isnan(failed.residuals.largest)  # and is not passed over: max(0.0, nan) is 0.0
    record = write_solution(tmp_path, failed, figures=False)
    assert record["kkt"] == {"stationarity": 0.0, "feasibility": 0.0, "complementarity": None}
    assert record["polishing_gain"] is None
    assert main(["show", str(tmp_path)]) == 0
    assert "KKT not a number" in capsys.readouterr().out


@pytest.mark.slow
def test_a_start_that_meets_all_demands_is_not_lost_by_the_easier_problem_without_obstacles() -> None:
    found = solve(problem(*WALLED), starts=1).best
    assert found.status is Status.SOLVED
    assert found.cost < 0.36  # of standing still


@pytest.mark.slow
def test_where_all_starts_fail_a_gait_of_the_file_that_meets_the_demands_is_shown() -> None:
    solver = solver_of(problem(*WALLED))
    start = solver.family.sample(np.random.default_rng(0))
    failed = replace(solve_one(solver, start, 0.05)[0], status=Status.INFEASIBLE, missed=0.1)
    shown = with_nearest(solver, MultiStart((failed,), ())).best
    assert shown.status is Status.NOT_CONVERGED  # and not infeasible: standing still meets all that is asked
    assert shown.missed == 0
    assert shown.trajectory.displacement == pytest.approx(0, abs=1e-12)


def test_a_way_says_by_how_much_it_is_too_short_or_too_long() -> None:
    moved = Played(np.array([[0.0, 0, 0], [0.3, 0.4, 0]]), np.zeros((2, 3, 2)), np.zeros((1, 1)))
    said = [Travel(least=a, most=b).outcome(moved) for a, b in ((0.7, 0.8), (0.1, 0.2), (0.5, 0.5))]
    assert [missed(words) for words in said] == [0.2, 0.3, 0]


def test_a_body_that_begins_in_an_obstacle_and_cannot_leave_it_says_how_deep_it_is() -> None:
    found, (words,) = nearest('{kind="disc",centre=[0.0,0.0],radius=0.9}')
    assert found.status is Status.INFEASIBLE
    assert 0 < missed(words) <= 0.9
    assert "vertex" in words


def test_what_is_met_is_missed_by_nothing() -> None:
    assert (miss(7.3e-32), miss(0.0), miss(3e-6), miss(0.25)) == ("0", "0", "3e-06", "0.2500")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            'task.demands=[{kind="reach",target=[0.3,0.0]},{kind="travel",least=0.5}]',
            r"1 \(reach\) and \S+ 2 \(travel\) contradict each other: displacement is 0\.3 and from 0\.5",
        ),
        (
            'task.demands=[{kind="reach",target=[0.3,0.0],radius=0.01},{kind="reach",target=[0.3,0.1],radius=0.02}]',
            r"contradict each other: y after 1 cycle",
        ),
        (
            'task.demands=[{kind="shape",angles=[1.5,0.0,0.0]}]',
            r"\[body\] joint_limit_deg and \S+ 1 \(shape\) contradict .* joint 1 at row 0",
        ),
        (
            'task.demands=[{kind="shape",at=0.0},{kind="shape",at=1.0,angles=[0.0,0.2,0.0]}]',  # closed: one row
            r"1 \(shape\) and \S+ 2 \(shape\) contradict each other: joint 2 at row 0",
        ),
        (
            'task={steps=16,constraints={straight=true},demands=[{kind="reach",target=[0.3,0.0],heading_rad=1.0}]}',
            r"\[task\.constraints\] and \S+ 1 \(reach\) contradict each other: heading",
        ),
        ('task.demands=[{kind="disc",centre=[0.0,0.0],radius=3.0}]', r"\(disc\) forbids where the body begins, by 2 "),
        (
            'task.demands=[{kind="box",half_widths=[0.5,0.5],inside=true},{kind="reach",target=[0.8,0.0]}]',
            r"\(box\) forbids the place of \S+ 2 \(reach\), by 0\.3 body lengths",
        ),
        (
            'medium={law="coulomb",anisotropy_ratio=0.2,dissipation="edge"}',
            r"efficiency: is one of viscous drag; with dry friction ask for transport",
        ),
        ('task.demands=[{kind="half_plane",point=[0.1,0.0],normal=[1.0,0.0]}]', r"\(half_plane\) forbids .* by 0\.1 "),
    ],
)
def test_demands_that_contradict_each_other_are_refused_before_the_work(change: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        problem("reach", *SMALL, *EFFICIENT if change.startswith("medium") else (), change)


@pytest.mark.parametrize(
    "demands",
    [
        '{kind="reach",target=[0.3,0.0],at=0.5},{kind="travel",least=0.5}',
        '{kind="reach",target=[0.3,0.0],cycles=2},{kind="travel",least=0.1}',
        '{kind="disc",centre=[0.3,0.0],radius=0.5}',  # a body may bend round it
        '{kind="box",half_widths=[0.5,0.2],inside=true},{kind="reach",target=[0.5,0.1],radius=0.1}',
    ],
)
def test_demands_that_may_be_met_are_not(demands: str) -> None:
    assert problem("reach", *SMALL, f"task.demands=[{demands}]").task.demands


def test_a_motion_that_is_not_closed_may_end_in_another_shape() -> None:
    ends = '{kind="shape",at=0.0},{kind="shape",at=1.0,angles=[0.0,0.2,0.0]}'
    assert problem("reach", *SMALL, "task.transient=true", f"task.demands=[{ends}]").task.demands


ONE_JOINT = "body.vertices=3", "body.joint_limit_deg=60", "task.steps=16"


def test_a_failure_of_one_joint_is_laid_to_the_one_joint_and_no_other_start_is_advised() -> None:
    found = solve(problem("reach", *ONE_JOINT, 'task.demands=[{kind="travel",least=0.1}]'), starts=1).best
    assert not found.status.ok
    assert "scallop" in found.message
    assert "start" not in found.message
    assert solution_record(found)["message"] == found.message


@pytest.mark.parametrize("change", ["task.transient=true", "body.vertices=4"])
def test_what_one_joint_cannot_do_is_not_said_of_a_way_without_return_nor_of_two_joints(change: str) -> None:
    assert why_unmoved(problem("reach", *ONE_JOINT)) is not None
    assert why_unmoved(problem("reach", *ONE_JOINT, change)) is None


@pytest.mark.parametrize(
    ("changes", "there_and_back"),
    [
        (("task.bounds.sigma=[0.0, 0.0]",), True),  # a standing wave: its shapes lie on a straight line
        (("task.bounds.a=[0.0, 0.0]",), True),  # one shape
        (("task.bounds.sigma=[0.0, 0.1]",), False),
        (("task.bounds.sigma=[0.0, 0.0]", "task.transient=true"), False),
        (("gait.family=fourier-joints", "task.bounds.angle=[-0.5, 0.5]"), False),
        (("gait.family=table", "task.bounds.angle=[-0.5, 0.5]"), False),
    ],
)
def test_bounds_that_leave_only_gaits_there_and_back_are_recognised(
    changes: tuple[str, ...], there_and_back: bool
) -> None:
    said = why_unmoved(problem("reference-optimum", "task.steps=12", *changes))
    assert (said is not None) == there_and_back
    assert said is None or "scallop theorem" in said


def test_a_curve_that_is_run_back_moves_no_body_whatever_the_law() -> None:
    """Shapes on a curve that is no line, the second half in reverse order: by every law the way back undoes the way."""
    way = (
        np.linspace(0, 1, 9)[:, None] * np.array([1.0, -0.7, 0.4])
        + np.array([[0.3 * k * (8 - k)] * 3 for k in range(9)]) / 16
    )
    way[:, 1] *= way[:, 0]
    table = np.vstack([way, way[-2:0:-1]])
    assert there_and_back(table)
    assert not there_and_back(np.vstack([way, way[-2:0:-1] * [1, 1, 0.9]]))
    for law in LAWS:
        model = problem("reference", "body.vertices=5", f'medium.law="{law}"').model
        assert simulate_batch(model, table[None]).poses[0, -1] == pytest.approx(np.zeros(3), abs=1e-9), law


def test_where_a_body_at_rest_does_as_well_it_is_said() -> None:
    at_the_start = 'task.objectives=[{kind="position",target=[0.0,0.0]}]'
    found = solve(problem("reach", *SMALL, at_the_start), starts=1).best
    assert found.status.ok
    assert found.note is not None
    assert "stands still does as well: no goal asks it to move" in found.summary()
    assert solution_record(found)["note"] == found.note


@pytest.mark.parametrize(
    ("objectives", "c", "said"),
    [
        ('{kind="displacement"}', 50.0, "no gait that was found is worth what it costs. Lower `c` (now 50)."),
        (
            '{kind="displacement"},{kind="effort",weight=9.0}',
            0.1,
            "is worth what it costs. Lower `c` (now 0.1) or the weight of `effort`.",
        ),
        ('{kind="displacement"}', 0.0, "goes anywhere within the bounds, limits and demands. Widen them."),
        ('{kind="effort"}', 0.2, "no goal asks it to move. Ask for `displacement`, "),
    ],
)
def test_a_body_that_is_asked_to_move_and_stands_is_told_what_weighs_more(objectives: str, c: float, said: str) -> None:
    assert said in rest_note(problem("reference", f"task.objectives=[{objectives}]"), c)


def test_an_optimum_that_is_better_than_rest_has_no_note() -> None:
    found = solve(problem("reach", *SMALL, 'task.objectives=[{kind="position",target=[0.2,0.0]}]'), starts=1).best
    assert found.status.ok
    assert found.note is None
    assert "note" not in solution_record(found)


def test_a_family_with_fewer_parameters_than_the_demands_fix_numbers_is_refused_with_larger_ones_named() -> None:
    shapes = 'task.demands=[{kind="shape"},{kind="shape",at=1.0,angles=[0.5,0.5,0.5,0.5]}]'
    small = "reference-optimum", "body.vertices=6", "task.transient=true", shapes
    with pytest.raises(InputError, match=r"got 6 \(`ellipse`\) for 8\. Take a larger family \(spline, table"):
        solver_of(problem(*small))


def test_a_turn_in_place_that_all_starts_lose_the_motion_for_is_found_by_way_of_an_objective() -> None:
    """Fixed, the heading lets a pose slip to another root of its step: starts turn by a radian the other way."""
    asked = (
        'task.demands=[{kind="reach",target=[0.0,0.0]}]',
        "task.constraints.heading_change_rad=1.5707",
        "task.c=0.01",
    )
    words = *asked, 'gait.family="fourier-joints"', "task.steps=30"
    found = solve(problem("reference-optimum", *words), starts=2, seed=3)
    slipped = [s for s in found.solutions if s is not found.best]
    assert slipped[0].status is Status.RESIMULATION_DISAGREES
    assert slipped[0].trajectory.heading_change < -1.0
    assert found.best.status is Status.SOLVED
    assert found.best.trajectory.heading_change == pytest.approx(1.5707, abs=1e-8)
    assert found.best.trajectory.displacement < 1e-7


@pytest.mark.parametrize("vertices", [8, 12])
def test_a_turn_in_place_ends_as_an_optimum_where_its_displacement_is_zero(vertices: int) -> None:
    """There the distance has a kink: searches for the gait that goes farthest while it stays did not end."""
    asked = (
        'task.demands=[{kind="reach",target=[0.0,0.0]}]',
        "task.constraints.heading_change_rad=-1.57",
        f"body.vertices={vertices}",
    )
    found = solve(problem("reference-optimum", *asked, 'gait.family="fourier-joints"', "task.steps=30"), 3, seed=1).best
    assert found.status is Status.SOLVED
    assert found.trajectory.heading_change == pytest.approx(-1.57, abs=1e-8)
    assert found.trajectory.displacement < 1e-8


def test_the_nearest_gait_has_no_certificate_of_the_gait_in_whose_place_it_stands(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found, _ = nearest(FAR[1])
    assert found.status is Status.INFEASIBLE
    record = write_solution(tmp_path, found, figures=False)
    assert set(record["kkt"].values()) == {record["resimulation_error"]} == {None}
    assert main(["show", str(tmp_path)]) == 0
    assert "certificate       none: nothing was confirmed of this gait" in capsys.readouterr().out
