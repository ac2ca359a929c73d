"""A file in another's place is called what it is, with its verb; a body of odd length is asked about its unit."""

from __future__ import annotations

from pathlib import Path

import pytest

from serpenoid.arena.protocol import Protocol
from serpenoid.body import Body
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.files import schema
from serpenoid.files.kinds import TAKEN_BY, kind_of
from serpenoid.measure.campaign import CampaignFile
from serpenoid.model_file import ModelFile
from serpenoid.problem import Problem
from serpenoid.robot.description import Robot
from specimens import PROBLEMS

SCHEMAS = {"problem": Problem, "model": ModelFile, "robot": Robot, "protocol": Protocol, "campaign": CampaignFile}
EXAMPLES = {
    "problem": PROBLEMS / "snake10.toml", "robot": PROBLEMS / "robots/snake10-robot.toml",
    "protocol": PROBLEMS / "protocols/two-gaits.toml", "campaign": PROBLEMS / "campaigns/lamprey.toml",
}  # fmt: skip


def test_every_example_is_known_for_what_it_is() -> None:
    folders = {"robots": "robot", "protocols": "protocol", "campaigns": "campaign", "problems": "problem"}
    for path in PROBLEMS.rglob("*.toml"):
        assert kind_of(schema.read_toml(path)) == folders[path.parent.name], path
    assert kind_of({"medium": {}, "effects": []}) == "model"
    assert kind_of({}) is None
    assert {k: s.file_kind for k, s in SCHEMAS.items()} == {k: k for k in TAKEN_BY}


@pytest.mark.parametrize(("wanted", "given"), [(w, g) for w in SCHEMAS for g in EXAMPLES if w != g])
def test_another_kind_of_file_is_named_with_its_verb(wanted: str, given: str) -> None:
    with pytest.raises(InputError) as said:
        schema.load(SCHEMAS[wanted], EXAMPLES[given])
    assert str(said.value) == f"{EXAMPLES[given]}: is a {given} file, where a {wanted} file belongs. {TAKEN_BY[given]}."


def test_a_recording_in_the_place_of_a_file_says_where_it_belongs() -> None:
    with pytest.raises(InputError, match=r"is no problem file but a table: recordings are named in a campaign"):
        schema.load(Problem, PROBLEMS / "recordings/lamprey.csv")


def test_a_program_in_the_place_of_a_problem_is_said_to_be_one() -> None:
    with pytest.raises(InputError, match=r"is no problem file but a Python program: .* takes is a TOML file"):
        schema.load(Problem, PROBLEMS / "own_objective.py")


def test_a_misspelt_verb_is_guessed(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stopped:
        main(["slove", "x"])
    assert stopped.value.code == 2
    assert capsys.readouterr().err.endswith("no verb `slove`. Did you mean `solve`?\n")


def test_a_robot_of_580_metres_is_asked_whether_it_was_measured_in_millimetres(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["new", "problem", str(tmp_path / "r.toml"), "--joints", "3", "--yes"]
    assert main([*asked, "--edges", "50,200,200,130"]) == 0
    said = capsys.readouterr().out
    assert "The body is 580 m long" in said
    assert "were they given in millimetres?" in said
    (tmp_path / "r.toml").unlink()
    assert main([*asked, "--edges", "0.05,0.2,0.2,0.13"]) == 0
    assert "plausible" not in capsys.readouterr().out


def test_limits_that_may_be_radians_are_asked_about_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "r.toml"
    assert main(["new", "problem", str(path), "--joints", "3", "--joint-limit", "1.2", "--yes"]) == 0
    assert "was it given in radians?" in capsys.readouterr().out
    words = ["--quiet", "--no-figures", "--out", str(tmp_path / "out"), "--set", "body.length_m=600"]
    rest = "[medium]\nanisotropy_ratio = 0.2\n[gait]\n"
    path.write_text(f"[body]\nvertices = 5\njoint_limit_deg = [-1.2, 1.0]\n{rest}", encoding="utf-8")
    assert main(["simulate", str(path), *words]) == 0
    said = capsys.readouterr().err
    assert "`joint_limit_deg` as small as 1.2 the whole body bends by no more than 3.6 degrees" in said
    assert "the body is 600 m long" in said
    assert "were they given in millimetres?" in said


@pytest.mark.parametrize(
    ("mass", "metres", "asked"),
    [(900.0, 0.53, True), (1380.0, 0.836, True), (1.38, 0.836, False), (97.5, 5.2, False), (900.0, None, False)],
)
def test_a_mass_that_may_be_grams_is_asked_about(mass: float, metres: float | None, asked: bool) -> None:
    said = Body(vertices=12, length_m=metres, mass_kg=mass).odd_units
    assert bool(said) is asked
    assert all("was it given in grams?" in words for words in said)


@pytest.mark.parametrize("limit", [None, 10.0, (0.0, 5.0)])
def test_small_limits_that_are_no_radians_raise_no_question(limit: float | tuple[float, float] | None) -> None:
    assert Body(vertices=4, joint_limit_deg=limit).odd_limit is None
    assert Body(vertices=40, joint_limit_deg=1.5).odd_limit is None  # 38 joints


@pytest.mark.parametrize(("kind", "metres"), [("crawler", 1e-3), ("swimmer", 5e-5), ("swimmer", 30.0), (None, 1.0)])
def test_nematodes_sperm_whales_and_robots_raise_no_question(kind: str | None, metres: float) -> None:
    assert Body(kind=kind, vertices=5, length_m=metres).odd_length is None
