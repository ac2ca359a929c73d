"""The documents are true as far as a program can tell: verbs, links, files and the README's commands exist."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import serpenoid
import serpenoid as sp
from serpenoid.cli.main import VERBS
from serpenoid.objectives import demands, terms
from serpenoid.objectives.obstacles import Obstacle
from serpenoid.objectives.term import Played
from serpenoid.problem import load
from serpenoid.scaffold.json_schema import schema_of

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


def test_the_reference_has_every_public_name() -> None:
    shown = re.findall(r"^::: ([\w.]+)$", (ROOT / "docs" / "reference.md").read_text(encoding="utf-8"), re.MULTILINE)
    alone = {path.rpartition(".")[2] for path in shown}
    assert [name for name in serpenoid.__all__ if name not in alone and serpenoid._PUBLIC[name] not in shown] == []


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


def test_the_example_of_another_solver_ends_in_an_optimum_that_is_certified(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(ROOT)
    *_, example = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "start" / "python.md").read_text("utf-8"), re.S)
    assert "ipopt" in example
    exec(example, {"sp": sp, "ca": ca})
    said = re.findall("# (solved, .*)", example)
    assert capsys.readouterr().out.splitlines()[-1] == f"<OwnCertificate {said[0]}>"


GOALS = (ROOT / "docs" / "goals.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^\n((?:    .*\n|\n(?=    ))+)", GOALS, re.M)
BODY = "[body]\nvertices = 6\n[medium]\nanisotropy_ratio = 0.3\n"


@pytest.mark.parametrize("block", [block for block in BLOCKS if "serpenoid" not in block], ids=lambda b: b.split()[0])
def test_the_examples_of_goals_are_parts_of_a_problem_file(tmp_path: Path, block: str) -> None:
    text = "\n".join(line.removeprefix("    ") for line in block.splitlines())
    (tmp_path / "mine.toml").write_text(f"{BODY}{text}\n", encoding="utf-8")
    (tmp_path / "plain.toml").write_text(BODY, encoding="utf-8")
    assert load(tmp_path / "mine.toml") != load(tmp_path / "plain.toml")  # it says something, too


def test_the_obstacles_of_goals_are_kept_by_a_body_at_rest_and_seen() -> None:
    asked = [d for d in demands() if issubclass(d, Obstacle)]
    block = next(block for block in BLOCKS if all(f'kind = "{d.model_fields["kind"].default}"' in block for d in asked))
    data = tomllib.loads("\n".join(line.removeprefix("    ") for line in block.splitlines()))
    straight = np.column_stack([np.linspace(-0.5, 0.5, 11), np.zeros(11)])
    for given in data["task"]["demands"]:
        kind = next(d for d in asked if d.model_fields["kind"].default == given["kind"])
        assert "met" in kind.model_validate(given).outcome(Played(np.zeros((2, 3)), straight[None], np.zeros((1, 9))))


def test_goals_name_every_kind_and_every_key_of_it() -> None:
    words = set(re.findall(r"`(\w+)`", GOALS)) | set(re.findall(r"^    (\w+) = ", GOALS, re.M))
    kinds = [*terms(), *demands()]
    assert {kind.model_fields["kind"].default for kind in kinds} <= set(re.findall(r"\w+", GOALS))
    assert {key for kind in kinds for key in kind.model_fields} <= words


PAGE = (ROOT / "docs" / "problem-file.md").read_text(encoding="utf-8")
SECTIONS = dict(part.split("\n", 1) for part in PAGE.split("\n## ")[1:])
SCHEMA = schema_of("problem")
WITH_KEYS = {
    "[about]": "About", "[body]": "Body", "[medium]": "Medium", "[task]": "Task", "[task.constraints]": "Constraints",
    "[task.robust]": "Robust", "[lift]": "Lift", "[power]": "Power",
}  # fmt: skip
BY_FAMILY = {"[gait]": "Gait", "[task.bounds]": "Bounds"}
BY_KIND = ("[[task.objectives]]", "[[task.demands]]")


def rows(section: str) -> list[list[str]]:
    """The cells of a section's table, without its head."""
    return [line.strip("| ").split(" | ") for line in SECTIONS[section].splitlines() if line.startswith("| `")]


def names(cell: str) -> set[str]:
    """Keys that a cell tells, in backticks, but for those that another one is told by (`mean` = as `angle`)."""
    return set(re.findall(r"`(\w+)`", re.sub(r"= as `\w+`", "", cell)))


def kinds(word: str, ending: str = "") -> dict[str, set[str]]:
    """Of the schema's definitions that a `kind` or `family` tells apart: their other keys."""
    of = [d["properties"] for name, d in SCHEMA["$defs"].items() if name.endswith(ending) and "properties" in d]
    return {keys[word]["const"]: set(keys) - {word} for keys in of if "const" in keys.get(word, {})}


def test_the_page_on_problem_files_has_the_sections_of_the_schema() -> None:
    assert {name.strip("[]") for name in SECTIONS if "." not in name} == set(SCHEMA["properties"])
    assert set(SECTIONS) == {*WITH_KEYS, *BY_FAMILY, *BY_KIND, "[[effects]]"}


@pytest.mark.parametrize("section", WITH_KEYS)
def test_the_page_on_problem_files_has_the_keys_of_the_schema(section: str) -> None:
    definition = SCHEMA["$defs"][WITH_KEYS[section]]
    said = {row[0].strip("`"): row[1] for row in rows(section)}
    assert set(said) == set(definition["properties"])
    assert {key for key, default in said.items() if default == "required"} == set(definition.get("required", []))
    for key, default in said.items():
        known = definition["properties"][key].get("default")
        if isinstance(known, int | float) and not isinstance(known, bool):
            assert float(default) == known, key


@pytest.mark.parametrize("section", BY_FAMILY)
def test_the_page_on_problem_files_has_the_keys_of_every_family(section: str) -> None:
    said: dict[str, set[str]] = {}
    for family, keys, *_ in rows(section):
        said.setdefault(family.strip("`"), set()).update(names(keys))
    assert said == kinds("family", BY_FAMILY[section])


def test_the_page_on_problem_files_has_every_kind_with_its_keys() -> None:
    assert {row[0].strip("`"): names(row[1]) for section in BY_KIND for row in rows(section)} == kinds("kind")


COMPUTING = (
    "compare",
    "diagnose",
    "files",
    "mechanics",
    "optimise",
    "parallel",
    "report",
    "simulation",
    "studies",
    "measure",
)


def test_the_architecture_names_every_module_that_computes() -> None:
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8").split("## Where a change")[0]
    source, said = ROOT / "src" / "serpenoid", set(re.findall(r"`(?:\w+/)*(\w+)`", text))
    found = {
        path for path in source.rglob("*.py") if path.relative_to(source).parts[0] in COMPUTING or path.parent == source
    }
    found = {
        path.stem for path in found if path.parent.name != "consistency" and not path.stem.startswith(("_", "choose_"))
    }
    assert found - said == set()


def test_numbers_that_decide_stand_where_the_method_says() -> None:
    """`module.NAME`, and `NAME` behind it of the same module."""
    text = (ROOT / "docs" / "diagnosis-method.md").read_text(encoding="utf-8").split("## Numbers that decide")[1]
    modules: dict[str, str] = {}
    for path in (ROOT / "src" / "serpenoid").rglob("*.py"):
        modules[path.stem] = modules.get(path.stem, "") + path.read_text(encoding="utf-8")
    found = []
    for row in re.findall(r"^\|.*\|$", text, re.MULTILINE):
        module = None
        for said, name in re.findall(r"`(?:([a-z_]+)\.)?([A-Z][A-Z_]+)`", row):
            module = said or module
            found.append((module, name))
    assert len(found) > 50
    missing = [
        f"{module}.{name}"
        for module, name in found
        if module is None or not re.search(rf"^(?:\w+, )*{name}\b.*=", modules.get(module, ""), re.MULTILINE)
    ]
    assert missing == []
