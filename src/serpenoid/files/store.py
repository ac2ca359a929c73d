"""Finished work kept by content: what was computed once from the same inputs by the same code is not computed again.

An entry is a file named by the SHA-256 of its inputs, options and the package's own source; it begins with the SHA-256
of what follows and is verified before it is read (a damaged one is made again). Values are frozen records of this
package, arrays and plain values, written as JSON and arrays: nothing in an entry can run. Entries are renamed into
place when they are whole; the folder (`SERPENOID_CACHE`, else the user's cache) stays below `MOST_BYTES`, the longest
unused leaving first.
"""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import io
import json
import math
import os
import weakref
from collections.abc import Callable
from contextlib import suppress
from functools import lru_cache, wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numpy as np

from serpenoid.files import cache
from serpenoid.files.schema import Record
from serpenoid.files.writing import atomic

MOST_BYTES = 1_000_000_000
LOOK = 0.01  # part of it that a process writes between two looks at what there is
DIGEST = hashlib.sha256().digest_size
PACKAGE = __name__.split(".", maxsplit=1)[0]
Array = np.ndarray
T = TypeVar("T")
P = ParamSpec("P")


def folder() -> Path:
    """Where entries lie."""
    return cache.place() / "work"


def remember(work: Callable[[], T], *inputs: Any) -> T:
    """The value of `work`, from an earlier run if its inputs (whatever can be stored) and the code are the same."""
    path = folder() / f"{key(*inputs)}.work"
    found = _read(path)
    if found is not None:
        return cast(T, found[0])
    arrays: list[Array] = []
    tree = json.dumps(_plain(work(), arrays)).encode()
    _write(path, tree, arrays)
    return cast(T, _made(json.loads(tree), [np.asarray(array, order="C") for array in arrays]))  # as it is found again


def remembered(work: Callable[P, T]) -> Callable[P, T]:
    """A function whose values are kept; its arguments and its name are the inputs."""

    @wraps(work)
    def kept(*args: P.args, **options: P.kwargs) -> T:
        return remember(lambda: work(*args, **options), f"{work.__module__}:{work.__qualname__}", args, options)

    return kept


def key(*inputs: Any) -> str:
    """SHA-256 of inputs and code, hexadecimal."""
    return hashlib.sha256((source_digest() + _hashed(inputs)).encode()).hexdigest()


def _hashed(value: Any) -> str:
    """SHA-256 of a storable value."""
    arrays: list[Array] = []
    digest = hashlib.sha256(json.dumps(_plain(value, arrays, _by_digest), sort_keys=True).encode())
    for array in arrays:
        digest.update(f"{array.dtype.str}{array.shape}".encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()


_digests: dict[int, tuple[weakref.ref[Any], str]] = {}  # of records by identity, as long as they live


def _by_digest(record: Any, _: list[Array]) -> Any:
    """A dataclass by the digest of its fields; of a frozen one it is taken once: nobody writes into its arrays."""
    known = _digests.get(id(record))
    if known is not None and known[0]() is record:
        return known[1]
    found = _hashed([(f.name, getattr(record, f.name)) for f in dataclasses.fields(record)])
    if type(record).__dataclass_params__.frozen:
        number = id(record)
        _digests[number] = weakref.ref(record, lambda _: _digests.pop(number, None)), found
    return found


@lru_cache(maxsize=1)
def source_digest() -> str:
    """SHA-256 of the package's source."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def file_digest(path: Path) -> str:
    """SHA-256 of a file's content; empty of what is none (a pipe would be waited for, a device never ends) or cannot be
    read: whoever reads it will say so."""
    if not path.is_file():
        return ""
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return ""


def _read(path: Path) -> tuple[Any] | None:
    try:
        data = path.read_bytes()
    except OSError:
        return None
    body = memoryview(data)[DIGEST:]
    if hashlib.sha256(body).digest() != data[:DIGEST]:
        return None
    with np.load(io.BytesIO(body), allow_pickle=False) as file:
        arrays = [file[f"a{i}"] for i in range(len(file.files) - 1)]
        tree = json.loads(bytes(file["tree"]))
    with suppress(OSError):
        os.utime(path)
    return (_made(tree, arrays),)


def _write(path: Path, tree: bytes, arrays: list[Array]) -> None:
    """A full disk or a folder that may not be written is no reason to lose the value; what is larger than all that is
    kept would be the only entry, and leave next."""
    if sum(array.nbytes for array in arrays) > MOST_BYTES:
        return
    stream = io.BytesIO()
    named: dict[str, Any] = {f"a{i}": np.asarray(array, order="C") for i, array in enumerate(arrays)}
    np.savez(stream, tree=np.frombuffer(tree, np.uint8), **named)
    body = stream.getbuffer()
    try:
        with atomic(path) as temporary, temporary.open("wb") as file:
            file.write(hashlib.sha256(body).digest())
            file.write(body)
        _bound(path.parent, len(body))
    except OSError as error:
        cache.lost(error)


_unseen = math.inf  # bytes that this process has written since it last looked at the whole folder


def _bound(place: Path, written: int) -> None:
    """The longest unused entries leave; another process may be doing the same. To look takes as long as to write."""
    global _unseen
    _unseen += written
    if _unseen < LOOK * MOST_BYTES:
        return
    _unseen = 0.0
    entries = []
    with os.scandir(place) as found:
        for entry in found:
            if entry.name.endswith(".work"):
                with suppress(OSError):
                    known = entry.stat()
                    entries.append((known.st_mtime, known.st_size, entry.path))
    excess = sum(size for _, size, _ in entries) - MOST_BYTES
    for _, size, path in sorted(entries) if excess > 0 else []:
        if excess <= 0:
            break
        Path(path).unlink(missing_ok=True)
        excess -= size


def _fields(record: Any, arrays: list[Array]) -> Any:
    """JSON of a dataclass."""
    return _plain({f.name: getattr(record, f.name) for f in dataclasses.fields(record)}, arrays)


def _plain(value: Any, arrays: list[Array], of_record: Callable[[Any, list[Array]], Any] = _fields) -> Any:
    """JSON of any storable value; arrays are set aside, `of_record` says what stands for a dataclass."""
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, np.ndarray):
        arrays.append(value)
        return {"array": len(arrays) - 1}
    if isinstance(value, np.generic):
        return _plain(value.item(), arrays)
    if isinstance(value, float):
        return value if math.isfinite(value) else {"float": repr(value)}
    if isinstance(value, set | frozenset):
        return {"set": [_plain(item, arrays, of_record) for item in sorted(value)]}
    if isinstance(value, tuple | list):
        return {type(value).__name__: [_plain(item, arrays, of_record) for item in value]}
    if isinstance(value, dict):
        return {"dict": [[_plain(k, arrays, of_record), _plain(v, arrays, of_record)] for k, v in value.items()]}
    if isinstance(value, slice):
        return {"slice": [value.start, value.stop, value.step]}
    name = f"{type(value).__module__}:{type(value).__qualname__}"
    if isinstance(value, Record):
        fields = {field: getattr(value, field) for field in type(value).model_fields}
        return {"record": name, "fields": _plain(fields, arrays, of_record)}
    if dataclasses.is_dataclass(value):
        return {"dataclass": name, "fields": of_record(value, arrays)}
    raise TypeError(f"{name} cannot be stored")


def _made(tree: Any, arrays: list[Array]) -> Any:
    """The value of `_plain`'s JSON."""
    if not isinstance(tree, dict):
        return tree
    if "array" in tree:
        return arrays[tree["array"]]
    if "float" in tree:
        return float(tree["float"])
    if "tuple" in tree:
        return tuple(_made(item, arrays) for item in tree["tuple"])
    if "list" in tree:
        return [_made(item, arrays) for item in tree["list"]]
    if "set" in tree:
        return frozenset(_made(item, arrays) for item in tree["set"])
    if "dict" in tree:
        return {_made(k, arrays): _made(v, arrays) for k, v in tree["dict"]}
    if "slice" in tree:
        return slice(*tree["slice"])
    fields = _made(tree["fields"], arrays)
    if "record" in tree:
        return _class(tree["record"], Record).model_construct(
            **fields
        )  # as made here: an infinite neutral value is one
    return _class(tree["dataclass"], object)(**fields)


def _class(name: str, kind: type) -> Any:
    """A record of this package by name."""
    module, _, qualified = name.partition(":")
    if module.split(".")[0] != PACKAGE:
        raise TypeError(f"{name} is no record of this package")
    found = getattr(importlib.import_module(module), qualified)
    if not (isinstance(found, type) and issubclass(found, kind)) or not (
        dataclasses.is_dataclass(found) or issubclass(found, Record)
    ):
        raise TypeError(f"{name} is no record of this package")
    return found
