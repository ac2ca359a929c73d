"""What holds a playing program up."""

import gc
import weakref

from serpenoid.robot.timing import older_objects_left_alone


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
