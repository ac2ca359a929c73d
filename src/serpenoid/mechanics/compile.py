"""Compiled evaluation: named Functions to C, cached on disk by content; CasADi's virtual machine where no compiler is.

The cache key is the C source, the compiler and its flags. Two processes that compile the same thing wait for each other
(file lock); a library is written beside its place and renamed into it. SERPENOID_COMPILE=0 switches compilation off,
SERPENOID_CACHE moves the cache. Without a compiler of the machine's own, that of the package ziglang serves (`zig cc`).
"""

from __future__ import annotations

import contextlib
import hashlib
import importlib.util
import logging
import os
import shutil
import stat
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

import casadi as ca
import filelock

from serpenoid.errors import InputError
from serpenoid.files import cache
from serpenoid.files.writing import atomic, write_text

FLAGS = ("-O3", "-fPIC", "-shared", "-ffp-contract=off")
ZIG = (sys.executable, "-m", "ziglang", "cc", "-mcpu=baseline")  # by itself it takes whatever this processor has
EFFORT = "-O1"  # of CasADi's C: more takes twice as long and longer to compile, and the code is no faster
log = logging.getLogger(__name__)
T = TypeVar("T")


def compiled(functions: Sequence[ca.Function]) -> list[ca.Function]:
    """The same functions, evaluated as machine code where a C compiler exists, else as they are."""
    if not find_compiler():
        _note_once()
        return list(functions)

    def load(library: str) -> list[ca.Function]:
        return [ca.external(function.name(), library) for function in functions]

    return loaded(functions[0].name(), generate_c(functions), load, (EFFORT,)) or list(functions)


def loaded(name: str, source: str, load: Callable[[str], T], flags: Sequence[str] = ()) -> T | None:
    """What `load` makes of the library of a C source, compiled once per source, compiler, flags; None: no library."""
    compiler = find_compiler()
    if not compiler:
        _note_once()
        return None
    try:
        library = _library(name, source, [*compiler, *FLAGS, *flags])
    except (OSError, subprocess.SubprocessError, filelock.Timeout) as error:
        if not cache.lost(error):
            log.warning("compiling failed, using CasADi's virtual machine: %s", error)
        return None
    try:
        return load(str(library))
    except (RuntimeError, OSError) as error:  # built for another machine that shares the cache
        library.unlink(missing_ok=True)
        reason = str(error).splitlines()[0]
        log.warning("%s cannot be loaded and was removed, using CasADi's virtual machine: %s", library, reason)
        return None


def find_compiler() -> tuple[str, ...]:
    """Words of the command that compiles C; empty where there is none, or SERPENOID_COMPILE=0."""
    if os.environ.get("SERPENOID_COMPILE", "1") == "0":
        return ()
    own = shutil.which(os.environ.get("CC", "cc")) or shutil.which("gcc") or shutil.which("clang")
    if own:
        return (own,)
    return ZIG if importlib.util.find_spec("ziglang") else ()


@lru_cache(maxsize=1)
def _note_once() -> None:
    if os.environ.get("SERPENOID_COMPILE", "1") != "0":
        log.warning(
            "no C compiler found: the same results from CasADi's virtual machine, but many times slower. Install gcc "
            "or clang, or a compiler that comes as a Python package: pip install ziglang"
        )


def generate_c(functions: Sequence[ca.Function]) -> str:
    """C source of `functions`, each under its own name."""
    generator = ca.CodeGenerator("functions.c")
    for function in functions:
        generator.add(function)
    return generator.dump()


def _library(name: str, source: str, command: Sequence[str]) -> Path:
    key = hashlib.sha256("\0".join([source, *command]).encode()).hexdigest()[:24]
    folder = cache.place()
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    refuse_shared(folder)
    library = folder / f"{name}-{key}.so"
    if _is_whole(library):
        return library
    with filelock.FileLock(folder / f"{key}.lock", timeout=300):
        if not _is_whole(library):
            _build(source, command, library)
            write_text(_receipt(library), _digest(library))
    with contextlib.suppress(OSError):
        (folder / f"{key}.lock").unlink()
    return library


def refuse_shared(folder: Path) -> None:
    """A library runs as soon as it is loaded: InputError where somebody else could have put one there."""
    if not hasattr(os, "getuid"):
        return
    trusted = (os.getuid(), 0)
    place = folder.resolve()
    for path in (place, *place.parents):
        about = path.stat()
        open_to = stat.S_IWOTH | (stat.S_IWGRP if path == place else 0)
        shared = about.st_mode & open_to and not (path != place and about.st_mode & stat.S_ISVTX)
        if about.st_uid not in trusted or shared:
            why = "may be written to by other users" if shared else f"belongs to another user (uid {about.st_uid})"
            remedy = f"chmod go-w {path}, set" if shared and about.st_uid == os.getuid() else "Set"
            raise InputError(
                f"compile cache {folder}: {path} {why}, who could put a program of theirs in it. {remedy} "
                "SERPENOID_CACHE to a folder of your own, or SERPENOID_COMPILE=0 (slower, the same results)."
            )


def _receipt(library: Path) -> Path:
    return library.with_suffix(".sha256")


def _digest(library: Path) -> str:
    return hashlib.sha256(library.read_bytes()).hexdigest()


def _is_whole(library: Path) -> bool:
    """Whether it is the library that was built: a truncated one ends the process when it is loaded."""
    try:
        return _receipt(library).read_text(encoding="ascii") == _digest(library)
    except (OSError, ValueError):
        return False


def _build(source: str, command: Sequence[str], library: Path) -> None:
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder, atomic(library) as target:
        path = Path(folder) / "functions.c"
        path.write_text(source, encoding="utf-8")
        whole = [*command, str(path), "-o", str(target), "-lm"]
        result = subprocess.run(whole, capture_output=True, text=True, check=False, timeout=280)
        if result.returncode != 0:
            raise subprocess.SubprocessError(result.stderr[-2000:] or f"{command[0]} ended with {result.returncode}")
    log.info("compiled %s in %.1f s", library.name, time.perf_counter() - begin)
