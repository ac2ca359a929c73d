"""One process beside the first, for what does not wait for it: it prepares, then does what it is asked.

It is forked when it is begun; what it is asked lies in a file that both hold open, so that whoever asks goes on at once
while it is still busy. So a heavy library can be imported on a core that has nothing else to do, and what needs it be
done there. Where nothing can be forked, or the process was killed, the first process does what was asked itself. It may
fork pieces of its own, and ends them when it is ended.
"""

from __future__ import annotations

import gc
import multiprocessing
import os
import pickle
import signal
import sys
import tempfile
from collections.abc import Callable
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.process import BaseProcess
from types import TracebackType
from typing import IO, Any, Self, TypeVar

from serpenoid.parallel.forks import Task, answered, attempted, may_fork, packed, raised_again
from serpenoid.parallel.local import interrupts_held

PATIENCE_S = 2.0  # in which a process ends that was told to
T = TypeVar("T")


class Beside:
    """A process that is there from `begin` to the end of the `with` block. prepare: what it does first."""

    def __init__(self, prepare: Callable[[], object]) -> None:
        self._prepare = prepare
        self._process: BaseProcess | None = None
        self._pipe: Connection | None = None
        self._room: IO[bytes] | None = None
        self._asked = 0  # bytes

    def begin(self) -> None:
        """Fork it, once."""
        if self._process is not None or not may_fork():
            return
        try:
            self._room = tempfile.TemporaryFile()  # noqa: SIM115 - open as long as the process
        except OSError:  # nowhere to write: what is asked is done here
            return
        ours, theirs = multiprocessing.Pipe()
        fork = multiprocessing.get_context("fork")
        self._process = fork.Process(target=_serve, args=(self._prepare, ours, theirs, self._room.fileno()))
        with interrupts_held(tracked=False):  # an interrupt amid a fork is lost or leaves one behind
            self._process.start()
            self._pipe = ours
        theirs.close()  # held by the process alone: it is heard when that ends

    def ask(self, function: Callable[..., T], *arguments: Any) -> Callable[[], T]:
        """Begin `function(*arguments)` there; what is returned waits for its value. All three must be picklable.

        What is asked twice is done, and must be waited for, in order.
        """
        pipe = self._sent((function, arguments))

        def value_of() -> T:
            found = None
            if pipe is not None:
                with suppress(EOFError, OSError):
                    found = pipe.recv()
            value: T = raised_again(found or answered((function, arguments)))
            return value

        return value_of

    def _sent(self, task: Task) -> Connection | None:
        """Where the answer will come; None where it must be found here."""
        if self._pipe is None or self._room is None:
            return None
        written = pickle.dumps(task)
        whole = False
        with suppress(OSError):  # a full disk
            whole = os.pwrite(self._room.fileno(), written, self._asked) == len(written)
        if not whole:
            return None
        with suppress(OSError):  # that it has ended is heard in the pipe
            self._pipe.send((self._asked, len(written)))
        self._asked += len(written)
        return self._pipe

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        if self._process is not None:
            self._process.terminate()
            self._process.join(PATIENCE_S)
            self._process.kill()  # Python drops what a signal raises in a destructor
            self._process.join()
        for held in (self._pipe, self._room):
            if held is not None:
                held.close()


def _serve(prepare: Callable[[], object], ours: Connection, pipe: Connection, room: int) -> None:
    """Deaf to Ctrl-C; SIGTERM ends it by an exception, so that pieces which it has forked are ended, too.

    It ends when nobody holds the other end of its pipe any more: it forks, so it has no thread to look for its parent.
    """
    gc.freeze()  # as for workers of `in_processes`
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(0))
    ours.close()  # or it would not hear that the first process has closed it
    attempted((prepare, ()))  # what cannot be prepared says so where it is needed
    with suppress(EOFError, OSError):
        while True:
            begin, count = pipe.recv()
            pipe.send_bytes(packed(attempted(pickle.loads(os.pread(room, count, begin)))))
