"""Waiting that ends at once: Ctrl-C, Ctrl-Z, Ctrl-\\, SIGTERM, hang-up, or the emergency stop key.

A program that Ctrl-Z suspends, or that Ctrl-\\ ends, would leave the servos holding with their torque on.

Signals only set a flag, so that no packet is cut in half; the player asks for the flag between packets.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import socket
import sys
import time
from collections.abc import Callable
from types import FrameType
from typing import Any, Self

from serpenoid.errors import StopRequested
from serpenoid.robot.faults import EmergencyStop

EMERGENCY_KEYS = {" ": "space", "q": "q", "Q": "q", "\x1b": "Esc"}
NAMES = ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGTSTP", "SIGBREAK")
SIGNALS = [getattr(signal, name) for name in NAMES if hasattr(signal, name)]


class StopWatcher:
    """Use `with`; inside, `check()` and `wait_until()` raise StopRequested or EmergencyStop."""

    def __init__(self) -> None:
        self._signal: int | None = None
        self._armed = True
        self._handlers: dict[int, Any] = {}
        self._reader, self._writer = socket.socketpair()
        self._restore_keyboard: Callable[[], None] = lambda: None
        self._keyboard: int | None = None

    def __enter__(self) -> Self:
        self._writer.setblocking(False)
        for number in SIGNALS:
            self._handlers[number] = signal.signal(number, self._note)
        self._listen_to_keys()
        return self

    def __exit__(self, *_: object) -> None:
        self._restore_keyboard()
        for number, handler in self._handlers.items():
            signal.signal(number, handler)
        self._reader.close()
        self._writer.close()

    @property
    def has_keys(self) -> bool:
        return self._keyboard is not None

    def disarm(self) -> None:
        """From here on nothing interrupts: the torque is being switched off."""
        self._armed = False

    def check(self) -> None:
        self.wait_until(0.0)

    def wait_until(self, deadline: float) -> None:
        """Sleep until the monotonic time `deadline` [s], or raise at once."""
        while True:
            self._raise_if_stopped()
            patience = max(0.0, deadline - time.monotonic())
            sources: list[Any] = [self._reader] + ([self._keyboard] if self._keyboard is not None else [])
            ready, _, _ = select.select(sources if self._armed else [], [], [], patience)
            if not ready and time.monotonic() >= deadline:
                return
            if self._reader in ready:
                self._reader.recv(64)
            if self._keyboard in ready:
                self._read_key()

    def _raise_if_stopped(self) -> None:
        if self._armed and self._signal is not None:
            raise StopRequested(f"({signal.Signals(self._signal).name})")

    def _note(self, number: int, _: FrameType | None) -> None:
        self._signal = number
        with contextlib.suppress(OSError):
            self._writer.send(b"!")

    def _read_key(self) -> None:
        if self._keyboard is None:
            return
        try:
            pressed = os.read(self._keyboard, 64).decode(errors="replace")
        except OSError:
            pressed = ""
        if not pressed:
            self._keyboard = None  # the terminal is gone
        for key in pressed:
            if key in EMERGENCY_KEYS:
                raise EmergencyStop(f"emergency stop: the {EMERGENCY_KEYS[key]} key was pressed.")

    def _listen_to_keys(self) -> None:
        """Take keys one by one, where there is a terminal in the foreground."""
        try:
            import termios
            import tty

            keyboard = sys.stdin.fileno()
            if not os.isatty(keyboard) or os.tcgetpgrp(keyboard) != os.getpgrp():
                return
            before = termios.tcgetattr(keyboard)
            tty.setcbreak(keyboard)
        except (ImportError, OSError, ValueError, AttributeError):
            return
        self._keyboard = keyboard
        self._restore_keyboard = lambda: termios.tcsetattr(keyboard, termios.TCSANOW, before)
