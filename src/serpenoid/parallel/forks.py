"""Short pieces of one task, forked so that large inputs need not be sent; on as many cores as are allowed; in order.

Ctrl-C reaches every process of a terminal. Workers ignore it; the first process ends them, and hears it only once they
are all there: an interrupt amid a fork is lost or leaves one behind.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from types import FrameType
from typing import Any

AT_MOST = 4
_allowed = AT_MOST
Task = tuple[Callable[..., Any], tuple[Any, ...]]
_tasks: list[Task] = []


def in_processes(tasks: Sequence[Task], awaited: Callable[[int], None] = lambda index: None) -> list[Any]:
    """Run every (function, arguments); forked where that exists, so that inputs need not be sent.

    awaited: hears the index of the task whose result is the next to come.
    """
    cores = min(len(tasks), _allowed, os.cpu_count() or 1)
    if multiprocessing.current_process().daemon:  # a worker that may have no children
        cores = 1
    if cores < 2 or "fork" not in multiprocessing.get_all_start_methods():
        return _collected((function(*arguments) for function, arguments in tasks), len(tasks), awaited)
    global _tasks
    _tasks = list(tasks)
    with _interrupts_later() as hear:
        pool = multiprocessing.get_context("fork").Pool(cores, _worker)
        with pool:
            hear()
            return _collected(pool.imap(_run, range(len(tasks))), len(tasks), awaited)


def _collected(results: Iterator[Any], count: int, awaited: Callable[[int], None]) -> list[Any]:
    found = []
    for index in range(count):
        awaited(index)
        found.append(next(results))
    return found


@contextmanager
def limited(cores: int) -> Iterator[None]:
    """Inside, `in_processes` uses so many at most."""
    global _allowed
    before, _allowed = _allowed, cores
    try:
        yield
    finally:
        _allowed = before


@contextmanager
def _interrupts_later() -> Iterator[Callable[[], None]]:
    """Ctrl-C is noted, not heard, until the function given is called: then the usual handler is back and hears it."""
    if threading.current_thread() is not threading.main_thread():
        yield lambda: None
        return
    noted: list[tuple[int, FrameType | None]] = []
    usual = signal.signal(signal.SIGINT, lambda number, frame: noted.append((number, frame)))

    def hear() -> None:
        signal.signal(signal.SIGINT, usual)
        if noted and callable(usual):
            usual(*noted[0])

    try:
        yield hear
    finally:
        signal.signal(signal.SIGINT, usual)


def _worker() -> None:
    """SIGTERM, by which a pool ends its workers, ends them at once: waiting for a lock they may never run a handler."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _run(index: int) -> Any:
    function, arguments = _tasks[index]
    return function(*arguments)
