"""What holds a playing program up."""

import gc
import os
import weakref

import pytest

from serpenoid.robot.timing import before_other_programs, older_objects_left_alone


class Loop:
    """Garbage that only a collection frees."""

    def __init__(self):
        self.own = self


def test_objects_of_before_are_not_looked_through_and_afterwards_they_are():
    gc.disable()
    try:
        garbage = weakref.ref(Loop())
        with older_objects_left_alone():
            gc.collect()
            assert garbage() is not None
        gc.collect()
        assert garbage() is None
    finally:
        gc.enable()


def test_what_was_set_aside_before_stays_so():
    gc.freeze()
    try:
        with older_objects_left_alone():
            pass
        assert gc.get_freeze_count() > 0
    finally:
        gc.unfreeze()


@pytest.mark.skipif(not hasattr(os, "sched_setscheduler"), reason="this system has no such policies")
@pytest.mark.parametrize("may", [True, False])
def test_a_bus_has_its_turn_first_where_the_system_lets_it_and_afterwards_as_before(monkeypatch, may):
    now = [(os.SCHED_OTHER, 0)]

    def set_policy(process: int, policy: int, param: os.sched_param) -> None:
        if policy != os.SCHED_OTHER and not may:
            raise PermissionError("Operation not permitted")
        now[0] = (policy, param.sched_priority)

    monkeypatch.setattr(os, "sched_getscheduler", lambda process: now[0][0])
    monkeypatch.setattr(os, "sched_getparam", lambda process: os.sched_param(now[0][1]))
    monkeypatch.setattr(os, "sched_setscheduler", set_policy)
    with before_other_programs():
        assert now == [(os.SCHED_RR, 1) if may else (os.SCHED_OTHER, 0)]
    assert now == [(os.SCHED_OTHER, 0)]


def test_a_system_without_such_policies_plays_all_the_same(monkeypatch):
    monkeypatch.delattr(os, "sched_getscheduler", raising=False)
    with before_other_programs():
        pass
