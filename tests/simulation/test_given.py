"""What simulations are given has the model's shape, or is refused before compiled code reads past its end."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import serpenoid as sp
from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.model import Model
from specimens import problem, reference, serpenoid_table

WEAK = ActiveEffect(name="gain_loss", place=3, loss=0.5)

DOORS: dict[str, Callable[[Model, Floats], Any]] = {
    "table": sp.simulate_joint_angles,
    "joint_angles": lambda model, rows: sp.simulate_realised(model, rows, np.arange(len(rows))),
    "tables": lambda model, rows: sp.simulate_batch(model, rows[None]),
}


@pytest.mark.parametrize("effects", [(), (WEAK,)], ids=["baseline", "extended"])
@pytest.mark.parametrize("columns", [1, 9, 11, 12])
@pytest.mark.parametrize("name", DOORS)
def test_angles_of_other_joints_than_the_bodys_are_refused(
    name: str, columns: int, effects: tuple[ActiveEffect, ...]
) -> None:
    model = replace(reference(), effects=effects)
    with pytest.raises(InputError, match=rf"`{name}` must have shape \(.*, 10\), got .*{columns}\)\.$"):
        DOORS[name](model, np.zeros((20, columns)))


@pytest.mark.parametrize("name", DOORS)
def test_whether_axes_are_exchanged_is_asked_where_that_would_mend_it(name: str) -> None:
    with pytest.raises(InputError, match=r"got \(.*10, 20\)\. Transposed\?$"):
        DOORS[name](reference(), np.zeros((10, 20)))


@pytest.mark.parametrize("name", DOORS)
@pytest.mark.parametrize("table", [np.zeros(10), np.zeros((0, 10)), [[0.0] * 10, [0.0]], "angles"])
def test_what_is_no_table_of_rows_is_refused(name: str, table: Any) -> None:
    door = sp.simulate_batch if name == "tables" else DOORS[name]
    with pytest.raises(InputError, match=f"`{name}` must "):
        door(reference(), [table] if name == "tables" else table)


@pytest.mark.parametrize(("points", "axes"), [(11, 2), (13, 2), (12, 3)])
def test_chains_of_other_vertices_or_axes_are_refused(points: int, axes: int) -> None:
    with pytest.raises(InputError, match=r"`vertices` must have shape \(1 or more, 12, 2\)"):
        sp.simulate_vertices(reference(), np.ones((4, points, axes)))
    with pytest.raises(InputError, match=r"`vertices` must have shape \(1 or more, 12, 3\)"):
        sp.simulate_in_space(reference(), np.ones((4, points, 5 - axes)))


@pytest.mark.parametrize("cycles", [0, -1, 1.5, "2"])
def test_a_number_of_cycles_that_is_none_is_refused(cycles: Any) -> None:
    with pytest.raises(InputError, match="`cycles` must be a whole number, 1 or more"):
        sp.simulate_joint_angles(reference(), serpenoid_table(reference()), cycles=cycles)


@pytest.mark.parametrize("unit", ["m8[ms]", "M8[ns]"])
def test_dates_and_durations_whose_unit_numpy_drops_are_refused(unit: str) -> None:
    table = serpenoid_table(reference())
    with pytest.raises(InputError, match=r"`times` must .* Divide them by np.timedelta64\(1, 's'\)"):
        sp.simulate_realised(reference(), table, np.arange(len(table)).astype(unit))


def test_a_start_so_far_away_that_steps_are_rounding_is_refused() -> None:
    table = serpenoid_table(reference())
    far = sp.simulate_joint_angles(reference(), table, start=(1e5, 0.0, 0.0))
    assert far.displacement == pytest.approx(sp.simulate_joint_angles(reference(), table).displacement, rel=1e-9)
    with pytest.raises(InputError, match=r"`start` must be within \+-100000 body lengths"):
        sp.simulate_joint_angles(reference(), table, start=(1e300, 0.0, 0.0))


@pytest.mark.parametrize("start", [[0.0, 0.0], [0.0, np.nan, 0.0], [[0.0, 0.0]]])
def test_a_start_that_is_no_pose_is_refused(start: Any) -> None:
    with pytest.raises(InputError, match="`start` must"):
        sp.simulate_joint_angles(reference(), serpenoid_table(reference()), start=start)


@pytest.mark.parametrize("times", [np.arange(19.0), np.zeros(20), np.full(20, np.nan)])
def test_times_that_are_no_clock_of_the_rows_are_refused(times: Floats) -> None:
    with pytest.raises(InputError, match="`times` must"):
        sp.simulate_realised(reference(), np.zeros((20, 10)), times)


def test_a_bad_gait_in_a_batch_with_effects_spoils_no_other() -> None:
    model = replace(reference(), effects=(WEAK,))
    good = serpenoid_table(model)
    bad = good.copy()
    bad[3, 4] = np.nan
    batch = sp.simulate_batch(model, np.array([good, bad]))
    assert batch.sound.tolist() == [True, False]
    np.testing.assert_allclose(batch.poses[0], sp.simulate_joint_angles(model, good).poses, atol=1e-12)


@pytest.mark.parametrize("name", DOORS)
def test_angles_that_may_be_degrees_are_asked_about(name: str) -> None:
    table = serpenoid_table(reference())
    assert "degrees" not in repr(DOORS[name](reference(), table))
    said = repr(DOORS[name](reference(), np.degrees(table)))
    assert re.search(r"warning: .*joint_[0-9]+ reaches [0-9.]+ degrees, more than half a turn.*in degrees\?", said)


def test_a_batch_names_the_table_whose_angles_may_be_degrees() -> None:
    table = serpenoid_table(reference())
    blank = np.full_like(table, np.nan)
    batch = sp.simulate_batch(reference(), np.array([table, np.degrees(table), blank]))
    assert repr(batch).startswith("<Batch 2 of 3 gaits simulated, ")
    assert "warning: tables[1]: joint_" in repr(batch)


@pytest.mark.parametrize("name", DOORS)
def test_complex_angles_are_refused_and_not_cut_to_their_real_part(name: str) -> None:
    """`fft` without `.real` gives them; cut, they may be a body that never moves."""
    with pytest.raises(InputError, match=rf"`{name}` must be an array of numbers .*got complex ones\. Take the real"):
        DOORS[name](reference(), 1j * np.ones((20, 10)))


@pytest.mark.parametrize("name", DOORS)
def test_masked_angles_are_refused_and_not_read_behind_their_mask(name: str) -> None:
    masked = np.ma.masked_greater(np.linspace(0, 1, 200).reshape(20, 10), 0.9)
    with pytest.raises(InputError, match=rf"`{name}` must be an array of numbers .*some are masked\. Fill them"):
        DOORS[name](reference(), masked)


def test_a_certificate_of_what_is_no_number_names_the_table() -> None:
    asked = problem("reference")
    table = sp.simulate(asked).table
    table[3, 4] = np.nan
    with pytest.raises(InputError, match=r"`table` must be finite numbers, got nan at \[3, 4\]"):
        sp.certify_table(asked, table)


def test_rows_that_do_not_come_back_are_played_once() -> None:
    table = serpenoid_table(reference())
    with pytest.raises(InputError, match="`cycles` must be 1 with `closed=False`, got 3"):
        sp.simulate_joint_angles(reference(), table, cycles=3, closed=False)
    with pytest.raises(InputError, match="`closed` must be True or False, got 'no'"):
        sp.simulate_joint_angles(reference(), table, closed="no")  # type: ignore[arg-type]
    with pytest.raises(InputError, match=r"task\.cycles must be 1 with `transient`"):
        problem("reference", "task.transient=true", "task.cycles=3")


@pytest.mark.parametrize("effects", [(), (WEAK,)], ids=["baseline", "extended"])
def test_angles_that_may_be_degrees_and_chains_that_may_be_millimetres_are_told(
    effects: tuple[ActiveEffect, ...],
) -> None:
    model = replace(reference(), effects=effects)
    table = serpenoid_table(model)
    told = r"joint_\d+ reaches [\d.]+ degrees, more than half a turn\. .* were they given in degrees"
    motion = sp.simulate_joint_angles(model, table)
    for right in (motion, sp.simulate_vertices(model, motion.vertices)):
        assert "warning" not in repr(right)
    realised = sp.simulate_realised(model, np.degrees(table), np.arange(len(table)))
    for wrong in (sp.simulate_joint_angles(model, np.degrees(table)), realised):
        assert re.search(f"; warning: {told}", repr(wrong))
    assert "the chains are 1000 body lengths long" in repr(sp.simulate_vertices(model, 1000 * motion.vertices))
    found = sp.certify_table(problem("reference"), np.degrees(table))
    assert re.search(f"body lengths per cycle; warning: {told}", repr(found))
