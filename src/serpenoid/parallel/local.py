"""Processes of this machine that stop at once: on Ctrl-C, on an error, and when whoever started them is killed.

They are loky's (by way of joblib): they import no main module, so scripts need no guard and notebooks may use them. If
one is killed, as by the system when memory runs out, the pool is started again with what is not finished.
"""

from __future__ import annotations

import logging
import os
import queue
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing import resource_tracker
from typing import Any, TypeVar

from serpenoid.interrupts import deferred
from serpenoid.parallel.retry import Lost, ruled_out
from serpenoid.wording import counted

T = TypeVar("T")
log = logging.getLogger(__name__)
LOOK_S = 0.5  # how often a worker looks whether its parent is still there


def in_pool(function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], jobs: int) -> Iterator[tuple[int, T]]:
    """(index, `function(*task)`) as they are finished."""
    waiting, losses = dict(enumerate(tasks)), 0
    while waiting:
        try:
            for index, result in _once(function, waiting, jobs):
                del waiting[index]
                yield index, result
        except Lost as error:
            losses = ruled_out(losses, str(error))
            log.warning("a worker was killed (%s); run again: %s", error, counted(len(waiting), "task"))


def _once(function: Callable[..., T], tasks: dict[int, tuple[Any, ...]], jobs: int) -> Iterator[tuple[int, T]]:
    from concurrent.futures import as_completed

    from joblib.externals.loky.process_executor import ProcessPoolExecutor, TerminatedWorkerError

    pool = ProcessPoolExecutor(min(jobs, len(tasks)), initializer=_worker, initargs=(os.getpid(),))
    try:
        with interrupts_held():
            futures = {pool.submit(function, *task): index for index, task in tasks.items()}
        for future in as_completed(futures):
            yield futures[future], future.result()
        pool.shutdown(wait=True)
    except TerminatedWorkerError as error:
        raise Lost(" ".join(str(error).split())) from None
    finally:
        _forget_what_waits(pool)
        pool.shutdown(wait=True, kill_workers=True)


def _forget_what_waits(pool: Any) -> None:
    """loky's thread drops waiting tasks as its pool is ended, then trips over their numbers, which it still has."""
    with suppress(queue.Empty):
        while True:
            pool._work_ids.get_nowait()


@contextmanager
def interrupts_held(tracked: bool = True) -> Iterator[None]:
    """Processes started inside are deaf to Ctrl-C, which a terminal sends to all; this one hears it afterwards, and
    SIGTERM: one amid a fork would leave a process that nobody ends.

    tracked: they share memory or locks. What keeps account of these is a process, too, and is started first: Python
    3.11 lets interrupts in again as it starts it.
    """
    if tracked:
        resource_tracker.ensure_running()
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        with deferred():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def _worker(parent: int) -> None:
    """Deaf to Ctrl-C for good: not only where this process was started, but wherever a library lets interrupts in."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    watch_parent(parent)


def watch_parent(parent: int | None = None) -> None:
    """End with the parent, even if it was killed and could not say so."""
    parent = parent or os.getppid()

    def wait() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_S)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
