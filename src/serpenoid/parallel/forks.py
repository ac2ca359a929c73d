"""Short pieces of one task, forked so that large inputs need not be sent; on as many cores as are allowed; in order.

Ctrl-C reaches every process of a terminal. Workers are deaf to it; the first process ends them. Each worker has a pipe
of its own: pools of the standard library share locks, and wait for ever for one that a worker held as it was ended.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import signal
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

from serpenoid.parallel.local import interrupts_held, watch_parent

AT_MOST = 4
_allowed = AT_MOST
Task = tuple[Callable[..., Any], tuple[Any, ...]]
Answer = tuple[bool, Any]  # True and what the task gave, or False and what it raised


def in_processes(tasks: Sequence[Task], awaited: Callable[[int], None] = lambda index: None) -> list[Any]:
    """Run every (function, arguments); forked where that exists, so that inputs need not be sent.

    awaited: hears the index of the task whose result is the next to come.
    """
    cores = min(len(tasks), _allowed, os.cpu_count() or 1)
    if cores < 2 or not may_fork():
        return _collected((function(*arguments) for function, arguments in tasks), len(tasks), awaited)
    workers: list[tuple[BaseProcess, Connection]] = []
    try:
        with interrupts_held(tracked=False):  # an interrupt amid a fork is lost or leaves one behind
            workers.extend(_started(tasks) for _ in range(cores))
        return _collected(_answers(tasks, [pipe for _, pipe in workers]), len(tasks), awaited)
    finally:
        for process, pipe in workers:
            process.terminate()
            process.join()
            pipe.close()


def may_fork() -> bool:
    """Whether pieces can be forked here, and more than one core is allowed. Workers have no children."""
    forks = "fork" in multiprocessing.get_all_start_methods() and not multiprocessing.current_process().daemon
    return forks and min(_allowed, os.cpu_count() or 1) > 1


def _started(tasks: Sequence[Task]) -> tuple[BaseProcess, Connection]:
    ours, theirs = multiprocessing.Pipe()
    process = multiprocessing.get_context("fork").Process(target=_serve, args=(tasks, theirs, os.getpid()), daemon=True)
    process.start()
    theirs.close()  # held by the worker alone: it is heard when that ends
    return process, ours


def _serve(tasks: Sequence[Task], pipe: Connection, parent: int) -> None:
    """A worker: indices in, answers out. SIGTERM ends it at once, whatever the first process does with signals."""
    gc.freeze()  # what it was forked with is not looked through for garbage: every page of it would be copied
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    watch_parent(parent)
    while True:
        answer(pipe, tasks[pipe.recv()])


def answer(pipe: Connection, task: Task) -> None:
    """Send what a task gives or raises; nothing of it is kept."""
    found = attempted(task)
    try:
        pipe.send(found)
    except OSError:  # nobody hears
        raise
    except Exception as error:  # noqa: BLE001 - whatever cannot be pickled says so in the first process
        pipe.send((False, error))


def attempted(task: Task) -> Answer:
    """What a task gives or raises."""
    function, arguments = task
    try:
        return True, function(*arguments)
    except Exception as error:  # noqa: BLE001 - raised again in the first process
        error.add_note(traceback.format_exc())  # where, which no pickle keeps
        return False, error


def raised_again(answer: Answer) -> Any:
    """What a task gave; what it raised is raised here."""
    done, value = answer
    if not done:
        raise value
    return value


def _answers(tasks: Sequence[Task], pipes: list[Connection]) -> Iterator[Any]:
    """What the tasks give, in order. A task whose worker was killed runs here."""
    rest = iter(range(len(tasks)))
    busy: dict[Connection, int] = {}
    answers: dict[int, Answer] = {}

    def give(pipe: Connection) -> None:
        index = next(rest, None)
        if index is not None:
            busy[pipe] = index
            with suppress(OSError):  # that its worker has ended is heard in the pipe
                pipe.send(index)

    for pipe in pipes:
        give(pipe)
    for index, task in enumerate(tasks):
        while index not in answers and busy:
            for pipe in [p for p in wait(list(busy)) if isinstance(p, Connection)]:
                asked = busy.pop(pipe)
                try:
                    answers[asked] = pipe.recv()
                except (EOFError, OSError):
                    answers[asked] = attempted(tasks[asked])
                else:
                    give(pipe)
        yield raised_again(answers.pop(index) if index in answers else attempted(task))


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
