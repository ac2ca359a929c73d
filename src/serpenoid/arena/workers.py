"""Several processes that stop at once: on Ctrl-C, on an error, and when the process that started them is killed."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import contextmanager
from typing import Any, TypeVar

T = TypeVar("T")


def results(function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], jobs: int) -> Iterator[T]:
    """`function(*task)` of every task, as they are finished; whoever stops listening stops the work."""
    if jobs == 1 or len(tasks) < 2:
        for task in tasks:
            yield function(*task)
        return
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, len(tasks)), mp_context=context, initializer=watch_parent) as pool:
        others = set(multiprocessing.active_children())
        complete = False
        try:
            with interrupts_held():
                futures = [pool.submit(function, *task) for task in tasks]
            for future in as_completed(futures):
                yield future.result()
            complete = True
        finally:
            if not complete:
                for child in set(multiprocessing.active_children()) - others:
                    child.terminate()
            pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def interrupts_held() -> Iterator[None]:
    """Processes started inside are deaf to Ctrl-C, which a terminal sends to all; this one hears it afterwards."""
    previous = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, previous)


def watch_parent() -> None:
    """End with the parent, even if it was killed and could not say so."""
    parent = multiprocessing.parent_process()

    def wait() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
