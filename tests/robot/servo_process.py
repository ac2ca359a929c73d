"""Emulated servos in a process of their own: what holds up the tests' interpreter does not hold up the servos.

`python -m robot.servo_process` reads pickles from its standard input, the chain with its terminal first, then what to
do with it, and writes one pickle for each. It ends with its input."""

from __future__ import annotations

import contextlib
import pickle
import queue
import sys
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, BinaryIO

from serpenoid.robot.emulator.chain import Chain, Reply
from serpenoid.robot.emulator.faults import Fault
from serpenoid.robot.emulator.server import PtyServer
from serpenoid.robot.emulator.servo import EmulatedServo
from serpenoid.robot.timing import before_other_programs


class HeardChain(Chain):
    """A chain that keeps what it hears."""

    def __init__(self, servos: Sequence[EmulatedServo], baud_rate: int, faults: Sequence[Fault] = ()) -> None:
        super().__init__(servos, baud_rate, faults)
        self.heard: list[bytes] = []

    def receive(self, data: bytes, now: float) -> list[Reply]:
        self.heard.append(data)
        return super().receive(data, now)


def itself(chain: HeardChain) -> HeardChain:
    """As it is now; the caller gets a copy."""
    return chain


def supply(chain: HeardChain, joint: int, voltage: float) -> None:
    chain.servos[joint].supply_voltage = voltage


def turn(chain: HeardChain, joint: int, ticks: float) -> None:
    chain.servos[joint].motion.position = ticks


def remember(chain: HeardChain, joint: int, registers: dict[str, int]) -> None:
    for name, value in registers.items():
        chain.servos[joint].table[name] = value


def take_out(chain: HeardChain, joint: int) -> None:
    chain.servos.pop(joint)


class Asked:
    """What the asking process wants done with the chain, between two turns of its server: never amid one."""

    def __init__(self, chain: HeardChain, questions: BinaryIO, answers: BinaryIO) -> None:
        self._chain, self._questions, self._answers = chain, questions, answers
        self._waiting: queue.SimpleQueue[tuple[Callable[..., Any], tuple[Any, ...]] | None] = queue.SimpleQueue()
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self) -> None:
        with contextlib.suppress(EOFError):
            while True:
                self._waiting.put(pickle.load(self._questions))
        self._waiting.put(None)

    def all_done(self) -> bool:
        """Whether the asking process has ended; what it asked until now is done."""
        while not self._waiting.empty():
            question = self._waiting.get()
            if question is None:
                return True
            do, words = question
            self.answer(do(self._chain, *words))
        return False

    def answer(self, value: object) -> None:
        pickle.dump(value, self._answers)
        self._answers.flush()


def main() -> None:
    chain, baud_rate, link = pickle.load(sys.stdin.buffer)
    server = PtyServer(chain, baud_rate, Path(link))
    asked = Asked(chain, sys.stdin.buffer, sys.stdout.buffer)
    asked.answer(server.port)
    try:
        with before_other_programs():
            server.serve(asked.all_done)
    finally:
        server.close()


if __name__ == "__main__":
    # by its own name: functions and classes are pickled with the name of their module
    from robot.servo_process import main as served

    served()
