"""Ctrl-C as the command line notes it: a KeyboardInterrupt can get lost in a library's callback, this note cannot."""

from __future__ import annotations

import _thread
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

AGAIN_S = 0.05  # after which an interrupt that got lost is sent once more: whatever lost it is over then

noted: list[int] = []  # numbers of the signals since the command began, until it ends


@contextmanager
def listening() -> Iterator[list[int]]:
    """`noted`, no longer empty once Ctrl-C was pressed: inside CasADi it surfaces as some other exception.

    SIGTERM, with which schedulers and shutdowns end programs, is heard like Ctrl-C; children of this process die of it.
    """
    noted.clear()
    if threading.current_thread() is not threading.main_thread():
        yield noted
        return
    owner = os.getpid()

    def note(number: int, _frame: FrameType | None) -> None:
        if number == signal.SIGTERM and os.getpid() != owner:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        noted.append(number)
        raise KeyboardInterrupt

    heard = [n for n in (signal.SIGINT, signal.SIGTERM) if signal.getsignal(n) is not signal.SIG_IGN]
    previous = {number: signal.signal(number, note) for number in heard}
    hook, sys.unraisablehook = sys.unraisablehook, _sent_again(sys.unraisablehook)
    try:
        yield noted
    finally:
        sys.unraisablehook = hook
        for number, handler in previous.items():
            signal.signal(number, handler)
        noted.clear()  # what is done next in this process was not interrupted


@contextmanager
def deferred() -> Iterator[None]:
    """Ctrl-C and SIGTERM that come inside are heard at its end. A mask does not see to that: it is a thread's own, and
    what another thread is sent Python raises in the first. A process forked inside ends by either at once, until it has
    handlers of its own."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    owner, came = os.getpid(), []

    def wait(number: int, frame: FrameType | None) -> None:
        if os.getpid() != owner:
            os._exit(1)
        came.append((number, frame))

    usual = {n: handler for n in (signal.SIGINT, signal.SIGTERM) if callable(handler := signal.getsignal(n))}
    for number in usual:
        signal.signal(number, wait)
    try:
        yield
    finally:
        for number, handler in usual.items():
            signal.signal(number, handler)
        for heard, frame in came:
            usual[signal.Signals(heard)](heard, frame)


def _sent_again(usual: Any) -> Any:
    """A hook for what Python cannot raise: Ctrl-C in a destructor or a weak reference's callback is sent once more, a
    moment later; all else goes to the usual hook."""

    def hook(unraisable: Any) -> None:
        if not issubclass(unraisable.exc_type, KeyboardInterrupt):
            usual(unraisable)
            return
        later = threading.Timer(AGAIN_S, _thread.interrupt_main)
        later.daemon = True
        later.start()

    return hook
