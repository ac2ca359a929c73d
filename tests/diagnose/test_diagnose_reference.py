"""The command with an earlier campaign: what was so then is no news, what changed since is named."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from serpenoid.cli.main import main
from serpenoid.diagnose.reference import in_other_cycles

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


GRIP = Effect("grip_saturation", None, {"saturation_speed": 0.03})
SLOPE = Effect("slope", None, {"pull_x": 0.008, "pull_y": 0.005})


@pytest.mark.slow  # the search of the earlier campaign, which nothing in the catalogue explains
def test_a_change_is_named_though_the_catalogue_does_not_hold_the_law_of_the_floor(tmp_path: Path) -> None:
    few = COMBINATIONS[:2]
    write(make(62, [], "then", few, base=[GRIP]), tmp_path / "then")
    write(make(62, [SLOPE], "now", few, base=[GRIP], chance=(1,)), tmp_path / "now")
    options = ["--reference", str(tmp_path / "then"), "--without=grip_saturation", "--no-figures", "--quiet"]
    assert main(["diagnose", str(tmp_path / "now"), *options, "--out", str(tmp_path / "out")]) == 0
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert said["reference"]["verdict"] != "explained"
    assert [e["name"] for e in said["effects"] if not e["stand_in"]] == ["slope"]


def test_what_a_reference_did_not_see_is_filled_by_the_same_phase_of_other_cycles() -> None:
    phase = np.array([0.25, 0.75, 0.25, 0.75, 0.25, 0.75])
    mean = np.array([1.0, 5.0, 1.2, np.nan, 0.8, 5.2])[:, None] * np.ones(3)
    filled, noise = in_other_cycles(mean, np.full((6, 3), 0.1), phase)
    np.testing.assert_allclose(filled[3], 5.1)
    # four values more than two means: sum of squares 0.04 + 0.04 + 0.01 + 0.01 over 3 degrees of freedom
    np.testing.assert_allclose(noise[3], np.sqrt(0.1 / 3 * 1.5))
    np.testing.assert_array_equal(noise[0], 0.1)


def test_one_cycle_fills_nothing() -> None:
    mean = np.array([1.0, np.nan])[:, None] * np.ones(3)
    filled, _ = in_other_cycles(mean, np.full((2, 3), 0.1), np.array([0.25, 0.75]))
    assert np.isnan(filled[1]).all()
