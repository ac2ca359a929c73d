"""Results of many runs as one table: every number stands under its name, whatever wrote it."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from serpenoid.cli.main import main
from specimens import PROBLEMS


def rows(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text(encoding="utf-8").splitlines()))


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two simulations, one answer set aside, a diagnosis and a campaign."""
    place = tmp_path_factory.mktemp("results")
    for a in (4, 5):
        words = ["--set", f"gait.a={a}.0", "--no-figures", "--quiet", "--out", str(place / f"a{a}")]
        assert main(["simulate", str(PROBLEMS / "reference.toml"), *words]) == 0
    (place / "a4" / "earlier-1").mkdir()
    (place / "a4" / "earlier-1" / "solution.json").write_text((place / "a4" / "solution.json").read_text())
    (place / "d").mkdir()
    effects = [{"name": "toe"}, {"name": "load"}]
    found = {"verdict": "explained", "effects": effects, "anisotropy_ratio": {"after": 0.2, "interval": [0.1, 0.3]}}
    (place / "d" / "diagnosis.json").write_text(json.dumps(found | {"scores": [{"x": 1}] * 40}))
    (place / "campaign").mkdir()
    trials = "".join(f'[[trial]]\nname = "t{i}"\ngait = "g"\npause_s = {i}.5\n' for i in range(2))
    (place / "campaign" / "campaign.toml").write_text(f'format = 1\nname = "foam"\n[body]\nvertices = 4\n{trials}')
    return place


def test_every_record_is_a_line_with_its_numbers_under_their_names(results: Path, tmp_path: Path) -> None:
    assert main(["table", str(results), "--out", str(tmp_path / "runs.csv"), "--quiet"]) == 0
    found = {(r["record"], Path(r["folder"]).name, r["trial"]): r for r in rows(tmp_path / "runs.csv")}
    assert len(found) == 5
    for name in ("a4", "a5"):
        record = json.loads((results / name / "solution.json").read_text())
        row = found["solution", name, ""]
        assert float(row["displacement_body_lengths"]) == record["displacement_body_lengths"]
        assert float(row["gait.a"]) == float(name[1:])
        assert row["problem"] == record["provenance"]["problem"]
    diagnosis = found["diagnosis", "d", ""]
    assert diagnosis["effects"] == "toe; load"
    assert [diagnosis[f"anisotropy_ratio.{k}"] for k in ("after", "interval.0", "interval.1")] == ["0.2", "0.1", "0.3"]
    assert [found["trials", "campaign", f"t{i}"]["pause_s"] for i in range(2)] == ["0.5", "1.5"]


def test_a_record_cut_short_is_a_line_that_says_so_and_keeps_no_other_back(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cut = tmp_path / "cut" / "solution.json"
    cut.parent.mkdir()
    cut.write_text((results / "a4" / "solution.json").read_text()[:300])
    assert main(["table", str(results), str(cut.parent), "--out", str(tmp_path / "runs.csv"), "--quiet"]) == 1
    assert f"{cut}: not valid JSON" in capsys.readouterr().err
    found = rows(tmp_path / "runs.csv")
    assert len(found) == 6
    assert found[-1]["status"] == "unreadable"
    assert found[-1]["message"].startswith(str(cut))
    assert found[-1]["displacement_body_lengths"] == ""


def test_folders_without_results_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["table", str(tmp_path), "--out", str(tmp_path / "x.csv")]) == 2
    assert main(["table", str(tmp_path / "none"), "--out", str(tmp_path / "x.csv")]) == 2
    assert main(["table", str(tmp_path), "--out", str(tmp_path / "x.txt")]) == 2
    said = capsys.readouterr().err
    assert all(words in said for words in ("no results there", "no such folder", "must end in .csv"))


def test_a_file_that_is_no_table_is_not_written_over(
    results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mine = tmp_path / "mine.csv"
    mine.write_text("t,x\n0,1\n")
    words = ["table", str(results), "--out", str(mine), "--quiet"]
    assert main(words) == 2
    assert "no table of runs" in capsys.readouterr().err
    assert mine.read_text() == "t,x\n0,1\n"
    assert main([*words, "--force"]) == 0
    assert main(words) == 0  # it is one now
