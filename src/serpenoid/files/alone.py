"""One process at a time: a port, a folder of results, a campaign that grows."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout

from serpenoid.errors import InputError


@contextmanager
def alone(kind: str, path: str | Path, refused: str, wait_s: float = 0.0) -> Iterator[None]:
    """Hold a path of a kind for this process, until it ends at the latest; InputError where another holds it, and does
    so after `wait_s` [s] still.

    The lock is a file of the temporary folder, named after the path.
    """
    name = hashlib.sha256(os.fsencode(os.path.realpath(path))).hexdigest()[:12]
    lock = FileLock(Path(tempfile.gettempdir()) / f"serpenoid-{kind}-{name}.lock", timeout=wait_s, mode=0o666)
    try:
        lock.acquire()
    except Timeout:
        raise InputError(refused) from None
    try:
        yield
    finally:
        lock.release()
