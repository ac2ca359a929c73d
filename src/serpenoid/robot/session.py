"""One trial from the open port to the summary: whatever happens, the last thing sent is torque off."""

from __future__ import annotations

import time
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from serpenoid.errors import StopRequested
from serpenoid.files.writing import provenance, write_json, write_text
from serpenoid.robot.bus import Bus, open_bus
from serpenoid.robot.faults import BusFault, RobotFault
from serpenoid.robot.log import ServoLog
from serpenoid.robot.plan import Plan
from serpenoid.robot.player import Player, Progress
from serpenoid.robot.power import PowerRecorder
from serpenoid.robot.stop import StopWatcher
from serpenoid.robot.table import write_table
from serpenoid.robot.ticks import to_radians
from serpenoid.robot.timing import before_other_programs, older_objects_left_alone

UNFINISHED = "how it ended was not written: the process was killed, or the disk was full"
RECONNECT_S = 3.0  # how long a lost port is waited for, to switch the torque off after all


@dataclass(frozen=True)
class TrialFiles:
    """Where a trial is recorded; `folder` None records nothing."""

    folder: Path | None = None
    power_port: str | None = None


@dataclass
class Outcome:
    """`status`: done, strayed (played, a joint off its command), stopped (by the user) or failed.

    `torque` says what is known about the motors; `notes` what the user should know beside it.
    """

    status: str
    reason: str
    torque: str = "never switched on"
    torque_off: bool = True
    timing: str = "no rows were sent"
    tracking: str = ""
    notes: list[str] = field(default_factory=list)
    numbers: dict[str, Any] = field(default_factory=dict)


def play_trial(port: str, plan: Plan, files: TrialFiles, progress: Progress) -> Outcome:
    """Play and record; faults and stops are reported in the Outcome, bad input is raised."""
    with ExitStack() as stack:
        stack.enter_context(older_objects_left_alone())
        stack.enter_context(before_other_programs())
        log = stack.enter_context(ServoLog(files.folder, plan.robot))
        log.check_room(plan.most_readings)
        recorders: list[ServoLog | PowerRecorder] = [log]
        if files.power_port is not None:
            recorders.append(stack.enter_context(PowerRecorder(files.power_port, files.folder)))
        stop = stack.enter_context(StopWatcher())
        if stop.has_keys:
            progress("emergency stop: space, Esc or q")
        outcome = _play(port, plan, recorders, stop, progress, files.folder)
        if files.folder is not None:
            _write_summary(files.folder, plan, outcome, log.begun)
        return outcome


def _play(
    port: str,
    plan: Plan,
    recorders: list[ServoLog | PowerRecorder],
    stop: StopWatcher,
    progress: Progress,
    folder: Path | None,
) -> Outcome:
    outcome = Outcome("done", "played to the end")
    log = next(recorder for recorder in recorders if isinstance(recorder, ServoLog))
    bus = open_bus(port, plan.robot.bus.baud_rate, plan.robot.by_id)
    try:
        player = Player(bus, plan, log, stop, progress, lambda: _begin(recorders, folder, plan))
        try:
            player.run()
            _judge_tracking(outcome, player)
        except RobotFault as fault:
            outcome.status, outcome.reason = "failed", _named(fault, plan)
        except StopRequested as request:
            outcome.status, outcome.reason = "stopped", f"by the user {request}".rstrip()
        finally:
            stop.disarm()
            outcome.torque_off, outcome.torque = switch_off(bus, port, plan, progress, player.switched_on)
        _account(outcome, player, bus)
    finally:
        bus.close()
    return outcome


def _begin(recorders: list[ServoLog | PowerRecorder], folder: Path | None, plan: Plan) -> None:
    """Recordings, and beside them all that is known before it ends: what is recorded can be used, however that is."""
    for recorder in recorders:
        recorder.begin()
    if folder is not None:
        try:
            _write_files(folder, plan, Outcome("unfinished", UNFINISHED, torque_off=False), recorded=True)
        except OSError as error:
            raise RobotFault(f"{folder}: cannot be written ({error.strerror}). Make room.") from None


def _judge_tracking(outcome: Outcome, player: Player) -> None:
    strayed = player.tracking.strayed
    if strayed:
        slowly = ", and more slowly than asked" if player.tracking.stretch > 1 else ""
        outcome.status = "strayed"
        outcome.reason = f"played to the end{slowly}, but {', '.join(strayed)} did not follow: not the gait asked for"


def _account(outcome: Outcome, player: Player, bus: Bus) -> None:
    """What the summary says beside the outcome itself."""
    outcome.timing = player.timing.sentence()
    outcome.notes = player.notes
    if player.timing.lateness:
        outcome.tracking = player.tracking.sentence()
    outcome.numbers = player.timing.summary() | {
        "given_up_readings": player.given_up_readings,
        "failed_exchanges": {str(servo): count for servo, count in sorted(bus.failures.items())},
        "tracking": player.tracking.summary(),
    }


def _named(fault: RobotFault, plan: Plan) -> str:
    """The bus knows servo IDs; the user also thinks in joints."""
    servo_id = fault.servo_id if isinstance(fault, BusFault) else None
    if servo_id not in plan.robot.ids:
        return str(fault)
    return str(fault).replace(f"servo {servo_id}", plan.robot.joint_label(plan.robot.ids.index(servo_id)), 1)


def switch_off(bus: Bus, port: str, plan: Plan, progress: Progress, switched_on: bool) -> tuple[bool, str]:
    """Torque off, over a port that is opened again if need be: (all confirmed, sentence)."""
    ids = plan.robot.ids
    try:
        silent = bus.torque_off(ids)
    except BusFault:
        silent = _switch_off_again(bus, port, plan, progress)
    if not silent:
        return True, "torque is off on every servo, each confirmed it"
    if not switched_on:  # and no watchdog was armed
        return False, f"nothing was switched on; servos {', '.join(map(str, silent))} did not answer: look at them"
    holds = f"their bus watchdogs stop them within {plan.watchdog_s:.2f} s, but they may hold. CUT THE BATTERY"
    return False, f"servos {', '.join(map(str, silent))} did not confirm torque off: {holds}"


def _switch_off_again(bus: Bus, port: str, plan: Plan, progress: Progress) -> list[int]:
    """The port is lost: a USB adapter often comes back within a second under the same name."""
    progress(f"the port is lost; trying for {RECONNECT_S:g} s to switch the torque off")
    give_up = time.monotonic() + RECONNECT_S
    while time.monotonic() < give_up:
        bus.close()
        try:
            with Bus(port, plan.robot.bus.baud_rate, plan.robot.by_id) as again:
                return again.torque_off(plan.robot.ids)
        except BusFault:
            time.sleep(0.1)
    return plan.robot.ids


def _write_summary(folder: Path, plan: Plan, outcome: Outcome, recorded: bool) -> None:
    """How it went. A disk that is full changes the outcome: what became of the motors is said all the same."""
    try:
        _write_files(folder, plan, outcome, recorded)
    except OSError as error:
        kept = ": readings, table and trial.toml are kept, play.json says `unfinished`" * recorded
        outcome.notes.append(f"{folder}: the summary could not be written ({error.strerror}){kept}")
        outcome.status = "failed" if outcome.status == "done" else outcome.status


def _write_files(folder: Path, plan: Plan, outcome: Outcome, recorded: bool) -> None:
    """The summary; beside a recording also the table that is played, and the campaign's trial section."""
    write_json(folder / "play.json", _summary(plan, outcome))
    if recorded:
        write_table(folder / "joint_table.csv", to_radians(plan.ticks, plan.robot))
        if plan.closed:  # campaigns know no other gaits
            write_text(folder / "trial.toml", _trial_section(folder, plan, outcome))


def _summary(plan: Plan, outcome: Outcome) -> dict[str, Any]:
    return {
        "status": outcome.status,
        "reason": outcome.reason,
        "torque_off": outcome.torque_off,
        "robot": plan.robot.name,
        "servos": [servo.name for servo in plan.robot.servos],
        "cycle_duration_s": plan.cycle_duration_s,
        "cycles": plan.cycles,
        "pause_s": plan.pause_s,
        "transient": not plan.closed,
        "timing": outcome.numbers,
        "notes": outcome.notes,
        "provenance": provenance(),
    }


def _trial_section(folder: Path, plan: Plan, outcome: Outcome) -> str:
    name = folder.resolve().name
    lines = [] if outcome.status == "done" else [f"# {outcome.status}: {' '.join(outcome.reason.split())}"]
    lines += [
        "# Paste into campaign.toml beside this folder; `gait` groups repeats, `motion` names the camera's file.",
        "[[trial]]",
        f'name = "{name}"',
        f'gait = "{name}"',
        f'joint_table = "{name}/joint_table.csv"',
        f"cycle_duration_s = {plan.cycle_duration_s!r}",
        f"cycles = {plan.cycles}",
        f"pause_s = {plan.pause_s!r}",
        f'# motion = "{name}/motion.csv"',
        f'servo_log = "{name}/servo.csv"',
    ]
    if (folder / "power.csv").exists():
        lines.append(f'power_log = "{name}/power.csv"')
    return "\n".join(lines) + "\n"
