"""One folder, one answer: another question is refused, or moves the earlier answer aside whole."""

from __future__ import annotations

import errno
import json
from importlib import import_module
from pathlib import Path

import pytest

from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.files.alone import alone
from serpenoid.files.writing import atomic

REFERENCE = str(Path(__file__).parents[2] / "problems" / "reference.toml")


def simulated(out: Path, *more: str) -> int:
    return main(["simulate", REFERENCE, "--no-figures", "--quiet", "--out", str(out), *more])


def test_the_same_question_writes_the_same_answer_again(tmp_path: Path) -> None:
    assert simulated(tmp_path / "out") == 0
    first = (tmp_path / "out" / "trajectory.csv").read_bytes()
    assert simulated(tmp_path / "out") == 0
    assert (tmp_path / "out" / "trajectory.csv").read_bytes() == first
    assert not list((tmp_path / "out").glob("earlier-*"))


def test_another_question_is_refused_and_nothing_is_touched(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "out"
    assert simulated(out) == 0
    before = {p.name: p.read_bytes() for p in out.iterdir()}
    assert simulated(out, "--set", "gait.a=4") == 2
    said = capsys.readouterr().err
    assert f"--out {out}: holds the answer of another `simulate` (there no --set; here --set gait.a=4)." in said
    assert "earlier-1 by --force" in said
    assert {p.name: p.read_bytes() for p in out.iterdir()} == before


def test_more_starts_are_told_from_fewer_and_with_force_solve_only_what_is_new(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    problem = str(Path(REFERENCE).with_name("reference-optimum.toml"))
    words = ["solve", problem, "--set", "task.steps=20", "--no-figures", "--quiet", "--out", str(tmp_path), "--starts"]
    assert main([*words, "1"]) in (0, 1)  # the mesh is coarse
    capsys.readouterr()
    assert main([*words, "2"]) == 2
    said = capsys.readouterr().err
    assert "holds the answer of another `solve` (there --starts 1; here --starts 2)" in said
    assert "by --force; what is solved there stays" in said
    assert main([*words, "2", "--force"]) in (0, 1)
    found = json.loads((tmp_path / "solution.json").read_text())["multi_start"]
    assert (found["starts"], found["kept_from_an_earlier_run"]) == (2, 1)
    assert (tmp_path / "earlier-1" / "solution.json").exists()


def test_a_file_that_was_changed_is_told_from_other_words(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine, out = tmp_path / "mine.toml", tmp_path / "out"
    words = ["simulate", str(mine), "--no-figures", "--quiet", "--out", str(out)]
    mine.write_text(Path(REFERENCE).read_text())
    assert main(words) == 0
    mine.write_text(Path(REFERENCE).read_text().replace("steps = ", "steps = 1", 1))
    assert main(words) == 2
    assert "another `simulate` (of the same words: what they read has changed since)" in capsys.readouterr().err


def test_each_question_of_a_diagnosis_has_a_folder_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    problems = Path(REFERENCE).parent
    lamprey, robot = str(problems / "campaigns" / "lamprey.toml"), str(problems / "lamprey-water.toml")
    folders: list[Path] = []

    def asked(_: object, folder: Path, *__: object) -> Path:
        folders.append(folder)
        raise InputError("enough is known")

    monkeypatch.setattr("serpenoid.cli.options.claim", asked)
    start = import_module("serpenoid.diagnose.start")
    monkeypatch.setattr(start, "check_reference", lambda *_: None)  # refuses an animal
    questions = [
        [lamprey],
        [lamprey, "--model", robot],
        [lamprey, "--reference", lamprey],
        [lamprey, "--without", "added_mass"],
        [lamprey, lamprey],
        [lamprey, lamprey, "--model", robot],
    ]
    for words in questions + questions:
        assert main(["diagnose", *words]) == 2
    first, again = folders[: len(questions)], folders[len(questions) :]
    assert first == again
    assert len(set(first)) == len(questions)
    assert {str(path).rpartition("-")[0] for path in first} == {"results/lamprey/diagnosis", "results/diagnoses"}


def test_a_folder_on_which_another_command_works_is_refused_until_that_ends(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    with alone(tmp_path / "elsewhere" / ".." / "out", ""):
        assert simulated(out) == 2
    assert "another serpenoid command is at work on it" in capsys.readouterr().err
    assert not out.exists()  # held, it was made; with nothing in it, it went again
    assert simulated(out) == 0
    assert simulated(out) == 0  # the first has let it go


def test_a_command_ended_amid_its_answer_may_be_given_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"

    def ended(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("serpenoid.cli.options.report", ended)  # all is written but the summary
        assert simulated(out) == 130
    assert (out / "solution.json").exists()
    assert simulated(out, "--set", "gait.a=4") == 2
    (out / "solution.json").unlink()  # killed earlier still
    capsys.readouterr()
    assert simulated(out, "--set", "gait.a=4") == 2
    assert "what another `simulate` left that was ended before its answer was whole" in capsys.readouterr().err
    assert simulated(out) == 0


def test_a_command_stopped_before_its_first_file_leaves_its_word_and_holds_up_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "below" / "out"

    def ended(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("serpenoid.simulation.problem.simulate", ended)
        assert simulated(out) == 130
    assert [path.name for path in out.iterdir()] == ["request.json"]
    capsys.readouterr()
    assert main(["show", str(out)]) == 2
    assert "holds no answer yet: `simulate` was stopped before it ended" in capsys.readouterr().err
    assert simulated(out, "--set", "gait.a=4") == 0  # another question: nothing of worth is here
    before = (out / "request.json").read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr("serpenoid.simulation.problem.simulate", ended)
        assert simulated(out, "--set", "gait.a=4") == 130
    assert (out / "request.json").read_bytes() == before  # the earlier answer is whole


def test_an_answer_that_was_cut_short_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device", "summary.txt")

    with monkeypatch.context() as patch:
        patch.setattr("serpenoid.cli.options.report", full)
        assert simulated(tmp_path) == 1
    (tmp_path / ".writing-gait-abc.svg").touch()  # killed, too
    (tmp_path / ".writing-report-abc.html").touch()
    capsys.readouterr()
    assert main(["show", str(tmp_path)]) == 0
    cut_short = capsys.readouterr().out
    assert cut_short.startswith("unfinished        files may be missing")
    assert ".writing-" not in cut_short
    assert simulated(tmp_path) == 0
    assert main(["show", str(tmp_path)]) == 0
    assert "unfinished" not in capsys.readouterr().out


def test_force_moves_the_earlier_answer_aside_with_its_figures(tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert simulated(out) == 0
    (out / "gait.png").write_bytes(b"a figure of the earlier answer")
    for number, a in enumerate(("4", "5"), start=1):
        displacement = json.loads((out / "solution.json").read_text())["displacement_body_lengths"]
        assert simulated(out, "--set", f"gait.a={a}", "--force") == 0
        earlier = json.loads((out / f"earlier-{number}" / "solution.json").read_text())
        assert earlier["displacement_body_lengths"] == displacement
        assert json.loads((out / "solution.json").read_text())["displacement_body_lengths"] != displacement
    assert (out / "earlier-1" / "gait.png").exists()
    assert not (out / "gait.png").exists()


@pytest.mark.parametrize("content", ["", "{", "[]", '{"verb": 5}'])
def test_an_answer_whose_question_is_lost_counts_as_another(tmp_path: Path, content: str) -> None:
    assert simulated(tmp_path) == 0
    (tmp_path / "request.json").write_text(content)
    assert simulated(tmp_path) == 2
    assert simulated(tmp_path, "--force") == 0


def test_what_a_killed_process_left_unfinished_is_cleared(tmp_path: Path) -> None:
    with atomic(tmp_path / "c-0.5" / "gait.png") as temporary:
        left = temporary.with_name(temporary.name + ".png")
        left.write_bytes(b"half a picture")
    assert left.exists()
    assert simulated(tmp_path) == 0
    assert not left.exists()


def test_a_folder_with_other_things_is_no_answer(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    assert simulated(tmp_path) == 0
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_table_that_is_no_answer_is_not_written_over(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "joint_table.csv").write_text("mine")
    for more in ([], ["--force"]):
        assert simulated(Path("."), *more) == 2
        assert "--out .: is no results folder, and holds another joint_table.csv" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["joint_table.csv"]
    assert (tmp_path / "joint_table.csv").read_text() == "mine"


def test_an_export_does_not_take_the_place_of_another_gaits(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gaits, out = [tmp_path / "one", tmp_path / "two"], tmp_path / "out"
    assert simulated(gaits[0]) == 0
    assert simulated(gaits[1], "--set", "gait.a=4") == 0
    words = [["export", str(gait), "--format", "csv", "--out", str(out)] for gait in gaits]
    assert main(words[0]) == 0
    assert main(words[0]) == 0  # the same again
    first = (out / "joint_table.csv").read_bytes()
    assert main(words[1]) == 2
    assert "holds another joint_table.csv" in capsys.readouterr().err
    assert (out / "joint_table.csv").read_bytes() == first
    assert main([*words[1], "--force"]) == 0
    assert (out / "earlier-1" / "joint_table.csv").read_bytes() == first
    assert (out / "joint_table.csv").read_bytes() != first
    file = tmp_path / "mine.csv"
    assert main([*words[1][:-1], str(file)]) == 0
    assert file.read_bytes() == (out / "joint_table.csv").read_bytes()
    assert main(["export", str(gaits[0]), "--format", "csv", "--out", str(file)]) == 2  # it holds another gait's
    assert main([*words[1][:2], "--format", "ros2", "--out", str(tmp_path / "mine.yaml")]) == 2
    assert "writes into a folder" in capsys.readouterr().err


def test_force_moves_neither_recordings_nor_what_the_command_reads(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    campaign = tmp_path / "campaign"
    campaign.mkdir()
    (campaign / "campaign.toml").write_text("format = 1\n")
    assert simulated(campaign, "--force") == 2
    assert "holds recordings (campaign.toml), and no answer" in capsys.readouterr().err
    out = tmp_path / "out"
    assert simulated(out) == 0
    mine = out / "mine.toml"
    mine.write_text(Path(REFERENCE).read_text())
    assert main(["simulate", str(mine), "--set", "gait.a=3", "--out", str(out), "--force", "--quiet"]) == 2
    assert "mine.toml, which is read" in capsys.readouterr().err
    assert mine.exists()
    assert not list(tmp_path.glob("*/earlier-*"))


def test_a_folder_that_is_called_as_a_word_of_the_command_is_no_input(tmp_path: Path) -> None:
    assert simulated(Path("simulate")) == 0
    assert simulated(Path("simulate"), "--set", "gait.a=3", "--force") == 0
    assert (tmp_path / "simulate" / "earlier-1" / "solution.json").exists()
