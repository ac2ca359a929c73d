"""One process at a time changes a folder (of results, a campaign that grows), or one name in it."""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from filelock import FileLock, Timeout

from serpenoid.errors import InputError

LOCK = ".serpenoid.lock"
ATTEMPTS = 100  # to lock a folder that others, who hold it in turn, remove as often as they made it in vain


@contextmanager
def alone(folder: str | Path, refused: str, wait_s: float = 0.0, lock: str = LOCK) -> Iterator[None]:
    """Hold a folder for this process, until it ends at the latest; InputError where another holds it, and does so
    after `wait_s` [s] still.

    The lock is a file in the folder itself: who can write there sees it, from any account, container or computer, by
    any name of the folder. The system lets go what a killed process held, and the file that it left holds nobody up.
    The file is removed while it is held: who waited for it notices that what it then has is no longer there, and
    begins anew. A folder that was not there is made, and removed if it is empty in the end and no other used it
    meanwhile. lock: the file's name, another one where not the whole folder is held.
    """
    place = Path(os.path.realpath(folder))
    made = [path for path in (place, *place.parents) if not path.exists()]
    acquired = _acquired(place / lock, folder, refused, wait_s)
    try:
        yield
    finally:
        with suppress(OSError):  # a full or lost disk; some systems remove no file that is open
            (place / lock).unlink(missing_ok=True)
        acquired.release()
        with suppress(OSError):  # not empty
            for path in made:
                path.rmdir()


def is_held(folder: str | Path) -> bool:
    """Whether a process holds this folder now."""
    path = Path(os.path.realpath(folder)) / LOCK
    try:
        if path.exists():
            FileLock(path, timeout=0, mode=0o666).acquire().lock.release()
    except Timeout:
        return True
    except OSError:  # where this account may not write, it cannot ask
        return False
    return False


def _acquired(path: Path, folder: str | Path, refused: str, wait_s: float) -> FileLock:
    lock = FileLock(path, timeout=wait_s, mode=0o666)
    for attempt in range(ATTEMPTS):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            lock.acquire()
            return lock
        except Timeout:
            break
        except OSError as error:
            removed = error.errno in (errno.ENOENT, errno.ESTALE)  # by one that had made it, here or over the network
            if not removed or attempt == ATTEMPTS - 1:
                said = error.strerror or error
                raise InputError(f"{folder}: {path.name} cannot be written there ({said}).") from None
    raise InputError(refused)
