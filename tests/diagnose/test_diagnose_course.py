"""Joint angles at times, straight in between."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.diagnose.data.course import Course


@pytest.mark.parametrize("count", [1, 2, 40])
def test_angles_are_those_on_straight_lines_and_held_beyond(count: int) -> None:
    rng = np.random.default_rng(count)
    course = Course(np.cumsum(rng.uniform(0.1, 1.0, count)), rng.normal(size=(count, 3)))
    time = np.concatenate([rng.uniform(course.time[0] - 1, course.time[-1] + 1, 200), course.time])
    straight = np.stack([np.interp(time, course.time, column) for column in course.angles.T], axis=1)
    np.testing.assert_allclose(course.at(time), straight, rtol=0, atol=1e-14)
