"""The servo log of `play`, the power log, and joint tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats, block, increasing_times, place, read_rows
from serpenoid.measure.formats.columns import (
    RADIANS,
    SECONDS,
    ServoColumns,
    ServoKeys,
    find_column,
    numbered,
    refuse_other_unit,
    shown,
)
from serpenoid.wording import counted

LARGEST_W = 10_000.0  # of any robot that is meant here
SPIKE, SPIKE_SHARE = 50.0, 0.02  # times the median and of the energy: all servos stalled draw 48 times the idle power
LIMIT_RAD = 2 * np.pi  # a joint angle beyond a full turn is in degrees or ticks
READ_AS_WRITTEN = ServoKeys()
TICK = RADIANS["ticks"]  # rad: the step of a servo's reading
TEN_BITS = 1023  # ticks: the last of an AX servo
AX = "servos that count 1024 ticks in 300 degrees (AX): `ticks_per_turn = 1228.8` and `zero_ticks = 512` in [servo_log]"
OWN_NAMES = (
    'Own names and units: [servo_log] with `columns = { time = "millis", position = "angle_*" }`, '
    '`time_unit = "ms"`, `angle_unit = "deg"` (docs/your-csv.md).'
)


@dataclass(frozen=True)
class ServoLog:
    """R rows of m joints, on the servo bus's own clock; repeated: rows that stood there once more, and are left out;
    absent: columns that `[servo_log]` names and the log has not, role by role."""

    time_s: Floats  # (R,)
    position: Floats  # (R, m) [rad]
    command: Floats | None  # (R, m) [rad]
    phase: tuple[str, ...] | None  # approach, play, pause, end
    cycle: Floats | None
    step: Floats | None
    source: str
    repeated: int = 0
    absent: tuple[str, ...] = ()

    @property
    def repeats_commands(self) -> bool:
        """Whether positions are the commands, to the last digit, while these move: no servo is as exact."""
        if self.command is None or not np.isfinite(self.position).any():
            return False
        return np.array_equal(self.position, self.command, equal_nan=True) and bool(np.ptp(self.command, axis=0).any())

    def stopped_in(self, rows: int) -> int | None:
        """The cycle (0, ...) within which play of a table of so many rows ended; None: after a whole one, or unknown.

        A slow log may miss the last rows: as many as it goes on by from one line to the next.
        """
        if self.phase is None or self.cycle is None or self.step is None or "play" not in self.phase:
            return None
        played = np.array([word == "play" for word in self.phase])
        last = self.cycle[played].max()
        if any(word == "pause" for word, cycle in zip(self.phase, self.cycle, strict=True) if cycle >= last):
            return None
        steps = self.step[played & (self.cycle == last)]
        each = np.diff(steps).max(initial=1)
        return int(last) if steps.max() + each < rows else None


@dataclass(frozen=True)
class PowerLog:
    """Electrical power on the power meter's own clock."""

    time_s: Floats
    power_W: Floats
    source: str


def read_servo_log(path: str | Path, keys: ServoKeys = READ_AS_WRITTEN) -> ServoLog:
    """Read a servo log; only time and positions are required; it may end in the middle of a row. A row that is the one
    before to the last character is that row. Voltage, load, current, temperature and errors are not looked at: nothing
    is computed of them, and servos of several models tell several of them."""
    path, own = Path(path), keys.columns
    rows = read_rows(path, live=True)
    header = [cell.strip() for cell in rows[0]]
    position = numbered(header, own.position, "position", path)
    if not position or own.time not in header:
        wanted = f"no column `{own.time}`" if position else f"no column is called `{own.position}`"
        raise InputError(f"{path}: row 1: {wanted}; the log has {shown(header)}. {OWN_NAMES}")
    groups = {"position": position, "command": numbered(header, own.command, "command", path)}
    if groups["command"] and len(groups["command"]) != len(position):
        raise InputError(
            f"{path}: row 1: {counted(len(position), 'column')} `{position[0]}`, ... and {len(groups['command'])} "
            f"`{groups['command'][0]}`, ...: one `command` is needed for every joint."
        )
    refuse_other_unit([own.time], keys.time_unit, SECONDS, "time_unit", path)
    refuse_other_unit([*position, *groups["command"]], keys.angle_unit, RADIANS, "angle_unit", path)
    single = [name for name in (own.cycle, own.step) if name in header]
    called = list(dict.fromkeys([own.time, *single, *(name for names in groups.values() for name in names)]))
    data = block(rows, 1, [find_column(header, name, name, path) for name in called], called, path)
    column = dict(zip(called, data.T, strict=True))
    once = np.array([0, *(i for i in range(1, len(data)) if rows[i + 1] != rows[i])])
    increasing_times(column[own.time][once], 1 + once, header.index(own.time), path, own.time)
    times = column[own.time] * SECONDS[keys.time_unit]
    read = {role: np.stack([column[name] for name in names], axis=1) for role, names in groups.items() if names}
    _refuse_ten_bits(read["position"], keys, path)
    straight, one = keys.scale
    angles = {role: (read[role] - straight) * one for role in ("position", "command") if role in read}
    for role, values in angles.items():
        _check_turn(values, read[role], groups[role], keys.angle_unit, header, path)
    phase = tuple(row[header.index(own.phase)].strip() for row in rows[1:]) if own.phase in header else None
    if phase is not None:
        _check_labels(column, single, phase, header, path)
    return _read_whole(
        ServoLog(
            times,
            angles["position"],
            angles.get("command"),
            phase,
            column.get(own.cycle),
            column.get(own.step),
            str(path),
            len(data) - len(once),
            _absent(own, header, groups["command"]),
        ),
        position,
        once,
    )


def _absent(own: ServoColumns, header: Sequence[str], commands: Sequence[str]) -> tuple[str, ...]:
    """Columns that somebody named and that are not there: what they would tell is not known, and may be misspelt."""
    there = {"command": bool(commands)} | {role: getattr(own, role) in header for role in ("phase", "cycle", "step")}
    return tuple(
        f"`{getattr(own, role)}` ({role})" for role in there if role in own.model_fields_set and not there[role]
    )


def _check_labels(
    column: Mapping[str, Floats], labels: Sequence[str], phase: Sequence[str], header: list[str], path: Path
) -> None:
    """Cycle and step of rows that are played are counted from 0; they say when a trial began."""
    played = np.array([word == "play" for word in phase])
    for name in labels:
        if name in column:
            values = column[name]
            for row in np.flatnonzero(played & ~((values >= 0) & (values == np.floor(values))))[:1]:
                where = place(path, row + 1, header.index(name), name)
                raise InputError(f"{where}: rows that are played count from 0, got {values[row]:g}.")


def _read_whole(log: ServoLog, called: list[str], once: NDArray[np.int64]) -> ServoLog:
    """Of the rows `once`, those in which no reading is missing: what is left out is a gap, as if never written."""
    there = np.isfinite(log.position)
    never = np.flatnonzero(~there.any(axis=0))
    if never.size:
        raise InputError(
            f"{log.source}: column `{called[never[0]]}` is empty throughout. A servo that does not answer? "
            "Leave `servo_log` out, and joint angles are taken from the markers."
        )
    kept = once[there[once].all(axis=1)]
    if len(kept) == len(there):
        return log
    if not kept.size:
        raise InputError(f"{log.source}: in no row is every joint's reading there.")

    def rows(values: Floats | None) -> Floats | None:
        return None if values is None else values[kept]

    return replace(
        log,
        time_s=log.time_s[kept],
        position=log.position[kept],
        command=rows(log.command),
        phase=None if log.phase is None else tuple(log.phase[row] for row in kept),
        cycle=rows(log.cycle),
        step=rows(log.step),
    )


def read_power_log(path: str | Path) -> PowerLog:
    """`t_s` and `power_W`, or `voltage_V` and `current_A`; it may end in the middle of a row."""
    path = Path(path)
    rows = read_rows(path, live=True)
    header = [cell.strip() for cell in rows[0]]
    if "t_s" not in header:
        raise InputError(f"{path}: row 1: a power log has a column `t_s`; it has {', '.join(header)}.")
    called = [name for name in ("t_s", "power_W", "voltage_V", "current_A") if name in header]
    data = block(rows, 1, [find_column(header, name, name, path) for name in called], called, path)
    column = dict(zip(called, data.T, strict=True))
    times = increasing_times(column["t_s"], 1, header.index("t_s"), path, "t_s")
    if "power_W" in column:
        power = column["power_W"]
    elif "voltage_V" in column and "current_A" in column:
        power = column["voltage_V"] * column["current_A"]
    else:
        raise InputError(f"{path}: row 1: a power log has `power_W`, or `voltage_V` and `current_A`; it has {header}.")
    bad = np.flatnonzero(~np.isfinite(power) | (power < 0))
    if bad.size:
        where = place(path, 1 + int(bad[0]), header.index("power_W") if "power_W" in header else 1, "power_W")
        raise InputError(f"{where}: power must be a number >= 0 [W], got {power[bad[0]]:g}.")
    _refuse_spike(power, path, header)
    if np.median(power) > 500:
        raise InputError(f"{path}: median power {np.median(power):g} W: is it in milliwatts? `power_W` is in watts.")
    return PowerLog(times, power, str(path))


def _refuse_spike(power: Floats, path: Path, header: list[str]) -> None:
    """One reading with so much of the recording's energy is a fault of the meter, and would decide every mean."""
    spike = int(power.argmax())
    share = power[spike] / max(power.sum(), 1e-300)
    if power[spike] > LARGEST_W or (power[spike] > SPIKE * np.median(power) and share > SPIKE_SHARE):
        where = place(path, 1 + spike, header.index("power_W") if "power_W" in header else 1, "power_W")
        raise InputError(
            f"{where}: one reading of {power[spike]:g} W has {share:.0%} of the whole recording's energy (median "
            f"{np.median(power):g} W). A fault of the meter? Leave the cell's row out."
        )


def _refuse_ten_bits(read: Floats, keys: ServoKeys, path: Path) -> None:
    """Ticks (R, m) that never leave the first quarter of a turn in any joint: all were bent by 90 degrees and more."""
    said = {"ticks_per_turn", "zero_ticks"} & keys.model_fields_set
    if keys.angle_unit == "ticks" and not said and np.nanmax(read, initial=-np.inf) <= TEN_BITS:
        raise InputError(f"{path}: no position is above {TEN_BITS} ticks, where 2048 is straight. Are these of {AX}?")


def _check_turn(angles: Floats, read: Floats, called: list[str], unit: str, header: list[str], path: Path) -> None:
    """Angles (R, m) [rad], read (R, m) in `unit`, are within a turn."""
    beyond = np.argwhere(np.abs(angles) > LIMIT_RAD)
    if beyond.size:
        row, joint = (int(i) for i in beyond[0])
        label = called[joint]
        ticks = "a servo's ticks (4096 a turn, 2048 is straight; others: `ticks_per_turn`, `zero_ticks`)"
        others = {"deg": "degrees", "ticks": ticks, "rad": "radians"}
        cures = [f'in {words} `angle_unit = "{other}"`' for other, words in others.items() if other != unit]
        raise InputError(
            f"{place(path, row + 1, header.index(label), label)}: joint angles are within a turn, got "
            f'{read[row, joint]:g} with `angle_unit = "{unit}"`. [servo_log] says of a log {", of one ".join(cures)}.'
        )
