"""Files that `serpenoid new` writes run as they are; `campaign add` takes a played trial in, or changes nothing."""

from __future__ import annotations

import json
import os
import pty
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from serpenoid.cli.main import main
from serpenoid.files.alone import alone
from serpenoid.files.schema import load as load_file
from serpenoid.measure.campaign import load_campaign_file, read_motion
from serpenoid.measure.formats.columns import SECONDS
from serpenoid.measure.load import load_campaign
from serpenoid.measure.trial_files import read_files
from serpenoid.measure.write import write_motive
from serpenoid.problem import load
from serpenoid.robot.checks import check_table
from serpenoid.robot.description import Robot
from serpenoid.scaffold.add import NewTrial, add_trial
from serpenoid.scaffold.film_format import format_of
from serpenoid.scaffold.json_schema import schema_of
from serpenoid.simulation.problem import simulate
from serpenoid.table_file import read_table, write_table

SIX = ["--joints", "6", "--edges", "0.05,0.1,0.12,0.1,0.08,0.1,0.05", "--mass", "0.95", "--joint-limit", "50"]


def new(kind: str, path: Path, *words: str) -> Path:
    assert main(["new", kind, str(path), "--yes", *words]) == 0
    return path


def satisfies(kind: str, path: Path) -> None:
    """Valid for its own schema, which its first line names."""
    directive, name = path.read_text().splitlines()[0].split()
    assert directive == "#:schema"
    schema = json.loads((path.parent / name).read_text())
    assert schema == schema_of(kind)
    jsonschema.validate(tomllib.loads(path.read_text()), schema)


@pytest.mark.parametrize(
    "words",
    [
        [],
        SIX,
        ["--joints", "1"],
        ["--joints", "16", "--length", "1.4", "--mass", "2"],
        [*SIX, "--wheels", "middles"],
        [*SIX, "--dissipation", "edge"],
    ],
)
def test_a_new_problem_file_is_valid_and_its_gait_moves_within_its_limits(tmp_path: Path, words: list[str]) -> None:
    path = new("problem", tmp_path / "mine.toml", *words)
    satisfies("problem", path)
    problem = load(path)
    result = simulate(problem)
    assert result.trajectory.status.ok
    assert not problem.model.remarks
    assert np.degrees(np.abs(result.table).max()) <= (problem.joint_limit_deg or 0) or problem.body.joint_count < 6


def test_edges_say_the_length_and_a_second_word_on_it_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    edges = ["--joints", "2", "--edges", "0.1,0.2,0.1"]
    new("problem", tmp_path / "three.toml", *edges)
    assert "--length" not in capsys.readouterr().out
    assert main(["new", "problem", str(tmp_path / "two.toml"), "--yes", *edges, "--length", "0.9"]) == 2
    assert "--length: --edges says it already. Leave one of them out." in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["problem", "robot", "protocol", "campaign"])
@pytest.mark.parametrize("name", ["my snake", "plain"])
def test_commands_of_a_new_file_are_those_that_a_shell_takes(kind: str, name: str, tmp_path: Path, capsys) -> None:
    """Names with spaces, and without `.toml`, are one word, and the file's own."""
    assert main(["new", kind, name, "--yes"]) == 0
    begin = capsys.readouterr().out.splitlines()[-1].removeprefix("Begin: ")
    assert name in shlex.split(begin)
    text = next(p for p in (tmp_path / name, tmp_path / name / "campaign.toml") if p.is_file()).read_text()
    commands = [line.removeprefix("#").split("  ")[1] for line in text.splitlines() if line.startswith("#   serpenoid")]
    assert sum(name in shlex.split(command) for command in commands) >= (1 if kind == "protocol" else 2)


def test_a_new_robot_file_fits_its_problem_and_passes_its_gait(tmp_path: Path) -> None:
    problem = load(new("problem", tmp_path / "mine.toml", *SIX))
    path = new(
        "robot", tmp_path / "servos.toml", "--problem", str(tmp_path / "mine.toml"), "--ids", "11,12,13,14,15,16"
    )
    satisfies("robot", path)
    robot = load_file(Robot, path)
    assert robot.ids == [11, 12, 13, 14, 15, 16]
    assert check_table(simulate(problem).table, robot, 5.0, robot.nominal_V) == []


@pytest.mark.parametrize(("said", "written"), [("3.25", 3.25), ("", 5.0), ("900", 5.0)])
def test_a_new_robot_file_has_the_cycle_of_its_problem(tmp_path: Path, said: str, written: float) -> None:
    """If robots play such long ones; results that say none are then played as the problem asks."""
    problem = new("problem", tmp_path / "mine.toml", *SIX)
    text = re.sub(r"(?m)^cycle_duration_s.*\n", "", problem.read_text(encoding="utf-8"))
    own = f"[task]\ncycle_duration_s = {said}" if said else "[task]"
    problem.write_text(text.replace("[task]", own), encoding="utf-8")
    robot = load_file(Robot, new("robot", tmp_path / "servos.toml", "--problem", str(problem)))
    assert robot.motion.cycle_duration_s == written


def test_a_gait_at_the_limit_is_within_the_same_limit_of_a_new_robot_file(tmp_path: Path) -> None:
    for limit in (50.0, 60.0, 72.3):
        path = new("robot", tmp_path / f"{limit}.toml", "--joints", "3", "--joint-limit", str(limit))
        robot, table = load_file(Robot, path), np.deg2rad(limit) * np.array([[1.0, 0, -1], [0, 0, 0], [-1, 0, 1]])
        assert check_table(table, robot, 60.0, robot.nominal_V) == []


def test_a_joint_that_bends_farther_to_one_side_is_asked_for_with_both_ends(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = load(new("problem", tmp_path / "mine.toml", *SIX[:-1], "0,60"))
    assert found.joint_limit_deg == (0.0, 60.0)
    with pytest.raises(SystemExit):
        main(["new", "problem", str(tmp_path / "other.toml"), "--yes", "--joint-limit", "-20,60"])
    assert "a value that begins with `-` is given as --joint-limit=VALUE" in capsys.readouterr().err
    assert main(["new", "problem", str(tmp_path / "other.toml"), "--yes", *SIX[:-1], "60,0"]) == 2
    assert "joint-limit: needs -180 <= lower < upper <= 180" in capsys.readouterr().err
    path = new("robot", tmp_path / "servos.toml", "--problem", str(tmp_path / "mine.toml"))
    assert "# The body in mine.toml bends by 0 to 60 degrees" in path.read_text(encoding="utf-8")
    robot = load_file(Robot, new("robot", tmp_path / "one-sided.toml", "--joint-limit=-20,60"))
    low, high = np.degrees(robot.joint[0].angle_range)
    assert (low, high) == (pytest.approx(-20, abs=0.1), pytest.approx(60, abs=0.1))  # a tick is 0.088 degrees
    assert load_file(Robot, new("robot", tmp_path / "half.toml", "--joint-limit", "0,60")).joint[0].zero_ticks == 2048
    assert main(["new", "robot", str(tmp_path / "bent.toml"), "--yes", "--joint-limit", "10,60"]) == 2
    assert "must hold 0, where a joint is straight" in capsys.readouterr().err


def test_limits_that_nobody_stated_are_said_to_be_assumed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    new("problem", tmp_path / "mine.toml", *SIX)
    limit = load(tmp_path / "mine.toml").body.joint_limit_deg
    capsys.readouterr()
    path = new("robot", tmp_path / "servos.toml", "--problem", str(tmp_path / "mine.toml"), "--baud-rate", "57600")
    assert "said: --model XL430-W250-T, --joint-limit 80, --speed-limit usual.\n" in capsys.readouterr().out
    text = path.read_text(encoding="utf-8")
    assert (
        "# Limits: +-80 degrees at 40 rpm, the same for every joint, as this file was asked for or by default." in text
    )
    assert f"# The body in mine.toml bends by {limit:g} degrees: `play` holds that, too." in text
    new(
        "robot",
        tmp_path / "told.toml",
        "--joints",
        "6",
        "--joint-limit",
        "70",
        "--speed-limit",
        "30",
        "--baud-rate",
        "57600",
        "--model",
        "XL430-W250-T",
    )
    assert "Assumed" not in capsys.readouterr().out


def test_a_new_protocol_is_played_in_the_arena_on_the_problems_own_body(tmp_path: Path) -> None:
    problem = new("problem", tmp_path / "robots" / "mine.toml", *SIX)
    words = ["--problem", str(problem), "--trials", "1", "--cycles", "1", "--cycle-duration", "3"]
    path = new("protocol", tmp_path / "lab" / "protocol.toml", *words)
    satisfies("protocol", path)
    out = tmp_path / "out"
    assert main(["arena", "run", str(path), "--out", str(out), "-j", "1", "--quiet"]) == 0
    assert load_campaign(out).body.joint_count == 6


def test_a_new_campaign_is_measured_with_its_made_up_trial(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    problem = new("problem", tmp_path / "mine.toml", *SIX)
    new("campaign", tmp_path / "camp", "--problem", str(problem))
    satisfies("campaign", tmp_path / "camp" / "campaign.toml")
    assert main(["measure", str(tmp_path / "camp"), "--out", str(tmp_path / "out"), "--no-figures"]) == 0
    assert "trial `example` is made up" in capsys.readouterr().out
    (trial,) = load_campaign(tmp_path / "camp").trials
    assert trial.name == "example"
    capsys.readouterr()
    assert main(["fit", str(tmp_path / "camp"), "--out", str(tmp_path / "fit"), "--no-figures", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["together"]["values"]["anisotropy_ratio"]
    # the trial is the drag model's own at 0.2, and the fit knows it to 0.03 %
    assert found == pytest.approx(0.2, rel=1e-3)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["problem", "--joints", "0"], "--joints: needs a whole number from 1 to 98, got '0'"),
        (["problem", "--joints", "6", "--edges", "1,2"], "--edges: needs 7 numbers for 6 joints, got 2"),
        (["problem", "--edges", "1"], "--edges: a joint stands between two edges, got 1"),
        (["problem", "--mass", "heavy"], "--mass: needs a number, got 'heavy'"),
        (["problem", "--anisotropy", "1.5"], "--anisotropy: needs a number above 0 and at most 1, got '1.5'"),
        (["robot", "--ids", "1,1,2,3,4,5"], "--ids: needs a different ID for every servo"),
        (["robot", "--ids", "1,2"], "--ids: needs 6 numbers, one a joint, got 2"),
        (["robot", "--baud-rate", "12345"], "--baud-rate: needs one of 9600, 57600"),
        (["robot", "--problem", "/no/such.toml"], "--problem: needs a file that is there"),
        (["campaign", "--format", "kinovea"], "--format: needs one of motive, vicon"),
    ],
)
def test_an_answer_that_cannot_be_is_refused_and_nothing_is_written(
    tmp_path: Path, words: list[str], complaint: str, capsys: pytest.CaptureFixture
) -> None:
    kind, *rest = words
    assert main(["new", kind, str(tmp_path / "x.toml"), "--yes", *rest]) == 2
    assert complaint in capsys.readouterr().err
    assert not (tmp_path / "x.toml").exists()


@pytest.mark.parametrize("name", ['a"b', "a\nb = 1", "a#\x00b", "<script>"])
def test_a_name_that_would_end_a_string_or_a_comment_is_refused(tmp_path: Path, name: str, capsys) -> None:
    for kind in ("problem", "robot", "campaign"):
        path = tmp_path / name / "campaign.toml" if kind == "campaign" else tmp_path / f"{name}.toml"
        assert main(["new", kind, str(path), "--yes"]) == 2
        assert "a name is made of letters" in capsys.readouterr().err


def test_links_of_a_body_without_edges_are_as_the_question_says(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["new", "problem", str(tmp_path / "p.toml"), "--joints", "2", "--yes"]) == 0
    assert load(tmp_path / "p.toml").body.edges.tolist() == pytest.approx([0.25, 0.5, 0.25])  # no Purcell swimmer
    capsys.readouterr()
    with pytest.raises(SystemExit):
        main(["new", "problem", "--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "half as long at both ends" in said
    assert "Mass in kilograms (default 0.9, of an animal none)" in said
    assert "(default 0.2, of a swimmer 0.5)" in said


def test_edges_alone_say_how_many_joints_there_are(tmp_path: Path) -> None:
    assert load(new("problem", tmp_path / "p.toml", "--edges", "0.1,0.2,0.1")).body.joint_count == 2
    assert load(new("problem", tmp_path / "q.toml")).body.joint_count == 6


def test_an_animal_has_no_servos_and_no_limit_of_theirs(tmp_path: Path) -> None:
    path = new("problem", tmp_path / "worm.toml", "--kind", "crawler")
    assert load(path).body.joint_speed_limit_rpm is None
    assert "servo" not in path.read_text()
    assert load(new("problem", tmp_path / "snake.toml")).body.joint_speed_limit_rpm == 57.0


def test_how_fast_servos_turn_is_asked_and_what_is_assumed_of_them_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture
) -> None:
    assert load(new("problem", tmp_path / "p.toml", "--speed-limit", "40")).body.joint_speed_limit_rpm == 40.0
    assert "--speed-limit" not in capsys.readouterr().out
    new("problem", tmp_path / "q.toml")
    assert "--speed-limit 57" in capsys.readouterr().out
    worm = new("problem", tmp_path / "worm.toml", "--kind", "crawler", "--speed-limit", "40")
    assert load(worm).body.joint_speed_limit_rpm == 40.0


@pytest.mark.parametrize(("kind", "ratio"), [("crawler", 0.2), ("swimmer", 0.5)])
def test_an_animal_is_a_smooth_body_of_which_nothing_is_made_up(
    tmp_path: Path, kind: str, ratio: float, capsys: pytest.CaptureFixture
) -> None:
    path = new("problem", tmp_path / "worm.toml", "--kind", kind)
    said, found = capsys.readouterr().out, load(path)
    assert all(word not in said for word in ("wheels", "mass", "joint-limit", "length"))
    assert (found.medium.dissipation, found.medium.anisotropy_ratio) == ("edge", ratio)
    assert (found.body.mass_kg, found.body.joint_limit_deg, found.body.told_length_m) == (None, None, None)
    assert found.body.sparse_edges is None
    assert found.task.cycle_duration_s is None
    assert simulate(found).trajectory.displacement > 0.1
    satisfies("problem", path)


def test_what_is_said_of_an_animal_is_written(tmp_path: Path) -> None:
    words = "--length", "0.002", "--joint-limit", "25", "--mass", "0.1", "--cycle-duration", "2"
    found = load(new("problem", tmp_path / "worm.toml", "--kind", "crawler", *words))
    assert (found.body.told_length_m, found.body.joint_limit_deg, found.body.mass_kg) == (0.002, 25.0, 0.1)
    assert found.task.cycle_duration_s == 2.0


def test_kind_and_dissipation_of_a_new_problem_are_options(tmp_path: Path) -> None:
    path = new("problem", tmp_path / "eel.toml", "--kind", "swimming robot", "--dissipation", "edge")
    found = load(path)
    assert (found.body.kind, found.medium.dissipation) == ("swimming robot", "edge")


def test_what_resists_a_new_robot_is_an_option_and_told_where_it_is_assumed(tmp_path: Path, capsys) -> None:
    assert load(
        new("problem", tmp_path / "carpet.toml", "--kind", "crawling robot", "--law", "coulomb")
    ).medium.law == ("coulomb")
    assert "--law" not in capsys.readouterr().out
    assert load(new("problem", tmp_path / "wheels.toml")).medium.law == "viscous"
    assert "--law viscous" in capsys.readouterr().out
    assert "coulomb (dry friction)" in (tmp_path / "wheels.toml").read_text(encoding="utf-8")


def test_without_a_terminal_it_is_said_that_nothing_is_asked(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["new", "problem", str(tmp_path / "a.toml")]) == 0
    assert "this is no terminal, so nothing is asked" in capsys.readouterr().err
    assert main(["new", "problem", str(tmp_path / "b.toml"), "--yes"]) == 0
    assert capsys.readouterr().err == ""


def test_the_file_may_be_named_by_the_option_that_other_verbs_have(tmp_path: Path, capsys) -> None:
    for kind in ("problem", "robot", "protocol", "campaign"):
        path = tmp_path / kind / "campaign.toml"
        assert main(["new", kind, "--yes", "--out", str(path)]) == 0
        assert path.exists()
    assert main(["new", "robot", "a.toml", "--yes", "--out", "b.toml"]) == 2
    assert "FILE and --out name the same" in capsys.readouterr().err


def test_no_file_is_overwritten(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    path = new("problem", tmp_path / "mine.toml")
    before = path.read_text()
    assert main(["new", "problem", str(path), "--yes", "--joints", "3"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert path.read_text() == before


def test_questions_are_asked_on_a_terminal_and_asked_again_after_a_wrong_answer(tmp_path: Path) -> None:
    master, slave = pty.openpty()
    words = [sys.executable, "-m", "serpenoid", "new", "problem", str(tmp_path / "mine.toml")]
    process = subprocess.Popen(words, stdin=slave, stderr=slave, stdout=subprocess.PIPE, text=True)
    os.close(slave)
    os.write(master, b"\nmany\n4\n\n0.5\n\n\n\n\n\n\n\n\n")
    out, _ = process.communicate(timeout=60)
    said = os.read(master, 65536).decode()
    os.close(master)
    assert process.returncode == 0
    assert "How many joints (empty: one fewer than edges, else 6; of an animal 19)?" in said
    assert "needs a whole number from 1 to 98, got 'many'" in said
    assert "Begin: serpenoid solve" in out
    assert load(tmp_path / "mine.toml").body.joint_count == 4


@pytest.fixture
def played(tmp_path: Path) -> Path:
    """A campaign folder, and beside it the log and the motion file of a trial: those of the arena's next robot."""
    problem = new("problem", tmp_path / "mine.toml", *SIX)
    new("campaign", tmp_path / "camp", "--problem", str(problem))
    example = tmp_path / "camp" / "example"
    log = tmp_path / "trials" / "wave-1"
    log.mkdir(parents=True)
    table = read_table(example / "joint_table.csv")
    write_table(log / "joint_table.csv", table)
    times = np.arange(0.0, 13.0, 0.05)
    names = ",".join(f"position_{j}" for j in range(1, 7))
    step = np.floor(((times - 1.5) % 6.0) / 5.0 * 50).astype(int)
    rows = np.where(((times >= 1.5) & (step < 50))[:, None], table[np.clip(step, 0, 49)], table[0])
    np.savetxt(log / "servo.csv", np.column_stack([times, rows]), delimiter=",", header=f"t_s,{names}", comments="")
    (log / "play.json").write_text(json.dumps({"status": "done", "reason": "played to the end"}))
    trial = 'name = "wave-1"\ncycle_duration_s = 5.0\ncycles = 2\npause_s = 1.0\n'
    (log / "trial.toml").write_text(f"[[trial]]\n{trial}")
    shutil.copy(example / "motion.csv", tmp_path / "take.csv")
    return tmp_path


def add(folder: Path, *words: str) -> int:
    parts = ["campaign", "add", str(folder / "camp"), str(folder / "trials" / "wave-1"), str(folder / "take.csv")]
    return main([*parts, "--format", "tidy", *words])


def test_a_transient_is_no_trial_of_a_campaign(played: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = played / "trials" / "wave-1"
    (log / "play.json").write_text(json.dumps({"status": "done", "transient": True}))
    (log / "trial.toml").unlink()
    assert add(played) == 2
    assert "this trial is a transient, and trials of a campaign play closed tables" in capsys.readouterr().err


def test_a_played_trial_takes_the_place_of_the_made_up_one_and_is_measured(played: Path) -> None:
    assert add(played) == 0
    campaign = load_campaign(played / "camp")
    assert [trial.name for trial in campaign.trials] == ["wave-1"]
    assert {path.name for path in (played / "camp" / "wave-1").iterdir()} == {
        "joint_table.csv",
        "motion.csv",
        "play.json",
        "servo.csv",
    } - {"motion.csv"} | {"take.csv"}
    assert main(["measure", str(played / "camp"), "--out", str(played / "out"), "--no-figures", "--quiet"]) == 0


def test_a_second_trial_with_the_same_table_is_a_repeat(played: Path) -> None:
    assert add(played) == 0
    film = (played / "take.csv").read_text()
    frame = film.splitlines()[-1]
    (played / "take.csv").write_text(film.replace(frame, frame.rsplit(",", 1)[0] + ",0.1234"))  # another recording
    assert add(played, "--name", "wave-2") == 0
    assert list(load_campaign(played / "camp").gaits) == ["wave-1"]
    assert len(load_campaign(played / "camp").gaits["wave-1"]) == 2


def spoil_status(folder: Path) -> str:
    (folder / "trials/wave-1/play.json").write_text(
        json.dumps({"status": "strayed", "reason": "joint_2 did not follow"})
    )
    return "not played as asked (strayed: joint_2 did not follow)"


def spoil_motion(folder: Path) -> str:
    (folder / "take.csv").write_text("no,motion\n1,2\n")
    return f"{folder / 'take.csv'}: row 1"


def spoil_servos(folder: Path) -> str:
    (folder / "trials/wave-1/servo.csv").write_text("no,log\n1,2\n")
    return f"{folder / 'trials/wave-1/servo.csv'}: row 1"


def spoil_schedule(folder: Path) -> str:
    path = folder / "trials/wave-1/trial.toml"
    path.write_text(path.read_text().replace("cycles = 2", 'cycles = "2"'))
    return "trial `wave-1`: cycles: "


def spoil_log(folder: Path) -> str:
    (folder / "trials/wave-1/play.json").unlink()
    return "Name a folder that `serpenoid play --log` wrote"


@pytest.mark.parametrize("spoil", [spoil_status, spoil_motion, spoil_servos, spoil_schedule, spoil_log])
def test_a_trial_that_cannot_be_taken_leaves_the_campaign_as_it_was(played: Path, spoil, capsys) -> None:
    complaint = spoil(played)
    before = (played / "camp" / "campaign.toml").read_text()
    assert add(played) == 2
    assert complaint in capsys.readouterr().err
    assert (played / "camp" / "campaign.toml").read_text() == before
    assert not (played / "camp" / "wave-1").exists()


def test_a_trial_that_is_taken_anyway_says_how_it_ended(played: Path) -> None:
    reason = "by the user\n(SIGINT)"
    (played / "trials" / "wave-1" / "play.json").write_text(json.dumps({"status": "stopped", "reason": reason}))
    assert add(played, "--anyway") == 0
    assert "\n# stopped: by the user (SIGINT)\n[[trial]]\n" in (played / "camp" / "campaign.toml").read_text()


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (["0.1,play,0,7,0.5", "0.2,play,1,3,0.5", "0.3,play,1,4"], "it ended in cycle 2 of 5, after step 3"),
        (["0.1,approach,0,0,0.5"], "it ended before the first row was reached"),
        ([], "it ended before the first row was reached"),
    ],
)
def test_a_trial_that_was_stopped_is_shown_with_the_cycle_it_stopped_in(
    tmp_path: Path, rows: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    told = {"robot": "r", "cycles": 5, "cycle_duration_s": 2.0, "pause_s": 0.0, "torque_off": True}
    (tmp_path / "play.json").write_text(json.dumps(told | {"status": "stopped", "reason": "by the user (SIGINT)"}))
    (tmp_path / "servo.csv").write_text("\n".join(["t_s,phase,cycle,step,position_1", *rows]) + "\n")
    assert main(["show", str(tmp_path)]) == 0
    assert said in capsys.readouterr().out


@pytest.mark.parametrize("name", ["../out", "a/b", "", ".hidden", "x\ny"])
def test_a_name_never_leads_out_of_the_campaign(played: Path, name: str, capsys) -> None:
    assert add(played, "--name", name) == (2 if name else 0)
    assert not (played / "out").exists()


def test_a_trial_may_be_called_as_play_lets_a_log_be_called(played: Path) -> None:
    (played / "trials" / "wave-1").rename(played / "trials" / "wave 1, cold")
    parts = ["campaign", "add", str(played / "camp"), str(played / "trials" / "wave 1, cold"), str(played / "take.csv")]
    assert main([*parts, "--format", "tidy"]) == 0
    assert [trial.name for trial in load_campaign(played / "camp").trials] == ["wave 1, cold"]


def test_the_same_name_twice_is_refused(played: Path, capsys) -> None:
    assert add(played) == 0
    assert add(played) == 2
    assert "has a trial `wave-1` already" in capsys.readouterr().err


@pytest.fixture
def worm(tmp_path: Path) -> Path:
    """Two films of a crawling body of five points, 25 frames a second: names and pixels, head first."""
    time, edges = np.arange(100) / 25, np.arange(4)
    angle = 0.5 * np.sin(2 * np.pi * (time[:, None] + edges / 4))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    points = np.concatenate([np.zeros((100, 1, 2)), np.cumsum(steps, axis=1)], axis=1)[:, ::-1]
    points[..., 0] += 0.5 * time[:, None]
    names = ["nose", "n1", "n2", "n3", "tip"]
    head = [["scorer", *["net"] * 10], ["bodyparts", *np.repeat(names, 2)], ["coords", *["x", "y"] * 5]]
    for number in (1, 2):
        rows = [[str(f), *map(repr, row)] for f, row in enumerate((40 * points + number).reshape(100, 10).tolist())]
        (tmp_path / f"worm-{number}.csv").write_text("\n".join(",".join(row) for row in head + rows) + "\n")
    return tmp_path


FILMED = ["--film", "worm-1.csv", "--format", "deeplabcut", "--first-point", "head", "--frames-per-second", "25"]


def test_films_of_an_animal_become_a_campaign_by_two_commands(worm: Path, capsys: pytest.CaptureFixture) -> None:
    new("campaign", worm / "c", *FILMED)
    assert "Assumed, as nobody said: --kind crawler." in capsys.readouterr().out
    satisfies("campaign", worm / "c" / "campaign.toml")
    assert main(["campaign", "add", "c", "worm-2.csv"]) == 0
    campaign = load_campaign(worm / "c")
    assert [trial.name for trial in campaign.trials] == ["worm-1", "worm-2"]
    assert (campaign.body.kind, campaign.body.vertices) == ("crawler", 5)
    assert campaign.file.motion.markers == ("tip", "n3", "n2", "n1", "nose")
    assert campaign.trials[0].motion is not None
    assert campaign.trials[0].motion.time_s[-1] == pytest.approx(99 / 25)
    assert "made up" not in (worm / "c" / "campaign.toml").read_text()
    assert main(["campaign", "add", "c", "worm-2.csv"]) == 2
    assert "has a trial `worm-2` already" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "text", "kind"),
    [
        ("worm-1.csv", None, "deeplabcut"),
        ("s.csv", "track,frame_idx,a.x,a.y,a.score\n,0,1,1,1\n", "sleap"),
        ("m.csv", "Format Version,1.23\n", "motive"),
        ("l.csv", "t,point,x,y\n0,1,2,3\n", "long"),
        ("t.csv", "Time (s),M1_x,M1_y\n0,1,2\n", "tidy"),
        ("q.tsv", "NO_OF_FRAMES\t3\n", "qualisys"),
        ("w.wcon", "{}", "wcon"),
        ("t.xml", "<Tracks/>", "trackmate"),
    ],
)
def test_a_film_says_its_format_by_what_it_begins_like(worm: Path, name: str, text: str | None, kind) -> None:
    if text is not None:
        (worm / name).write_text(text)
    assert format_of(worm / name) == kind


def test_a_film_whose_format_nobody_says_is_read_as_what_it_is(worm: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["new", "campaign", "c", "--yes", "--film", "worm-1.csv"]) == 0
    assert "Assumed, as nobody said: --format deeplabcut" in capsys.readouterr().out
    assert load_campaign_file(worm / "c")[0].motion.format == "deeplabcut"


def test_films_that_are_added_at_the_same_time_are_all_there(worm: Path) -> None:
    new("campaign", worm / "c", *FILMED)
    lines = (worm / "worm-2.csv").read_text().splitlines()
    films = [worm / f"film-{n}.csv" for n in range(4)]
    for n, film in enumerate(films):
        rows = [[float(cell) for cell in line.split(",")] for line in lines[3:]]
        moved = [",".join(map(repr, [frame, *(x + 10 * n for x in points)])) for frame, *points in rows]
        film.write_text("\n".join([*lines[:3], *moved]) + "\n")
    with ThreadPoolExecutor(len(films)) as pool:
        names = list(pool.map(lambda film: add_trial(worm / "c", NewTrial(None, film)), films))
    trials = [trial.name for trial in load_campaign(worm / "c").trials]
    assert {*names} < {*trials}
    assert len(trials) == 1 + len(films)


def test_an_end_that_the_names_of_the_points_contradict_is_refused(worm: Path, capsys: pytest.CaptureFixture) -> None:
    film = worm / "worm-1.csv"
    film.write_text(film.read_text().replace("nose", "Snout").replace("tip", "Tail_tip"))
    words = ["new", "campaign", "c", "--yes", "--film", "worm-1.csv", "--format", "deeplabcut"]
    assert main(words) == 2
    said = "the first point of the film is `Snout` and the last `Tail_tip`. Give --first-point head."
    assert said in capsys.readouterr().err
    assert main([*words, "--first-point", "head"]) == 0
    assert load_campaign_file(worm / "c")[0].motion.markers[0] == "Tail_tip"


@pytest.mark.parametrize(
    ("header", "extra", "told"),
    [
        ("t,point,x [cm],y [cm]", ["--columns", "time=t,point=point,x=x [cm],y=y [cm]"], "Here: --length-unit."),
        ("t [ms],point,x,y", ["--columns", "time=t [ms],point=point,x=x,y=y"], "Here: --time-unit."),
        ("t,who,x,y", [], "the file has t, who, x, y. Name them in `columns`. Here: --columns."),
        ("t,point,x,y", [], "Is a row there twice? Leave it out. Here: --columns, --individual."),
    ],
)
def test_what_a_film_lacks_is_said_by_the_options_that_give_it(worm: Path, header, extra, told, capsys) -> None:
    """No campaign file is there yet, in which a key could be set."""
    rows = [f"{f / 10},{point},{point},{f % 2}" for f in range(10) for point in (0, 1, 2, 3, 3)]
    (worm / "long.csv").write_text("\n".join([header, *rows]))
    assert main(["new", "campaign", "c", "--film", "long.csv", "--format", "long", "--yes", *extra]) == 2
    assert told in " ".join(capsys.readouterr().err.split())


def test_a_tidy_film_without_times_is_told_the_options_that_read_it(worm: Path, capsys) -> None:
    rows = [f"{f / 10:.1f},0,1,{f % 2},2,0,3,0" for f in range(20)]
    (worm / "bare.csv").write_text("\n".join(["x_0,y_0,x_1,y_1,x_2,y_2,x_3,y_3", *rows]))
    words = ["new", "campaign", "c", "--film", "bare.csv", "--format", "tidy", "--yes"]
    assert main(words) == 2
    assert "Here: --length-unit, --columns, --frames-per-second." in capsys.readouterr().err
    assert main([*words, "--columns", "x=x_*,y=y_*", "--frames-per-second", "10"]) == 0
    assert "frames_per_second = 10" in (worm / "c" / "campaign.toml").read_text()


def test_a_film_that_says_its_times_keeps_them(worm: Path, capsys: pytest.CaptureFixture) -> None:
    rows = [f"{f / 10:.1f},0,0,1,{f % 2},2,0,3,0" for f in range(20)]
    (worm / "tidy.csv").write_text("\n".join(["t_s,x_0,y_0,x_1,y_1,x_2,y_2,x_3,y_3", *rows]))
    path = new("campaign", worm / "c", "--film", "tidy.csv", "--format", "tidy", "--length-unit", "mm")
    assert "frames-per-second" not in capsys.readouterr().out
    text = (path / "campaign.toml").read_text()
    assert "frames_per_second" not in text
    assert "vertices = 4" in text
    assert 'length_unit = "mm"' in text


@pytest.mark.parametrize("told", ["s", "ms"])
def test_a_films_times_are_in_the_unit_that_an_option_tells(worm: Path, told: str) -> None:
    rows = [f"{10.0 * f / SECONDS[told]:.1f},0,0,1,{f % 2},2,0,3,0" for f in range(20)]
    (worm / "tidy.csv").write_text("\n".join(["t_s,x_0,y_0,x_1,y_1,x_2,y_2,x_3,y_3", *rows]))
    words = ["--film", "tidy.csv", "--format", "tidy", "--length-unit", "mm", "--time-unit", told]
    file, folder = load_campaign_file(new("campaign", worm / "c", *words))
    tracks = read_motion(file, file.trial[0], folder)
    assert tracks is not None
    assert tracks.time_s[-1] - tracks.time_s[0] == pytest.approx(190.0)


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (
            [*FILMED, "--problem", "robot.toml"],
            "--problem: --film is of an animal, whose body the film tells. Of a robot leave that out: `campaign add`",
        ),
        (["--kind", "swimmer"], "--kind: is for --film alone. Give that, too."),
        (["--film", "none.csv"], "--film: needs a file that is there"),
        ([*FILMED, "--columns", "time"], "--columns: needs names and words as a=x,b=y, got 'time'"),
        ([*FILMED, "--time-unit", "ms"], "--time-unit: is for tidy and long films, got --format deeplabcut"),
        ([*FILMED, "--columns", "time=t"], "--columns: is for tidy and long films, got --format deeplabcut"),
        ([*FILMED, "--individual", "two"], "the file has no names of individuals"),
        (["--film", "worm-1.csv", "--format", "motive"], 'Is `format = "motive"` right for this file?'),
    ],
)
def test_a_film_that_cannot_be_read_makes_no_campaign(worm: Path, words: list[str], complaint: str, capsys) -> None:
    assert main(["new", "campaign", "c", "--yes", *words]) == 2
    assert complaint in capsys.readouterr().err
    assert not (worm / "c").exists()


def test_a_new_campaign_of_a_robot_with_wheels_amid_its_links_has_markers_at_joints_and_ends(tmp_path: Path) -> None:
    problem = new("problem", tmp_path / "mine.toml", "--joints", "3", "--wheels", "middles")
    new("campaign", tmp_path / "camp", "--problem", str(problem), "--format", "deeplabcut")
    campaign = load_campaign(tmp_path / "camp")
    motion = campaign.file.motion
    assert (campaign.body.vertices, motion.vertices) == (9, (0, 2, 4, 6, 8))
    assert motion.markers == ("Robot:tail", "Robot:joint_1", "Robot:joint_2", "Robot:joint_3", "Robot:head")
    assert campaign.trials[0].motion is not None


def test_a_robots_trial_is_not_its_film_alone(played: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "add", str(played / "camp"), str(played / "take.csv")]) == 2
    assert "LOG is missing: a robot's trial is what `serpenoid play --log` recorded, and its film." in (
        capsys.readouterr().err
    )


def test_a_table_that_another_controller_played_becomes_a_trial_and_its_repeat(
    played: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    camp, film = played / "camp", played / "take.csv"
    table = played / "trials" / "wave-1" / "joint_table.csv"
    gait = played / "gait"
    gait.mkdir()
    shutil.copy(table, gait)
    words = ["campaign", "add", str(camp), str(gait), str(film), "--format", "tidy", "--cycles", "2", "--pause", "1"]
    assert main(words) == 2
    assert "does not say how it was played. Give --cycle-duration" in capsys.readouterr().err
    assert not (camp / "take").exists()
    assert main([*words, "--cycle-duration", "3"]) == 0
    assert (
        main([*words, "--cycle-duration", "3", "--name", "again", "--servo-log", str(table.with_name("servo.csv"))])
        == 0
    )
    first, again = load_campaign_file(camp)[0].trial
    assert (first.name, first.gait, again.gait) == ("take", "take", "take")
    assert (first.cycles, first.pause_s, first.cycle_duration_s) == (2, 1.0, 3.0)
    assert (first.servo_log, again.servo_log) == (None, "again/servo.csv")
    np.testing.assert_array_equal(read_table(camp / "again" / "joint_table.csv"), read_table(table))


def test_files_that_are_not_what_the_campaign_says_of_them_are_refused_before_they_are_taken(
    played: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    camp, film, table = played / "camp", played / "take.csv", played / "trials" / "wave-1" / "joint_table.csv"
    before, log = (camp / "campaign.toml").read_text(), played / "log.csv"
    log.write_text(table.with_name("servo.csv").read_text().replace("position_", "ist_"))
    own = shutil.copy(table, played / "own.csv")
    words = ["campaign", "add", str(camp), str(own), str(film), "--cycles", "2", "--cycle-duration", "5"]
    assert main([*words, "--format", "tidy", "--servo-log", str(log)]) == 2
    assert "no column is called `position_*`; the log has t_s, ist_1" in capsys.readouterr().err
    names = [f"Snake:{k}" for k in range(8)]
    write_motive(film, np.arange(20) / 120, np.cumsum(np.ones((20, 8, 2)), axis=1) / 10, names)
    assert main([*words, "--format", "motive"]) == 2
    assert "none of the campaign's `markers` is in it; it has Snake:0" in capsys.readouterr().err
    assert (camp / "campaign.toml").read_text() == before
    assert not (camp / "take").exists()


def test_schedules_beside_what_play_recorded_or_beside_nothing_are_refused(
    played: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    camp, log, film = (str(played / name) for name in ("camp", "trials/wave-1", "take.csv"))
    assert main(["campaign", "add", camp, log, film, "--cycles", "2"]) == 2
    assert "play.json says how it was played. Leave out --cycles" in capsys.readouterr().err
    table = played / "mine.csv"
    shutil.copy(played / "trials" / "wave-1" / "joint_table.csv", table)
    assert main(["campaign", "add", camp, str(table), film]) == 2
    assert "of a joint table that another controller played say --cycles" in capsys.readouterr().err
    for words, said in [
        ([str(played / "none.csv"), film], "no such joint table"),
        ([str(table), film, "--cycle-duration", "0"], "cycle_duration_s"),
        (
            [str(table), film, "--cycle-duration", "5", "--pause", "nan"],
            "`pause_s` must be a number of seconds, got nan",
        ),
        ([str(table), film, "--cycle-duration", "5", "--from", "inf"], "`from_s` must be a number of seconds, got inf"),
        ([str(table), film, "--cycle-duration", "5", "--servo-log", "none.csv"], "none.csv: no such servo log"),
    ]:
        assert main(["campaign", "add", camp, *words, "--format", "tidy", "--cycles", "2"]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.parametrize("kind", ["long", "tidy", "c3d"])
def test_a_new_campaign_of_any_format_is_read_and_says_which_keys_the_format_needs(tmp_path: Path, kind: str) -> None:
    new("campaign", tmp_path / "camp", "--format", kind)
    text = (tmp_path / "camp" / "campaign.toml").read_text(encoding="utf-8")
    assert ("columns = {" in text) == (kind in ("long", "tidy"))
    assert ("up_axis" in text) == (kind == "c3d")
    assert "kind = " in text
    assert len(read_files(*load_campaign_file(tmp_path / "camp"))[1]) == 1


def test_a_campaign_of_a_smooth_body_fits_its_drag_where_the_problem_has_it(tmp_path: Path) -> None:
    path = new("problem", tmp_path / "mine.toml", *SIX, "--dissipation", "edge", "--kind", "swimming robot")
    body = load(path).body
    assert body.joint_count == 6
    assert body.vertices == 4 * 7 + 1
    folder = new("campaign", tmp_path / "c" / "campaign.toml", "--problem", str(path), "--format", "deeplabcut").parent
    campaign = load_campaign(folder)
    assert campaign.file.medium is not None
    assert campaign.file.medium.dissipation == "edge"
    motion = campaign.trials[0].motion
    assert motion is not None
    assert motion.hidden_share == 0  # what cuts a link into edges has no marker, and is none that is hidden
    assert len(motion.never_seen) == body.vertices - 8
    angle = np.abs(motion.smooth_angles).max()
    assert angle == pytest.approx(np.abs(read_table(folder / "example" / "joint_table.csv")).max(), abs=0.01)


def test_two_that_write_into_one_folder_at_once_are_not_mixed(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    folder, problem = tmp_path / "c", Path(__file__).parents[1] / "problems" / "purcell-stroke.toml"
    words = ["new", "campaign", str(folder), "--problem", str(problem), "--yes"]
    with alone(folder, "held"):
        assert main(words) == 2
    assert "another serpenoid command writes in its folder" in capsys.readouterr().err
    assert not folder.exists()
    assert main(words) == 0
    assert not (folder / ".serpenoid.lock").exists()


def test_a_film_of_too_few_frames_begins_no_campaign(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (film := tmp_path / "short.csv").write_text("t_s,x_0,y_0,x_1,y_1,x_2,y_2\n0,0,0,1,0,2,0\n")
    words = ["new", "campaign", str(tmp_path / "c"), "--yes", "--film", str(film), "--format", "tidy"]
    assert main(words) == 2
    assert "short.csv: 1 frame; a motion takes 8 or more" in capsys.readouterr().err
    assert not (tmp_path / "c").exists()
