"""What `play` would send, in words: settings, approach, every row, torque off."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from serpenoid.robot.plan import Plan, read_time_s, velocity_unit, write_time_s


def describe(plan: Plan) -> Iterator[str]:
    """One line per thing that would be sent."""
    robot, ids = plan.robot, plan.robot.ids
    yield f"robot {robot.name}: {robot.in_words()} at {robot.bus.baud_rate} baud, IDs {_row(ids)}"
    yield f"cycle {plan.cycle_duration_s:g} s, {plan.steps} steps, one every {plan.row_period_s * 1000:.1f} ms"
    write, read = write_time_s(robot) * 1000, read_time_s(robot) * 1000
    yield f"on the bus a row takes {write:.2f} ms to write and {read:.2f} ms to read back"
    yield "ping each servo; check model, firmware, voltage, hardware errors"
    yield "torque_enable = 0, bus_watchdog = 0, profile_acceleration = 0 on every servo"
    for register, values in plan.settings().items():
        keeps = register.endswith("_limit") and not plan.widen_limits
        where = "where it differs; a servo's own narrower limit stays" if keeps else "where it differs"
        yield f"{register} = {_row(values)}   ({where})"
    yield f"profile_velocity = {_row(plan.approach_velocity())}   ({velocity_unit(robot)})"
    yield f"bus_watchdog = {_row(plan.watchdog_units)}   ({plan.watchdog_s:.2f} s, from torque on)"
    yield "goal_position = present position, torque_enable = 1 on every servo"
    yield f"approach:   goal_position = {_row(plan.ticks[0])}; wait for arrival"
    yield f"profile_velocity = {_row(plan.play_velocity())}"
    for row in plan.rows():
        place = f"cycle {row.cycle} step {row.step:3d} {row.phase}"
        yield f"{row.time:9.3f} s  {place:<22} goal_position = {_row(row.goals)}"
    yield f"{plan.end_s:9.3f} s  torque_enable = 0 on every servo"


def _row(values: Iterable[int]) -> str:  # one format for lists and arrays
    return " ".join(str(int(value)) for value in values)
