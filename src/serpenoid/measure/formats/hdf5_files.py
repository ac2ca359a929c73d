"""HDF5 files of whatever program, opened, their data sets read whole or refused (`pip install 'serpenoid[hdf5]'`)."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from serpenoid.errors import InputError
from serpenoid.files.inputs import begins

BROKEN = (OSError, LookupError, RuntimeError, ValueError, TypeError, AttributeError, MemoryError, OverflowError)
MOST_NUMBERS = 100_000_000  # of one data set: an hour of a hundred points at 100 frames/s; packed files may say more
SUFFIXES = (".h5", ".hdf5")
MAGIC = b"\x89HDF"
MOST_SHOWN = 8


def is_hdf5(path: Path) -> bool:
    """Whether its name says so, or how it begins."""
    return path.suffix.lower() in SUFFIXES or begins(path, MAGIC)


@contextmanager
def hdf5(path: Path) -> Iterator[Any]:
    """An HDF5 file to read from; InputError where it is none."""
    try:
        import h5py
    except ImportError:
        raise InputError("reading HDF5 needs h5py: pip install h5py.") from None
    if not path.is_file():
        raise InputError(f"{path}: no such file.")
    try:
        with h5py.File(path, "r") as file:
            yield file
    except InputError:
        raise
    except BROKEN as error:
        raise InputError(f"{path}: not a readable HDF5 file: {error}") from None


def whole(data: Any, path: Path) -> Any:
    """All of a data set, if it is one that can be read."""
    if not hasattr(data, "dtype"):
        raise InputError(f"{path}: `{data.name}` is a group, where a table of numbers belongs.")
    numbers = data.size * data.dtype.itemsize // 8
    if numbers > MOST_NUMBERS:
        raise InputError(f"{path}: `{data.name}` says that it holds {numbers:.3g} numbers. Is it the right file?")
    return data[()]


def require(file: Any, path: Path, kind: str, *names: str) -> None:
    missing = next((name for name in names if name not in file), None)
    if missing is not None:
        raise InputError(f"{path}: a {kind} file holds `{missing}`; this one has {inside(file)}.")


def inside(file: Any) -> str:
    """What it holds, in words."""
    return ", ".join(f"`{name}`" for name in list(file)[:MOST_SHOWN]) or "nothing"


def texts(data: Any, path: Path) -> list[str]:
    """All words of a data set."""
    return [word.decode(errors="replace") if isinstance(word, bytes) else str(word) for word in whole(data, path)]
