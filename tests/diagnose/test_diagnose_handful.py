"""A handful of hidden effects, each strong; what is hidden is opened only after the diagnosis has been written."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from blind.study import Study, run_one

ROOT = Path(__file__).parents[2]


@pytest.mark.slow  # whole diagnoses of campaigns that are not so short: test_diagnose_reference.py, _newcomers, _skin
@pytest.mark.parametrize("index", range(8))
def test_the_hidden_effect_is_named(index: int, tmp_path: Path) -> None:
    command = f"{sys.executable} -m serpenoid diagnose --quiet --no-figures"
    row = run_one(Study("handful", tmp_path, str(ROOT / "problems" / "snake10.toml"), command), index)
    assert row["outcome"] == "right", row
    assert min(row["strengths"], default=6) >= 6
    assert row["verdict"] == ("explained" if row["hidden"] else "nothing"), row
