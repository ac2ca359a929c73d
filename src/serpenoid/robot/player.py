"""Play a plan on a bus: prepare, approach, play, and torque off whatever happened. m: joints."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from serpenoid.robot.bus import ATTEMPTS_IN_MOTION, Bus, ServoState
from serpenoid.robot.checks import check_start, check_table
from serpenoid.robot.faults import RobotFault
from serpenoid.robot.log import ServoLog
from serpenoid.robot.plan import READING_INTERVAL_S, Plan, RowCommand, read_time_s
from serpenoid.robot.prepare import refuse, set_profile, set_up
from serpenoid.robot.stop import StopWatcher
from serpenoid.robot.ticks import radians_per_tick, to_radians
from serpenoid.robot.timing import RowTiming
from serpenoid.robot.tracking import RowClock, Tracking
from serpenoid.robot.watch import ServoWatch

SLIPPED_S = 0.5  # rows' time that leaves more than a row late, less what leaves in time
STANDSTILL_TICKS = 3  # between two readings
MISSED_SHARE = 0.1  # of a row's time: later than this is a missed deadline

Progress = Callable[[str], None]


class Player:
    """Plays once. The caller owns port, log and stop watcher, and switches torque off afterwards.

    `begin()` is called when nothing speaks against playing and before anything moves: it opens the recording.
    """

    def __init__(
        self,
        bus: Bus,
        plan: Plan,
        log: ServoLog,
        stop: StopWatcher,
        progress: Progress,
        begin: Callable[[], None] = lambda: None,
    ) -> None:
        self._bus, self._plan, self._log, self._stop, self._progress = bus, plan, log, stop, progress
        self._begin = begin
        self._ids = plan.robot.ids
        self._slipped_s = 0.0
        self._watch = ServoWatch(bus, plan)
        self._reading_s = read_time_s(plan.robot)
        self._gave_up = False
        self.given_up_readings = 0
        self.switched_on = False  # from just before the first torque_enable = 1; all watchdogs are armed by then
        self.tracking = Tracking(plan.robot, plan.cycle_duration_s)
        self.notes: list[str] = []
        self.timing = RowTiming(MISSED_SHARE * plan.row_period_s)

    def run(self) -> None:
        """Raise RobotFault, StopRequested or InputError; the motors are then still as they were at that moment."""
        self._progress("checking and setting up the servos")
        self._plan, self.notes = set_up(self._bus, self._plan, self._stop)
        self._refuse_bad_start()
        self._begin()
        self._switch_on()
        self._bus.attempts = ATTEMPTS_IN_MOTION
        self._approach()
        self._play()

    def _refuse_bad_start(self) -> None:
        """The table at the voltage that the servos measure, and the way to its first row."""
        plan, robot = self._plan, self._plan.robot
        states = self._bus.read_states(self._ids)
        volts = min(state.voltage for state in states.values())
        refusals = check_table(to_radians(plan.ticks, robot), robot, plan.cycle_duration_s, volts, plan.closed)
        refuse(refusals + check_start(self._positions(states), plan.ticks[0], robot), self.notes)

    def _switch_on(self) -> None:
        """Profile and watchdogs, which wait for torque; goal = where it stands, so that nothing jumps; then torque."""
        states = self._bus.read_states(self._ids)
        set_profile(self._bus, self._plan, self._plan.approach_velocity())
        for servo_id, units in zip(self._ids, self._plan.watchdog_units, strict=True):
            self._stop.check()
            self._bus.write(servo_id, "bus_watchdog", units)
        self.switched_on = True
        fed = time.monotonic()
        for servo_id in self._ids:
            self._stop.check()
            self._bus.write(servo_id, "goal_position", states[servo_id].position)
            self._bus.write(servo_id, "torque_enable", 1)
            if time.monotonic() - fed > READING_INTERVAL_S:  # a long chain: those that are on must hear something
                self._bus.read_states(self._ids)
                fed = time.monotonic()

    def _approach(self) -> None:
        """Slowly to the first row; a joint that does not arrive stops the trial."""
        first = RowCommand(0.0, "approach", 0, 0, self._plan.ticks[0])
        motion, tick = self._plan.robot.motion, radians_per_tick(self._plan.robot)
        states = self._bus.read_states(self._ids)
        farthest = float((np.abs(self._positions(states) - first.goals) * tick).max())
        seconds = farthest / (motion.approach_speed_rpm * 2 * np.pi / 60)
        self._progress(f"approaching the first row ({seconds:.1f} s)")
        tolerance = np.radians(self._plan.robot.arrival_tolerances_deg) / tick
        give_up = time.monotonic() + 1.5 * seconds + 2.0
        self._send(first)
        before = self._positions(states)
        while True:
            self._stop.wait_until(time.monotonic() + READING_INTERVAL_S / 2)
            now = self._positions(self._read(first))
            off, moved, before = np.abs(now - first.goals), np.abs(now - before), now
            if (off <= tolerance).all() and moved.max() <= STANDSTILL_TICKS:
                break
            if time.monotonic() > give_up:
                raise RobotFault(self._not_there(off))
        set_profile(self._bus, self._plan, self._plan.play_velocity())

    def _not_there(self, off: NDArray[np.int64]) -> str:
        robot = self._plan.robot
        short, limits = np.degrees(off * radians_per_tick(robot)), robot.arrival_tolerances_deg
        joint = int((short - limits).argmax())
        where = f"{robot.joint_label(joint)} did not arrive at the first row: {short[joint]:.1f} degrees short"
        limit = f"the limit is {limits[joint]:g} (`limit_deg` in [tracking])"
        return f"{where}, {limit}. Is it blocked, or does the floor hold it?"

    def _play(self) -> None:
        plan = self._plan
        rows = list(plan.rows())
        ends = [row.time for row in rows[1:]] + [plan.end_s]
        clock = RowClock(time.monotonic() + plan.row_period_s)
        for row, end in zip(rows, ends, strict=True):
            self._progress(f"cycle {row.cycle + 1} of {plan.cycles}, step {row.step} of {plan.steps}")
            self._stop.wait_until(clock.due(row.time))
            late = self._send(row, clock.due(row.time))
            if late > plan.watchdog_s:
                self._refuse_after_trip(late)
            self._refuse_slipped(late)
            before = self.tracking.stretch
            self._read_until(row, clock.due(row.time), clock.due(end))
            if self.tracking.stretch > before:
                clock.stretch(self.tracking.stretch, end)
        self._stop.wait_until(clock.due(plan.end_s))
        self._read(plan.end(plan.end_s, "end", plan.cycles - 1))

    def _send(self, row: RowCommand, due: float | None = None) -> float:
        """Send one row; return how late [s] it left."""
        late = 0.0 if due is None else time.monotonic() - due
        self._bus.write_goals(dict(zip(self._ids, row.goals.tolist(), strict=True)))
        self.tracking.sent(time.monotonic(), row.goals)
        if due is not None:
            self.timing.note(late)
        return late

    def _read_until(self, row: RowCommand, begin: float, end: float) -> None:
        """Read at once and, in long rows and pauses, every 0.1 s: this is the watchdogs' food."""
        readings = max(1, int(np.ceil((end - begin) / READING_INTERVAL_S - 1e-9)))
        for k in range(readings):
            due = begin + k * (end - begin) / readings
            if k and time.monotonic() > due + READING_INTERVAL_S:
                continue
            self._stop.wait_until(due)
            if self._leaves_time_to_read(end):
                self._read(row)

    def _leaves_time_to_read(self, end: float) -> bool:
        """After a hitch one reading is given up, so that the next row leaves in time; never two running."""
        tight = time.monotonic() + self._reading_s > end
        self._gave_up = tight and not self._gave_up
        self.given_up_readings += self._gave_up
        return not self._gave_up

    def _read(self, row: RowCommand) -> dict[int, ServoState]:
        before, failures = time.monotonic(), self._bus.failures.copy()
        states = self._bus.read_states(self._ids)
        moment = (before + time.monotonic()) / 2
        healths = self._watch.ask(states)
        errors = {i: health.hardware_error for i, health in healths.items()}
        self._log.write(moment, (row.phase, row.cycle, row.step), row.goals, states, errors)
        self._watch.judge(healths, states, {i for i in self._ids if self._bus.failures[i] > failures[i]})
        if row.phase != "approach":
            self.tracking.read(moment, self._positions(states))
        return states

    def _refuse_after_trip(self, late: float) -> None:
        tripped = [i for i in self._ids if self._bus.read_health(i).watchdog_tripped]
        if tripped:
            text = f"this computer stalled for {late:.2f} s and the bus watchdogs of servos {tripped} stopped them"
            raise RobotFault(f"{text}. Close what keeps it busy, then play again.")

    def _refuse_slipped(self, late: float) -> None:
        """One late row is a hitch; a row of them is another gait than the one that was asked for."""
        period = self._plan.row_period_s
        self._slipped_s = max(0.0, self._slipped_s + (period if late > period else -period))
        if self._slipped_s > SLIPPED_S:
            worst = self._bus.failures.most_common(1)
            blame = f"servo {worst[0][0]} failed {worst[0][1]} exchanges" if worst else "this computer is too busy"
            text = f"row after row leaves more than a whole row late: {blame}"
            raise RobotFault(f"{text}. Check its cable, play a longer cycle, or close what keeps this computer busy.")

    def _positions(self, states: Mapping[int, ServoState]) -> NDArray[np.int64]:
        return np.array([states[servo_id].position for servo_id in self._ids])
