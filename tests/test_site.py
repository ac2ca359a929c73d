"""The site's tutorials are true: their Python runs, block after block, and their commands are commands."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from serpenoid.cli.main import VERBS, build_parser, main

ROOT = Path(__file__).parents[1]
STARTS = sorted((ROOT / "docs" / "start").glob("*.md")) + sorted((ROOT / "docs" / "how-to").glob("*.md"))


def commands(page: Path) -> list[list[str]]:
    """Every indented `serpenoid ...` line of a page, as words."""
    lines = re.findall(r"^    serpenoid (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return [shlex.split(line, comments=True) for line in lines]


@pytest.mark.parametrize("page", STARTS, ids=lambda path: path.stem)
def test_commands_of_a_tutorial_are_understood(page: Path) -> None:
    parser = build_parser(*VERBS)
    for words in commands(page):
        parser.parse_args(words)
        named = [word for word in words if word.startswith("problems/")]
        assert all((ROOT / name).exists() for name in named), words


def test_the_python_tutorial_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["examples"]) == 0
    text = (ROOT / "docs" / "start" / "python.md").read_text(encoding="utf-8")
    names: dict[str, object] = {}
    for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL):
        exec(compile(block, "python.md", "exec"), names)
    said = capsys.readouterr().out
    assert "<Simulation reference: solved" in said
    assert "SOLVED 0.0" in said


def test_the_animal_tutorial_measures_its_example(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["examples"]) == 0
    measure = next(words for words in commands(ROOT / "docs" / "start" / "animal.md") if words[0] == "measure")
    assert main([*measure, "--no-figures", "--out", "measured"]) == 0
    assert "vertices" in capsys.readouterr().out
