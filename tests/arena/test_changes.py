"""Each hidden change does to the robot what its name says."""

import numpy as np
import pytest

from arena.support import ROBOT, run, serpenoid_table
from serpenoid.arena.assembly import Assembly
from serpenoid.arena.changes import Changes
from serpenoid.arena.world import World

HEALTHY = Assembly.healthy(ROBOT)
CURVED = serpenoid_table()[0]


def changed(**changes):
    return Changes.model_validate(changes).apply(HEALTHY)


def standing(assembly, seconds=0.0):
    world = World(assembly)
    world.place(CURVED)
    for _ in range(round(seconds / ROBOT.timestep_s)):
        world.step()
    return world


def bends(markers):
    """True joint angles (10,) from marker positions (12, 3)."""
    edges = np.diff(markers[:, :2], axis=0)
    return np.diff(np.unwrap(np.arctan2(edges[:, 1], edges[:, 0])))


@pytest.fixture(scope="module")
def healthy():
    return run()


def test_no_change_is_the_healthy_robot():
    assert Changes().apply(HEALTHY) is HEALTHY
    assert len(Changes.model_fields) >= 16


def test_payload_is_carried_by_the_wheels_beside_it():
    more = standing(changed(payload={"link": 4, "mass_kg": 0.3})).wheel_loads() - standing(HEALTHY).wheel_loads()
    assert more.sum() == pytest.approx(0.3 * 9.81, rel=0.02)
    assert more[3:7].sum() > 0.6 * more.sum()  # links give a little, so the neighbours share


def test_a_lifted_wheel_carries_nothing_and_its_neighbours_more():
    loads = standing(changed(lifted_wheel={"vertex": 6})).wheel_loads()
    assert loads[6] == pytest.approx(0, abs=0.01)
    assert loads[[5, 7]].min() > standing(HEALTHY).wheel_loads()[[5, 7]].min() + 0.2


def test_a_seized_wheel_brakes(healthy):
    braked = run(changed(seized_wheel={"vertex": 5}))
    assert braked.forward < 0.9 * healthy.forward


def test_toe_turns_the_robot(healthy):
    turned = run(changed(toe={"vertex": 11, "angle_deg": 12.0}))
    assert abs(heading(turned) - heading(healthy)) > np.radians(3)


def heading(result):
    """Turn of the chord from tail to head over the run [rad]."""
    chords = result.paths[:, -1] - result.paths[:, 0]
    angles = np.unwrap(np.arctan2(chords[:, 1], chords[:, 0]))
    return angles[-1] - angles[0]


def test_a_ratchet_hinders_going_backward_more_than_going_forward(healthy):
    change = {"ratchet": {"torque": 0.004}}
    back = serpenoid_table()[-np.arange(50)]
    assert abs(run(changed(**change), back).forward) < 0.8 * abs(run(table=back).forward)
    assert run(changed(**change)).forward > 0.8 * healthy.forward


def test_tyres_that_grip_one_side_bend_the_way(healthy):
    sides = [run(changed(sideways={"factor": 0.4, "weak_side": side})) for side in ("left", "right")]
    assert heading(sides[0]) - heading(sides[1]) != pytest.approx(0, abs=np.radians(2))


def test_a_slope_pulls_downhill_and_the_patch_slips(healthy):
    down = run(changed(slope={"angle_deg": 4.0, "downhill_deg": 0.0}))
    up = run(changed(slope={"angle_deg": 4.0, "downhill_deg": 180.0}))
    assert down.forward > healthy.forward > up.forward
    assert run(changed(slippery_patch={"radius_m": 3.0, "factor": 0.5})).forward < 0.9 * healthy.forward


def test_a_smooth_tyre_changes_the_motion(healthy):
    assert np.abs(run(changed(smooth_tyre={"vertex": 0, "factor": 0.2})).paths - healthy.paths).max() > 0.01


def test_a_wrong_zero_shows_in_the_markers_and_not_in_the_reading():
    world = standing(changed(wrong_zero={"joint": 3, "angle_deg": 8.0}))
    off = bends(world.markers()) - world.angles()
    assert np.degrees(off[2]) == pytest.approx(8.0, abs=0.3)
    assert np.degrees(np.abs(np.delete(off, 2)).max()) < 0.3


def test_a_loose_joint_plays_behind_the_servos_back(healthy):
    result = run(changed(loose_joint={"joint": 5, "play_deg": 8.0}))
    spread = [
        max(abs(bends(m) - r)[4] for m, r in zip(x.paths[1:], x.readings, strict=True)) for x in (result, healthy)
    ]
    assert np.degrees(spread[0]) == pytest.approx(4.0, abs=1.0)  # half the play, one way and the other
    assert np.degrees(spread[1]) < 1.0


def test_servo_changes_show_in_the_readings(healthy):
    table = serpenoid_table()
    stuck = run(changed(stuck_joint={"joint": 2, "angle_deg": 10.0}))
    assert np.degrees(np.abs(stuck.readings[10:, 1] - np.radians(10)).max()) < 4  # it gives under load, as servos do
    short = run(changed(short_stroke={"joint": 7, "factor": 0.5}))
    assert np.ptp(short.readings[:, 6]) < 0.6 * np.ptp(table[:, 6])
    weak = run(changed(weak_servo={"joint": 4, "factor": 0.1}))
    assert np.abs(weak.readings - table)[:, 3].mean() > 2 * np.abs(healthy.readings - table)[:, 3].mean()


def test_a_sagging_battery_makes_fast_gaits_small():
    table = serpenoid_table(a=9.0)
    low = changed(battery_sag={"voltage_V": 6.5})
    error = [np.abs(run(each, table, duration=1.5).readings - table).mean() for each in (HEALTHY, low)]
    assert error[1] > 1.3 * error[0]
    falling = World(changed(battery_sag={"voltage_V": 11.1, "drop_V_per_s": 0.5}))
    falling.place(CURVED)
    for _ in range(720):
        falling.step()
    assert falling.source_voltage() == pytest.approx(10.1, abs=0.01)


def test_a_displaced_marker_is_off_its_axis():
    change = {"vertex": 5, "along_m": 0.0, "across_m": 0.01}
    moved = standing(changed(displaced_marker=change)).markers() - standing(HEALTHY).markers()
    # the robot is set down by the middle of its markers, so all of them shift by a twelfth
    assert np.linalg.norm(moved[5] - moved[4]) == pytest.approx(0.01, abs=1e-4)
    assert np.linalg.norm(moved[4]) == pytest.approx(0.01 / 12, abs=1e-4)


@pytest.mark.parametrize(
    "change",
    [
        {"magnet": {"x_m": 0.3, "y_m": 0.1, "force_N": 3.0}},
        pytest.param({"tether": {"stiffness": 20.0, "length_m": 0.05}}, marks=pytest.mark.slow),
        pytest.param({"gust": {"force_y_N": 8.0, "begin_s": 1.0}}, marks=pytest.mark.slow),
    ],
)
def test_pulls_from_outside_the_catalogue_move_the_robot(change, healthy):
    assert np.abs(run(changed(**change)).paths - healthy.paths).max() > 0.02
