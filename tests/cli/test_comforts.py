"""What makes a command line pleasant: version, examples, completion, a log, remaining time, `show` and `--open`."""

from __future__ import annotations

import argparse
import json
import logging
import os
import re
import shutil
import subprocess
import sys
import webbrowser
from pathlib import Path

import pytest

import serpenoid
from serpenoid.cli import options
from serpenoid.cli.main import VERBS, main
from serpenoid.cli.remaining import remaining
from serpenoid.files.alone import LOCK, alone

REFERENCE = str(Path(__file__).parents[2] / "problems" / "reference.toml")


def simulated(folder: Path, *more: str) -> int:
    """`simulate`, quick: the reference gait, no figures."""
    return main(["simulate", REFERENCE, "--no-figures", "--out", str(folder), *more])


def test_the_version_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["--version"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"serpenoid {serpenoid.__version__}\n"


def test_simulate_says_what_coarse_steps_make_of_the_motion(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert simulated(tmp_path / "out", "--set", "task.steps=3", "--set", "task.cycles=2") == 0
    (said,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("mesh "))
    assert "one cycle: " in said
    assert "error of 3 steps" in said
    assert not json.loads((tmp_path / "out" / "solution.json").read_text(encoding="utf-8"))["mesh"]["converged"]


def test_examples_are_copied_whole_and_keep_what_was_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "mine"
    assert main(["examples", str(folder)]) == 0
    assert (folder / "reference.toml").read_bytes() == Path(REFERENCE).read_bytes()
    assert (folder / "robots" / "snake10-robot.toml").exists()
    (folder / "reference.toml").write_text("# mine", encoding="utf-8")
    (folder / "purcell.toml").unlink()
    assert main(["examples", str(folder)]) == 0
    assert (folder / "reference.toml").read_text(encoding="utf-8") == "# mine"
    assert capsys.readouterr().out.splitlines()[-1].startswith("1 file copied")


@pytest.mark.parametrize("shell", ["bash", "zsh", "tcsh"])
def test_completion_knows_every_verb(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    script = capsys.readouterr().out
    assert all(verb in script for verb in VERBS)


def test_bash_completes_verbs_and_options(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    main(["completion", "bash"])
    script = tmp_path / "completion"
    script.write_text(capsys.readouterr().out, encoding="utf-8")

    def completed(*words: str) -> set[str]:
        line = " ".join(f"'{word}'" for word in words)
        typed = f"COMP_WORDS=({line}); COMP_CWORD={len(words) - 1}"
        ask = f"source {script}; {typed}; _shtab_serpenoid; echo ${{COMPREPLY[@]}}"
        return set(subprocess.run(["bash", "-c", ask], capture_output=True, text=True, check=True).stdout.split())

    assert completed("serpenoid", "si") == {"simulate"}
    assert "--starts" in completed("serpenoid", "solve", "--st")


def test_the_log_tells_what_ran_and_how_it_ended(tmp_path: Path) -> None:
    log = tmp_path / "a" / "run.log"  # in the results folder, which is not there yet
    assert simulated(tmp_path / "a", "--log-file", str(log)) == 0
    assert main(["simulate", "missing.toml", "--log-file", str(log)]) == 2
    text = log.read_text(encoding="utf-8")
    assert f"serpenoid {serpenoid.__version__}" in text
    assert "exit code 0" in text
    assert "missing.toml" in text
    assert text.splitlines()[-1].endswith("exit code 2")
    assert not logging.getLogger("serpenoid").handlers


@pytest.mark.parametrize("words", [["arena", "--log-file", "{log}", "run"], ["arena", "run", "--log-file", "{log}"]])
def test_the_log_may_be_asked_for_after_a_verb_and_after_its_action(words: list[str], tmp_path: Path) -> None:
    log = tmp_path / "run.log"
    assert main([*(w.format(log=log) for w in words), "missing.toml"]) == 2
    assert "missing.toml" in log.read_text(encoding="utf-8")


def test_a_file_that_is_no_log_is_not_written_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = tmp_path / "problem.toml"
    other.write_text("[body]\n")
    assert main(["simulate", "missing.toml", "--log-file", str(other)]) == 2
    assert "is there and no log of ours" in capsys.readouterr().err
    assert other.read_text() == "[body]\n"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes with names")
def test_a_pipe_that_nobody_reads_is_refused_and_one_that_is_read_has_the_whole_log(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pipe, kept = tmp_path / "pipe", tmp_path / "kept"
    os.mkfifo(pipe)
    assert main(["simulate", "missing.toml", "--log-file", str(pipe)]) == 2
    assert "is a pipe that nobody reads" in capsys.readouterr().err
    with kept.open("w") as to, subprocess.Popen(["cat", str(pipe)], stdout=to) as reader:
        while main(["simulate", "missing.toml", "--log-file", str(pipe)]) == 2 and not kept.stat().st_size:
            pass  # the reader has yet to open it
        assert reader.wait(10) == 0
    lines = kept.read_text(encoding="utf-8").splitlines()
    assert "command: serpenoid simulate" in lines[1]
    assert lines[-1].endswith("exit code 2")


def test_a_log_may_be_in_the_folder_that_results_have_by_themselves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["simulate", REFERENCE, "--no-figures"]
    assert main(words) == 0
    folder = next(Path("results/reference").iterdir())
    shutil.rmtree("results")
    assert main([*words, "--log-file", "results/typo/run.log"]) == 2
    assert "--log-file results/typo/run.log: there is no folder results/typo" in capsys.readouterr().err
    assert not Path("results").exists()
    assert main([*words, "--log-file", str(folder / "run.log")]) == 0
    lines = (folder / "run.log").read_text(encoding="utf-8").splitlines()
    assert "command: serpenoid simulate" in lines[1]  # what was said before the folder was known
    assert lines[-1].endswith("exit code 0")


def test_a_log_may_be_in_the_folder_that_a_trial_is_recorded_in(tmp_path: Path) -> None:
    snake, trial = Path(REFERENCE).with_name("snake10.toml"), tmp_path / "trial"
    assert main(["simulate", str(snake), "--set", "gait.a=4", "--no-figures", "--out", str(tmp_path / "gait")]) == 0
    robot = str(snake.parent / "robots" / "snake10-robot.toml")
    words = ["play", str(tmp_path / "gait"), "--robot", robot, "--dry-run", "--log", str(trial)]
    assert main([*words, "--log-file", str(trial / "run.log")]) == 0
    assert "exit code 0" in (trial / "run.log").read_text(encoding="utf-8")


def test_a_log_may_be_in_the_folder_of_any_of_several_sweeps(tmp_path: Path) -> None:
    files = [REFERENCE, REFERENCE.replace("reference", "gait-a")]
    words = ["sweep", *files, "--set", "task.steps=12", "--c", "1", "--starts", "1", "--no-figures", "--no-polish"]
    main(words)  # twelve steps may be too coarse
    folder = next(Path("results/gait-a").iterdir())
    shutil.rmtree("results")
    main([*words, "--log-file", str(folder / "run.log")])
    assert "exit code" in (folder / "run.log").read_text(encoding="utf-8")


def test_a_crash_leaves_its_traceback_in_the_log(tmp_path: Path) -> None:
    log = tmp_path / "run.log"
    code = (
        "import sys, serpenoid.simulation.problem as p, serpenoid.cli.main as m\n"
        "p.simulate = lambda problem: 1 / 0\n"
        f"m.main(['simulate', {REFERENCE!r}, '--out', {str(tmp_path)!r}, '--log-file', {str(log)!r}])\n"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True).returncode == 1
    assert "ZeroDivisionError: division by zero" in log.read_text(encoding="utf-8")


def test_a_log_that_cannot_be_written_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for place, said in (
        (tmp_path, "cannot be written"),
        (tmp_path / "typo" / "run.log", "there is no folder"),
        (tmp_path / "a" / "deeper" / "run.log", "there is no folder"),
    ):
        assert simulated(tmp_path / "a", "--log-file", str(place)) == 2
        err = capsys.readouterr().err
        assert f"--log-file {place}" in err
        assert said in err
    assert list(tmp_path.iterdir()) == []


def test_verbose_is_about_this_package_and_not_about_its_libraries(tmp_path: Path) -> None:
    """matplotlib alone notes some hundred lines about fonts, filelock two for every lock."""
    words = ["simulate", REFERENCE, "--out", str(tmp_path / "a"), "-v", "--log-file", str(tmp_path / "run.log")]
    run = subprocess.run([sys.executable, "-m", "serpenoid", *words], capture_output=True, text=True, check=True)
    said = [line.split()[1] for line in run.stderr.splitlines() if line.startswith(("DEBUG", "INFO"))]
    assert "serpenoid:" in said
    assert all(name.startswith("serpenoid") for name in said)
    assert "matplotlib" not in (tmp_path / "run.log").read_text(encoding="utf-8")


def test_remaining_time_is_the_elapsed_over_the_done_share() -> None:
    assert remaining(30.0, 1, 4) == "about 1:30 left"
    assert remaining(30.0, 0, 4) == ""
    assert remaining(30.0, 4, 4) == ""


def test_open_shows_the_report_before_any_picture(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda url: bool(opened.append(url)) or True)
    assert simulated(tmp_path, "--open") == 0
    assert "neither a report nor a picture" in capsys.readouterr().err
    for name in ("b.png", "motion.png", "animation.png", "report.html"):
        (tmp_path / name).touch()
        assert main(["show", str(tmp_path), "--open"]) == 0
    assert [Path(url).name for url in opened] == ["b.png", "motion.png", "motion.png", "report.html"]


@pytest.mark.parametrize("width", [80, 140])
def test_progress_keeps_elapsed_and_remaining_time_on_a_narrow_terminal(
    width: int, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", str(width))
    monkeypatch.setenv("FORCE_COLOR", "1")
    args = argparse.Namespace(quiet=False, json=False)
    with options.progress_bar(args, "a problem of a long name", 4, left=lambda: 754.0) as advance:
        advance(1, "start 12, iteration 1234, 0.0123 s each, 1256 unknowns, and more of what nobody can read there")
    line = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", capsys.readouterr().err).splitlines()[-1].split("\r")[-1]
    assert len(line) <= width
    for word in ("a problem of a long name", " 25% ", "0:00:00 ", "about 12:34 left", "start", "…"):
        assert word in line


def test_show_of_what_was_begun_alone_says_how_to_go_on(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "request.json").write_text('{"verb": "sweep", "request": "0"}', encoding="utf-8")
    assert main(["show", str(tmp_path)]) == 2
    assert "holds no answer yet: `sweep` was stopped before it ended: run it again" in capsys.readouterr().err


def test_show_of_a_folder_where_a_command_is_at_work_says_so(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with alone(tmp_path / "out", ""):
        assert main(["show", str(tmp_path / "out")]) == 2
        assert "holds no answer yet: a serpenoid command is at work in this folder." in capsys.readouterr().err
        assert main(["show", str(tmp_path)]) == 2
        assert f"Name a folder within: {tmp_path / 'out'}." in capsys.readouterr().err
        (tmp_path / "out" / "fit.json").write_text("{}", encoding="utf-8")
        (tmp_path / "out" / "summary.txt").write_text("anisotropy_ratio 0.2\n", encoding="utf-8")
        assert main(["show", str(tmp_path / "out")]) == 0
        assert capsys.readouterr().out.startswith("unfinished        a serpenoid command is at work in this folder: ")
    (tmp_path / "out" / LOCK).touch()  # what a process that was killed leaves
    assert main(["show", str(tmp_path / "out")]) == 0
    assert "at work" not in capsys.readouterr().out


@pytest.mark.parametrize("solved", [0, 3])
def test_a_sweep_that_is_stopped_says_what_is_there_and_how_to_go_on(
    solved: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(_problem: object, _values: object, folder: Path, *_: object) -> None:
        for i in range(solved):
            (folder / "chain").mkdir(parents=True, exist_ok=True)
            (folder / "chain" / f"up-{i}.npz").touch()
        raise KeyboardInterrupt

    monkeypatch.setattr("serpenoid.cli.sweep.sweep_one", stopped)
    assert main(["sweep", REFERENCE, "--quiet", "--out", str(tmp_path)]) == 130
    kept = f"Solved points are kept in {tmp_path}; the same command goes on from there."
    none = "No point was solved yet; the same command begins anew."
    assert f"stopped. {kept if solved else none}" in capsys.readouterr().err


@pytest.mark.parametrize(("verb", "kept"), [("solve", True), ("solve", False), ("simulate", False)])
def test_a_command_that_is_stopped_as_it_writes_says_how_to_go_on(
    verb: str, kept: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def stopped(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    written = "serpenoid.results.write_solution" if kept else "serpenoid.optimise.solve.solve"
    monkeypatch.setattr(written if verb == "solve" else "serpenoid.simulation.problem.simulate", stopped)
    words = ["--set", "body.vertices=5", "--set", "task.steps=10", "--set", "task.constraints.joint_limits=false"]
    starts = ["--starts", "1"] * (verb == "solve")
    assert main([verb, REFERENCE, *words, *starts, "--quiet", "--out", str(tmp_path)]) == 130
    goes_on = f"Solved starts are kept in {tmp_path}; the same command goes on from there."
    anew = (
        "No start was solved yet; the same command begins anew." if verb == "solve" else "The same command begins anew."
    )
    assert f"stopped. {goes_on if kept else anew}" in capsys.readouterr().err


def test_show_repeats_what_a_verb_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "fit.json").write_text(json.dumps({"joint": {}}), encoding="utf-8")
    assert main(["show", str(tmp_path)]) == 2
    assert "stopped before it ended: run it again" in capsys.readouterr().err
    (tmp_path / "summary.txt").write_text("anisotropy_ratio 0.2\n", encoding="utf-8")
    assert main(["show", str(tmp_path)]) == 0
    assert capsys.readouterr().out.startswith("anisotropy_ratio 0.2\n")


def test_show_says_where_a_folder_holds_no_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["show", str(tmp_path)]) == 2
    assert "holds no results" in capsys.readouterr().err
    (tmp_path / "mine.toml").write_text("")
    assert main(["show", str(tmp_path)]) == 2
    assert "or `serpenoid measure` one of mine.toml" in capsys.readouterr().err


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_a_log_on_a_full_disk_is_said_once_and_stops_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects", "--log-file", "/dev/full"]) == 0
    said = capsys.readouterr().err
    assert said.count("No space left on device; it ends here.") == 1
    assert "Traceback" not in said


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
def test_a_terminal_that_lacks_letters_is_given_escapes(tmp_path: Path, encoding: str) -> None:
    words = [sys.executable, "-m", "serpenoid", "show", str(tmp_path / "sweep")]
    (tmp_path / "sweep").mkdir()
    (tmp_path / "sweep" / "fit.json").write_text("{}")
    (tmp_path / "sweep" / "summary.txt").write_text("fit of Ω\n", encoding="utf-8")
    done = subprocess.run(words, env={**os.environ, "PYTHONIOENCODING": encoding}, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"fit of \\u03a9")
