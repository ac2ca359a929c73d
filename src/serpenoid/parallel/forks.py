"""Short pieces of one task, forked so that large inputs need not be sent; on as many cores as are allowed; in order.

Ctrl-C reaches every process of a terminal. Workers are deaf to it; the first process ends them. Each worker has a pipe
of its own: pools of the standard library share locks, and wait for ever for one that a worker held as it was ended.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import pickle
import signal
import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from itertools import takewhile
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from multiprocessing.reduction import ForkingPickler
from typing import Any, TypeVar

from serpenoid.interrupts import noted
from serpenoid.parallel.local import interrupts_held, watch_parent

AT_MOST = 4
WORD, WORDS = 4, 1000  # bytes of a number, and how many numbers every pipe holds
_allowed = AT_MOST
T = TypeVar("T")
Task = tuple[Callable[..., Any], tuple[Any, ...]]
Answer = tuple[bool, Any]  # True and what the task gave, or False and what it raised


def in_processes(tasks: Sequence[Task], awaited: Callable[[int], None] = lambda index: None) -> list[Any]:
    """Run every (function, arguments); forked where that exists, so that inputs need not be sent. The first process
    works, too.

    awaited: hears every index in order, no sooner than its task is begun.
    """
    cores = min(len(tasks), _allowed, os.cpu_count() or 1)
    if cores < 2 or not may_fork():
        return _one_by_one(tasks, awaited)
    workers: list[tuple[BaseProcess, Connection]] = []
    queue = _queue(len(tasks))
    try:
        with interrupts_held(tracked=False):  # an interrupt amid a fork is lost or leaves one behind
            workers.extend(_started(tasks, queue) for _ in range(cores - 1))
        return _together(tasks, queue, [pipe for _, pipe in workers], awaited)
    finally:
        _ended(workers, queue)


def _ended(workers: Sequence[tuple[BaseProcess, Connection]], queue: int) -> None:
    """Workers are killed: a SIGTERM that finds one being forked is lost, for Python forgets what is pending then."""
    os.close(queue)
    for process, pipe in workers:
        process.kill()
        process.join()
        pipe.close()


@contextmanager
def meanwhile(function: Callable[..., T], *arguments: Any) -> Iterator[Callable[[], T]]:
    """Inside, another process is at `function(*arguments)`; what is yielded waits for its value.

    Where nothing is forked, or the process was killed, it is found when it is asked for.
    """
    if not may_fork():
        yield lambda: raised_again(answered((function, arguments)))
        return
    task, queue = (function, arguments), _queue(1)
    worker: list[tuple[BaseProcess, Connection]] = []
    try:
        with interrupts_held(tracked=False):
            worker.append(_started([task], queue))
        yield lambda: raised_again(_heard([pipe for _, pipe in worker]).get(0) or answered(task))
    finally:
        _ended(worker, queue)


def may_fork() -> bool:
    """Whether pieces can be forked here, and more than one core is allowed. Workers have no children."""
    forks = "fork" in multiprocessing.get_all_start_methods() and not multiprocessing.current_process().daemon
    return forks and min(_allowed, os.cpu_count() or 1) > 1


def _queue(count: int) -> int:
    """What all processes read to know what they do next, word by word; at its end nothing is left."""
    reading, writing = os.pipe()
    os.write(writing, b"".join(first.to_bytes(WORD, sys.byteorder) for first in range(0, count, _run(count))))
    os.close(writing)
    return reading


def _run(count: int) -> int:
    """How many tasks a word stands for."""
    return -(-count // WORDS)


def _worked(
    tasks: Sequence[Task], queue: int, begun: Callable[[int], None] = lambda index: None
) -> Iterator[tuple[int, Answer]]:
    """Tasks that nobody else has begun, and what they give. Once one has failed nobody begins another: all before it
    have been begun."""
    while word := os.read(queue, WORD):
        first = int.from_bytes(word, sys.byteorder)
        for index in range(first, min(first + _run(len(tasks)), len(tasks))):
            begun(index)
            found = attempted(tasks[index])
            while not found[0] and os.read(queue, WORD):
                pass
            yield index, found


def _started(tasks: Sequence[Task], queue: int) -> tuple[BaseProcess, Connection]:
    ours, theirs = multiprocessing.Pipe()
    arguments = (tasks, queue, theirs, os.getpid())
    process = multiprocessing.get_context("fork").Process(target=_serve, args=arguments, daemon=True)
    process.start()
    theirs.close()  # held by the worker alone: it is heard when that ends
    return process, ours


def _serve(tasks: Sequence[Task], queue: int, pipe: Connection, parent: int) -> None:
    """A worker, whose answers are sent when no task is left. SIGTERM ends it at once, whatever the first process does
    with signals."""
    gc.freeze()  # what it was forked with is not looked through for garbage: every page of it would be copied
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    watch_parent(parent)
    for index, data in [(index, packed(found)) for index, found in _worked(tasks, queue)]:
        pipe.send(index)
        pipe.send_bytes(data)


def packed(answer: Answer) -> memoryview:
    """An answer as it is sent; whatever cannot be pickled says so in the first process."""
    try:
        return ForkingPickler.dumps(answer)
    except Exception as error:  # noqa: BLE001 - raised again in the first process
        return ForkingPickler.dumps((False, error))


def attempted(task: Task) -> Answer:
    """What a task gives or raises."""
    function, arguments = task
    try:
        return True, function(*arguments)
    except Exception as error:  # noqa: BLE001 - raised again in the first process
        error.add_note(traceback.format_exc())  # where, which no pickle keeps
        return False, error


def answered(task: Task) -> Answer:
    """What a task gives or raises, found here as another process would find it."""
    return as_sent(attempted(task))


def as_sent(answer: Answer) -> Answer:
    """Laid out as what another process sends: sums of arrays that lie otherwise differ in their last bits, and a search
    that goes by them may end elsewhere."""
    return pickle.loads(packed(answer)) if answer[0] else answer


def raised_again(answer: Answer) -> Any:
    """What a task gave; what it raised is raised here."""
    done, value = answer
    if not done:
        raise value
    return value


def _together(tasks: Sequence[Task], queue: int, pipes: list[Connection], awaited: Callable[[int], None]) -> list[Any]:
    """What the tasks give, in order, found here and by workers. A task whose worker was killed runs here."""
    answers: dict[int, Answer] = {}
    unheard = iter(range(len(tasks)))

    def begun(index: int) -> None:
        if noted:
            raise KeyboardInterrupt  # one that got lost in a library
        for number in takewhile(lambda number: number < index, unheard):
            awaited(number)
        awaited(index)

    with limited(1):  # what workers do, they do alone
        for index, found in _worked(tasks, queue, begun):
            answers[index] = as_sent(found)
    answers |= _heard(pipes)
    for number in unheard:
        awaited(number)
    return [raised_again(answers[i] if i in answers else answered(task)) for i, task in enumerate(tasks)]


def _heard(pipes: Sequence[Connection]) -> dict[int, Answer]:
    """What workers send until they end."""
    answers: dict[int, Answer] = {}
    for pipe in pipes:
        with suppress(EOFError, OSError):
            while True:
                index = pipe.recv()
                answers[index] = pipe.recv()
    return answers


def _one_by_one(tasks: Sequence[Task], awaited: Callable[[int], None]) -> list[Any]:
    found = []
    for index, task in enumerate(tasks):
        awaited(index)
        found.append(raised_again(answered(task)))
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
