"""The page and the notebook for one's own CSV run as they stand, and say what the page says they do."""

from __future__ import annotations

import json
import re
import shlex
import shutil
from pathlib import Path

import pytest

from serpenoid.cli.main import main

ROOT = Path(__file__).parents[1]
pytestmark = pytest.mark.usefixtures("virtual_machine")


def test_the_page_runs_as_it_stands(tmp_path, monkeypatch, capsys):
    page = (ROOT / "docs" / "your-csv.md").read_text(encoding="utf-8")
    (toml,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    commands = re.findall(r"```console\n(.*?)```", page, re.DOTALL)
    (tmp_path / "campaign.toml").write_text(toml)
    shutil.copy(ROOT / "problems" / "recordings" / "lamprey.csv", tmp_path)
    monkeypatch.chdir(tmp_path)
    for command in commands:
        assert main([*shlex.split(command)[1:], *(["--no-figures"] if "compare" in command else [])]) == 0
    said = capsys.readouterr().out
    assert "moves head first" in said
    ratio = float(re.search(r"K = 1 / eps +([\d.]+)", said)[1])
    assert ratio == pytest.approx(float(re.search(r"about (\d+): three", page)[1]), abs=0.5)  # the page rounds
    share = float(re.search(r"Resim / Exp = ([\d.]+)", said)[1])
    assert round(100 * share) == int(re.search(r"move (\d+) % of the measured path", page)[1])
    assert (tmp_path / "measured" / "trial-swim-1.png").exists()


def test_the_notebook_runs_as_it_stands(monkeypatch, capsys):
    monkeypatch.chdir(ROOT)
    notebook = json.loads((ROOT / "problems" / "your_csv.ipynb").read_text(encoding="utf-8"))
    names: dict[str, object] = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert "drag alone explains 13" in capsys.readouterr().out
