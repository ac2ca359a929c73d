"""A gait that ends where the file ends the search says so."""

import json
from pathlib import Path

import pytest

from serpenoid.cli.main import main
from serpenoid.cli.starts import bound_lines
from specimens import problem

SNAKE = Path(__file__).parents[2] / "problems" / "snake10.toml"


@pytest.mark.parametrize(("least", "said"), [(0.5, []), (0.9, ["xi = 0.9"])])
def test_a_parameter_at_its_bound_is_named(tmp_path, capsys, least, said):
    words = ["solve", str(SNAKE), "--c", "1", "--starts", "1", "--out", str(tmp_path / "out"), "--no-figures"]
    assert main([*words, "--set", f"task.bounds.xi=[{least}, 2.5]"]) == 0
    line = "at its bounds     xi = 0.9: [task.bounds] may be widened, if the body can do more"
    assert (line in capsys.readouterr().out) == bool(said)
    assert json.loads((tmp_path / "out" / "solution.json").read_text())["at_bounds"] == said
    assert main(["show", str(tmp_path / "out")]) == 0
    assert (line in capsys.readouterr().out) == bool(said)


def test_what_is_lifted_is_widened_where_it_stands_and_natural_ends_are_not_named():
    assert bound_lines(["lift.bias = 0.5"]) == [
        "at its bounds     lift.bias = 0.5: [lift] may be widened, if the body can do more"
    ]
    both = bound_lines(["xi = 0.5", "lift.bias = 0.5"])[0]
    assert "[task.bounds] and [lift] may be widened" in both
    wanted = problem("reference-optimum")
    family = wanted.family_of()
    assert family.ended_at("sigma", 1.0) is None  # an ellipse is never rounder than a circle
    assert family.ended_at("a", 0.0) is None
    assert family.ended_at("sigma", 0.0) == "sigma"  # down to -1: the wave runs backwards
    assert problem("sidewinding").family_of().ended_at("bias", 0.5) == "lift.bias"
