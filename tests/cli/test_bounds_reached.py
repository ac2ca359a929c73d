"""A gait that ends where the file ends the search says so."""

import json
from pathlib import Path

import pytest

from serpenoid.cli.main import main

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
