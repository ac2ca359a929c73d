"""A limit that the body declares holds from the problem file to the servo, and is switched off in words only."""

import json
import re
from math import degrees

import numpy as np
import pytest
from emulated import ROBOT_FILE, gait, serpenoid

from serpenoid.optimise.program.limits import path_limits, violations
from serpenoid.optimise.solve import solve
from serpenoid.problem import Problem, load
from serpenoid.robot.table import write_table

SIX = """
[body]
vertices = 8
edge_lengths = [0.05, 0.1, 0.12, 0.1, 0.08, 0.1, 0.05]
joint_limit_deg = 50
joint_speed_limit_rpm = 30
[medium]
anisotropy_ratio = 0.2
[task]
steps = 30
cycle_duration_s = 4.0
"""


@pytest.fixture
def six(tmp_path) -> Problem:
    (tmp_path / "six.toml").write_text(SIX)
    return load(tmp_path / "six.toml")


def without(folder, *names: str) -> Problem:
    return load(folder / "six.toml", set=[f"task.constraints.{name}=false" for name in names])


def test_an_optimum_keeps_the_limits_that_its_body_declares(six):
    best = solve(six, starts=2, seed=0).best
    assert best.status.ok
    assert degrees(np.abs(best.table).max()) <= 50 * (1 + 1e-9)
    assert violations(best.table, path_limits(six)).max() <= 1e-9


def test_a_limit_that_is_switched_off_no_longer_binds_the_optimum(six, tmp_path):
    free = solve(without(tmp_path, "joint_limits", "joint_speed_limits"), starts=2, seed=0).best
    assert free.status.ok
    assert degrees(np.abs(free.table).max()) > 50


def test_declared_and_demanded_limits_are_one_problem_and_switched_off_ones_another(six, tmp_path):
    demanded = load(tmp_path / "six.toml", set=["task.constraints.joint_limits=true"])
    assert demanded.hash == six.hash
    assert len({six.hash, without(tmp_path, "joint_limits").hash, without(tmp_path, "joint_speed_limits").hash}) == 3


def test_a_model_that_brings_its_own_body_leaves_the_limits_of_the_joints(six, tmp_path):
    body = "[body]\nvertices = 8\nlength_m = 0.6\n"
    (tmp_path / "model.toml").write_text(body + "[medium]\nanisotropy_ratio = 0.3\n")
    model = load(tmp_path / "six.toml", model=tmp_path / "model.toml")
    assert (model.joint_limit_deg, model.joint_speed_limit_rpm) == (50, 30)
    assert model.body.length_m == 0.6


def test_summary_says_whether_a_limit_holds_is_broken_or_is_switched_off(six, tmp_path):
    words = ["simulate", tmp_path / "six.toml", "--no-figures", "--force", "--out", tmp_path / "out"]
    done = serpenoid(*words, "--set", "gait.a=3")
    assert "joint limit       50 degrees; joints reach" in done.stdout
    done = serpenoid(*words, "--set", "gait.a=9")
    assert "warning           joint_" in done.stdout
    assert "its limit is 50" in done.stdout
    done = serpenoid(*words, "--set", "gait.a=9", "--set", "task.constraints.joint_limits=false")
    assert "50 degrees SWITCHED OFF by `joint_limits`" in done.stdout


def stated(folder, held: bool) -> None:
    """A results folder whose gait bends its joints by 34 degrees, of a body that allows 30."""
    folder.mkdir()
    write_table(folder / "joint_table.csv", gait(40, 0.6))
    own = {"body": {"joint_limit_deg": 30.0}, "limits_held": {"joint_limits": held}}
    record = {"cycle_duration_s": 5.0, "transient": False} | own
    (folder / "solution.json").write_text(json.dumps(record))


VERBS = {
    "check": ["robot", "check", "{}", "--robot", ROBOT_FILE],
    "play": ["play", "{}", "--robot", ROBOT_FILE, "--dry-run"],
    "export": ["export", "{}", "--robot", ROBOT_FILE, "--format", "ticks", "--out", "{}/ticks"],
    "export without a robot": ["export", "{}", "--format", "csv", "--out", "{}/csv"],
}


@pytest.mark.parametrize("verb", VERBS)
def test_no_verb_passes_a_gait_beyond_the_limit_of_its_body_unless_told_to(tmp_path, verb):
    stated(tmp_path / "held", held=True)
    words = [str(word).format(tmp_path / "held") for word in VERBS[verb]]
    done = serpenoid(*words)
    assert done.returncode == 1
    assert "angle 34.4 degrees; the body's limit is 30 degrees" in done.stderr
    done = serpenoid(*words, "--no-joint-limits")
    assert done.returncode == 0, done.stderr
    assert "the limits of the results' body are not held" in done.stderr


@pytest.mark.parametrize(
    ("limit", "said"),
    [
        ([0, 60], "angle -34.4 degrees; the body's limit is 0 to 60 degrees"),
        ([[-40, 40]] * 9 + [[-40, 34.3]], "joint_10, step"),
        ([[-40, 40]] * 9 + [[-34.37, 40]], "angle -34.4 degrees; the body's limit is -34.37 to 40 degrees"),
        ([[0, 60], [-60, 0]], "`joint_limit_deg` needs 10 pairs"),
        ([-40, 40], None),
        ([[-40, 40]] * 9 + [[-36, 35]], None),
    ],
)
def test_a_table_beyond_the_range_of_one_joint_is_not_exported(tmp_path, limit, said):
    stated(tmp_path / "one", held=True)
    file = tmp_path / "one" / "solution.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"body": {"joint_limit_deg": limit}}))
    done = serpenoid("export", tmp_path / "one", "--format", "csv", "--out", tmp_path / "csv")
    assert done.returncode == (0 if said is None else 1), done.stderr
    assert said is None or said in done.stderr


@pytest.mark.slow
def test_summary_says_which_joint_bends_to_the_side_that_it_has_not(six, tmp_path):
    words = ["simulate", tmp_path / "six.toml", "--force", "--out", tmp_path / "out", "--set", "gait.a=3"]
    done = serpenoid(*words, "--set", "body.joint_limit_deg=[0, 60]")
    assert re.search(r"warning           joint_\d reaches -\d+\.\d degrees, its limit is 0 to 60\n", done.stdout)
    assert (tmp_path / "out" / "solution.json").is_file()
    done = serpenoid(*words, "--no-figures", "--set", "body.joint_limit_deg=[-70, 60]")
    assert re.search(r"joint limit       -70 to 60 degrees; joints reach -\d+\.\d to \d+\.\d\n", done.stdout)
    each = "body.joint_limit_deg=[[-70, 70], [-70, 70], [-1, 60], [-70, 60], [-70, 60], [-70, 60]]"
    done = serpenoid(*words, "--no-figures", "--set", each)
    assert re.search(r"warning           joint_3 reaches -\d+\.\d degrees, its limit is -1 to 60\n", done.stdout)
    done = serpenoid(*words, "--no-figures", "--set", each, "--set", "task.constraints.joint_limits=false")
    assert "70, 70, -1 to 60, -70 to 60, -70 to 60 and -70 to 60 (by joint) degrees SWITCHED OFF" in done.stdout


@pytest.mark.parametrize(
    "verb", [pytest.param("check", marks=pytest.mark.slow), "play", pytest.param("export", marks=pytest.mark.slow)]
)
def test_all_limits_are_told_at_once_and_a_cycle_that_keeps_them_all(tmp_path, verb):
    """The servos' limit asks for a shorter cycle than the body's: whoever plays what is said is refused no more."""
    stated(tmp_path / "slow", held=False)
    file = tmp_path / "slow" / "solution.json"
    body = {"joint_limit_deg": 30.0, "joint_speed_limit_rpm": 2.0}
    file.write_text(json.dumps(json.loads(file.read_text()) | {"body": body}))
    words = [str(word).format(tmp_path / "slow") for word in VERBS[verb]]
    done = serpenoid(*words, "--cycle-duration", "0.2")
    assert done.returncode == 1
    assert "`speed_limit_rpm`" in done.stderr
    assert "the body's limit is 2 rpm" in done.stderr
    (needed,) = set(re.findall(r"a cycle of (\S+) s or more", done.stderr))
    assert serpenoid(*words, "--cycle-duration", needed).returncode == 0
    shorter = serpenoid(*words, "--cycle-duration", str(float(needed) - 0.01))
    assert shorter.returncode == 1
    assert "speed 2.0 rpm" not in shorter.stderr  # of a limit of 2 rpm


def test_a_limit_switched_off_in_the_problem_file_is_named_when_its_gait_is_checked(tmp_path):
    stated(tmp_path / "off", held=False)
    done = serpenoid("robot", "check", tmp_path / "off", "--robot", ROBOT_FILE)
    assert done.returncode == 0
    assert "joint limit of 30 degrees switched off in the problem file" in done.stderr


@pytest.mark.parametrize("verb", VERBS)
def test_a_gait_that_solve_refused_is_played_with_a_warning(tmp_path, verb):
    stated(tmp_path / "bad", held=False)
    file = tmp_path / "bad" / "solution.json"
    refused = {"kind": "optimum", "status": "infeasible", "message": "no start met all constraints"}
    file.write_text(json.dumps(json.loads(file.read_text()) | refused | {"rows_that_cross": 5}))
    done = serpenoid(*(str(word).format(tmp_path / "bad") for word in VERBS[verb]))
    assert done.returncode == 0, done.stderr
    assert "`solve` found no optimum, infeasible: no start met all constraints" in done.stderr
    assert "the body crosses itself in 5 rows: links may hit each other" in done.stderr


def transient(folder, rows):
    """A results folder of a transient."""
    folder.mkdir()
    write_table(folder / "joint_table.csv", np.asarray(rows))
    record = {"cycle_duration_s": 5.0, "transient": True, "body": {}, "limits_held": {}}
    (folder / "solution.json").write_text(json.dumps(record))
    return folder


@pytest.mark.parametrize("verb", VERBS)
def test_a_transient_is_played_and_exported_once(tmp_path, verb):
    open_end = transient(tmp_path / "open", gait(40, 0.2)[:25])
    done = serpenoid(*(str(word).format(open_end) for word in VERBS[verb]))
    assert done.returncode == 0, done.stderr
    assert ("24 steps to be played once; hold the last row" in done.stderr) == verb.startswith("export")


@pytest.mark.parametrize("verb", ["play", "export without a robot"])
def test_a_transient_is_not_repeated_unless_its_end_is_its_beginning(tmp_path, verb):
    angles = gait(40, 0.2)
    open_end, closed = transient(tmp_path / "open", angles), transient(tmp_path / "closed", [*angles, angles[0]])
    done = serpenoid(*(str(word).format(open_end) for word in VERBS[verb]), "--cycles", 2)
    assert done.returncode == 1
    assert "this table is a transient, and 2 cycles of it would jump back. Play it once (--cycles 1)" in done.stderr
    done = serpenoid(*(str(word).format(closed) for word in VERBS[verb]), "--cycles", 2)
    assert done.returncode == 0, done.stderr


def test_a_summary_tells_the_speed_of_a_transients_own_steps(six, tmp_path):
    """6 joints from 0 to 0.6 rad in 30 even steps and 4 s: 1.43 rpm."""
    write_table(tmp_path / "there.csv", np.linspace(0, 0.6, 31)[:, None] * np.ones(6))
    (tmp_path / "there.toml").write_text(SIX + 'transient = true\n[gait]\npath = "there.csv"\n')
    done = serpenoid("simulate", tmp_path / "there.toml", "--no-figures", "--out", tmp_path / "out")
    assert "joint speed       30 rpm; joints reach 1.4" in done.stdout
