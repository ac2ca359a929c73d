"""docs/effects.md says what the catalogue says."""

from __future__ import annotations

from pathlib import Path

from serpenoid.effects import catalogue
from serpenoid.effects.base import USES
from serpenoid.effects.document import parameters_table, uses_table

DOCUMENT = Path(__file__).parents[2] / "docs" / "effects.md"


def test_tables_of_the_document_are_the_catalogues() -> None:
    text = DOCUMENT.read_text(encoding="utf-8")
    assert uses_table() in text
    assert parameters_table() in text


def test_every_cell_without_a_yes_gives_a_reason() -> None:
    for effect in catalogue().values():
        assert set(effect.reasons) <= set(USES)
        assert all(len(reason) > 20 for reason in effect.reasons.values())
