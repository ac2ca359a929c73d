"""Processes of this machine that stop at once: on Ctrl-C, on an error, and when whoever started them is killed.

They are loky's (by way of joblib): they import no main module, so scripts need no guard and notebooks may use them. If
one is killed, as by the system when memory runs out, the pool is started again with what is not finished.
"""

from __future__ import annotations

import logging
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import islice
from typing import Any, TypeVar

from serpenoid.parallel.retry import Lost, ruled_out

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
            log.warning("a worker was killed (%s); %d task(s) run again", error, len(waiting))


def _once(function: Callable[..., T], tasks: dict[int, tuple[Any, ...]], jobs: int) -> Iterator[tuple[int, T]]:
    """Each worker has one task at a time: a pool that is ended trips over what it has not begun."""
    from concurrent.futures import FIRST_COMPLETED, Future, wait

    from joblib.externals.loky.process_executor import ProcessPoolExecutor, TerminatedWorkerError

    pool = ProcessPoolExecutor(min(jobs, len(tasks)), initializer=watch_parent, initargs=(os.getpid(),))
    following, begun = iter(list(tasks.items())), dict[Future[T], int]()

    def begin(count: int) -> None:
        with interrupts_held():
            begun.update({pool.submit(function, *task): index for index, task in islice(following, count)})

    try:
        begin(min(jobs, len(tasks)))
        while begun:
            for future in wait(begun, return_when=FIRST_COMPLETED).done:
                index, result = begun.pop(future), future.result()
                begin(1)
                yield index, result
        pool.shutdown(wait=True)
    except TerminatedWorkerError as error:
        raise Lost(" ".join(str(error).split())) from None
    finally:
        pool.shutdown(wait=True, kill_workers=True)


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Processes started inside are deaf to Ctrl-C, which a terminal sends to all; this one hears it afterwards."""
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def watch_parent(parent: int | None = None) -> None:
    """End with the parent, even if it was killed and could not say so."""
    parent = parent or os.getppid()

    def wait() -> None:
        while os.getppid() == parent:
            time.sleep(LOOK_S)
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
