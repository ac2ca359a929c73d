"""Several campaigns in one command: each in a process of its own, all answers in one table, nothing computed twice."""

from __future__ import annotations

import csv
import json
import shutil
from pathlib import Path

import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from serpenoid.cli.main import main


@pytest.fixture(scope="module")
def campaigns(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("many")
    write(make(81, [], combinations=COMBINATIONS[:1]), folder / "first")
    shutil.copytree(folder / "first", folder / "second")
    (folder / "second" / "campaign.toml").write_text("format = 1\n", encoding="utf-8")
    return [folder / "first", folder / "second"]


@pytest.mark.parametrize("jobs", [pytest.param("1", marks=pytest.mark.slow), "2"])
def test_two_campaigns_have_a_folder_each_and_one_table(campaigns: list[Path], jobs: str, tmp_path: Path) -> None:
    command = ["diagnose", *map(str, campaigns), "--jobs", jobs, "--out", str(tmp_path / "out"), "--no-figures"]
    assert main(command) == 1  # one of them cannot be diagnosed, and the other is all the same
    with (tmp_path / "out" / "diagnoses.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["campaign"] for row in rows] == ["first", "second"]
    assert (rows[0]["verdict"], rows[0]["fault"]) == ("nothing", "")
    assert rows[1]["verdict"] == ""
    assert "campaign.toml" in rows[1]["fault"]
    answer = tmp_path / "out" / "first" / "diagnosis.json"
    assert json.loads(answer.read_text(encoding="utf-8"))["verdict"] == "nothing"
    made = answer.stat().st_mtime_ns
    assert main(command) == 1
    assert answer.stat().st_mtime_ns == made
