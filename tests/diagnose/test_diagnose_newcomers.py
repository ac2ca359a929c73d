"""An effect that is one new file is tried, found and named: nothing else knows of it."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from blind import outside
from blind.campaign import COMBINATIONS, Trial, make
from blind.catalogue import Effect, World
from blind.folder import write
from blind.ground import Ground
from blind.snake import Floats, Robot
from serpenoid.group import rotation

FILES = Path(__file__).parents[1] / "newcomers"
SAG, TURN = 0.02, -6e-3  # 1/s, rad/s
# the catalogue lists what lies in its packages' folders: here they have one folder more
COMMAND = f"""
import sys, serpenoid.effects.medium, serpenoid.effects.observation
serpenoid.effects.medium.__path__.append({str(FILES / "medium")!r})
serpenoid.effects.observation.__path__.append({str(FILES / "observation")!r})
from serpenoid.cli.main import main
sys.exit(main(sys.argv[1:]))
"""


def sagging(rng: np.random.Generator, robot: Robot) -> tuple[Effect, World]:
    """The world of `sagging_floor`."""

    def force(places: Floats, time: Floats) -> Floats:
        return -SAG * robot.weights[:, None] * places

    return Effect("sagging_floor", None, {"rate": SAG}), World(Ground(0.2, robot, external=(force,)))


def turned(trial: Trial) -> Trial:
    """The trial as cameras see it whose frame turns."""
    film = trial.film
    turns = rotation(TURN * np.maximum(film.time, 0))
    return replace(trial, film=replace(film, markers=np.einsum("fij,fkj->fki", turns, film.markers)))


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The record of a diagnosis whose catalogue has both newcomers, of a campaign that hides both."""
    folder = tmp_path_factory.mktemp("newcomers")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(outside.OUTSIDE, "sagging_floor", sagging)
        campaign = make(5, "sagging_floor", "new", COMBINATIONS[:2])
    write(replace(campaign, trials=tuple(turned(t) for t in campaign.trials)), folder / "new")
    options = ["diagnose", folder / "new", "--out", folder / "out", "--no-figures", "--quiet"]
    subprocess.run([sys.executable, "-c", COMMAND, *map(str, options)], check=True)
    found: dict[str, Any] = json.loads((folder / "out" / "diagnosis.json").read_text())
    return found


@pytest.mark.parametrize(("name", "truth"), [("sagging_floor", SAG), ("turning_frame", TURN)])
def test_a_newcomer_is_found_and_its_interval_covers_it(said: dict[str, Any], name: str, truth: float) -> None:
    (found,) = (e for e in said["effects"] if e["name"] == name)
    low, high = found["parameters"]["rate"]["interval"]
    assert low < truth < high
    assert high - low < 0.1 * abs(truth)


def test_two_newcomers_are_all_that_is_named(said: dict[str, Any]) -> None:
    assert said["verdict"] == "explained"
    assert len(said["effects"]) == 2
