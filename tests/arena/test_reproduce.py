"""The paper's protocol, one gait pair of it, from start to figures; and the numbers it is put beside."""

import json
import math
import sys

import pytest

from serpenoid.cli.main import main
from serpenoid.problem import load
from serpenoid.studies import reproduce
from serpenoid.studies.reproduce import PAPER, PAPER_S, beside_the_paper, paper_protocol
from specimens import PROBLEMS


def test_the_papers_numbers_fit_each_other():
    """For log-normal quotients the mean is exp(s^2): the design notes' s follows from the printed mean."""
    for pair, (mean, _) in PAPER.items():
        assert math.sqrt(math.log(mean)) == pytest.approx(PAPER_S[pair], abs=6e-4)  # four printed digits


def test_the_protocol_is_the_papers():
    protocol = paper_protocol(load(PROBLEMS / "snake10.toml"), [f"g{n}" for n in range(24)], 3, 0)
    assert (len(protocol.gait), protocol.trials, protocol.cycles, protocol.pause_s) == (24, 3, 3, 2.0)
    assert protocol.cameras.frames_per_second == 120


def test_from_start_to_figures_and_again_without_playing(tmp_path, capsys, monkeypatch):
    """One cycle of the paper's three."""
    once = lambda *asked: paper_protocol(*asked).model_copy(update={"cycles": 1})  # noqa: E731
    monkeypatch.setattr(reproduce, "paper_protocol", once)
    words = ["reproduce", "--gaits", "1", "--trials", "1", "-j", "2", "--out", str(tmp_path / "out")]
    assert main(words) == 0
    said = capsys.readouterr().out
    assert "beside the paper" in said
    rows = json.loads((tmp_path / "out/beside-the-paper.json").read_text())
    assert [row["pair"] for row in rows] == list(PAPER)
    assert all(row["mean"] >= 1 for row in rows)  # Xi_ij Xi_ji = 1: the mean cannot be less
    for name in ("report.html", "compare.json", "beside-the-paper.md"):
        assert (tmp_path / "out" / name).stat().st_size > 100
    stamps = {p: p.stat().st_mtime_ns for p in (tmp_path / "out/campaign").glob("*-1/*.csv")}
    assert len(stamps) == 6
    assert main([*words, "--no-figures", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["beside_the_paper"] == rows
    assert all(path.stat().st_mtime_ns == stamp for path, stamp in stamps.items())


def test_a_pair_is_put_beside_its_own_numbers():
    class Found:
        pair, mean, std, s, s_interval, bias, rank_correlation = "Exp/Sim", 1.1, 0.2, 0.3, (0.2, 0.4), 1.0, 0.9

    (row,) = beside_the_paper((Found(),))
    assert (row["paper_mean"], row["paper_std"], row["paper_s"]) == (1.0410, 0.2974, 0.2005)


def test_nonsense_is_refused(capsys):
    assert main(["reproduce", "--gaits", "0"]) == 2
    assert "positive" in capsys.readouterr().err


def test_without_mujoco_no_gaits_are_sought(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    assert main(["reproduce", "--gaits", "1", "--out", str(tmp_path / "out")]) == 2
    assert "pip install mujoco" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
