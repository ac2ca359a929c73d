"""Model files, and the command line with them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import serpenoid as sp
from effects.conftest import PROBLEM, typical
from serpenoid.cli.main import main
from serpenoid.effects import catalogue
from serpenoid.errors import InputError
from serpenoid.medium import Medium
from serpenoid.model_file import write_model_file
from serpenoid.problem import Problem


@pytest.fixture
def model_file(tmp_path: Path) -> Path:
    path = tmp_path / "extended-model.toml"
    effects = [typical("worn_wheel"), typical("slope"), typical("grip_saturation")]
    write_model_file(path, Medium(anisotropy_ratio=0.21), effects, comment="found in a campaign")
    return path


def test_a_model_file_replaces_medium_and_effects(model_file: Path, problem: Problem) -> None:
    loaded = sp.load(PROBLEM, model=model_file)
    assert loaded.medium.anisotropy_ratio == 0.21
    assert loaded.body == problem.body
    assert loaded.effects == (typical("worn_wheel"), typical("slope"), typical("grip_saturation"))
    assert loaded.hash != sp.load(PROBLEM).hash


def test_a_model_file_without_effects_takes_those_of_the_problem_away(model_file: Path, tmp_path: Path) -> None:
    plain = tmp_path / "plain.toml"
    write_model_file(plain, Medium(anisotropy_ratio=0.2), [])
    assert sp.load(PROBLEM, model=plain).effects == ()


def test_a_model_file_may_bring_a_body(tmp_path: Path) -> None:
    body = sp.load(PROBLEM).body.model_copy(update={"mass_kg": 2.0})
    write_model_file(tmp_path / "m.toml", Medium(anisotropy_ratio=0.2), [], body)
    assert sp.load(PROBLEM, model=tmp_path / "m.toml").body == body


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('name = "worn_weel"\nplace = 3\nseizure = 0.1', "Did you mean `worn_wheel`"),
        ('name = "worn_wheel"\nplace = 3\nseizure = 7', r"`seizure` must be in \[0, 1\], got 7"),
        ('name = "worn_wheel"\nplace = 33\nseizure = 0.1', "must be a vertex from 0 to 11"),
        ('name = "worn_wheel"\nplace = 3\nseizure = "a lot"', "effects"),
        ("place = 3\nseizure = 0.5", "name: is required"),
    ],
)
def test_faults_in_a_model_file_are_named(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text(f"[medium]\nanisotropy_ratio = 0.2\n[[effects]]\n{text}\n", encoding="utf-8")
    with pytest.raises(InputError, match=message):
        sp.load(PROBLEM, model=path)


def test_a_model_file_that_was_cut_off_anywhere_is_refused(model_file: Path, tmp_path: Path) -> None:
    text, cut = model_file.read_text(encoding="utf-8"), tmp_path / "cut.toml"
    taken = []
    for length in range(len(text)):
        cut.write_text(text[:length], encoding="utf-8")
        try:
            taken.append((length, sp.load(PROBLEM, model=cut)))
        except InputError:
            continue
    assert [length for length, _ in taken] == [len(text) - 1]  # it lacks the last newline alone


def test_a_model_file_may_be_changed_by_hand(model_file: Path) -> None:
    text = model_file.read_text(encoding="utf-8")
    first, second, *rest = text.split("[[effects]]")
    model_file.write_text("[[effects]]".join([first, *rest]), encoding="utf-8")
    assert len(sp.load(PROBLEM, model=model_file).effects) == 2
    model_file.write_text(f"{text}[[effects]]{second}", encoding="utf-8")
    with pytest.raises(InputError, match="worn_wheel"):  # twice at one place: read to its end
        sp.load(PROBLEM, model=model_file)
    model_file.write_text("\n".join(line for line in text.splitlines() if line[:1] != "#"), encoding="utf-8")
    assert len(sp.load(PROBLEM, model=model_file).effects) == 3


def test_speed_without_a_clock_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    write_model_file(path, Medium(anisotropy_ratio=0.2), [typical("inertia")])
    reference = PROBLEM.parent / "reference.toml"
    with pytest.raises(InputError, match="`inertia` knows speed; give the seconds per cycle"):
        sp.load(reference, model=path)
    assert sp.load(reference, ["task.cycle_duration_s=4"], path).effects


@pytest.mark.parametrize("verb", [["simulate"], ["solve", "--starts", "1"], ["sweep", "--c", "1", "--starts", "1"]])
def test_an_extended_model_is_a_model_for_every_verb(
    verb: list[str], model_file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = [str(PROBLEM), "--model", str(model_file), "--set", "task.steps=30", "--no-figures"]
    out = tmp_path / "out"
    assert main([*verb, *arguments, "--out", str(out), "--quiet"]) == 0
    name = "sweep.json" if verb[0] == "sweep" else "solution.json"
    record = json.loads((out / name).read_text(encoding="utf-8"))
    if verb[0] != "sweep":
        assert [e["name"] for e in record["effects"]] == ["worn_wheel", "slope", "grip_saturation"]
        assert main(["show", str(out)]) == 0
        assert "worn_wheel at 4: seizure 0.5" in capsys.readouterr().out


def test_effects_verb_lists_the_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["effects"]) == 0
    printed = capsys.readouterr().out
    assert all(name in printed for name in catalogue())
    assert main(["effects", "--json"]) == 0
    records = json.loads(capsys.readouterr().out)
    assert [r["name"] for r in records] == list(catalogue())
    assert main(["effects", "frame_drift"]) == 0
    assert "not in nlp: " in capsys.readouterr().out
    assert main(["effects", "backlas"]) == 2
