"""A robot for the tests: emulated servos in a process of their own, `serpenoid` in another."""

from __future__ import annotations

import csv
import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from robot import servo_process
from robot.servo_process import HeardChain
from serpenoid.files.schema import load
from serpenoid.robot.description import Robot
from serpenoid.robot.emulator.faults import parse_fault
from serpenoid.robot.emulator.servo import EmulatedServo
from serpenoid.robot.models import DEFAULT, ServoModel, models
from serpenoid.robot.table import write_table

ROOT = Path(__file__).parents[2]
ROBOT_FILE = ROOT / "problems" / "robots" / "snake10-robot.toml"
XL430 = models()[DEFAULT]
LOWEST, HIGHEST = 1138, 2958  # the robot file's limits


def robot() -> Robot:
    return load(Robot, ROBOT_FILE)


def gait(steps: int = 20, amplitude: float = 0.15, joints: int = 10) -> np.ndarray:
    """A travelling wave, (steps, joints) [rad]."""
    phase = np.arange(steps)[:, None] / steps + np.arange(joints) / 10
    return amplitude * np.sin(2 * np.pi * phase)


def write_gait(folder: Path, **shape: float) -> Path:
    write_table(folder / "gait.csv", gait(**shape))
    return folder / "gait.csv"


def make_chain(faults: Sequence[str] = (), baud_rate: int = 1000000, position: float = 2048.0) -> HeardChain:
    return make_chain_of([XL430] * 10, faults, baud_rate, position)


def make_chain_of(
    kinds: Sequence[ServoModel], faults: Sequence[str] = (), baud_rate: int = 1000000, position: float = 2048.0
) -> HeardChain:
    """Servos of any models with IDs 1, 2, ..."""
    codes = [{rate: code for code, rate in kind.baud_rates.items()}[baud_rate] for kind in kinds]
    servos = [
        EmulatedServo(kind, i, code, position) for i, (kind, code) in enumerate(zip(kinds, codes, strict=True), 1)
    ]
    return HeardChain(servos, baud_rate, [parse_fault(text) for text in faults])


class Emulator:
    """The asking end of `servo_process`."""

    def __init__(self, process: subprocess.Popen[bytes]) -> None:
        self._process = process
        self.port: str = self._answer()

    def _answer(self) -> Any:
        assert self._process.stdout is not None
        return pickle.load(self._process.stdout)

    def do(self, what: Callable[..., Any], *words: object) -> Any:
        """`what(chain, *words)`, a function of `servo_process`, where the servos are."""
        assert self._process.stdin is not None
        pickle.dump((what, words), self._process.stdin)
        self._process.stdin.flush()
        return self._answer()

    @property
    def chain(self) -> HeardChain:
        """A copy of the servos as they are now: to look at."""
        chain: HeardChain = self.do(servo_process.itself)
        return chain

    @property
    def torques(self) -> list[bool]:
        return [servo.torque for servo in self.chain.servos]

    def check_limits(self) -> None:
        for servo in self.chain.servos:
            assert servo.lowest >= LOWEST, servo.id
            assert servo.highest <= HIGHEST, servo.id


@contextmanager
def emulator(folder: Path, *faults: str, baud_rate: int = 1000000) -> Iterator[Emulator]:
    """Serves on `folder`/port until the block ends."""
    with serving(make_chain(faults, baud_rate), folder, baud_rate) as rig:
        yield rig


@contextmanager
def serving(chain: HeardChain, folder: Path, baud_rate: int = 1000000) -> Iterator[Emulator]:
    """The same with servos of one's own."""
    words = [sys.executable, "-m", servo_process.__name__]
    places = {"PYTHONPATH": os.pathsep.join(map(str, (ROOT / "src", ROOT / "tests")))}
    with subprocess.Popen(words, env=os.environ | places, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin is not None
        pickle.dump((chain, baud_rate, folder / "port"), process.stdin)
        process.stdin.flush()
        yield Emulator(process)
        process.stdin.close()
        assert process.wait(timeout=10) == 0


def command(*words: object) -> list[str]:
    return [sys.executable, "-m", "serpenoid", *map(str, words)]


def environment() -> dict[str, str]:
    return os.environ | {"PYTHONPATH": str(ROOT / "src")}


def serpenoid(*words: object) -> subprocess.CompletedProcess[str]:
    """Run a command to its end; 60 s is a hang on any machine."""
    return subprocess.run(
        command(*words), env=environment(), capture_output=True, text=True, timeout=60, stdin=subprocess.DEVNULL
    )


def start(*words: object) -> subprocess.Popen[str]:
    pipe = subprocess.PIPE
    return subprocess.Popen(
        command(*words), env=environment(), stdout=pipe, stderr=pipe, text=True, stdin=subprocess.DEVNULL
    )


def play_words(table: Path, port: str, log: Path, cycles: int = 3, pause: float = 0.1) -> list[object]:
    return [
        *("play", table, "--robot", ROBOT_FILE, "--port", port, "--log", log),
        *("--cycles", cycles, "--cycle-duration", 0.8, "--pause", pause),
    ]


def wait_for_rows(log: Path, phase: str = "play", count: int = 3) -> None:
    """Until the log has `count` rows of `phase`: then the robot is under way."""
    give_up = time.monotonic() + 30
    while time.monotonic() < give_up:
        if log.exists() and log.read_text().count(f",{phase},") >= count:
            return
        time.sleep(0.02)
    raise TimeoutError(f"no {count} rows of {phase} in {log}")


def read_log(path: Path) -> tuple[list[str], list[dict[str, str]]]:
    """Header and whole rows; every row but the last must be whole."""
    with path.open(newline="") as stream:
        header, *rows = list(csv.reader(stream))
    assert all(len(row) == len(header) for row in rows[:-1])
    return header, [dict(zip(header, row, strict=True)) for row in rows if len(row) == len(header)]


def interrupt(process: subprocess.Popen[str], number: int = signal.SIGINT) -> tuple[int, str]:
    process.send_signal(number)
    _, err = process.communicate(timeout=30)
    return process.returncode, err
