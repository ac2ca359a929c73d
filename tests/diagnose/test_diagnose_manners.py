"""What `diagnose` says to rubbish and to Ctrl-C: a sentence and an exit code, no half-written file, no worker left."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from serpenoid.cli.main import main

ROOT = Path(__file__).parents[2]
SNAKE, PURCELL = str(ROOT / "problems" / "snake10.toml"), str(ROOT / "problems" / "purcell.toml")
LAMPREY = str(ROOT / "problems" / "campaigns" / "lamprey.toml")


def replaced(name: str, change: Callable[[str], str]) -> Callable[[Path], None]:
    """One file of a campaign with its text changed."""

    def fault(folder: Path) -> None:
        path = next(p for p in folder.rglob(name))
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")

    return fault


def cut_after(frames: int) -> Callable[[str], str]:
    """A recording (one row of header) that was stopped early."""
    return lambda text: "\n".join(text.splitlines()[: 1 + frames]) + "\n"


def emptied(folder: Path) -> None:
    shutil.rmtree(folder)
    folder.mkdir()


@pytest.mark.parametrize(
    ("fault", "said"),
    [
        (shutil.rmtree, "no such file"),
        (emptied, "holds no campaign.toml"),
        (replaced("servo.csv", lambda text: text.splitlines()[0] + "\n"), "has a header and no data rows"),
        (replaced("servo.csv", lambda text: text.replace("play,0,5,", "play,0,5,x", 1)), "must be a number or empty"),
        (replaced("servo.csv", lambda text: text[: len(text) // 4]), "follow neither its servo log"),
        (replaced("motion.csv", cut_after(3)), "3 frames; a motion takes 8 or more"),
        (replaced("motion.csv", cut_after(20)), "the markers show no motion beyond their noise"),
        (replaced("campaign.toml", lambda text: text.replace("edge_lengths", "#")), "needs `edge_lengths`"),
    ],
)
def test_a_faulty_campaign_is_refused_in_a_sentence(
    fault: Callable[[Path], None], said: str, campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, out = tmp_path / "campaign", tmp_path / "out"
    shutil.copytree(campaign, folder)
    fault(folder)
    assert main(["diagnose", str(folder), "--model", SNAKE, "--out", str(out)]) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--model", PURCELL], "a body of 13 vertices, but the campaign `snake10, two` records one of 12"),
        (["--model", "none.toml"], "none.toml: no such file"),
        (["--model", LAMPREY], "is a campaign file, where --model takes a problem or model file. Leave --model out"),
        (["--out", __file__], "is a file, not a folder"),
    ],
)
def test_wrong_words_are_refused_before_the_work(
    words: list[str], said: str, campaign: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "serpenoid.diagnose.data.recordings.reading.read_recording", lambda *_: pytest.fail("a trial was read")
    )
    assert main(["diagnose", str(campaign), *words]) == 2
    assert said in capsys.readouterr().err


def test_a_model_whose_links_are_cut_finer_is_told_how_the_campaign_is_to_be(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What `new problem --dissipation edge` writes: as many joints, four edges a link."""
    assert main(["new", "problem", str(tmp_path / "m.toml"), "--joints", "10", "--dissipation", "edge", "--yes"]) == 0
    assert main(["diagnose", str(campaign), "--model", str(tmp_path / "m.toml")]) == 2
    assert "Both have as many joints: give the campaign the [body] of this file" in capsys.readouterr().err


def test_a_model_file_that_says_nothing_is_refused(
    campaign: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "empty.toml").touch()
    assert main(["diagnose", str(campaign), "--model", str(tmp_path / "empty.toml")]) == 2
    assert "empty.toml: says nothing of a model" in capsys.readouterr().err


def test_help_teaches(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["diagnose", "--help"])
    said = capsys.readouterr().out
    assert stopped.value.code == 0
    for word in (
        "partly explained",
        "noise level",
        "report.html",
        "extended-model.toml",
        "next-experiment.csv",
        "twice",
    ):
        assert word in said


def children(pid: int) -> list[str]:
    """Processes that a process has started and that still are."""
    try:
        return Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []


def group(number: int) -> list[str]:
    """Commands of a process group's members."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            name, _, rest = stat.read_text().rpartition(")")
        except OSError:
            continue  # ended meanwhile
        if int(rest.split()[2]) == number and rest.split()[0] != "Z":
            found.append(name)
    return found


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="looks at processes in /proc")
def test_ctrl_c_leaves_its_word_and_no_workers(campaign: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    words = [sys.executable, "-m", "serpenoid", "diagnose", str(campaign), "--model", SNAKE, "--out", str(out)]
    # what other tests have finished would leave no work to interrupt
    environment = {**os.environ, "SERPENOID_CACHE": str(tmp_path / "cache"), "SERPENOID_COMPILE": "0"}
    process = subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True, env=environment
    )
    patience = time.monotonic() + 120
    while len(children(process.pid)) < 2 and time.monotonic() < patience:
        assert process.poll() is None, "ended before any worker was seen"
        time.sleep(0.002)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does: to every process
    answer, said = process.communicate(timeout=60)
    assert process.returncode == 130, said
    assert "Traceback" not in said
    assert "stopped" in said.splitlines()[-1]
    assert answer == ""
    assert [path.name for path in out.iterdir()] == ["request.json"]  # what `show` names
    assert group(process.pid) == []
