"""eps that is another than in the reference is a finding, though it has no name; chance makes none of it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from blind.campaign import COMBINATIONS, make
from blind.folder import write
from blind.protocol import usual
from serpenoid.cli.main import main
from serpenoid.diagnose.report.sentences import meaning
from serpenoid.diagnose.report.summary import lines

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
