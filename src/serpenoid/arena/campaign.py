"""A whole campaign: every trial of a protocol in its own folder, several at a time, resumable, never half written."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import numpy as np

from serpenoid.arena import mujoco_module
from serpenoid.arena.cameras import ASSET, film, marker_names, write_motive
from serpenoid.arena.logs import write_power_log, write_servo_log
from serpenoid.arena.protocol import Protocol
from serpenoid.arena.trial import Plan, Recording, plans, play, randomness
from serpenoid.body import Floats
from serpenoid.errors import InputError, StopRequested
from serpenoid.files.alone import LOCK
from serpenoid.files.inputs import read_json
from serpenoid.files.writing import EARLIER, atomic, short_hash, toml_string, write_json, write_text
from serpenoid.parallel import Workers, results
from serpenoid.table_file import write_table

RECEIPT = ".arena.json"  # what the folder was made from, so that it can be continued
UNFINISHED = ".unfinished-"
ALONE = Workers()
Report = Callable[[int, str], None]  # trials finished, name of the last


def run_campaign(
    protocol: Protocol,
    tables: dict[str, Floats],
    folder: Path,
    *,
    workers: Workers = ALONE,
    truth: Path | None = None,
    report: Report = lambda finished, name: None,
) -> Path:
    """Play what is not yet in `folder` and describe all of it in campaign.toml; raise StopRequested on Ctrl-C."""
    mujoco_module()
    if (other := another(protocol, tables, folder)) is not None:
        raise InputError(f"--out {folder}: {other}. Name another folder, or move what is in it aside by --force.")
    write_json(folder / RECEIPT, _receipt(protocol, tables))
    _sweep(folder)
    for name, table in tables.items():
        write_table(folder / "gaits" / f"{name}.csv", table)
    wanted = plans(protocol)
    missing = [plan for plan in wanted if not (folder / plan.name).is_dir()]
    finished = len(wanted) - len(missing)
    report(finished, "")
    try:
        tasks = [(protocol, plan, tables[plan.gait], folder, truth) for plan in missing]
        for _, name in results(run_trial, tasks, workers):
            finished += 1
            report(finished, name)
    except KeyboardInterrupt:
        kept = "the finished trials are kept" if finished else "no trial was finished"
        raise StopRequested(f"{folder}: {kept}; run the same command to continue.") from None
    finally:
        _sweep(folder)
        done = [plan for plan in wanted if (folder / plan.name).is_dir()]
        if done:
            write_text(folder / "campaign.toml", campaign_toml(protocol, done))
    return folder


def another(protocol: Protocol, tables: dict[str, Floats], folder: Path) -> str | None:
    """What else `folder` holds; None where it is free, or a campaign of this protocol was begun in it."""
    receipt = folder / RECEIPT
    if receipt.is_file():
        try:
            mine = read_json(receipt) == _receipt(protocol, tables)
        except InputError:
            return f"its {RECEIPT} is damaged, so nothing says what it holds"
        return None if mine else "holds a campaign of another protocol"
    free = not folder.exists() or (
        folder.is_dir() and all(p.name.startswith((EARLIER, LOCK)) for p in folder.iterdir())
    )
    if not free:
        return "is not empty and not a campaign of the arena"
    return None


def _receipt(protocol: Protocol, tables: dict[str, Floats]) -> dict[str, str]:
    return {"protocol": short_hash(protocol.model_dump(), {name: table.tolist() for name, table in tables.items()})}


def _sweep(folder: Path) -> None:
    """Remove what an interruption left unfinished."""
    for leftover in folder.glob(f"{UNFINISHED}*"):
        shutil.rmtree(leftover)


def run_trial(protocol: Protocol, plan: Plan, table: Floats, folder: Path, truth: Path | None) -> str:
    """Play one trial and put its folder in place, whole."""
    recording = play(protocol, plan, table)
    part = Path(tempfile.mkdtemp(prefix=f"{UNFINISHED}{plan.name}-", dir=folder))
    part.chmod(0o755)
    cameras, logs = protocol.cameras, protocol.logs
    tracks = film(recording.markers, marker_names(protocol.robot), cameras, randomness(protocol, plan, 3))
    write_motive(part / "motion.csv", tracks, cameras.frames_per_second, plan.name, "2025-01-01 12.00.00.000 PM")
    write_servo_log(part / "servo.csv", recording, table, logs, randomness(protocol, plan, 4))
    write_power_log(part / "power.csv", recording, logs, randomness(protocol, plan, 5))
    if truth is not None:
        _write_truth(truth / f"{plan.name}.npz", recording)
    try:
        part.rename(folder / plan.name)
    except OSError:
        if not (folder / plan.name).is_dir():
            raise
        shutil.rmtree(part, ignore_errors=True)  # a worker that outlived its command was quicker: the same trial
    return plan.name


def _write_truth(path: Path, recording: Recording) -> None:
    arrays = {name: value for name, value in vars(recording).items() if name != "commands"}
    with atomic(path) as temporary, temporary.open("wb") as stream:
        np.savez_compressed(stream, commands=json.dumps([asdict(c) for c in recording.commands[1:]]), **arrays)


def campaign_toml(protocol: Protocol, done: list[Plan]) -> str:
    """The description of the folder; it says nothing about the robot that a laboratory would not know."""
    robot = protocol.robot
    text = [
        "format = 1",
        f"name = {toml_string(protocol.name)}",
        f"description = {toml_string(protocol.description)}",
        "",
        "[body]",
        f"vertices = {robot.wheels}",
        *([] if robot.servos == robot.wheels - 2 else [f"joints = {list(robot.links.joints)}"]),
        f"edge_lengths = {_numbers(robot.edge_lengths_m)}",
        f"weights = {_numbers(robot.vertex_masses_kg)}",
        f"mass_kg = {robot.mass_kg}",
        "",
        "[motion]",
        'format = "motive"',
        'length_unit = "m"',
        'up_axis = "y"',
        f"markers = {json.dumps([f'{ASSET}:{name}' for name in marker_names(robot)])}",
        f"frames_per_second = {protocol.cameras.frames_per_second}",
    ]
    for plan in done:
        text += [
            "",
            "[[trial]]",
            f'name = "{plan.name}"',
            f'gait = "{plan.gait}"',
            f'joint_table = "gaits/{plan.gait}.csv"',
            f"cycle_duration_s = {plan.cycle_duration_s}",
            f"cycles = {protocol.cycles}",
            f"pause_s = {protocol.pause_s}",
            *(f'{key} = "{plan.name}/{file}.csv"' for key, file in FILES.items()),
        ]
    return "\n".join(text) + "\n"


FILES = {"motion": "motion", "servo_log": "servo", "power_log": "power"}


def _numbers(values: Floats) -> str:
    return "[" + ", ".join(f"{value:.6g}" for value in values) + "]"
