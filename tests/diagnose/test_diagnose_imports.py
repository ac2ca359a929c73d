"""The diagnosis does not know the generator of its tests."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src" / "serpenoid"


@pytest.mark.parametrize("room", ["diagnose", "effects", "simulation", "measure"])
def test_no_module_imports_the_blind_generator(room: str) -> None:
    pattern = re.compile(r"^\s*(from|import)\s+(tests|blind|oracle)\b", re.MULTILINE)
    guilty = [f.name for f in (SOURCE / room).rglob("*.py") if pattern.search(f.read_text())]
    assert guilty == []
