"""The documents are true as far as a program can tell: verbs, links, files and the README's commands exist."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import pytest

from serpenoid.cli.main import VERBS

ROOT = Path(__file__).parents[1]
DOCUMENTS = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_links_lead_somewhere(document: Path) -> None:
    links = re.findall(r"\]\(([^)#]+)\)", document.read_text(encoding="utf-8"))
    lost = [link for link in links if not link.startswith("http") and not (document.parent / link).exists()]
    assert not lost


def test_the_readme_names_every_verb() -> None:
    table = (ROOT / "README.md").read_text(encoding="utf-8").split("## Verbs")[1].split("\n## ")[0]
    assert set(VERBS) <= set(re.findall(r"`(\w+)", table))


def test_the_readme_gives_a_reason_for_every_dependency() -> None:
    table = (ROOT / "README.md").read_text(encoding="utf-8").split("## Dependencies")[1]
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    names = [re.split(r"[<>=\[ ]", line)[0] for line in project["dependencies"]]
    assert all(name in table for name in names)
    assert all(f"`{extra}`" in table for extra in project["optional-dependencies"])


def test_the_readmes_test_command_is_the_one_that_ci_runs() -> None:
    assert ".venv/bin/pytest -n 2" in (ROOT / "README.md").read_text(encoding="utf-8")
    assert '"$venv/bin/pytest" -n 2' in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_the_architecture_names_every_folder() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    folders = {path.parent.name for path in (ROOT / "src" / "serpenoid").glob("*/__init__.py")}
    assert {folder for folder in folders if f"`{folder}/`" not in text} == set()
