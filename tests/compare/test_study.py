"""What `compare` says beside its numbers, and which gaits moved."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from serpenoid.compare.study import moving
from serpenoid.measure.usage import said_once


def passages(far: list[float], sd: list[float]) -> list[Any]:
    pairs = zip(far, sd, strict=True)
    return [SimpleNamespace(gait="g", exp=SimpleNamespace(displacement=d), exp_sd=own) for d, own in pairs]


def test_a_passage_whose_ends_are_seen_poorly_hides_no_motion_of_the_others():
    """An outside laboratory's swimmer: six passages alike, a marker hidden at one's end."""
    six = passages([0.0573, 0.0569, 0.0573, 0.0566, 0.057, 0.0571], [0.0708, 0.0007, 0.0016, 0.001, 0.0008, 0.0012])
    assert moving(six) == (six, [])


@pytest.mark.parametrize("poor", [1.0, 100.0])
def test_a_body_at_rest_is_told_however_poorly_one_passage_is_seen(poor):
    """sd is of both directions on the floor together."""
    rng, sd = np.random.default_rng(2), np.array([poor, 1, 1, 1, 1, 1]) * 1e-3
    for _ in range(50):
        far = np.hypot(*rng.normal(size=(2, 6))) * sd / np.sqrt(2)
        moved, (words,) = moving(passages(far.tolist(), sd.tolist()))
        assert not moved
        assert words.startswith("g: the body moved no farther")
    assert moving(passages([0.0], [0.0]))[0] == []


def test_a_note_is_said_once_with_its_trials():
    trials = [("a", ("gap", "late")), ("b", ("gap",)), ("c", ())]
    assert said_once(trials) == ["a, b: gap", "a: late"]


def test_trials_of_a_note_are_named_while_they_are_few():
    every = [f"t{k:02d}" for k in range(16)]

    def about(*numbers):
        return said_once((name, ["gap"] * (k in numbers)) for k, name in enumerate(every))

    assert about(0, 3, 5, 9) == ["t00, t03, t05, t09: gap"]
    assert about(*range(1, 10)) == ["t01, t02, t03 and 6 others: gap"]
    assert about(*range(16)) == ["all 16 trials: gap"]
    assert about(*range(2, 16)) == ["all 16 trials but t00 and t01: gap"]
