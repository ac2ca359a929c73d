"""The servo log: one line per reading, on disk before the next row is sent (docs/campaign-format.md).

A log that ends in the middle of a line lost that line and no other.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Self, TextIO

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.robot.bus import ServoState
from serpenoid.robot.description import Robot
from serpenoid.robot.faults import RobotFault
from serpenoid.robot.ticks import to_radians

LINE_BYTES = len("10000.000000,approach,1000,1000\n")
JOINT_BYTES = len(",-0.516952,-0.516952,11.8,-0.123,30,0")  # as GROUPS, which `write` writes
GROUPS = ("command", "position", "voltage", "effort", "temperature", "error")


class ServoLog:
    """Appends to `servo.csv` in `folder`, from `begin()` on; `folder` None writes nothing."""

    def __init__(self, folder: Path | None, robot: Robot) -> None:
        self._robot = robot
        self._path = None if folder is None else check_new(folder / "servo.csv")
        self._start = time.monotonic()
        self.rows = 0
        self._stream: TextIO | None = None

    @property
    def begun(self) -> bool:
        """Whether there is a recording."""
        return self._stream is not None

    def check_room(self, readings: int) -> None:
        """InputError where so many of them have no room on the disk; nothing is created."""
        if self._path is None:
            return
        there = next(folder for folder in self._path.absolute().parents if folder.exists())
        needed, free = readings * (LINE_BYTES + JOINT_BYTES * len(self._robot.joint)), shutil.disk_usage(there).free
        if needed > free:
            raise InputError(
                f"{self._path}: the recording takes up to {_size(needed)}, {_size(free)} are free. Make room, play "
                "fewer cycles, or choose another --log folder."
            )

    def begin(self) -> None:
        """Create the file; time zero is now."""
        self._start = time.monotonic()
        if self._path is not None:
            self._stream = open_new(self._path)
            columns = [f"{self._column(group, j)}_{j + 1}" for group in GROUPS for j in range(len(self._robot.joint))]
            self._put(",".join(["t_s", "phase", "cycle", "step", *columns]))

    def _column(self, group: str, joint: int) -> str:
        """A servo's effort is called what it is: `load`, or `current` where it measures that."""
        return self._robot.servos[joint].effort.column if group == "effort" else group

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._stream is not None:
            with contextlib.suppress(OSError):  # a full disk was reported when it was met
                self._stream.close()

    def write(
        self,
        moment: float,
        place: tuple[str, int, int],
        goals: NDArray[np.int64],
        states: Mapping[int, ServoState],
        errors: Mapping[int, int],
    ) -> None:
        """`moment`: monotonic time [s]; `place`: phase, cycle, step; `goals` (m,) [ticks]; the rest by servo ID."""
        self.rows += 1
        if self._stream is None:
            return
        servos = [states[servo_id] for servo_id in self._robot.ids]
        commanded = to_radians(goals, self._robot)
        measured = to_radians([servo.position for servo in servos], self._robot)
        cells = [f"{moment - self._start:.6f}", *map(str, place)]
        cells += [f"{angle:.6f}" for angle in (*commanded, *measured)]
        cells += [f"{servo.voltage:.1f}" for servo in servos]
        cells += [f"{servo.effort:.3f}" for servo in servos]
        cells += [str(servo.temperature) for servo in servos]
        cells += [str(errors.get(servo_id, 0)) for servo_id in self._robot.ids]
        self._put(",".join(cells))

    def _put(self, line: str) -> None:
        stream = self._stream
        if stream is None:
            return
        try:
            stream.write(line + "\n")
            stream.flush()
        except OSError as error:
            raise RobotFault(f"{self._path}: cannot be written any more ({error.strerror}). Make room.") from None


def check_new(path: Path) -> Path:
    """The path itself, if a recording could be made there; nothing is created. InputError else."""
    there = next(folder for folder in path.absolute().parents if folder.exists())
    if path.exists():
        raise InputError(_taken(path))
    if os.path.lexists(path.parent) and not path.parent.exists():
        raise InputError(f"--log {path.parent}: is a link to what is not there. Choose another --log folder.")
    try:
        with tempfile.TemporaryFile(dir=there):
            return path
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}). Choose another --log folder.") from None


def _taken(path: Path) -> str:
    return f"{path}: a recording is already there. Choose another --log folder for this trial."


def open_new(path: Path) -> TextIO:
    """Open a text file that must not exist yet: a recording is never overwritten."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("x", encoding="utf-8", newline="\n")
    except FileExistsError:
        raise InputError(_taken(path)) from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror}). Choose another --log folder.") from None


def _size(count: int) -> str:
    return f"{count / 1e6:.1f} MB" if count >= 1e6 else f"{count / 1e3:.0f} kB"
