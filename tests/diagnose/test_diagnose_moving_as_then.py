"""Which trials move as an earlier campaign predicts: repeats that agree with each other are told together."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from serpenoid.diagnose.residuals import from_trial_to_trial

SETTINGS = [("a", 2.0), ("b", 2.0)]


def told(
    monkeypatch: pytest.MonkeyPatch, rms: list[float], apart: dict[int, float]
) -> tuple[tuple[str, ...], tuple[str, ...]] | None:
    """Of a1, b1, a2, b2, whose paths are off by rms [mm] and, of a and of b, from the next by apart [mm]; repeats were
    1 mm apart in the earlier campaign, and by chance are up to 2 mm."""
    names = ["a1", "b1", "a2", "b2"]
    tracks = tuple(
        SimpleNamespace(recording=SimpleNamespace(name=name, setting=SETTINGS[name[0] == "b"])) for name in names
    )
    earlier = SimpleNamespace(apart=tuple((setting, 1e-3, 3) for setting in SETTINGS))
    medium = SimpleNamespace(with_ratio=lambda _: None)
    motion = SimpleNamespace(tracks=tracks, earlier=earlier, ratio=0.2, held=())
    for name, value in (
        ("predictions", list(rms)), ("laid_alike", [(0, 2), (1, 3)]), ("residuals", None), ("largest_factor", 2.0),
        ("differing", {a: (1e-3 * x) ** 2 for a, x in apart.items()}), ("Model", None),
    ):  # fmt: skip
        monkeypatch.setattr(from_trial_to_trial, name, lambda *args, value=value: value)
    monkeypatch.setattr(from_trial_to_trial, "path_rms", lambda track, off: 1e-3 * off)
    found = from_trial_to_trial.after_some(cast(Any, motion), cast(Any, SimpleNamespace(body=None, medium=medium)))
    return None if found is None else (found.changed, found.others)


def test_what_acts_from_one_trial_on_is_told_with_its_trials(monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(monkeypatch, [0.5, 0.5, 9.0, 8.0], {0: 6.0, 1: 5.0}) == (("a2", "b2"), ("a1", "b1"))


def test_a_threshold_between_two_repeats_that_agree_divides_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """A foot that had slipped in all trials: "all of a1, b1 and b2 move as the reference predicts"."""
    assert told(monkeypatch, [1.9, 0.5, 2.2, 0.5], {0: 0.2, 1: 0.1}) is None


def test_repeats_that_agree_are_on_one_side(monkeypatch: pytest.MonkeyPatch) -> None:
    assert told(monkeypatch, [0.5, 1.9, 0.5, 2.2], {0: 0.2, 1: 0.1}) is None  # off in turn: no run of trials
    assert told(monkeypatch, [1.5, 1.5, 2.2, 9.0], {0: 0.5, 1: 7.0}) == (("b2",), ("a1", "b1", "a2"))
