"""Checks before anything moves; each refusal names joint, step, value, limit and remedy.

T: steps, m: joints; a table has T rows where it is closed, and T + 1 where it is a transient.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, degrees, tau

import numpy as np
from numpy.typing import NDArray

from serpenoid.joint_limits import KEPT, farthest, turns_per_cycle
from serpenoid.joint_range import Limit, misfit
from serpenoid.robot.description import Robot
from serpenoid.robot.plan import read_time_s, row_speeds_rpm, write_time_s
from serpenoid.robot.stated import Stated
from serpenoid.robot.ticks import coarsest_tick, to_ticks
from serpenoid.table_file import header
from serpenoid.wording import counted

BUS_SHARE = 0.9  # of a row's time that its packets may take


@dataclass(frozen=True)
class Refusal:
    """`where` names joint and step; the sentence reads `where: value, limit. remedy`.

    shortest_s: the shortest cycle that keeps the limit [s]; the remedy is then what else may be done, if anything.
    """

    where: str
    value: str
    limit: str
    remedy: str
    shortest_s: float | None = None

    def __str__(self) -> str:
        return f"{self.where}: {self.value}; {self.limit}. {self._advice}"

    @property
    def _advice(self) -> str:
        if self.shortest_s is None:
            return self.remedy
        slower = f"Play it slower: a cycle of {self.shortest_s:g} s or more (--cycle-duration)"
        return f"{slower}, or {self.remedy}." if self.remedy else f"{slower}."


def kept_by_one_cycle(refusals: list[Refusal]) -> list[Refusal]:
    """The same, each with the shortest cycle that keeps the limits of all: whoever plays that is refused no more."""
    longest = max((r.shortest_s for r in refusals if r.shortest_s is not None), default=None)
    return [r if r.shortest_s is None else replace(r, shortest_s=longest) for r in refusals]


def check_table(
    angles: NDArray[np.float64], robot: Robot, cycle_duration_s: float, voltage: float, closed: bool = True
) -> list[Refusal]:
    """All that is wrong with playing the table `angles` [rad] on `robot`, at `voltage` [V] at the servos."""
    if malformed := check_given(angles, robot):
        return malformed
    ticks = to_ticks(angles, robot)
    speeds = row_speeds_rpm(ticks, robot, cycle_duration_s, closed)
    refusals = _check_positions(angles, ticks, robot) + _check_speeds(speeds, robot, cycle_duration_s, voltage, closed)
    return kept_by_one_cycle(refusals + _check_bus(len(speeds), robot, cycle_duration_s))


def check_given(angles: NDArray[np.float64], robot: Robot) -> list[Refusal]:
    """What keeps a table from being looked at: another number of joints, or cells that are no numbers."""
    return _check_shape(angles, robot) or check_finite(angles)


def check_body(
    angles: NDArray[np.float64], stated: Stated, cycle_duration_s: float | None, columns: Sequence[str] | None = None
) -> list[Refusal]:
    """What the body of the results allows its joints: table `angles` [rad], in a cycle of that duration if known.

    columns: what its columns are called, by default joint_1, joint_2, ...
    """
    names, allowed = columns or header(angles.shape[1]), stated.joint_limit_deg
    refusals = [] if allowed is None else _check_body_angles(angles, allowed, names)
    joint, turns = turns_per_cycle(angles, closed=not stated.transient)
    limit = stated.joint_speed_limit_rpm
    if limit is None or cycle_duration_s is None or turns * 60 / cycle_duration_s <= limit * (1 + KEPT):
        return refusals
    value = f"speed {_beyond(turns * 60 / cycle_duration_s, limit)} rpm in a cycle of {cycle_duration_s:g} s"
    limit_words, shortest = f"the body's limit is {limit:g} rpm", _up(turns * 60 / limit)
    return [*refusals, Refusal(names[joint], value, limit_words, "say --no-joint-limits", shortest)]


def _check_body_angles(angles: NDArray[np.float64], limit: Limit, names: Sequence[str]) -> list[Refusal]:
    if (said := misfit(limit, angles.shape[1])) is not None:
        return [Refusal("all joints, all steps", "the table and the body's limits do not fit", said, "Solve again.")]
    worst = farthest(angles, limit)
    if worst.kept:
        return []
    where, value = f"{names[worst.joint]}, step {worst.step}", worst.reach
    shown = _beyond(value, worst.upper if value > worst.upper else worst.lower)
    remedy = "Solve with this limit, or say --no-joint-limits: the robot file's limits then hold alone."
    return [Refusal(where, f"angle {shown} degrees", f"the body's limit is {worst.limit} degrees", remedy)]


def _beyond(value: float, limit: float) -> str:
    """In words that show on which side of the limit it is: never two equal numbers."""
    short = round(value, 1)
    return f"{value:.1f}" if short != limit and (short > limit) == (value > limit) else f"{value:.7g}"


def check_repetition(angles: NDArray[np.float64], stated: Stated, cycles: int) -> list[Refusal]:
    """A transient (T + 1, m) leads from shape to shape: another cycle would jump, unless it ends where it began."""
    jump = np.abs(angles[0] - angles[-1])
    if not stated.transient or cycles == 1 or jump.max() <= coarsest_tick() / 2:
        return []
    joint = int(jump.argmax())
    value = f"it is {degrees(jump[joint]):.2f} degrees from the first row"
    limit = f"this table is a transient, and {cycles} cycles of it would jump back"
    remedy = "Play it once (--cycles 1), or add rows that lead back to the first, in a folder of their own."
    return [Refusal(f"joint_{joint + 1}, last row", value, limit, remedy)]


def check_start(present: NDArray[np.int64], first_row: NDArray[np.int64], robot: Robot) -> list[Refusal]:
    """The way from the `present` positions (m,) [ticks] to the first row."""
    refusals = []
    limit_deg = robot.motion.approach_limit_deg
    for j, joint in enumerate(robot.joint):
        where = f"{robot.joint_label(j)}, step 0"
        if not joint.minimum_ticks <= present[j] <= joint.maximum_ticks:
            limit = f"the limits are {joint.minimum_ticks}..{joint.maximum_ticks}"
            remedy = "Torque is off: turn the joint by hand into its range."
            refusals.append(Refusal(where, f"the servo stands at {present[j]} ticks", limit, remedy))
            continue
        jump = degrees(abs(int(first_row[j]) - int(present[j])) * joint.radians_per_tick)
        if jump > limit_deg:
            remedy = "Torque is off: bring the robot nearer to its first shape by hand, or raise `approach_limit_deg`."
            value = f"the first row is {jump:.1f} degrees away from where the servo stands"
            refusals.append(Refusal(where, value, f"the limit is {limit_deg:g} degrees", remedy))
    return refusals


def check_voltage(voltages: NDArray[np.float64], robot: Robot) -> list[Refusal]:
    """Each servo's input voltage (m,) [V] against the robot's window."""
    window = robot.voltage
    refusals = []
    for j, volts in enumerate(voltages):
        if not window.minimum_V <= volts <= window.maximum_V:
            remedy = "Charge the battery." if volts < window.minimum_V else "Check that this is the right supply."
            limit = f"the window is {window.minimum_V:g}..{window.maximum_V:g} V"
            refusals.append(
                Refusal(f"{robot.joint_label(j)}, before step 0", f"input voltage {volts:.1f} V", limit, remedy)
            )
    return refusals


def _check_shape(angles: NDArray[np.float64], robot: Robot) -> list[Refusal]:
    joints = angles.shape[1] if angles.ndim == 2 else 0
    if joints == len(robot.joint) and len(angles) >= 2:
        return []
    value = f"the table is {' x '.join(map(str, angles.shape))} (steps x joints)"
    limit = f"robot `{robot.name}` has {counted(len(robot.joint), 'joint')} and needs at least 2 steps"
    cure = "Use a table of this robot's body, or the right --robot file."
    if joints > len(robot.joint):
        cure += " Of a robot without its dead servos: a body whose `joints` leave them out (docs/robot.md)."
    return [Refusal("all joints, all steps", value, limit, cure)]


def check_finite(angles: NDArray[np.float64]) -> list[Refusal]:
    """The first ten cells of `angles` (T, m) that are not finite."""
    bad = np.argwhere(~np.isfinite(angles))
    limit = "angles must be finite numbers"
    remedy = "Solve or export the gait again; a failed solution has no table to play."
    return [Refusal(f"joint_{j + 1}, step {i}", f"angle {angles[i, j]}", limit, remedy) for i, j in bad[:10]]


def _check_positions(angles: NDArray[np.float64], ticks: NDArray[np.int64], robot: Robot) -> list[Refusal]:
    refusals = []
    for j, joint in enumerate(robot.joint):
        excess = np.maximum(ticks[:, j] - joint.maximum_ticks, joint.minimum_ticks - ticks[:, j])
        step = int(excess.argmax())
        if excess[step] > 0:
            low, high = (degrees(angle) for angle in joint.angle_range)
            value = f"angle {degrees(angles[step, j]):.1f} degrees ({ticks[step, j]} ticks)"
            limit = f"the limits are {low:.1f}..{high:.1f} degrees ({joint.minimum_ticks}..{joint.maximum_ticks} ticks)"
            outside = int((excess > 0).sum())
            asked = "ask for `joint_limit_deg` in [body] when solving"
            remedy = f"{counted(outside, 'step')} outside: {asked}, or reduce the amplitude."
            refusals.append(Refusal(f"{robot.joint_label(j)}, step {step}", value, limit, remedy))
    return refusals


def _check_speeds(
    speeds: NDArray[np.float64], robot: Robot, cycle_duration_s: float, voltage: float, closed: bool
) -> list[Refusal]:
    refusals = []
    for j, joint in enumerate(robot.joint):
        no_load = joint.no_load_speed_rpm(voltage)
        limit = min(joint.speed_limit_rpm, no_load)
        step = int(speeds[:, j].argmax())
        if speeds[step, j] > limit:
            why = f"no-load speed at {voltage:.1f} V" if no_load < joint.speed_limit_rpm else "`speed_limit_rpm`"
            value, remedy, shortest = _too_fast(speeds[:, j], limit, cycle_duration_s, closed)
            limit_words = f"the limit is {limit:.1f} rpm ({why})"
            refusals.append(Refusal(f"{robot.joint_label(j)}, step {step}", value, limit_words, remedy, shortest))
    return refusals


def _too_fast(
    speeds: NDArray[np.float64], limit: float, cycle_duration_s: float, closed: bool
) -> tuple[str, str, float | None]:
    """Value, remedy and shortest cycle of a joint's speeds (T,). A jump from the last row to the first, alone too fast,
    is a table that does not close: slower is no remedy."""
    step, last = int(speeds.argmax()), len(speeds) - 1
    rest = speeds[:-1].max() if last else 0.0
    value = f"speed {speeds[step]:.1f} rpm in a cycle of {cycle_duration_s:g} s"
    if limit <= 0:
        return (
            value,
            "It cannot move at all: check its supply voltage and its own Velocity Limit (--widen-limits).",
            None,
        )
    if closed and step == last and rest <= limit and speeds[last] > 3 * rest:
        jump = degrees(speeds[last] * cycle_duration_s / len(speeds) * tau / 60)
        value = f"jump of {jump:.1f} degrees from the last row to the first ({speeds[last]:.1f} rpm)"
        return value, "The table does not close: the row after the last one is the first. Export a whole cycle.", None
    return value, "", _up(cycle_duration_s * float(speeds[step]) / limit)


def _up(seconds: float) -> float:
    """The next hundredth that is no shorter."""
    return ceil(seconds * 100) / 100


def _check_bus(steps: int, robot: Robot, cycle_duration_s: float) -> list[Refusal]:
    needed = (write_time_s(robot) + read_time_s(robot)) / BUS_SHARE
    period = cycle_duration_s / steps
    if needed <= period:
        return []
    value = f"{needed * 1000:.1f} ms of packets per row at {robot.bus.baud_rate} baud"
    limit_words, remedy = f"a row lasts {period * 1000:.1f} ms", "raise the baud rate of servos and robot file"
    return [Refusal("all joints, every step", value, limit_words, remedy, _up(needed * steps))]
