"""The chain behind a pseudo-terminal, at the pace of the baud rate."""

from __future__ import annotations

import contextlib
import os
import select
import termios
import time
import tty
from collections.abc import Callable
from pathlib import Path
from typing import Any

from serpenoid.robot.emulator.chain import Chain, Reply
from serpenoid.robot.models import WATCHDOG_TRIPPED

IDLE_S = 0.02


class PtyServer:
    """Serves until `stopped()`; `link`, if given, is a symbolic link to the terminal that survives an unplugging."""

    def __init__(self, chain: Chain, baud_rate: int, link: Path | None = None) -> None:
        self.chain = chain
        self.baud_rate = baud_rate
        self.link = link
        self._master: int | None = None
        self._slave: int | None = None
        self._replies: list[Reply] = []
        self._unplugged_since: float | None = None
        self._plug_in()

    @property
    def port(self) -> str:
        return str(self.link) if self.link else self._name

    def serve(self, stopped: Callable[[], bool]) -> None:
        while not stopped():
            now = time.monotonic()
            self._deliver(now)
            self._obey_cable(now)
            self._listen(self._patience(now))

    def close(self) -> None:
        self._unplug()
        if self.link is not None:
            self.link.unlink(missing_ok=True)

    def report(self) -> dict[str, Any]:
        """What became of the servos: for tests, and for a user who wants to know whether the torque is off."""
        self.chain.advance(time.monotonic())
        return {
            "instructions": self.chain.instructions,
            "rejected": self.chain.parser.rejected,
            "servos": [
                {
                    "id": servo.id,
                    "model": servo.model.name,
                    "torque": servo.torque,
                    "watchdog_tripped": servo.table["bus_watchdog"] == WATCHDOG_TRIPPED,
                    "position_ticks": servo.table["present_position"],
                    "lowest_ticks": servo.lowest,
                    "highest_ticks": servo.highest,
                    "fastest_rpm": servo.fastest / servo.motion.per_rpm,
                    "hardware_error": servo.table["hardware_error_status"],
                }
                for servo in self.chain.servos
            ],
        }

    def _patience(self, now: float) -> float:
        return min(IDLE_S, max(0.0, self._replies[0].due - now)) if self._replies else IDLE_S

    def _listen(self, patience: float) -> None:
        if self._master is None:
            time.sleep(patience)
            self.chain.advance(time.monotonic())
            return
        ready, _, _ = select.select([self._master], [], [], patience)
        if not ready:
            self.chain.advance(time.monotonic())
            return
        with contextlib.suppress(OSError):
            data = os.read(self._master, 4096)
            if self._speed() == self.baud_rate:
                self._replies += self.chain.receive(data, time.monotonic())
                self._replies.sort(key=lambda reply: reply.due)  # a late answer comes after its neighbours

    def _deliver(self, now: float) -> None:
        while self._replies and self._replies[0].due <= now:
            reply = self._replies.pop(0)
            if self._master is not None:
                with contextlib.suppress(OSError):
                    os.write(self._master, reply.data)

    def _obey_cable(self, now: float) -> None:
        for fault in self.chain.faults:
            if fault.kind != "unplug" or not fault.active(self.chain.elapsed(now)):
                continue
            if self._unplugged_since is None:
                self._unplugged_since = now
                self._unplug()
            elif self._master is None and now - self._unplugged_since > fault.value:
                self._plug_in()

    def _plug_in(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self._name = os.ttyname(self._slave)
        if self.link is not None:
            self.link.unlink(missing_ok=True)
            self.link.symlink_to(self._name)

    def _unplug(self) -> None:
        for descriptor in (self._master, self._slave):
            if descriptor is not None:
                os.close(descriptor)
        self._master = self._slave = None
        self._replies.clear()
        if self.link is not None:
            self.link.unlink(missing_ok=True)

    def _speed(self) -> int:
        """The baud rate that the client has set on its end."""
        if self._slave is None:
            return 0
        code = termios.tcgetattr(self._slave)[4]
        return _SPEEDS.get(code, 0)


_SPEEDS = {
    getattr(termios, f"B{rate}"): rate
    for rate in (9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000)
    if hasattr(termios, f"B{rate}")
}
