"""Causes of one name at several places: told side by side, with the value that would do for all of them."""

from __future__ import annotations

from typing import Any

import pytest

from serpenoid.diagnose.report.together import in_common, title_of, titles, together


def weak(joint: int, value: float, half: float = 0.004, stand_in: bool = False) -> dict[str, Any]:
    loss = {"value": value, "interval": [value - half, value + half], "unit": "1"}
    return {
        "name": "gain_loss", "place": joint, "parameters": {"loss": loss}, "strength_over_noise": 2.0 + joint / 10,
        "stand_in": stand_in,
    }  # fmt: skip


def record(*effects: dict[str, Any]) -> dict[str, Any]:
    return {"effects": effects, "alternatives": []}


def test_three_weak_servos_are_told_together_and_two_apart() -> None:
    lag = weak(5, 0.05) | {"name": "lagging_joint"}
    three = record(weak(4, 0.095), lag, weak(2, 0.096), weak(3, 0.094))
    assert [[e["place"] for e in group] for group in together(three)] == [[2, 3, 4], [5]]
    assert [title_of(group) for group in together(three)] == ["gain_loss at joints 2 to 4", "lagging_joint at joint 5"]
    assert titles(together(three)[0]) == "gain_loss at joints 2 to 4 (2.2 to 2.4 times the noise)"
    assert [len(group) for group in together(record(weak(4, 0.095), lag, weak(2, 0.096)))] == [1, 1, 1]


def test_stand_ins_and_what_may_be_another_are_told_alone() -> None:
    other = {"name": "slow_joint", "place": 2, "instead_of": weak(2, 0.1)}
    said = record(weak(1, 0.1), weak(2, 0.1), weak(3, 0.1), weak(7, 0.1, stand_in=True)) | {"alternatives": [other]}
    said["alternatives"][0]["separation_over_noise"] = 0.5
    assert [len(group) for group in together(said)] == [1, 1, 1, 1]


@pytest.mark.parametrize(("third", "alike"), [(0.097, True), (0.120, False)])
def test_one_value_for_all_is_said_where_every_interval_holds_it(third: float, alike: bool) -> None:
    words = in_common([weak(1, 0.095), weak(2, 0.096), weak(5, third)])
    assert words.startswith("loss 0.096 lies in every interval") == alike
    assert bool(words) == alike


def test_places_that_are_not_in_a_row_are_listed() -> None:
    assert titles([weak(1, 0.1), weak(2, 0.1), weak(5, 0.1)]).startswith("gain_loss at joints 1, 2 and 5 (")
