"""`serpenoid campaign add`: what `play` recorded (of an animal nothing) and what the cameras saw become a trial."""

from __future__ import annotations

import json
import shutil
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.inputs import read_json, read_text
from serpenoid.files.schema import plain_name, read_toml, validate
from serpenoid.files.writing import write_text
from serpenoid.measure.campaign import CampaignFile, load_campaign_file, read_motion
from serpenoid.robot.ticks import coarsest_tick
from serpenoid.scaffold.campaign import BEGIN, END
from serpenoid.table_file import read_table

FILES = {"servo_log": "servo.csv", "power_log": "power.csv", "joint_table": "joint_table.csv"}


@dataclass(frozen=True)
class NewTrial:
    """What is added: `log` a folder that `play` wrote (of an animal none), `motion` the cameras' file; other keys as in
    `[[trial]]`."""

    log: Path | None
    motion: Path
    name: str | None = None
    gait: str | None = None
    keys: tuple[tuple[str, Any], ...] = ()  # format, from_s, to_s, ... where given
    anyway: bool = False


def add_trial(campaign: Path, new: NewTrial) -> str:
    """Copy the files into the campaign's folder and append the trial; returns its name. A fault changes nothing."""
    file = campaign / "campaign.toml" if campaign.is_dir() else campaign
    known, folder = load_campaign_file(campaign)
    entry = _entry(known, folder, new)
    target = folder / entry["name"]
    place = {key: f"{entry['name']}/{source.name}" for key, source in _sources(new).items()}
    ended = entry.pop("ended", None)
    text = _without_example(read_text(file)).rstrip() + "\n\n" + _section(entry | place, ended)
    made = not target.exists()
    if not made and (new.log is None or target.resolve() != new.log.resolve()):
        raise InputError(f"{target}: is there already. Give another --name.")
    target.mkdir(exist_ok=True)
    try:
        _copy(target, new)
        _check(text, file, entry["name"], folder)
        write_text(file, text)
    except BaseException:
        if made:
            shutil.rmtree(target)
        raise
    return str(entry["name"])


def _sources(new: NewTrial) -> dict[str, Path]:
    log = new.log
    there = {} if log is None else {key: log / name for key, name in FILES.items() if (log / name).is_file()}
    return there | {"motion": new.motion}


def _copy(target: Path, new: NewTrial) -> None:
    for source in (*_sources(new).values(), *([] if new.log is None else [new.log / "play.json"])):
        if source.resolve() != (target / source.name).resolve():
            shutil.copyfile(source, target / source.name)


def _check(text: str, file: Path, name: str, folder: Path) -> None:
    """The file with the new trial must be valid, and its motion readable."""
    data = validate(CampaignFile, tomllib.loads(text), str(file))
    read_motion(data, next(trial for trial in data.trial if trial.name == name), folder)


def _entry(known: CampaignFile, folder: Path, new: NewTrial) -> dict[str, Any]:
    """The trial's schedule from what `play` wrote, and under `ended` how it ended where that is not as asked."""
    if new.log is None and not known.tracked_only:
        raise InputError(
            "LOG is missing: a robot's trial is what `serpenoid play --log` recorded, and its film. Name both."
        )
    played = {} if new.log is None else _played(new.log, new.anyway)
    name = new.name or (new.motion.stem if new.log is None else new.log.resolve().name)
    try:
        plain_name(name)
    except ValueError as error:
        raise InputError(f"--name {error}, got {name!r}.") from None
    if name in {trial.name for trial in known.trial}:
        raise InputError(f"the campaign has a trial `{name}` already. Give another --name.")
    if not new.motion.is_file():
        raise InputError(f"{new.motion}: no such motion file.")
    schedule: dict[str, Any] = {k: played[k] for k in ("cycle_duration_s", "cycles", "pause_s", "ended") if k in played}
    gait = new.gait if new.log is None else new.gait or _same_gait(known, folder, new.log) or name
    return {"name": name, **({} if gait is None else {"gait": gait}), **schedule, **dict(new.keys)}


def _played(log: Path, anyway: bool) -> dict[str, Any]:
    path = log / "play.json"
    if not path.exists():
        raise InputError(f"{path}: no such file. Name a folder that `serpenoid play --log` wrote.")
    record = read_json(path)
    _refuse_transient(path, record)
    try:
        trial = read_toml(log / "trial.toml")["trial"][0]
    except (KeyError, IndexError, TypeError) as error:
        raise InputError(f"{log}: is no recording of `serpenoid play` ({error}).") from None
    status, reason = (record.get("status"), record.get("reason", "")) if isinstance(record, dict) else (None, "")
    if status == "done":
        return dict(trial)
    if not anyway:
        remedy = "Play it again, or take it --anyway."
        raise InputError(f"{path}: this trial was not played as asked ({status}: {reason}). {remedy}")
    return dict(trial) | {"ended": " ".join(f"{status}: {reason}".split())}


def _refuse_transient(path: Path, record: Any) -> None:
    if isinstance(record, dict) and record.get("transient") is True:
        remedy = "Play it with rows that lead back to the first (docs/campaign-format.md)."
        raise InputError(f"{path}: this trial is a transient, and trials of a campaign play closed tables. {remedy}")


def _same_gait(known: CampaignFile, folder: Path, log: Path) -> str | None:
    """The label of a trial with the same joint table, to the tick."""
    mine = read_table(log / "joint_table.csv")
    for trial in known.trial:
        if trial.gait is not None and trial.joint_table is not None and trial.name != "example":
            theirs = read_table(folder / trial.joint_table)
            if theirs.shape == mine.shape and np.abs(theirs - mine).max() <= coarsest_tick():
                return trial.gait
    return None


def _without_example(text: str) -> str:
    begin, end = text.find(BEGIN), text.find(END)
    return text if begin < 0 or end < begin else text[:begin] + text[end + len(END) :].lstrip("\n")


def _section(entry: dict[str, Any], ended: str | None) -> str:
    lines = [f"{key} = {json.dumps(value, ensure_ascii=False)}" for key, value in entry.items()]
    return "\n".join([*([f"# {ended}"] if ended else []), "[[trial]]", *lines]) + "\n"
