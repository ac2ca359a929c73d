"""What `compare` says beside its numbers."""

from types import SimpleNamespace

from serpenoid.compare.study import said_once


def test_a_note_is_said_once_with_its_trials():
    trials = [("a", ("gap", "late")), ("b", ("gap",)), ("c", ())]
    campaign = SimpleNamespace(trials=[SimpleNamespace(name=name, notes=notes) for name, notes in trials])
    assert said_once(campaign) == ["a, b: gap", "a: late"]
