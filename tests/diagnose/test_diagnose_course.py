"""Joint angles at times, straight in between."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.diagnose.data.shapes import beside_course
from serpenoid.diagnose.data.shapes.course import Course


@pytest.mark.parametrize("count", [1, 2, 40])
def test_angles_are_those_on_straight_lines_and_held_beyond(count: int) -> None:
    rng = np.random.default_rng(count)
    course = Course(np.cumsum(rng.uniform(0.1, 1.0, count)), rng.normal(size=(count, 3)))
    time = np.concatenate([rng.uniform(course.time[0] - 1, course.time[-1] + 1, 200), course.time])
    straight = np.stack([np.interp(time, course.time, column) for column in course.angles.T], axis=1)
    np.testing.assert_allclose(course.at(time), straight, rtol=0, atol=1e-14)


@pytest.mark.parametrize("late", [-0.71, -0.05, 0.0, 0.33, 0.9])
def test_a_course_that_jumps_is_met_at_every_moment_of_a_row(late: float) -> None:
    """Every row of 0.5 s is reached in a tenth of it: most readings stand still, and say no way."""
    rng, apart = np.random.default_rng(4), 0.5
    rows = np.cumsum(rng.normal(size=(60, 2)), axis=0)
    begins = apart * np.arange(60)
    course = Course(
        np.ravel([begins, begins + 0.1 * apart], order="F"),
        np.stack([np.roll(rows, 1, axis=0), rows], 1).reshape(-1, 2),
    )
    time = np.arange(2.0, 28.0, 0.17)
    readings = course.at(time - late) + 1e-4 * rng.normal(size=(len(time), 2))
    assert course.late(time, readings, 1.0, apart) == pytest.approx(late, abs=1e-3)
    if late == 0.33:  # two thirds of a row: the slopes' own steps end elsewhere
        assert course.late(time, readings, 1.0) != pytest.approx(late, abs=1e-2)


@pytest.mark.parametrize("count", [1, 2, 40])
def test_what_readings_miss_of_a_course_is_the_same_where_no_compiler_is(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(count)
    course = Course(np.cumsum(rng.choice([1e-6, 0.1, 0.7], count)), rng.normal(size=(count, 3)))
    time = np.sort(rng.uniform(course.time[0] - 1, course.time[-1] + 1, 200))
    readings = np.where(rng.uniform(size=(200, 3)) < 0.1, np.nan, rng.normal(size=(200, 3)))
    late = rng.uniform(-2, 2, 7)
    found = beside_course.missed(course, time, readings, late)
    squares = [np.nansum((readings - course.at(time - by)) ** 2) for by in late]
    np.testing.assert_allclose(found[:, 0], squares, rtol=1e-9)
    monkeypatch.setattr(beside_course, "_missed", lambda: None)
    np.testing.assert_allclose(beside_course.missed(course, time, readings, late), found, rtol=1e-9)
