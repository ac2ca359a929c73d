"""What is said of goals and demands: met within the optimiser's tolerance, or by how much it is missed."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from serpenoid.cli.goals import clear_lines, mesh_lines
from serpenoid.cli.main import main
from serpenoid.objectives.heading import Heading
from serpenoid.objectives.obstacles import Disc
from serpenoid.objectives.position import Position
from serpenoid.objectives.reach import Reach
from serpenoid.objectives.shape import Shape
from serpenoid.objectives.swing import Swing
from serpenoid.objectives.term import Played
from serpenoid.objectives.travel import Travel
from serpenoid.optimise.circle import circle_note
from serpenoid.optimise.clear.clearance import Clearance
from serpenoid.optimise.outcomes import goal_words
from serpenoid.optimise.solution import SelfClear
from serpenoid.simulation.mesh import MeshStudy
from serpenoid.status import Status
from serpenoid.trajectory import Trajectory
from specimens import PROBLEMS, problem


def moved(x: float = 0.0, heading: float = 0.0, table: tuple[tuple[float, ...], ...] = ((0.0,),) * 2) -> Played:
    poses = np.zeros((3, 3))
    poses[-1] = x, 0, heading
    return Played(poses, np.zeros((3, 2, 2)), np.array(table))


def test_what_is_within_tolerance_is_met() -> None:
    near = moved(0.3 + 5e-8, 0.4 - 5e-8)
    assert Reach(target=(0.3, 0.0), heading_rad=0.4).outcome(near) == "(0.3, 0) met; heading there met"
    assert Travel(least=0.3, most=0.3).outcome(near) == "displacement 0.3 met"
    assert Position(target=(0.3, 0.0)).outcome(near) == "(0.3, 0) met"
    assert Heading(target_rad=0.4).outcome(near) == "heading 0.4 rad met"
    assert Shape().outcome(near) == "shape at 0 met"
    assert Heading(target_rad=0.5).outcome(near) == "heading 0.5 rad missed by -0.1000 rad"


@pytest.mark.parametrize(
    ("left", "said"),
    [
        (0.0149, "met: 0.0149 body lengths away, 0.02 allowed"),
        (0.02 + 5e-8, "met: 0.02 body lengths away, 0.02 allowed"),
        (0.02003, "missed: 0.02003 body lengths away, 0.02 allowed"),
        (0.02 + 2e-7, "missed: 0.0200002 body lengths away, 0.02 allowed"),
        (0.5, "missed: 0.5000 body lengths away, 0.02 allowed"),
    ],
)
def test_what_is_missed_and_what_is_allowed_have_as_many_digits_as_tell_them_apart(left: float, said: str) -> None:
    assert Reach(target=(0.0, 0.0), radius=0.02).outcome(moved(left)) == f"(0, 0) {said}"


def test_an_allowance_smaller_than_the_digits_is_not_told_as_nothing() -> None:
    near = Reach(target=(0.0, 0.0), radius=1e-5).outcome(moved(0.0104))
    assert near == "(0, 0) missed: 0.0104 body lengths away, 1e-05 allowed"


def test_what_an_obstacle_misses_is_said_with_place_and_step() -> None:
    points = np.zeros((3, 2, 2))
    points[:, 1, 0] = 1.0
    points[2, 1] = (1.0, 0.5)  # a tenth inside the disc, and a step before it not
    disc = Disc(centre=(1.0, 0.8), radius=0.2, clearance=0.2)
    motion = Played(np.zeros((3, 3)), points, np.zeros((2, 1)))
    assert disc.outcome(motion) == "clearance of disc missed by 0.1000 body lengths at vertex 1, step 2"
    assert Disc(centre=(5.0, 0.0), radius=1.0).outcome(motion) == "clearance of disc met at every vertex and step"


def test_a_shape_that_does_not_rest_and_a_swing_the_other_way_are_missed() -> None:
    going = moved(table=((0.0,), (0.25,)))
    assert Shape(still=True).outcome(going) == "shape at 0 met; rest there missed by 0.2500 rad"
    assert Swing().outcome(going) == "swing of joint 1 met"
    assert Swing().outcome(moved(table=((0.25,), (0.0,)))) == "swing of joint 1 missed by 0.2500 rad"
    assert Swing().outcome(moved(table=((0.25,), (0.0,), (0.0,)))) == "swing of joint 1 missed by 0.2500 rad"


def test_in_space_a_shape_is_one_of_the_yaws() -> None:
    played = Played(np.zeros((3, 6)), np.zeros((3, 3, 3)), np.array([[0.0, 0.3], [0.1, 0.3]]))
    assert Shape().outcome(played) == "shape at 0 met"


def test_a_distance_from_itself_is_met_where_it_is_proven() -> None:
    def said(least: float, proven: float) -> str:
        return SelfClear(least=least, proven=proven, wanted=0.08).goal

    assert said(0.05, 0.05) == "distance from itself missed by 0.0300 body lengths"
    assert said(0.09, 0.08) == "distance from itself met"
    assert said(0.09, 0.07) == "distance from itself met where it was looked, but not proven between"


def test_what_is_proven_says_of_which_motion_and_more_steps_may_break_it() -> None:
    coarse = Clearance(7e-4, 2e-5)
    of = "clearance         at least 2.00e-05 body lengths at every time and place of the motion in 80 steps, proven; "
    (line,) = clear_lines(coarse, None, None, 80, "--refine")
    assert line == f"{of}the least gap found is 7.00e-04"
    _, holds = clear_lines(coarse, Clearance(3e-3, 1e-3), None, 80, "--refine")
    assert holds.strip() == (
        "in 320 steps at least 1.00e-03 body lengths at every time and place, proven; the least gap found is 3.00e-03"
    )
    _, breaks, own = clear_lines(coarse, Clearance(-2.47e-3, -2.5e-3), SelfClear(0.1, 0.09, 0.08), 80, "--refine")
    assert breaks.startswith(
        "warning           the same gait in 320 steps comes 2.47e-03 body lengths nearer to obstacles than it may. "
    )
    assert own.startswith("from itself       at least 9.00e-02 body lengths at every time and place, proven")


@pytest.mark.parametrize(
    ("goals", "said"),
    [
        (["(1.6, 0.3) missed by 0.0345", "clearance of disc met at every vertex and step"], "goals that are met are"),
        (["clearance of disc met at every vertex and step"], "goals are"),
    ],
)
def test_goals_are_not_said_to_be_met_beside_one_that_is_missed(goals: list[str], said: str) -> None:
    coarse = MeshStudy(80, (1.59, 1.62, 1.63), (1.13, 1.127, 1.127))
    assert mesh_lines(coarse, goals, "--refine")[1].strip().startswith(f"{said} met with 80 steps; with many")
    assert len(mesh_lines(coarse, goals[:-1], "--refine")) == 1


def test_demands_of_one_kind_are_counted_as_complaints_count_them() -> None:
    discs = ",".join(f'{{kind="disc",centre=[0.5,{y}],radius=0.1}}' for y in (0.5, -0.05))
    asked = problem("reach", f'task.demands=[{{kind="travel",least=0.1}},{discs}]', "task.objectives=[]")
    table = np.zeros((9, asked.body.joint_count))
    straight = np.linspace([-0.5, 0], [0.5, 0], asked.body.vertices)
    motion = Trajectory(Status.SOLVED, np.zeros((9, 3)), np.tile(straight, (9, 1, 1)), np.zeros(8), 0.0, 8)
    assert goal_words(asked, table, motion, None) == [
        "displacement 0.1 to 100 missed by 0.1000 body lengths",
        "demand 2: clearance of disc met at every vertex and step",
        f"demand 3: clearance of disc missed by 0.0500 body lengths at vertex {asked.body.vertices - 1}, step 0",
    ]


ASKED = {
    "turn-in-a-box": ["missed by -3.1416 rad", "clearance of box missed by 0.0100", "clearance         at least"],
    "checkpoints": ["shape at 0 met; rest there met", "(0.4, 0.1) missed: 0.4123 body lengths away, 0.05 allowed"],
    "steer": ["heading change 0.3 rad missed by -0.3000 rad"],
    "purcell-stroke": ["swing of joint 1 met"],
    "sidewind-to": ["(0.3, 0.8) missed by"],
}


@pytest.mark.parametrize("name", ASKED)
def test_simulate_says_what_the_gait_makes_of_what_the_file_asks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str
) -> None:
    cycles = 1 if name == "checkpoints" else 2  # from shape to shape, once
    words = ["--set", f"task.cycles={cycles}", "--no-figures", "--out", str(tmp_path / "out")]
    assert main(["simulate", str(PROBLEMS / f"{name}.toml"), *words]) == 0
    out = capsys.readouterr().out
    assert all(said in out for said in ASKED[name])
    assert "-0.000000" not in out


def test_simulate_says_of_an_optimum_what_solve_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The gait of an optimum, played again: the same lines of goals, and how far it is from itself."""
    file = PROBLEMS / "reference-optimum.toml"
    asks = ["body.vertices=5", "task.steps=24", "task.c=0.3",
            'task.demands=[{kind="travel",least=0.2},{kind="self",distance=0.05}]']  # fmt: skip
    words = [str(file), *(word for ask in asks for word in ("--set", ask)), "--no-figures"]
    assert main(["solve", *words, "--starts", "1", "--out", str(tmp_path / "best")]) == 0
    solved = capsys.readouterr().out.splitlines()
    gait = json.loads((tmp_path / "best" / "solution.json").read_text())["gait"]
    given = [w for key, value in gait.items() for w in ("--set", f"gait.{key}={json.dumps(value)}")]
    assert main(["simulate", *words, *given, "--out", str(tmp_path / "again")]) == 0
    simulated = capsys.readouterr().out.splitlines()
    kinds = ("goal", "from itself")
    assert [line for line in simulated if line.startswith(kinds)] == [line for line in solved if line.startswith(kinds)]
    assert "goal              distance from itself met" in simulated


@pytest.mark.parametrize(
    ("turn", "said"),
    [
        (86.0, "turns 86 degrees per cycle, so that it comes back after about 4.2 cycles; `straight = true`"),
        (-10.0, "turns 10 degrees per cycle, so that it comes back after about 36 cycles"),
        (345.0, "turns 345 degrees per cycle, so that it comes back after about 24 cycles"),
        (3.0, None),
        (358.0, None),
    ],
)
def test_a_gait_that_turns_is_said_to_come_back(turn: float, said: str | None) -> None:
    found = circle_note(problem("reference"), np.radians(turn))
    assert (found is None) == (said is None)
    assert found is None or found.startswith(said or "")


@pytest.mark.parametrize(
    "asked",
    [
        "task.constraints.straight=true",
        "task.constraints.heading_change_rad=1.5",
        'task.objectives=[{kind="effort"}]',
        'task.objectives=[{kind="displacement"},{kind="heading",target_rad=1.0}]',
        'task.demands=[{kind="reach",target=[0.1,0.0]}]',
    ],
)
def test_a_gait_that_was_asked_to_turn_or_to_do_something_else_has_no_word_of_circles(asked: str) -> None:
    assert circle_note(problem("reference", asked), 1.5) is None
