"""A rehearsal: the model's own motion written as a laboratory would record it, so that every number has a known truth.

The robot follows the table exactly (or with a lag), slips as the model says, is seen by cameras with noise and
drop-outs, and logs servos and power on clocks of their own.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.files.writing import write_csv, write_text
from serpenoid.measure.logs import TICK
from serpenoid.measure.schedule import Schedule, play_record
from serpenoid.measure.write import write_motive, write_power_log, write_servo_log
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles

FINER = 8  # steps a frame: what the mesh of the truth misses is then well below the interval of eps


@dataclass(frozen=True)
class Laboratory:
    """What the cameras and logs do to the truth."""

    frames_per_second: float = 120.0
    marker_sd_m: float = 0.0002
    hidden_share: float = 0.05
    servo_log_hz: float = 50.0
    servo_clock_s: float = 3.7  # camera clock minus servo clock
    power_clock_s: float = -12.4
    lag_s: float = 0.0  # first-order servo lag
    still_s: float = 0.5  # recorded before the first and after the last command
    idle_W: float = 4.0
    dissipation_W: float = 30.0  # per unit of dissipation rate [1/s^2]


@dataclass(frozen=True)
class Rehearsal:
    """The truth behind one trial."""

    time_s: Floats
    joint_angles: Floats
    poses: Floats
    vertices: Floats  # (F, N, 2) [body lengths]
    power_W: Floats


def rehearse(model: Model, schedule: Schedule, lab: Laboratory, start: Floats | None = None) -> Rehearsal:
    """The motion on the cameras' own time grid, from `still_s` before the first command."""
    end = schedule.end_s + lab.still_s
    often, some = FINER * lab.frames_per_second, slice(None, None, FINER)
    time = np.arange(schedule.start_s - lab.still_s, end, 1 / often)
    angles = _lagged(schedule.commanded(time), lab.lag_s * often)
    motion = simulate_joint_angles(model, angles, start=start, closed=False)
    power = lab.idle_W + lab.dissipation_W * np.append(motion.step_energy * often**2, 0.0)
    return Rehearsal(time[some], angles[some], motion.poses[some], motion.vertices[some], power[some])


def write_trial(folder: Path, name: str, model: Model, schedule: Schedule, lab: Laboratory, seed: int) -> Rehearsal:
    """Write `<name>/motion.csv`, `servo.csv` and `power.csv` (schedule and recording on the cameras' clock)."""
    rng = np.random.default_rng(seed)
    start = np.array([*rng.uniform(-0.5, 0.5, 2), rng.uniform(-np.pi, np.pi)])
    truth = rehearse(model, schedule, lab, start)
    length = model.body.total_length_m
    seen = truth.vertices * length + rng.normal(scale=lab.marker_sd_m, size=truth.vertices.shape)
    seen[rng.random(seen.shape[:2]) < lab.hidden_share] = np.nan
    markers = [f"Snake:vertex_{k}" for k in range(model.body.vertices)]
    write_motive(folder / name / "motion.csv", truth.time_s - truth.time_s[0], seen, markers)
    log_time, labels = play_record(schedule, lab.servo_log_hz)
    at = log_time + schedule.start_s
    position = np.stack([np.interp(at, truth.time_s, column) for column in truth.joint_angles.T], axis=1)
    ticks = np.round(position / TICK) * TICK
    own_clock = at - truth.time_s[0] - lab.servo_clock_s
    write_servo_log(folder / name / "servo.csv", own_clock, ticks, schedule.commanded(at), labels)
    power_time = np.arange(truth.time_s[0], truth.time_s[-1], 0.05)
    power = np.interp(power_time, truth.time_s, truth.power_W)
    write_power_log(folder / name / "power.csv", power_time - truth.time_s[0] - lab.power_clock_s, power)
    return truth


def write_campaign(
    folder: Path, model: Model, tables: dict[str, Floats], lab: Laboratory, trials: int, seed: int,
    cycle_duration_s: float = 5.0, cycles: int = 3, pause_s: float = 2.0,
) -> dict[str, Rehearsal]:  # fmt: skip
    """A whole campaign of `trials` repeats of every table; returns the truth of every trial."""
    truths, entries = {}, []
    for gait, table in tables.items():
        header = [f"joint_{j}" for j in range(1, table.shape[1] + 1)]
        write_csv(folder / "gaits" / f"{gait}.csv", header, table.tolist())
        for repeat in range(trials):
            name, seed = f"{gait}-{repeat + 1}", seed + 1
            schedule = Schedule(table, cycle_duration_s, cycles, pause_s)
            truths[name] = write_trial(folder, name, model, schedule, lab, seed)
            entries.append(
                f'[[trial]]\nname = "{name}"\ngait = "{gait}"\njoint_table = "gaits/{gait}.csv"\n'
                f"cycle_duration_s = {cycle_duration_s}\ncycles = {cycles}\npause_s = {pause_s}\n"
                f'motion = "{name}/motion.csv"\nservo_log = "{name}/servo.csv"\npower_log = "{name}/power.csv"\n'
            )
    write_text(folder / "campaign.toml", _head(model) + "\n".join(entries))
    return truths


def _head(model: Model) -> str:
    body = model.body
    markers = ", ".join(f'"Snake:vertex_{k}"' for k in range(body.vertices))
    mass = f"mass_kg = {body.mass_kg}\n" if body.mass_kg else ""
    return (
        'format = 1\nname = "rehearsal"\ndescription = "the model\'s own motion, recorded as a laboratory would"\n\n'
        f"[body]\nvertices = {body.vertices}\nedge_lengths = {body.edges_m.tolist()}\n"
        f"weights = {body.vertex_weights.tolist()}\n{mass}\n"
        f'[motion]\nformat = "motive"\nup_axis = "y"\nmarkers = [{markers}]\n\n'
    )


def _lagged(command: Floats, rows: float) -> Floats:
    """First-order lag by so many rows; zero gives the command itself."""
    if rows <= 0:
        return command
    follow = 1 - np.exp(-1 / rows)
    angles = command.copy()
    for row in range(1, len(angles)):
        angles[row] = angles[row - 1] + follow * (command[row] - angles[row - 1])
    return angles
