"""The OpenRB-150 sketch: the template beside this file, filled with a plan."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib.resources import files
from math import ceil, radians

import numpy as np

from serpenoid.errors import InputError
from serpenoid.robot.plan import BITS_PER_BYTE, Plan, velocity_unit, write_time_s
from serpenoid.robot.ticks import radians_per_tick
from serpenoid.wording import counted

BUTTON_PIN = 2
LONGEST_US = 2**31  # deadlines are differences of a 32-bit microsecond clock
SOURCE = re.compile(r"[^\w \n.,:{}+()=-]", re.ASCII)  # what enters the sketch is made of these alone
FLASH_BYTES = 200_000  # of 256 KiB, the rest is for the program


def sketch(plan: Plan, power_stream: bool = False) -> str:
    """The whole .ino file; raise InputError where the board cannot do what the plan asks."""
    _refuse_oversize(plan)
    robot = plan.robot
    motion, window = robot.motion, robot.voltage
    tick, servos = radians_per_tick(robot), robot.servos
    shared = servos[0].shared
    approach_s = motion.approach_limit_deg / (motion.approach_speed_rpm * 6.0)
    values = {
        "TITLE": f"{_comment(robot.name)}: {plan.steps} steps, "
        f"{counted(plan.cycles, 'cycle')} of {plan.cycle_duration_s:g} s",
        "JOINTS": len(robot.joint),
        "STEPS": plan.steps,
        "ROWS": len(plan.ticks),
        "END_ROW": plan.end_row,
        "CYCLES": plan.cycles,
        "CYCLE_US": round(plan.cycle_duration_s * 1e6),
        "PAUSE_US": round(plan.pause_s * 1e6),
        "BAUD": robot.bus.baud_rate,
        "BUTTON_PIN": BUTTON_PIN,
        "STREAM_POWER": "true" if power_stream else "false",
        "MODELS": _list(servo.number for servo in servos),
        "MODEL_NAMES": ", ".join(kind.name for kind in robot.kinds),
        "VELOCITY_UNIT": velocity_unit(robot),
        "FACTORY_SPEED_LIMITS": _list(servo.registers["velocity_limit"].initial for servo in servos),
        "POSITION_MODES": _list(servo.position_mode for servo in servos),
        "GOAL_ADDRESS": shared.goal.address,
        "GOAL_SIZE": shared.goal.size,
        "TORQUE_ADDRESS": shared.torque.address,
        "TORQUE_SIZE": shared.torque.size,
        "MINIMUM_DECIVOLT": ceil(window.minimum_V / shared.volt_per_unit - 1e-9),
        "MAXIMUM_DECIVOLT": int(window.maximum_V / shared.volt_per_unit + 1e-9),
        "ARRIVAL_TICKS": _list(np.rint(np.radians(robot.arrival_tolerances_deg) / tick)),
        "APPROACH_LIMIT_TICKS": _list(np.rint(radians(motion.approach_limit_deg) / tick)),
        "APPROACH_VELOCITIES": _list(plan.approach_velocity()),
        "APPROACH_MS": round(1500 * approach_s + 2000),
        "LOOK_TIME_US": _look_time_us(plan),
        "WIDEN_LIMITS": "true" if plan.widen_limits else "false",
        "WATCHDOGS": _list(plan.watchdog_units),
        "IDS": _list(robot.ids),
        "MINIMA": _list(joint.minimum_ticks for joint in robot.joint),
        "MAXIMA": _list(joint.maximum_ticks for joint in robot.joint),
        "SPEED_LIMITS": _list(plan.settings()["velocity_limit"]),
        "PLAY_VELOCITIES": _list(plan.play_velocity()),
        "TABLE": ",\n".join(f"  {{{_list(row)}}}" for row in plan.ticks),
    }
    text = files("serpenoid.robot").joinpath("openrb150.ino").read_text(encoding="utf-8")
    for name, value in values.items():
        if SOURCE.search(str(value)):
            raise ValueError(f"{name} must not enter source code: {value!r}")
        text = text.replace(f"@{name}@", str(value))
    return text


def _comment(name: str) -> str:
    """A name in one line of plain ASCII, for a comment."""
    return re.sub(r"[^\w .,+()=-]", "_", name, flags=re.ASCII)


def _look_time_us(plan: Plan) -> int:
    """Two reads of one servo (at most 58 bytes), one row, and 2 ms for the board itself."""
    baud = plan.robot.bus.baud_rate
    return round(1e6 * (58 * BITS_PER_BYTE / baud + write_time_s(plan.robot))) + 2000


def _refuse_oversize(plan: Plan) -> None:
    if (plan.cycle_duration_s + plan.pause_s) * 1e6 >= LONGEST_US:
        raise InputError("--format openrb: cycle and pause together must stay below 2147 s, the board's clock wraps.")
    size = plan.ticks.size * np.int16().nbytes
    if size > FLASH_BYTES:
        raise InputError(
            f"--format openrb: the table needs {size} bytes of flash, {FLASH_BYTES} are free. Use fewer steps."
        )


def _list(values: Iterable[float]) -> str:
    return ", ".join(str(int(value)) for value in values)
