"""Recordings that are another trial's, number by number: as repeats they would tell that chance is nothing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from hashlib import sha256

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.blame import Contradiction
from serpenoid.measure.trial_files import Files

Numbers = Callable[[Files], Floats | None]


def copied_films(read: Sequence[Files]) -> list[Contradiction]:
    """Two trials with the same numbers are one."""
    cure = "name its own, or leave it out; of one that shows both, give each its part by `from_s` and `to_s`"
    return [_copy(files, other, "recording", cure) for files, other in _alike(read, _film)]


def copied_logs(read: Sequence[Files]) -> list[tuple[Contradiction, str]]:
    """Logs that are another trial's, with that trial: servos read alike twice no more than cameras see alike. Parts of
    one film may have one log."""
    found = []
    logs: dict[str, Numbers] = {"servo_log": _servos, "power_log": _power}
    for key, numbers in logs.items():
        cure = f"which of the two is it of? Name each trial's own in `{key}`, or leave it out"
        for files, other in _alike(read, numbers):
            if not (files.tracks and other.tracks and files.tracks.source == other.tracks.source):
                found.append((_copy(files, other, key.replace("_", " "), cure), other.entry.name))
    return found


def _alike(read: Sequence[Files], numbers: Numbers) -> list[tuple[Files, Files]]:
    """Trials whose numbers are those of an earlier one, with that one."""
    first: dict[bytes, Files] = {}
    found = []
    for files in read:
        if (mine := numbers(files)) is not None:
            other = first.setdefault(sha256(mine.tobytes()).digest(), files)
            found += [(files, other)] if other is not files else []
    return found


def _copy(files: Files, other: Files, what: str, cure: str) -> Contradiction:
    words = f"its {what} is that of trial `{other.entry.name}`, number by number"
    return Contradiction(files.entry.name, "copy", words, cure, np.inf)


def _film(files: Files) -> Floats | None:
    tracks = files.tracks
    return None if tracks is None else np.column_stack([tracks.time_s, tracks.floor.reshape(len(tracks.time_s), -1)])


def _servos(files: Files) -> Floats | None:
    log = files.servo_log
    return None if log is None else np.column_stack([log.time_s, log.position])


def _power(files: Files) -> Floats | None:
    log = files.power_log
    return None if log is None else np.column_stack([log.time_s, log.power_W])
