"""docs/effects.md says what the catalogue says."""

from __future__ import annotations

import re
from pathlib import Path

from effects import test_generator, test_observe, test_optimise, test_sensitivity, test_servos
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


def test_every_yes_is_a_case_of_the_tests_named_in_the_document() -> None:
    tried = {
        "simulate": {*test_generator.MOVING, *test_observe.SEEN, *test_sensitivity.OF_LAWS},
        "nlp": set(test_optimise.OPTIMISED),
        "fit": {*test_sensitivity.MEDIUM, *test_servos.ACTUATION, *test_observe.SEEN},
        "diagnose": set(catalogue()),  # test_diagnose_catalogue.py compares its own list with the catalogue
    }
    for use in USES:
        assert {name for name, effect in catalogue().items() if effect.applies_to(use)} <= tried[use]
    text = DOCUMENT.read_text(encoding="utf-8")
    for name in re.findall(r"`(?:tests/)?(?:\w+/)*(test_\w+\.py)`", text):
        assert list(DOCUMENT.parents[1].glob(f"tests/*/{name}")), name
