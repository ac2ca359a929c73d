"""The same function on many inputs, on as many cores as there are; results in order.

Ctrl-C reaches every process of a terminal: workers leave it to the first one, which ends them.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Sequence
from typing import Any

AT_MOST = 4
Task = tuple[Callable[..., Any], tuple[Any, ...]]
_tasks: list[Task] = []


def in_processes(tasks: Sequence[Task]) -> list[Any]:
    """Run every (function, arguments); forked where that exists, so that inputs need not be sent."""
    cores = min(len(tasks), AT_MOST, os.cpu_count() or 1)
    if cores < 2 or "fork" not in multiprocessing.get_all_start_methods():
        return [function(*arguments) for function, arguments in tasks]
    global _tasks
    _tasks = list(tasks)
    heard = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})  # what is blocked here stays so in the workers
    try:
        pool = multiprocessing.get_context("fork").Pool(cores)
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, heard)
    with pool:
        return pool.map(_run, range(len(tasks)), chunksize=1)


def _run(index: int) -> Any:
    function, arguments = _tasks[index]
    return function(*arguments)
