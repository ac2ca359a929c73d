"""eps that is another than in the reference is a finding, though it has no name; chance makes none of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from blind.protocol import usual, with_joints
from serpenoid.cli.main import main
from serpenoid.diagnose.report.summary import lines
from serpenoid.diagnose.report.verdicts import meaning
from serpenoid.diagnose.stages.motion import ratio_change

SEED, FEW = 61, COMBINATIONS[:1]


@pytest.mark.parametrize("factor", [pytest.param(1.0, marks=pytest.mark.slow), 1.15])
def test_a_ratio_that_has_changed_is_no_verdict_of_nothing(factor: float, tmp_path: Path) -> None:
    then = usual(SEED, FEW)
    write(make(SEED, [], "then", protocol=then), tmp_path / "then")
    write(make(SEED, [], "now", protocol=replace(then, eps=factor * then.eps), chance=(1,)), tmp_path / "now")
    options = ["--reference", str(tmp_path / "then"), "--out", str(tmp_path / "out"), "--no-figures", "--quiet"]
    assert main(["diagnose", str(tmp_path / "now"), *options]) == 0
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    change = said["anisotropy_ratio"]["change"]
    assert said["effects"] == []
    if factor == 1:
        assert said["verdict"] == "nothing"
        assert change is None
        return
    assert said["verdict"] == "explained"
    assert change["factor"] == pytest.approx(factor, abs=0.03)
    assert change["strength_over_noise"] > 1
    assert "only the anisotropy ratio has changed" in meaning(said)
    first, second, *_ = lines(said)
    assert first.startswith("verdict")
    assert second.startswith("since then")  # the news stands before what has long been known


@pytest.mark.slow
def test_a_ratio_that_has_changed_is_told_by_gaits_that_were_played_once(tmp_path: Path) -> None:
    """Cycles of a trial tell noise, and gaits agree about the change."""
    then = replace(with_joints(usual(SEED, COMBINATIONS[:4]), 5), plays=1)
    write(make(SEED, [], "then", protocol=then), tmp_path / "then")
    write(make(SEED, [], "now", protocol=replace(then, eps=1.15 * then.eps), chance=(1,)), tmp_path / "now")
    options = ["--reference", str(tmp_path / "then"), "--out", str(tmp_path / "out"), "--no-figures", "--quiet"]
    assert main(["diagnose", str(tmp_path / "now"), *options]) == 0
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert said["noise_from"] == "cycles"
    assert said["anisotropy_ratio"]["change"]["factor"] == pytest.approx(1.15, abs=0.05)


@pytest.mark.parametrize(("chance", "told"), [("trials", True), ("cycles", False)])
def test_gaits_that_disagree_tell_no_change_where_each_was_played_once(
    chance: str, told: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cycles share what differs from trial to trial: each gait has that once."""
    model = SimpleNamespace(medium=SimpleNamespace(anisotropy_ratio=0.2))
    fit = SimpleNamespace(model=model, effects=(), predictions=())
    selection = SimpleNamespace(
        motion=SimpleNamespace(tracks=(), ratio_held=False), settled=fit, best=fit, noise_level_m=1e-3
    )
    found, baseline = SimpleNamespace(selection=selection, stage=None), SimpleNamespace(model=model)
    baseline.ratio_before = lambda tracks: (0.18, 0.18)
    for name, value in (
        ("chance_from", chance), ("fits_of_ratio", [fit]), ("ratio_ends", (0.19, 0.21)),
        ("ratio_interval", (0.19, 0.21)), ("ends_by_gaits", (0.1, 0.4)), ("strength", 2e-3), ("_with", None),
        ("linearised", (None, None)),
    ):  # fmt: skip
        monkeypatch.setattr(ratio_change, name, lambda *args, value=value: value)
    change = ratio_change.ratio_changed(cast(Any, found), cast(Any, baseline))
    assert (change is not None) is told
