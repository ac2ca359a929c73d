"""The robot's own files: the servo log as `play` writes it, and the power sensor's log, each on its own clock."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from serpenoid.arena.protocol import Logs
from serpenoid.arena.trial import Recording, commanded_angles
from serpenoid.body import Floats
from serpenoid.files.writing import write_csv

ROOM_C, HOT_C_PER_W = 31, 0.4  # servo case: idle, and per watt drawn by all of them


def write_servo_log(path: Path, recording: Recording, table: Floats, logs: Logs, random: np.random.Generator) -> None:
    """Readings at `servo_hz`; positions in ticks, voltage in tenths, load in thousandths, as the servos give them."""
    columns = ("command", "position", "voltage", "load", "temperature", "error")
    servos = recording.angles.shape[1]
    names = [f"{column}_{number}" for column in columns for number in range(1, servos + 1)]
    picked = _picked(recording.time_s, logs.servo_hz)
    clock = random.uniform(0, logs.clocks_differ_s) if logs.clocks_differ_s else 0.0
    command = commanded_angles(recording, table)
    voltage = np.round(recording.voltage_V, 1)
    load = np.round(np.clip(recording.duty, -1, 1), 3)
    warmth = round(ROOM_C + HOT_C_PER_W * float(recording.power_W.mean()))
    rows = [
        [
            round(float(recording.time_s[i]) + clock, 6),
            *_place(recording, i),
            *(round(value, 6) for value in command[i].tolist()),
            *(round(value, 6) for value in recording.angles[i].tolist()),
            *[float(voltage[i])] * servos,
            *load[i].tolist(),
            *[warmth] * servos,
            *[0] * servos,
        ]
        for i in picked
    ]
    write_csv(path, ["t_s", "phase", "cycle", "step", *names], rows)


def _place(recording: Recording, index: int) -> tuple[str, int, int]:
    command = recording.commands[recording.command[index]]
    return command.phase, command.cycle, command.step


def write_power_log(path: Path, recording: Recording, logs: Logs, random: np.random.Generator) -> None:
    """The sensor averages over each of its intervals; volts in 1.25 mV, amperes in 1.25 mA steps (INA260)."""
    clock = random.uniform(0, logs.clocks_differ_s) if logs.clocks_differ_s else 0.0
    edges = np.arange(0, recording.time_s[-1], 1 / logs.power_hz)
    power = _averaged(recording.time_s, recording.power_W, edges)
    power = power + random.normal(0, logs.power_noise_W, len(power))
    volts = np.round(_averaged(recording.time_s, recording.voltage_V, edges) / 0.00125) * 0.00125
    amperes = np.round(power / volts / 0.00125) * 0.00125
    rows = zip(edges[1:] + clock, volts, amperes, volts * amperes, strict=True)
    header = ["t_s", "voltage_V", "current_A", "power_W"]
    write_csv(path, header, [[round(float(cell), 6) for cell in row] for row in rows])


def _picked(time_s: Floats, rate_hz: float) -> list[int]:
    """Indices of the samples next to each tick of a slower clock."""
    ticks = np.arange(0, time_s[-1], 1 / rate_hz)
    return np.unique(np.searchsorted(time_s, ticks - 1e-9)).tolist()


def _averaged(time_s: Floats, values: Floats, edges: Floats) -> Floats:
    """Mean of `values` between neighbouring `edges`."""
    sums = np.concatenate([[0.0], np.cumsum(values * np.gradient(time_s))])
    at = np.interp(edges, np.concatenate([time_s, [2 * time_s[-1] - time_s[-2]]]), sums)
    return np.diff(at) / np.diff(edges)
