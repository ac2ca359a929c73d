"""The JSON Schemas accept what the package accepts: every shipped file, and what is written in other ways."""

from __future__ import annotations

import json
import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from serpenoid.cli.main import main
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import catalogue, places
from serpenoid.model_file import write_model_file
from serpenoid.scaffold.json_schema import KINDS, schema_of
from specimens import PROBLEMS, problem

FOLDERS = {"robots": "robot", "protocols": "protocol", "campaigns": "campaign"}
SHIPPED = sorted(PROBLEMS.rglob("*.toml"))


@cache
def validator(kind: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(schema_of(kind))


def faults(kind: str, data: dict[str, Any]) -> list[str]:
    return [error.message for error in validator(kind).iter_errors(data)]


@pytest.mark.parametrize("kind", KINDS)
def test_schema_is_a_schema(kind: str) -> None:
    jsonschema.Draft202012Validator.check_schema(schema_of(kind))
    json.dumps(schema_of(kind), allow_nan=False)  # no infinite bound: that is no JSON


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.relative_to(PROBLEMS).as_posix())
def test_every_shipped_file_satisfies_its_schema(path: Path) -> None:
    kind = FOLDERS.get(path.parent.name, "problem")
    assert faults(kind, tomllib.loads(path.read_text(encoding="utf-8"))) == []


@pytest.mark.parametrize("name", catalogue())
def test_every_effect_that_a_model_file_can_hold_satisfies_the_schema(name: str, tmp_path: Path) -> None:
    asked = problem("snake10")
    effect = ActiveEffect.typical(name, places(catalogue()[name], asked.body)[-1])
    write_model_file(tmp_path / "model.toml", asked.medium, [effect])
    data = tomllib.loads((tmp_path / "model.toml").read_text(encoding="utf-8"))
    assert faults("model", data) == []
    assert faults("problem", {"body": {"vertices": 12}, **data}) == []


BODY: dict[str, Any] = {"body": {"vertices": 5}, "medium": {"anisotropy_ratio": 0.2}}


@pytest.mark.parametrize(
    "more",
    [
        {"gait": {}},
        {"gait": {"a": 3}},
        {"gait": {"path": "table.csv"}},
        {"gait": {"family": "table", "path": "table.csv"}},
        {"gait": {"sigma": 0.5}, "task": {"bounds": {"sigma": [0, 1]}, "constraints": {"joint_limits": False}}},
        {"body": {"vertices": 5, "joint_limit_deg": 60}},
        {"body": {"vertices": 5, "joint_limit_deg": [0, 60]}},
        {"body": {"vertices": 5, "joint_limit_deg": [[0, 60], [-30, 30], [-10, 5]]}},
    ],
)
def test_what_may_be_left_out_of_a_problem_file_may_be_left_out_for_the_schema(more: dict[str, Any]) -> None:
    assert faults("problem", BODY | more) == []


@pytest.mark.parametrize(
    ("kind", "data"),
    [
        ("problem", BODY | {"gait": {"amplitude": 3}}),
        ("problem", BODY | {"task": {"stepz": 3}}),
        ("problem", BODY | {"effects": [{"name": "slope", "steepness": 2}]}),
        ("problem", BODY | {"effects": [{"name": "slpe"}]}),
        ("problem", {"body": {"vertices": 2}, "medium": {"anisotropy_ratio": 0.2}}),
        ("problem", BODY | {"body": {"vertices": 5, "joint_limit_deg": [0, 200]}}),
        ("problem", BODY | {"body": {"vertices": 5, "joint_limit_deg": [0, 30, 60]}}),
        ("problem", BODY | {"body": {"vertices": 5, "joint_limit_deg": -60}}),
        ("robot", {"format": 1, "name": "x"}),
        ("protocol", {"gait": []}),
        ("campaign", {"format": 2}),
    ],
)
def test_what_the_package_refuses_the_schema_refuses(kind: str, data: dict[str, Any]) -> None:
    assert faults(kind, data)


def test_schema_is_written_for_editors_and_its_line_names_it(tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    assert main(["schema", "robot", "--write", str(tmp_path)]) == 0
    directive, path = capsys.readouterr().out.split()
    assert directive == "#:schema"
    assert json.loads((tmp_path / path).read_text()) == schema_of("robot")
