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
SAG, TURN, SLIDE = 0.02, -6e-3, 0.04  # 1/s, rad/s, 1
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


def seen(trial: Trial) -> Trial:
    """The trial as cameras see it whose frame turns, markers on a skin that slides."""
    film = trial.film
    turns, markers = rotation(TURN * np.maximum(film.time, 0)), film.markers.copy()
    markers[:, 1:-1] += SLIDE * np.diff(film.markers, 2, axis=1)  # hidden where a neighbour is
    return replace(trial, film=replace(film, markers=np.einsum("fij,fkj->fki", turns, markers)))


@pytest.fixture(scope="module")
def said(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The record of a diagnosis whose catalogue has the newcomers, of a campaign that hides them all."""
    folder = tmp_path_factory.mktemp("newcomers")
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(outside.OUTSIDE, "sagging_floor", sagging)
        campaign = make(5, "sagging_floor", "new", COMBINATIONS[:2])
    write(replace(campaign, trials=tuple(seen(t) for t in campaign.trials)), folder / "new")
    options = ["diagnose", folder / "new", "--out", folder / "out", "--no-figures", "--quiet"]
    subprocess.run([sys.executable, "-c", COMMAND, *map(str, options)], check=True)
    found: dict[str, Any] = json.loads((folder / "out" / "diagnosis.json").read_text())
    return found


NEWCOMERS = [("sagging_floor", "rate", SAG), ("turning_frame", "rate", TURN), ("sliding_skin", "share", SLIDE)]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "parameter", "truth"), NEWCOMERS)
def test_a_newcomer_is_found_and_its_interval_covers_it(
    said: dict[str, Any], name: str, parameter: str, truth: float
) -> None:
    (found,) = (e for e in said["effects"] if e["name"] == name)
    low, high = found["parameters"][parameter]["interval"]
    assert low < truth < high
    assert high - low < 0.1 * abs(truth)


@pytest.mark.slow
def test_the_newcomers_are_all_that_is_named(said: dict[str, Any]) -> None:
    assert said["verdict"] == "explained"
    assert len(said["effects"]) == len(NEWCOMERS)
