"""Ctrl-C while IPOPT runs: a handler sets a flag, and the iteration callback asks IPOPT to stop.

IPOPT swallows KeyboardInterrupt and exceptions raised in callbacks; both are stored and acted upon after it returns.
"""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

import casadi as ca
import numpy as np

from serpenoid import interrupts


class StopFlag:
    """True once Ctrl-C was pressed inside `catch_interrupt`."""

    def __init__(self) -> None:
        self.stopped = False

    def __bool__(self) -> bool:
        return self.stopped


@contextmanager
def catch_interrupt() -> Iterator[StopFlag]:
    """Turn SIGINT into a flag inside the block (main thread only; elsewhere the flag never rises).

    SIGTERM too, where somebody handles it. A second one goes to the handler from before: as a rule it raises
    KeyboardInterrupt.
    """
    flag = StopFlag()
    flag.stopped = bool(interrupts.noted)  # pressed before, and lost in a library
    if threading.current_thread() is not threading.main_thread():
        yield flag
        return

    handlers = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    previous = {n: h for n, h in handlers.items() if n == signal.SIGINT or callable(h)}

    def raise_flag(number: int, frame: FrameType | None) -> None:
        before = previous[signal.Signals(number)]
        if callable(before) and (flag or (number == signal.SIGTERM and os.getpid() != owner)):
            before(number, frame)
        flag.stopped = True

    owner = os.getpid()
    for number in previous:
        signal.signal(number, raise_flag)
    try:
        yield flag
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


class IterationCallback(ca.Callback):
    """Called by IPOPT after every iteration with the current point."""

    def __init__(self, sizes: tuple[int, int, int], observe: Callable[[float], None] | None) -> None:
        ca.Callback.__init__(self)
        self.sizes, self.observe = sizes, observe
        self.flag: StopFlag | None = None
        self.error: Exception | None = None
        self.construct("iteration", {})

    def get_n_in(self) -> int:
        return ca.nlpsol_n_out()

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return ca.nlpsol_out(i)

    def get_name_out(self, _i: int) -> str:
        return "ret"

    def get_sparsity_in(self, i: int) -> ca.Sparsity:
        nx, ng, np_ = self.sizes
        rows = {"f": 1, "x": nx, "lam_x": nx, "g": ng, "lam_g": ng, "lam_p": np_}[ca.nlpsol_out(i)]
        return ca.Sparsity.dense(rows, 1)

    def has_eval_buffer(self) -> bool:
        """Arguments come as they lie in memory: copies of them would take a tenth of an iteration."""
        return True

    def eval_buffer(self, arguments: list, results: list) -> int:
        """Observe the objective; tell IPOPT to go on (0) or stop (1)."""
        try:
            if self.observe is not None:
                self.observe(float(np.frombuffer(arguments[1])[0]))
        except Exception as error:  # noqa: BLE001 - stored here, raised again by the caller after IPOPT has returned
            self.error = error
        np.frombuffer(results[0])[0] = float(self.error is not None or bool(self.flag))
        return 0
