"""The command with an earlier campaign: what was so then is no news, what changed since is named."""

from __future__ import annotations

import json
from pathlib import Path

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.cli.main import main

TOE = Effect("toe", None, {"angle": 0.05})  # there all the time
ZERO = Effect("zero_offset", 6, {"offset": 0.05})


def test_what_changed_since_the_reference_is_named_and_what_was_so_is_not(tmp_path: Path) -> None:
    few = COMBINATIONS[:2]
    write(make(61, [TOE], "then", few), tmp_path / "then")
    write(make(61, [TOE, ZERO], "now", few, chance=(1,)), tmp_path / "now")
    out = tmp_path / "out"
    options = ["--reference", str(tmp_path / "then"), "--out", str(out), "--no-figures", "--quiet"]
    assert main(["diagnose", str(tmp_path / "now"), *options]) == 0
    said = json.loads((out / "diagnosis.json").read_text())
    assert said["verdict"] == "explained"
    (found,) = said["effects"]
    assert (found["name"], found["place"]) == ("zero_offset", 6)
    low, high = found["parameters"]["offset"]["interval"]
    assert low < ZERO.parameters["offset"] < high
    assert said["reference"]["verdict"] == "explained"
    assert [e["name"] for e in said["reference"]["effects"]] == ["toe"]
