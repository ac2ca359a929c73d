"""What a command says of its inside: warnings on the screen, and with --log-file all of it, with times, in a file."""

from __future__ import annotations

import argparse
import errno
import logging
import os
import platform
import re
import shlex
import sys
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

from serpenoid.errors import InputError
from serpenoid.files.inputs import first_line
from serpenoid.files.writing import ESCAPED
from serpenoid.version import __version__

log = logging.getLogger("serpenoid")
LINE = "%(asctime)s %(levelname)s %(name)s: %(message)s"


class _LogFile(logging.FileHandler):
    """A log file that may fill its disk: said once, and the command goes on without it."""

    full = False

    def emit(self, record: logging.LogRecord) -> None:
        if not self.full:
            super().emit(record)

    def handleError(self, record: logging.LogRecord) -> None:
        """Called by `emit`, of which the exception is."""
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            super().handleError(record)
            return
        self.full = True
        sys.stderr.write(f"serpenoid: --log-file {self.baseFilename}: {error.strerror}; it ends here.\n")

    def close(self) -> None:
        """What could not be written is still in the buffer, and cannot be written now."""
        with suppress(OSError):
            super().close()


class _Waiting(logging.Handler):
    """A log file in a results folder that the command has yet to name: what is said until then is kept for it."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.path = path
        self._kept: list[logging.LogRecord] = []
        self._file: logging.Handler | None = None

    def emit(self, record: logging.LogRecord) -> None:
        if self._file is None:
            self._kept.append(record)
        else:
            self._file.handle(record)

    def open_in(self, folders: Sequence[Path]) -> None:
        """InputError where the file is in none of these folders; what was kept is written."""
        if self._file is None:
            self._file = _handler(self.path, folders)
            for record in self._kept:
                self._file.handle(record)

    def close(self) -> None:
        if self._file is not None:
            self._file.close()
        super().close()


def settle(folders: Sequence[Path]) -> None:
    """A command knows where its results go: a log file in a folder that was not there is begun, or refused."""
    for handler in log.handlers:
        if isinstance(handler, _Waiting):
            handler.open_in(folders)


def begin(args: argparse.Namespace, words: Sequence[str]) -> ExitStack:
    """Loggers as -v, --quiet and --log-file ask for; closing what is returned closes the file.

    What libraries note to themselves is no part of it: -v and --log-file are about this package's own loggers.
    """
    others = logging.ERROR if getattr(args, "quiet", False) else logging.WARNING
    logging.basicConfig(level=others, format="%(levelname)s %(name)s: %(message)s")
    stack = ExitStack()
    if args.log_file is None and not args.verbose:
        return stack
    handler = None if args.log_file is None else _handler_of(args)
    log.setLevel(logging.DEBUG)
    stack.callback(log.setLevel, logging.NOTSET)
    if handler is None:
        return stack
    for existing in logging.getLogger().handlers:
        existing.setLevel(logging.DEBUG if args.verbose else others)
    log.addHandler(handler)
    stack.callback(handler.close)
    stack.callback(log.removeHandler, handler)
    log.info("serpenoid %s, Python %s on %s", __version__, platform.python_version(), platform.platform())
    log.info("command: serpenoid %s", shlex.join(words))
    return stack


def _handler_of(args: argparse.Namespace) -> logging.Handler:
    """Of --log-file; it waits where its folder may be the one that the results have without --out."""
    path, out = args.log_file, getattr(args, "out", None) or getattr(args, "log", None)
    if hasattr(args, "out") and out is None and not os.path.exists(path.parent):
        return _Waiting(path)
    return _handler(path, [] if out is None else [Path(out)])


def _handler(path: Path, folders: Iterable[Path]) -> logging.Handler:
    """A folder that is not there is made where it is one of the results: any other is a slip of the pen."""
    if not os.path.exists(path.parent) and path.parent.absolute() not in [folder.absolute() for folder in folders]:
        raise InputError(f"--log-file {path}: there is no folder {path.parent}. Make it, or name one that is there.")
    if not _begins_as_log(path):
        raise InputError(f"--log-file {path}: is there and no log of ours. Name another file.")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with _reader_of(path):
            handler = _LogFile(path, encoding="utf-8", errors=ESCAPED)
    except OSError as error:
        raise InputError(f"--log-file {path}: cannot be written ({error.strerror}).") from None
    handler.setFormatter(logging.Formatter(LINE))
    return handler


@contextmanager
def _reader_of(path: Path) -> Iterator[None]:
    """A pipe is opened without waiting first, for ever if nobody reads it; one that is closed again has ended."""
    if not path.is_fifo():
        yield
        return
    try:
        begun = os.open(path, os.O_WRONLY | os.O_NONBLOCK)
    except OSError as error:
        if error.errno != errno.ENXIO:
            raise
        raise InputError(f"--log-file {path}: is a pipe that nobody reads. Start its reader first.") from None
    try:
        yield
    finally:
        os.close(begun)


def _begins_as_log(path: Path) -> bool:
    """Whether it may be written on: it is not there, is empty, no regular file, or begins as a log does."""
    if not path.is_file() or not path.stat().st_size:
        return True
    return re.match(r"\d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d{3} [A-Z]+ serpenoid", first_line(path)) is not None


def ended(code: int) -> int:
    """Note the exit code, and hand it on."""
    log.info("exit code %d", code)
    return code


def stopped() -> None:
    """Note what became of Ctrl-C in a library: for the log file, no news on the screen."""
    log.debug("stopped in %s", sys.exc_info()[0], exc_info=True)


def failed() -> None:
    """Note the exception that is being handled, with its traceback."""
    log.error("ended by %s", sys.exc_info()[0], exc_info=True)
