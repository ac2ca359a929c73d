"""What `compare` says beside its numbers."""

from serpenoid.measure.usage import said_once


def test_a_note_is_said_once_with_its_trials():
    trials = [("a", ("gap", "late")), ("b", ("gap",)), ("c", ())]
    assert said_once(trials) == ["a, b: gap", "a: late"]
