"""The arena's physics, as a ladder: rest, friction, energy, symmetry, then a gait that crawls."""

from dataclasses import replace

import numpy as np
import pytest

from arena.support import LENGTH, ROBOT, run, serpenoid_table
from serpenoid.arena.assembly import Assembly
from serpenoid.arena.world import World

HEALTHY = Assembly.healthy(ROBOT)
STRAIGHT = np.zeros(10)
CURVED = serpenoid_table()[0]


@pytest.fixture(scope="module")
def reference():
    return run(cycles=2)


def test_the_parts_weigh_what_the_paper_weighed():
    assert World(HEALTHY).model.body_mass.sum() == pytest.approx(1.38, abs=1e-9)
    assert ROBOT.vertex_masses_kg.sum() == pytest.approx(1.38)
    assert pytest.approx(0.92) == LENGTH + ROBOT.spacing_m


def test_wheels_carry_the_weight_and_sink_less_than_a_millimetre_into_the_foam():
    world = World(HEALTHY)
    world.place(CURVED)
    assert world.wheel_loads().sum() == pytest.approx(1.38 * 9.81, rel=0.01)  # 1 %: the last of the settling
    assert world.wheel_loads().min() > 0.3
    sink = ROBOT.wheel_diameter_m / 2 - world.data.geom_xpos[world._tyres, 2]
    assert 0 < sink.mean() < 0.001


def test_a_robot_at_rest_stays_at_rest():
    world = World(HEALTHY)
    world.place(CURVED)
    before = world.markers()
    for _ in range(round(2 / ROBOT.timestep_s)):
        world.step()
    assert np.abs(world.markers() - before).max() < 1e-5  # a twentieth of the cameras' noise


def _friction(direction):
    """Friction over weight of the straight robot pushed with its own weight: weight minus mass times acceleration."""
    dry = ROBOT.model_copy(update={"rolling_damping": 0.0})
    world = World(Assembly.healthy(dry))
    world.place(STRAIGHT)
    world.data.xfrc_applied[:, :2] = 9.81 * world.model.body_mass[:, None] * np.array(direction)
    before, steps = world.data.subtree_com[1].copy(), round(0.25 / ROBOT.timestep_s)
    for _ in range(steps):
        world.step()
    moved = (world.data.subtree_com[1] - before)[:2] @ np.array(direction)
    return 1 - 2 * moved / (steps * ROBOT.timestep_s) ** 2 / 9.81


def test_sideways_friction_is_the_tyres_grip_and_lengthwise_that_of_rolling():
    along, across = _friction((1, 0)), _friction((0, 1))
    # the wheels' own spin adds 0.6 of their mass to what is pushed: 0.6 * 0.24 / 1.38 = 10 % of the acceleration
    assert along == pytest.approx(0.05 + 0.10 * (1 - 0.05), abs=0.03)
    assert across == pytest.approx(0.6, abs=0.03)
    assert _friction((-1, 0)) == pytest.approx(along, abs=0.005)
    assert _friction((0, -1)) == pytest.approx(across, abs=0.005)


def test_a_gentle_push_does_not_move_it():
    world = World(HEALTHY)
    world.place(STRAIGHT)
    before = world.markers()
    world.data.xfrc_applied[:, 0] = 0.03 * 9.81 * world.model.body_mass
    for _ in range(round(0.5 / ROBOT.timestep_s)):
        world.step()
    assert np.abs(world.markers() - before)[:, 0].max() < 5e-4  # static friction creeps by a hair


def test_without_motors_the_energy_only_falls():
    world = World(replace(HEALTHY, gain=np.full(10, 1e-9)))
    world.place(CURVED)
    mujoco_energy = []
    world.model.opt.enableflags |= 1 << 1  # mjENBL_ENERGY
    world.data.qvel[:2] = [0.5, 0.3]
    for _ in range(round(1.5 / ROBOT.timestep_s)):
        world.step()
        mujoco_energy.append(world.data.energy.sum())
    rises = np.diff(mujoco_energy)
    assert rises.max() < 1e-4 * (max(mujoco_energy) - min(mujoco_energy)) + 1e-4  # foam lends and takes back
    assert np.abs(world.data.qvel).max() < 0.02


def test_the_motors_work_is_what_friction_takes():
    """Over a cycle in the steady state: motor work = losses in tyres, bearings, gears and joints."""
    table = serpenoid_table()
    world = World(HEALTHY)
    world.place(table[0])
    motor = lost = 0.0
    for count in range(100):
        world.command(table[count % 50])
        for _ in range(36):
            speed = world.data.qvel.copy()
            world.step()
            middle = (speed + world.data.qvel) / 2
            if count >= 50:
                motor += world.data.qfrc_actuator @ middle
                lost -= (world.data.qfrc_constraint + world.data.qfrc_passive) @ middle
    assert motor > 0
    assert lost == pytest.approx(motor, rel=0.05)  # kinetic energy returns after a cycle; 5 %: first-order time steps


def test_the_reference_gait_moves_head_first_by_half_a_body_length(reference):
    assert 0.3 < reference.forward < 0.8
    assert abs(reference.left) < 0.05 * reference.forward


def test_a_gait_played_backwards_moves_tail_first(reference):
    back = run(table=serpenoid_table()[-np.arange(50)], cycles=2)
    # dry friction would reverse exactly; the wheels stand 18 mm behind the joints and the servos lag: 10 %
    assert back.forward == pytest.approx(-reference.forward, rel=0.10)


def test_the_mirrored_gait_mirrors_the_motion():
    table = serpenoid_table(a=5.0, sigma=0.6)
    one, other = run(table=table), run(table=-table)
    assert other.forward == pytest.approx(one.forward, abs=0.02)  # contacts switch: 0.02 body lengths is their scatter
    assert other.left == pytest.approx(-one.left, abs=0.02)


def test_heading_does_not_matter(reference):
    world = World(HEALTHY)
    table = serpenoid_table()
    world.place(table[0], 0.3, -0.2, np.radians(77))
    chord = world.markers()[-1] - world.markers()[0]
    assert np.degrees(np.arctan2(chord[1], chord[0])) == pytest.approx(77, abs=0.2)
    before = ROBOT.vertex_masses_kg @ world.markers()[:, :2] / 1.38
    for row in [*table, *table]:
        world.command(row)
        for _ in range(36):
            world.step()
    moved = np.linalg.norm(ROBOT.vertex_masses_kg @ world.markers()[:, :2] / 1.38 - before) / LENGTH / 2
    assert moved == pytest.approx(reference.forward, rel=0.04)


@pytest.mark.slow  # a mesh that takes long
def test_half_the_time_step_changes_the_displacement_by_a_few_percent(reference):
    fine = ROBOT.model_copy(update={"timestep_s": ROBOT.timestep_s / 2})
    assert run(Assembly.healthy(fine), cycles=2).forward == pytest.approx(reference.forward, rel=0.04)


def test_servos_lag_and_err_by_degrees_not_by_tens(reference):
    errors = reference.readings - np.tile(serpenoid_table(), (2, 1))
    assert 0.5 < np.degrees(np.sqrt((errors**2).mean())) < 4


def test_power_is_standby_and_a_few_watts_of_motion(reference):
    standby = 10 * 0.052 * 11.1 + 0.6
    assert reference.power.min() == pytest.approx(standby, abs=0.3)
    assert standby + 1 < reference.power.mean() < standby + 10
