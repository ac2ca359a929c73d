"""A robot that was mended since its reference was recorded: what is gone has its name."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, Effect, make
from blind.folder import write
from serpenoid.cli.main import main
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.doubt.law_doubt import Doubted, _together, _Told
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.report.summary import lines
from serpenoid.diagnose.report.words import gone, parameter, what_to_do
from serpenoid.diagnose.stages.motion.choose_motion import beside_earlier
from serpenoid.effects.active import ActiveEffect

ROOT = Path(__file__).parents[2]
FAULTS = [
    Effect("stuck_joint", 4, {"angle": 0.2}),
    Effect("slow_joint", 8, {"max_speed": 0.6}),
    Effect("marker_offset", 5, {"along": 0.006, "left": 0.003}),
    Effect("load", 2, {"share": 0.5}),
]


def since(then: Sequence[Effect], now: Sequence[Effect], folder: Path) -> dict[str, Any]:
    """The record of a diagnosis of a robot, beside itself with other effects."""
    for name, effects in (("then", then), ("now", now)):
        write(make(11, list(effects), name, COMBINATIONS[:3]), folder / name)
    command = ["diagnose", folder / "now", "--model", ROOT / "problems" / "snake10.toml"]
    more = ["--reference", folder / "then", "--out", folder / "out", "--no-figures", "--quiet"]
    assert main([*map(str, (*command, *more))]) == 0
    return json.loads((folder / "out" / "diagnosis.json").read_text())


@pytest.mark.slow
def test_what_is_gone_since_the_reference_has_its_name(tmp_path: Path) -> None:
    found = since(FAULTS, [], tmp_path)
    assert found["verdict"] == "explained"
    assert {(e["name"], e["place"]) for e in found["effects"]} == {(e.name, e.place) for e in FAULTS}
    assert all(gone(e) and not e["stand_in"] and not what_to_do(e, found) for e in found["effects"])
    told = "\n".join(lines(found))
    assert told.count("gone since the reference") == len(FAULTS)
    assert "what to do" not in told
    extended = (tmp_path / "out" / "extended-model.toml").read_text()
    assert not any(name in extended for name in ("stuck_joint", "slow_joint"))


@pytest.mark.slow
def test_what_is_half_mended_has_its_value_and_the_one_before(tmp_path: Path) -> None:
    half = [Effect("zero_offset", 4, {"offset": 0.04}), Effect("load", 2, {"share": 0.25})]
    found = since([Effect("zero_offset", 4, {"offset": 0.08}), Effect("load", 2, {"share": 0.5})], half, tmp_path)
    assert found["verdict"] == "explained"
    values = {e["name"]: e["parameters"] for e in found["effects"]}
    for effect in half:
        (name, true), (p,) = *effect.parameters.items(), values[effect.name].values()
        assert p["interval"][0] < true < p["interval"][1], name
        assert p["before"] == pytest.approx(2 * true, rel=0.02)


def test_what_changes_nothing_is_the_value_that_is_held() -> None:
    held = ActiveEffect.of("load", 5, share=0.3)
    motion = Motion((), None, (), held=(held,))  # type: ignore[arg-type]
    assert motion.unchanged(ActiveEffect.of("load", 5, share=0.7)) == [0.3]
    assert motion.unchanged(ActiveEffect.of("load", 6, share=0.7)) == [0.0]
    named = Named(ActiveEffect.of("load", 5, share=0.02), {"share": (-0.03, 0.07)}, 5.0, before={"share": 0.3})
    assert not named.may_change_nothing
    assert replace(named, before={}).may_change_nothing


def test_explanations_are_compared_by_what_each_changes() -> None:
    """Beside one, a load of 0.3 was there and 0.1 is; beside the other none was, and -0.2 is: both say 0.2 less."""
    told = [
        _Told(Doubted(0.1, 0.01, resting=0.3), 1.0, 1.0),
        _Told(Doubted(-0.2, 0.01, resting=0.0), 1.0, 1.0),
    ]
    both = _together(told)
    assert both.value == pytest.approx(0.1)
    assert both.deviation == pytest.approx(0.01)
    assert both.away > 10
    assert np.all(np.array(both.ends) < both.resting)


def test_a_gone_effect_is_told_with_what_it_was() -> None:
    p = {"value": 0.001, "interval": [-0.01, 0.01], "unit": "1", "before": 0.5}
    load = {"name": "load", "place": 2, "stand_in": False, "parameters": {"share": p}}
    assert gone(load)
    assert parameter(p) == "0.001 (95 %: -0.01 .. 0.01), before 0.5"
    assert not gone(load | {"parameters": {"share": p | {"value": 0.2, "interval": [0.19, 0.21]}}})
    assert parameter({"value": 0.2, "interval": [None, None], "unit": "rad", "before": 0.2}) == "before 11.5°"
    stuck = {"name": "stuck_joint", "place": 4, "stand_in": False, "gone": True, "parameters": {}}
    assert gone(stuck)
    assert not gone({"name": "stuck_joint", "place": 4, "stand_in": False, "parameters": {}})


def test_a_change_of_what_stood_in_for_another_law_is_a_stand_in() -> None:
    slope = ActiveEffect.of("slope", pull_x=0.01, pull_y=0.0)
    ends = {"pull_x": (0.009, 0.011), "pull_y": (-0.001, 0.001)}
    stage = Stage("motion", (Named(slope, ends, 3.0, before={"pull_x": 0.002, "pull_y": 0.0}),))
    known: Any = SimpleNamespace(doubt_of=lambda _: np.zeros((2, 2)))
    for guessed in (False, True):
        known.guessed = lambda _, guessed=guessed: guessed
        (n,) = beside_earlier(stage, known).named
        assert n.stand_in is guessed
    same = replace(stage.named[0], intervals={"pull_x": (0.001, 0.02), "pull_y": (-0.001, 0.001)})
    assert beside_earlier(replace(stage, named=(same,)), known).named == ()  # and it may change nothing
