"""One folder, one answer: who asks something else of a results folder is refused, or has what is there moved aside.

What was asked stands in request.json: the verb, a hash of all that its answer depends on, and the arguments in words;
until the command has ended also that it has not. The same command again goes on or writes the same answer again;
another one needs another --out, or --force.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import shutil
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from serpenoid.cli.asked import INPUTS, asked, difference
from serpenoid.errors import InputError
from serpenoid.files.alone import LOCK, alone
from serpenoid.files.inputs import RECORDING_BYTES, read_bytes, read_json
from serpenoid.files.writing import CHAIN, EARLIER, atomic, clear_unfinished, short_hash, write_json

REQUEST = "request.json"
AT_WORK = "unfinished"  # its key until the command has ended
ASKED = "arguments"  # its key of what the command was given
TABLES = "joint_table.csv", "trajectory.csv"  # that somebody may have made by hand, and play from where they are
# what tells a folder of results from any other
RECORDS = ("solution.json", "set.json", "sweep.json", "campaign.json", "fit.json", "compare.json", "diagnosis.json",
           "in-use.json", "play.json", "campaign.toml", ".arena.json", REQUEST)  # fmt: skip


def claim(args: argparse.Namespace, folder: Path, *key: Any) -> Path:
    """Refuse a folder that answers another request, or move what is in it aside (--force); returns it.

    key: what the answer depends on, JSON values. request.json is written by `sign`. Until the command ends the folder
    is refused to others.
    """
    _hold(args, folder)
    request = {"verb": args.verb, "request": short_hash(*key), ASKED: asked(args)}
    held = [name for name in RECORDS if (folder / name).exists()]
    if held and _question(_held(folder)) != _question(request) and not _is_begun_only(folder):
        _refuse_inputs(args, folder, held)
        if not getattr(args, "force", False):
            raise InputError(
                f"--out {folder}: holds {_words(folder, held, request)}. Name another folder, or move that answer to "
                f"{_aside(folder)} by --force{_kept(args, folder)}."
            )
        move_aside(folder)
    others = [] if held else [name for name in TABLES if (folder / name).exists()]
    if others:
        raise InputError(
            f"--out {folder}: is no results folder, and holds another {' and '.join(others)}. Name another folder."
        )
    clear_unfinished(folder)
    args.requests = [*getattr(args, "requests", []), (folder, request)]
    return folder


def _refuse_inputs(args: argparse.Namespace, folder: Path, held: list[str]) -> None:
    """InputError where the folder holds what somebody recorded, or what this command reads: no --force moves it."""
    if "campaign.toml" in held and not {REQUEST, ".arena.json"} & set(held):
        raise InputError(f"--out {folder}: holds recordings (campaign.toml), and no answer. Name another folder.")
    given = [value for name in INPUTS if (value := getattr(args, name, None)) is not None]
    place = folder.resolve()
    for path in (Path(x) for value in given for x in (value if isinstance(value, list) else [value])):
        if os.path.exists(path) and place in (path.resolve(), *path.resolve().parents):
            raise InputError(f"--out {folder}: holds another answer, and {path}, which is read. Name another folder.")


def _hold(args: argparse.Namespace, folder: Path) -> None:
    if folder in (mine for mine, _ in getattr(args, "requests", [])):
        return
    said = f"--out {folder}: another serpenoid command is at work on it. Name another folder, or wait for its end."
    args.held.enter_context(alone(folder, said))


def place(args: argparse.Namespace, made: Path, folder: Path) -> list[Path]:
    """Move the files in `made` into `folder`; refuse where others of their names are, or move those aside (--force)."""
    names = sorted(path.name for path in made.iterdir())
    others = [n for n in names if (folder / n).exists() and not _alike(folder / n, made / n)]
    if others and not args.force:
        raise InputError(
            f"--out {folder}: holds another {' and '.join(others)}. Name another folder, or move it to "
            f"{_aside(folder)} by --force."
        )
    if others:
        move_aside(folder, [folder / name for name in others])
    for name in names:
        with atomic(folder / name) as temporary:
            shutil.copyfile(made / name, temporary)
    return [folder / name for name in names]


def _alike(one: Path, other: Path) -> bool:
    return one.is_file() and one.read_bytes() == other.read_bytes()


def sign(args: argparse.Namespace) -> None:
    """Write what was asked, before the answer's first file: who is killed or runs out of disk amid it may go on."""
    for folder, request in getattr(args, "requests", []):
        write_json(folder / REQUEST, request | {AT_WORK: True})


def leave_word(args: argparse.Namespace) -> None:
    """Write what was asked where a command was stopped before its answer's first file, for `show`."""
    for folder, request in getattr(args, "requests", []):
        if not any((folder / name).exists() for name in RECORDS):
            with suppress(OSError):
                write_json(folder / REQUEST, request | {AT_WORK: True})


def stopped_verb(folder: Path) -> str:
    """Which verb it was that left its word here, in the words of a sentence's beginning."""
    verb = _verb(folder)
    return "the command" if verb is None else f"`{verb}`"


def _verb(folder: Path) -> str | None:
    request = _held(folder)
    verb = request.get("verb") if isinstance(request, dict) else None
    return verb if isinstance(verb, str) else None


def _is_begun_only(folder: Path) -> bool:
    """Whether all that is here is the word of a command that was stopped before its answer's first file."""
    return is_unfinished(folder) and {path.name for path in folder.iterdir()} <= {REQUEST, LOCK}


def finish(args: argparse.Namespace) -> None:
    """Write that what was signed is whole, after the answer's last file."""
    for folder, request in getattr(args, "requests", []):
        if is_unfinished(folder):
            write_json(folder / REQUEST, request)


def is_unfinished(folder: Path) -> bool:
    """Whether the command that writes this folder has not ended, or was ended from outside or by a full disk."""
    request = _held(folder)
    return isinstance(request, dict) and request.get(AT_WORK) is True


def content_of(*paths: Path) -> list[str]:
    """Hashes of files; a part of a key."""
    return [hashlib.sha256(read_bytes(path, RECORDING_BYTES)).hexdigest() for path in paths]


def content_of_campaign(campaign: str | Path) -> list[str]:
    """Hashes of campaign.toml and of every file that it names."""
    from serpenoid.measure.campaign import load_campaign_file

    file, folder = load_campaign_file(campaign)
    named = sorted({name for t in file.trial for name in (t.joint_table, t.motion, t.servo_log, t.power_log) if name})
    return [short_hash(file.model_dump(mode="json")), *content_of(*(folder / name for name in named))]


def _held(folder: Path) -> Any:
    try:
        return read_json(folder / REQUEST)
    except InputError:
        return None


def _question(request: Any) -> Any:
    told = AT_WORK, ASKED
    return {k: v for k, v in request.items() if k not in told} if isinstance(request, dict) else request


def _words(folder: Path, held: list[str], request: dict[str, Any]) -> str:
    verb = _verb(folder)
    if verb is None:
        return f"another answer ({held[0]})"
    other = difference(_held(folder).get(ASKED), request[ASKED]) if verb == request["verb"] else ""
    if held == [REQUEST]:
        return f"what another `{verb}` left that was ended before its answer was whole{other}"
    return f"the answer of another `{verb}`{other}"


def _kept(args: argparse.Namespace, folder: Path) -> str:
    """What --force leaves where it is, for the next answer of the same verb."""
    if _verb(folder) != args.verb or not has_solved(folder):
        return ""
    return "; what is solved there stays, and is not solved again where this command asks for it, too"


def has_solved(folder: Path) -> bool:
    """Whether a results folder keeps solved points of a sweep or of many starts."""
    return any((folder / CHAIN).glob("*.npz"))


def _aside(folder: Path) -> Path:
    return next(path for path in _names(folder) if not path.exists())


def _names(folder: Path) -> Iterator[Path]:
    number = 1
    while True:
        yield folder / f"{EARLIER}{number}"
        number += 1


def move_aside(folder: Path, found: Sequence[Path] | None = None) -> None:
    """These files, or all but what was moved before: nothing is lost, and no figure of an earlier answer stays beside.

    A sweep's solved points stay: each is checked against the problem when it is taken up.
    """
    if found is None:
        found = [path for path in folder.iterdir() if not path.name.startswith((EARLIER, CHAIN, LOCK))]
    place = _aside(folder)
    place.mkdir()
    for path in found:
        path.rename(place / path.name)
