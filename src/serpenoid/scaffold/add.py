"""`serpenoid campaign add`: what was played (of an animal nothing) and what the cameras saw become a trial.

What `play` recorded says itself how it was played; of a table that another controller played the caller says it.
"""

from __future__ import annotations

import json
import math
import shutil
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from serpenoid.errors import InputError
from serpenoid.files.alone import alone
from serpenoid.files.inputs import read_json, read_text
from serpenoid.files.schema import plain_name, read_toml, validate
from serpenoid.files.writing import write_text
from serpenoid.measure.campaign import CampaignFile, TrialEntry, load_campaign_file
from serpenoid.measure.trial_files import read_trial
from serpenoid.robot.stated import read_stated
from serpenoid.robot.ticks import coarsest_tick
from serpenoid.scaffold.campaign import BEGIN, END
from serpenoid.table_file import read_table

FILES = {"servo_log": "servo.csv", "power_log": "power.csv", "joint_table": "joint_table.csv"}

WAIT_S = 60.0  # for another process that adds a trial: it reads one film


@dataclass(frozen=True)
class Schedule:
    """How another controller played a table: cycles, rest after each [s], time of one [s] (None: its results say it);
    what its servos read, if they do."""

    cycles: int | None = None
    pause_s: float = 0.0
    cycle_duration_s: float | None = None
    servo_log: Path | None = None


BY_PLAY = Schedule()


@dataclass(frozen=True)
class NewTrial:
    """What is added: `played` a folder that `play` wrote, or a joint table beside a `schedule` (of an animal none),
    `motion` the cameras' file; other keys as in `[[trial]]`."""

    played: Path | None
    motion: Path
    name: str | None = None
    gait: str | None = None
    keys: tuple[tuple[str, Any], ...] = ()  # format, from_s, to_s, ... where given
    anyway: bool = False
    schedule: Schedule = BY_PLAY

    @property
    def by_play(self) -> bool:
        """Whether `play` recorded it."""
        return self.played is not None and self.schedule == BY_PLAY

    @property
    def table(self) -> Path | None:
        """The joint table, in the folder that was named, or what was named itself."""
        return self.played / FILES["joint_table"] if self.played is not None and self.played.is_dir() else self.played


def add_trial(campaign: Path, new: NewTrial) -> str:
    """Copy the files into the campaign's folder and append the trial; returns its name. A fault changes nothing. What
    is added at the same time is added one after the other."""
    file = campaign / "campaign.toml" if campaign.is_dir() else campaign
    load_campaign_file(file)  # of what is no campaign no folder is held
    with alone(file.parent, f"{campaign}: another process adds trials to it. Wait until it has.", WAIT_S):
        return _add_trial(file, new)


def _add_trial(file: Path, new: NewTrial) -> str:
    known, folder = load_campaign_file(file)
    entry = _entry(known, folder, new)
    target = folder / entry["name"]
    place = {key: f"{entry['name']}/{file_name}" for key, (_, file_name) in _sources(new).items()}
    ended = entry.pop("ended", None)
    validate(TrialEntry, entry | place, f"trial `{entry['name']}`")  # of the caller, and not of the campaign's file
    text = _without_example(read_text(file)).rstrip() + "\n\n" + _section(entry | place, ended)
    made = not target.exists()
    if not made and (new.played is None or target.resolve() != new.played.resolve()):
        raise InputError(f"{target}: is there already. Give another --name.")
    target.mkdir(exist_ok=True)
    try:
        _copy(target, new)
        with _told_of_sources(target, new):
            _check(text, file, entry["name"], folder)
        write_text(file, text)
    except BaseException:
        if made:
            shutil.rmtree(target)
        raise
    return str(entry["name"])


def _sources(new: NewTrial) -> dict[str, tuple[Path, str]]:
    """By the key that names it in the trial: each file, and what it is called beside the others."""
    there: dict[str, tuple[Path, str]] = {}
    if new.by_play and new.played is not None:
        there = {key: (new.played / name, name) for key, name in FILES.items() if (new.played / name).is_file()}
    elif new.table is not None:
        there = {"joint_table": (new.table, FILES["joint_table"])}
        if new.schedule.servo_log is not None:
            there["servo_log"] = (new.schedule.servo_log, FILES["servo_log"])
    there["motion"] = (new.motion, new.motion.name)
    names = [name for _, name in there.values()]
    if len(set(names)) < len(names):
        raise InputError(f"{new.motion}: other files of a trial are called {', '.join(names[:-1])}. Rename the film.")
    return there


@contextmanager
def _told_of_sources(target: Path, new: NewTrial) -> Iterator[None]:
    """Faults of copies are told of what was copied: no copy stays."""
    try:
        yield
    except InputError as fault:
        said = str(fault)
        for source, name in _sources(new).values():
            said = said.replace(str(target / name), str(source))
        raise InputError(said) from None


def _copy(target: Path, new: NewTrial) -> None:
    sources = list(_sources(new).values())
    if new.by_play and new.played is not None:
        sources.append((new.played / "play.json", "play.json"))
    for source, name in sources:
        if source.resolve() != (target / name).resolve():
            shutil.copyfile(source, target / name)


def _check(text: str, file: Path, name: str, folder: Path) -> None:
    """The file with the new trial must be valid, and its files what that says of them: units, columns, markers."""
    data = validate(CampaignFile, tomllib.loads(text), str(file))
    read_trial(data, next(trial for trial in data.trial if trial.name == name), folder)


def _entry(known: CampaignFile, folder: Path, new: NewTrial) -> dict[str, Any]:
    """The trial's schedule, and under `ended` how it ended where that is not as asked."""
    if new.played is None and not known.tracked_only:
        raise InputError(
            "LOG is missing: a robot's trial is what `serpenoid play --log` recorded, and its film. Name both. Where "
            "another controller played the robot, name the joint table in place of LOG, and say --cycles, --pause and "
            "--cycle-duration."
        )
    if new.played is None and new.schedule != BY_PLAY:
        raise InputError("--cycles, --pause, --cycle-duration, --servo-log: are of a joint table that a robot played.")
    schedule = _schedule(new)
    name = new.name or (new.played.resolve().name if new.by_play and new.played is not None else new.motion.stem)
    try:
        plain_name(name)
    except ValueError as error:
        raise InputError(f"--name {error}, got {name!r}.") from None
    if name in {trial.name for trial in known.trial}:
        raise InputError(f"the campaign has a trial `{name}` already. Give another --name.")
    for file, what in ((new.motion, "motion file"), (new.schedule.servo_log, "servo log")):
        if file is not None and not file.is_file():
            raise InputError(f"{file}: no such {what}.")
    schedule = {k: schedule[k] for k in ("cycle_duration_s", "cycles", "pause_s", "ended") if k in schedule}
    for key, value in (schedule | dict(new.keys)).items():
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"`{key}` must be a number of seconds, got {value}.")
    gait = new.gait if new.table is None else new.gait or _same_gait(known, folder, new.table) or name
    return {"name": name, **({} if gait is None else {"gait": gait}), **schedule, **dict(new.keys)}


def _schedule(new: NewTrial) -> dict[str, Any]:
    """How it was played, as `play` wrote it, or else as the caller and what is stated of the table say."""
    if new.played is None or new.table is None:
        return {}
    if new.by_play:
        return _played(new.played, new.anyway)
    if (new.played / "play.json").exists():
        raise InputError(f"{new.played}: play.json says how it was played. Leave out --cycles and the others.")
    return _by_another(new.schedule, new.table)


def _by_another(given: Schedule, table: Path) -> dict[str, Any]:
    if not table.is_file():
        raise InputError(f"{table}: no such joint table.")
    read_table(table)
    stated = read_stated(table)
    duration = stated.cycle_duration_s if given.cycle_duration_s is None else given.cycle_duration_s
    if given.cycles is None or duration is None:
        lacking = "--cycles" if given.cycles is None else "--cycle-duration"
        raise InputError(f"{table}: does not say how it was played. Give {lacking}.")
    _refuse_transient(table, stated.transient)
    return {"cycle_duration_s": duration, "cycles": given.cycles, "pause_s": given.pause_s}


def _played(log: Path, anyway: bool) -> dict[str, Any]:
    path = log / "play.json"
    if not path.exists():
        raise InputError(
            f"{path}: no such file. Name a folder that `serpenoid play --log` wrote; of a joint table that another "
            "controller played say --cycles, --pause and --cycle-duration."
        )
    record = read_json(path)
    _refuse_transient(path, isinstance(record, dict) and record.get("transient") is True)
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


def _refuse_transient(path: Path, transient: bool) -> None:
    if transient:
        remedy = "Play it with rows that lead back to the first (docs/campaign-format.md)."
        raise InputError(f"{path}: this trial is a transient, and trials of a campaign play closed tables. {remedy}")


def _same_gait(known: CampaignFile, folder: Path, table: Path) -> str | None:
    """The label of a trial with the same joint table, to the tick."""
    mine = read_table(table)
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
