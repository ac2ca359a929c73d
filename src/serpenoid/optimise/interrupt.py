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

AT_REST = 1e-4  # body lengths, radians: of every pose of the cycle
# iterations: of 18 of the problem files, four starts each, no search stood for more than 8; with a constraint of the
# user's own that all starts broke one stood for 46 and came away, another for 391 of 399 and did not
STOOD = 60


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
    """Called by IPOPT after every iteration with the current point.

    poses: how many of the variables, the first ones, are poses; a search that keeps them next to zero for `STOOD`
    iterations running is given up: it stands where the displacement has a kink, which no derivative leads away from.
    """

    def __init__(self, sizes: tuple[int, int, int], observe: Callable[[float], None] | None, poses: int = 0) -> None:
        ca.Callback.__init__(self)
        self.sizes, self.observe, self.poses, self.stood = sizes, observe, poses, 0
        self.flag: StopFlag | None = None
        self.error: Exception | None = None
        self.construct("iteration", {})

    @property
    def given_up(self) -> bool:
        """Whether the search has stood for too long."""
        return self.stood >= STOOD

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
            if self.poses:
                rests = np.abs(np.frombuffer(arguments[0])[: self.poses]).max() < AT_REST
                self.stood = self.stood + 1 if rests else 0
            if self.observe is not None:
                self.observe(float(np.frombuffer(arguments[1])[0]))
        except Exception as error:  # noqa: BLE001 - stored here, raised again by the caller after IPOPT has returned
            self.error = error
        np.frombuffer(results[0])[0] = float(self.error is not None or bool(self.flag) or self.given_up)
        return 0
