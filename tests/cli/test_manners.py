"""What the command line says to rubbish, to a closed pipe and to Ctrl-C: a sentence and an exit code, no traceback."""

from __future__ import annotations

import csv
import json
import os
import platform
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from serpenoid.cli.main import main
from serpenoid.cli.sweep import parse_values

PROBLEMS = Path(__file__).parents[2] / "problems"
REFERENCE, SNAKE = str(PROBLEMS / "reference.toml"), str(PROBLEMS / "snake10.toml")
LONG = "x" * 300
TABLE = "[body]\nvertices = 4\n[medium]\nanisotropy_ratio = 0.2\n[gait]\npath = 'gait.csv'\n"


def changed(folder: Path, old: str, new: str) -> str:
    """The reference problem with one text replaced, as a file."""
    path = folder / "changed.toml"
    path.write_text((PROBLEMS / "reference.toml").read_text(encoding="utf-8").replace(old, new), encoding="utf-8")
    return str(path)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "anisotropy_ratio",
            "anisotropy_ration",
            r"[medium] anisotropy_ration: unknown key. Did you mean `anisotropy_ratio`?",
        ),
        ("0.1865", "nan", "[medium] anisotropy_ratio: Input should be a finite number"),
        ("0.1865", "1.7", "must be in (0, 1], got 1.7: it is lengthwise drag over sideways"),
        ("vertices = 12", 'vertices = "twelve"', "[body] vertices"),
        ("vertices = 12", "vertices = 12\nweights = [1.0, 2.0]", "`weights` needs 12 numbers for 12 vertices, got 2"),
        (
            "vertices = 12",
            "vertices = 3\nweights = [1.0, -2.0, 1.0]",
            "[body] weights, entry 2: must be above 0, got -2.0.",
        ),
        (
            "vertices = 12",
            "vertices = 3\nedge_lengths = [0.1, -0.1]",
            "[body] edge_lengths, entry 2: must be above 0, got",
        ),
        ("vertices = 12", "edge_lengths = [0.1, 0.1]", "`vertices` is required and not there. 2 edges join 3"),
        ("[medium]", "[mediun]", "mediun: unknown key. Did you mean `medium`?"),
        ("steps = 50", "steps = 1", "[task] steps"),
        ("xi = 1.0", "xii = 1.0", "[gait] xii: unknown key. Did you mean `xi`?"),
        ("[body]", "[body", "not valid TOML"),
    ],
)
def test_a_wrong_problem_file_is_located(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, said: str
) -> None:
    assert main(["simulate", changed(tmp_path, old, new)]) == 2
    assert said in capsys.readouterr().err


def test_what_is_no_problem_file_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    binary = tmp_path / "binary.toml"
    binary.write_bytes(bytes(range(128, 256)))
    for path, said in ((tmp_path, "is a folder"), (binary, "not a text file"), (tmp_path / "none", "no such file")):
        assert main(["simulate", str(path)]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        (None, "no such file"),
        (["joint_1", "0.1", "0.2", "0.3"], "the header must be joint_1,joint_2 with 2 joints"),
        (["joint_1,joint_2", "0.1,0.2", "0.1,x", "0.1,0.2"], "gait.csv:3: joint_2 is 'x', not a number"),
        (["joint_1,joint_2", "0.1,0.2", "30,40", "0.1,0.2"], "Are these degrees?"),
        (["joint_1,joint_2", "0.1,0.2", "0.1", "0.1,0.2"], "needs 2 numbers, got 1"),
        (["joint_1,joint_2", "0.1,0.2"], "at least 3 rows, got 1"),
    ],
)
def test_a_wrong_joint_table_is_located(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rows: list[str] | None, said: str
) -> None:
    (tmp_path / "table.toml").write_text(TABLE, encoding="utf-8")
    if rows is not None:
        (tmp_path / "gait.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert main(["simulate", str(tmp_path / "table.toml")]) == 2
    assert said in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["solve", SNAKE, "--c", "abc"],
        ["solve", SNAKE, "--starts", "0"],
        ["solve", SNAKE, "--seed", "-1"],
        ["solve", SNAKE, "--improve", "0"],
        ["sweep", SNAKE, "--jobs", "0"],
        ["sweep", SNAKE, "--starts", "0"],
        ["sing", SNAKE],
    ],
)
def test_wrong_words_end_with_usage(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 2
    assert "error: argument" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "usage"),
    [
        (["solve", REFERENCE, "--foo", "3"], "usage: serpenoid solve "),
        (["--foo", "solve", REFERENCE], "usage: serpenoid solve "),
        (["new", "campaign", "--foo"], "usage: serpenoid new campaign "),
    ],
)
def test_an_unknown_option_ends_with_the_usage_of_the_command_meant(
    words: list[str], usage: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(words)
    assert stopped.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith(usage)
    assert "error: unrecognized arguments: --foo" in said


@pytest.mark.parametrize("values", ["abc", "0:1", "0:1:0", "nan", "0:inf:3", "-1:1:3", ""])
def test_values_of_c_that_make_no_sense_are_refused(values: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", SNAKE, f"--c={values}"]) == 2
    assert "write first:last:count or a list" in capsys.readouterr().err


def test_a_value_of_c_that_is_there_twice_is_one_point_of_a_sweep() -> None:
    """Its bar counts points: of three equal ones it ended at a third."""
    assert parse_values("1,0.5,1,1") == [1.0, 0.5]
    assert parse_values("2:2:5") == [2.0]


@pytest.mark.parametrize("verb", ["simulate", "solve", "sweep"])
def test_out_that_is_a_file_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], verb: str
) -> None:
    (tmp_path / "file").touch()
    assert main([verb, SNAKE, "--out", str(tmp_path / "file")]) == 2
    assert "is a file, not a folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    [
        ["simulate", REFERENCE, "--out", LONG],
        ["simulate", REFERENCE, "--log-file", f"{LONG}/run.log"],
        ["export", LONG, "--format", "csv", "--out", "gait"],
        ["compare", LONG],
        ["show", LONG],
    ],
)
def test_a_name_longer_than_files_may_have_is_bad_input(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(words) == 2
    assert capsys.readouterr().err.startswith("serpenoid: ")


def test_two_problems_do_not_share_a_folder(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", SNAKE, SNAKE, "--c", "0,1"]) == 2
    assert "the same folder" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "text"), [("solution.json", '{"status": 1}'), ("sweep.json", "x"), ("set.json", "[]"), ("none", "")]
)
def test_show_refuses_what_is_no_record(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, text: str
) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    assert main(["show", str(tmp_path)]) == 2
    assert str(tmp_path) in capsys.readouterr().err


def test_show_names_the_answers_within_a_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("diagnosis-2b", "diagnosis-1a", "notes"):
        (tmp_path / name).mkdir()
        if name != "notes":
            (tmp_path / name / "diagnosis.json").write_text("{}")
    assert main(["show", str(tmp_path)]) == 2
    within = ", ".join(str(tmp_path / name) for name in ("diagnosis-1a", "diagnosis-2b"))
    assert f"Name a folder within: {within}." in capsys.readouterr().err


def test_json_is_json_and_quiet_is_quiet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["simulate", REFERENCE, "--no-figures", "--out", str(tmp_path)]
    assert main([*words, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == "solved"
    assert main([*words, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_closed_pipe_is_no_error_message() -> None:
    command = f"{sys.executable} -m serpenoid schema | true"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=False)
    assert done.stderr == ""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_and_sigterm_alike_end_a_search_with_what_there_is(
    number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    before = signal.getsignal(number)

    def ended(done: float, _text: str = "", **_: object) -> None:
        if done >= 1:  # news of a start that lasts may come before
            os.kill(os.getpid(), number)

    @contextmanager
    def bar(*_: object) -> Iterator[object]:
        yield ended

    monkeypatch.setattr("serpenoid.cli.options.progress_bar", bar)
    words = ["--set", "body.vertices=5", "--set", "task.steps=10", "--no-figures", "--out", str(tmp_path)]
    assert main(["solve", str(PROBLEMS / "reach.toml"), "--starts", "3", *words]) == 130
    assert "stopped after 1 of 3 starts" in capsys.readouterr().err
    assert (tmp_path / "solution.json").exists()
    assert signal.getsignal(number) is before


def test_ctrl_c_inside_generated_code_has_the_usual_exit_code(tmp_path: Path) -> None:
    """Of `python -m`: Python remembers an interrupt of `exec`, as dataclasses use it, though it was handled."""
    (tmp_path / "interrupted.py").write_text(
        "import serpenoid.cli.main as cli\nfrom serpenoid.__main__ import entry\n"
        "def main():\n    try:\n        exec('raise KeyboardInterrupt')\n    except KeyboardInterrupt:\n"
        "        return cli.stopped()\ncli.main = main\nentry()\n"
    )
    words = [sys.executable, "-m", "interrupted"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60)
    assert (done.returncode, done.stderr) == (130, "serpenoid: stopped.\n")


def test_what_libraries_have_made_is_not_looked_through_as_a_command_ends(tmp_path: Path) -> None:
    (tmp_path / "ended.py").write_text(
        "import gc\nimport serpenoid.cli.main as cli\nfrom serpenoid.__main__ import entry\ncli.main = lambda: 3\n"
        "try:\n    entry()\nexcept SystemExit as end:\n    print(end.code, gc.get_freeze_count() > 10_000)\n"
    )
    words = [sys.executable, "-m", "ended"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "3 True\n"


def test_a_backend_of_somebody_elses_ends_no_command_after_its_work(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "serpenoid", "simulate", str(PROBLEMS / "reference.toml"), "--out", "out", "--quiet"]
    elsewhere = {**os.environ, "MPLBACKEND": "module://of_a_notebook"}, {**os.environ, "MPLBACKEND": "nonsense"}
    for k, environment in enumerate(elsewhere):
        words[-2] = f"out-{k}"
        done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, "")
        assert (tmp_path / f"out-{k}" / "motion.png").exists()


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="other C libraries keep memory as they like")
def test_memory_that_was_freed_is_kept_for_what_comes_next() -> None:
    import resource

    def used() -> int:
        """Pages that the system gave for four arrays of 16 MB at once, ten times."""
        before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
        for _ in range(10):
            assert all(part.all() for part in [np.ones(2**21) for _ in range(4)])
        return resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before

    used()
    assert used() < 2**26 / resource.getpagesize()


def test_what_is_found_after_the_file_was_read_names_it_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["solve", str(PROBLEMS / "sidewinding.toml"), "--ladder", "--out", str(tmp_path)]
    assert main(words) == 2
    assert "sidewinding.toml: [lift]: --ladder" in capsys.readouterr().err


def test_ctrl_c_keeps_solved_points_and_the_same_command_goes_on(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "serpenoid", "sweep", SNAKE, "--c", "0:2.5:201", "--starts", "1", "--no-polish"]
    words += ["--no-figures", "--quiet", "--out", str(tmp_path)]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    chain, patience = tmp_path / "chain", time.monotonic() + 90
    while not (chain.exists() and len(list(chain.glob("up-*"))) > 3) and time.monotonic() < patience:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=60)
    assert (process.returncode, said.strip().count("\n")) == (130, 0)
    assert "the same command goes on from there" in said
    with (tmp_path / "sweep.csv").open(newline="", encoding="utf-8") as stream:
        kinds = {row["status"] for row in csv.DictReader(stream)}
    assert {"solved", "not reached"} <= kinds
    kept = {path: os.stat(path).st_mtime_ns for path in chain.glob("up-0.*")}
    again = [*words[:5], "--c", "0,0.0125", *words[7:], "--force"]
    assert subprocess.run(again, check=False, timeout=90).returncode == 0
    assert kept
    assert all(os.stat(path).st_mtime_ns == written for path, written in kept.items())


def test_the_cost_of_transport_of_a_straight_gait_does_not_depend_on_the_cycles_simulated(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = []
    for cycles in (1, 3):
        power = ["--set", "power.idle_W=2", "--set", "power.dissipation_J=40"]
        words = [
            "simulate",
            SNAKE,
            "--json",
            "--no-figures",
            "--out",
            str(tmp_path / str(cycles)),
            "--set",
            f"task.cycles={cycles}",
        ]
        assert main([*words, *power]) == 0
        found.append(json.loads(capsys.readouterr().out)["cost_of_transport"])
    assert found[1] == pytest.approx(found[0], rel=1e-9)  # sigma = 1 turns nowhere, so displacements add up


@pytest.mark.parametrize(
    "words",
    [
        ["simulate", REFERENCE, "--out"],
        ["solve", REFERENCE, "--out"],
        ["sweep", REFERENCE, "--out"],
        ["measure", ".", "--out"],
        ["fit", ".", "--out"],
        ["compare", ".", "--out"],
        ["diagnose", ".", "--out"],
        ["reproduce", "--out"],
        ["table", ".", "--out"],
        ["export", ".", "--format", "csv", "--out"],
        ["play", ".", "--robot", "robot.toml", "--log"],
        ["robot", "power", "--port", "here", "--out"],
        ["robot", "emulate", "--report"],
        ["arena", "run", "protocol.toml", "--out"],
        ["arena", "use", ".", "protocol.toml", "--out"],
        ["new", "problem", "--out"],
        ["schema", "--write"],
        ["simulate", REFERENCE, "--log-file"],
    ],
    ids=lambda words: " ".join(w for w in words if w[0] not in "./"),
)
def test_a_place_to_write_that_is_empty_is_refused(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """As `--out "$OUT"` where OUT is not set: the answer would be elsewhere than the next command looks for it."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as ended:
        main([*words, ""])
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert words[-1] in said
    assert "names nothing. Name where to write" in said
    assert not list(tmp_path.iterdir())
