"""Beside a reference, what else does as much as another anisotropy ratio."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from serpenoid.diagnose.inference.doubt.same_ratio import as_much_as_another_ratio
from serpenoid.diagnose.inference.search import ratio_as_it_was
from serpenoid.diagnose.inference.search.tries import beside_the_earlier_ratio


def test_what_another_ratio_hides_is_told_and_has_no_name(
    diagnosed: tuple[Any, dict[str, Any], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A worn wheel, as if the reference had said what eps was: another eps alone makes up for a part of it."""
    monkeypatch.setattr(ratio_as_it_was, "MOST", 0.05)
    found = diagnosed[0].motion.selection
    (hidden,) = found.best.effects
    eps = found.best.model.medium.anisotropy_ratio
    nothing_named = replace(found, best=found.null, bases=(), motion=replace(found.motion, ratio=eps))
    (said,) = as_much_as_another_ratio(nothing_named)
    assert said.startswith("another anisotropy ratio takes away ")
    assert f"{hidden.name} at vertex {hidden.place}" in said
    assert not as_much_as_another_ratio(replace(nothing_named, best=found.best))
    assert not as_much_as_another_ratio(replace(nothing_named, motion=found.motion))  # no reference: eps was not known


def test_a_ratio_that_is_what_it_was_hides_nothing(diagnosed: tuple[Any, dict[str, Any], Any]) -> None:
    found = diagnosed[0].motion.selection
    eps = found.null.model.medium.anisotropy_ratio
    assert not as_much_as_another_ratio(
        replace(found, best=found.null, bases=(), motion=replace(found.motion, ratio=eps))
    )


def test_a_search_beside_a_reference_begins_from_the_earlier_ratio_too(
    diagnosed: tuple[Any, dict[str, Any], Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fits from there may change eps again, and the hidden one is among them; without a reference there are none."""
    found = diagnosed[0].motion.selection
    (hidden,) = found.best.effects
    eps = found.best.model.medium.anisotropy_ratio
    assert not beside_the_earlier_ratio(found.motion, found.null)
    known = replace(found.motion, ratio=0.97 * eps)
    assert not beside_the_earlier_ratio(known, found.null)  # another eps does next to nothing
    monkeypatch.setattr(ratio_as_it_was, "MOST", 0.05)
    tries = beside_the_earlier_ratio(known, found.null)
    best = min(tries, key=lambda t: t.fit.chi2)
    assert best.added.key == hidden.key
    assert best.fit.chi2 == pytest.approx(found.best.chi2, rel=0.02)
    assert best.fit.model.medium.anisotropy_ratio == pytest.approx(eps, rel=2e-3)
