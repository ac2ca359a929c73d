"""Files that are either whole or absent: written beside their place and renamed into it."""

from __future__ import annotations

import csv
import hashlib
import json
import os
import platform
import tempfile
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

ESCAPED = "backslashreplace"  # how a file's name in no encoding of the system stands in a text that is UTF-8
UNFINISHED = ".writing-"
EARLIER = "earlier-"  # begins the folder of what --force moved aside
CHAIN = "chain"  # the folder of solved points within a results folder


@contextmanager
def atomic(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path in the same folder; on success it replaces `path`, on error it is removed."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    descriptor, name = tempfile.mkstemp(dir=path.parent, prefix=f"{UNFINISHED}{path.stem}-", suffix=path.suffix)
    os.close(descriptor)
    try:
        yield Path(name)
        os.chmod(name, 0o644)
        os.replace(name, path)
    except OSError as error:  # a full disk: name the file that it was for
        Path(name).unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def clear_unfinished(folder: Path) -> None:
    """Remove what a process that was killed left of files it was writing."""
    for path in folder.rglob(f"{UNFINISHED}*"):
        if path.is_file():
            path.unlink(missing_ok=True)


def write_text(path: str | Path, text: str) -> None:
    with atomic(path) as temporary:
        temporary.write_text(text, encoding="utf-8", errors=ESCAPED)


def write_json(path: str | Path, data: Any) -> None:
    """Write JSON without NaN (null stands for an unknown number)."""
    write_text(path, json.dumps(data, indent=2, allow_nan=False) + "\n")


def write_csv(path: str | Path, header: Sequence[str], rows: Iterable[Sequence[Any]]) -> None:
    """Write a CSV with full-precision floats."""
    with atomic(path) as temporary, temporary.open("w", newline="", encoding="utf-8", errors=ESCAPED) as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows([_plain(cell) for cell in row] for row in rows)


def examples() -> Path:
    """Problem, robot, protocol and campaign files that come with the package; in a checkout they stand in problems/."""
    packaged = Path(__file__).parents[1] / "examples"
    return packaged if packaged.is_dir() else Path(__file__).parents[3] / "problems"


def toml_string(text: str) -> str:
    """A basic string of TOML: JSON's escapes, and no other character that TOML forbids."""
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def short_hash(*parts: Any) -> str:
    """Eight hexadecimal digits that change with any of `parts` (made of JSON values)."""
    text = json.dumps(parts, sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def provenance(**extra: Any) -> dict[str, Any]:
    """What is needed to make a result again: versions, time, and what the caller adds (problem hash, seed)."""
    versions = {name: _version(name) for name in ("serpenoid", "casadi", "numpy", "scipy")}
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return {"versions": versions, "python": platform.python_version(), "written": now, **extra}


def _plain(cell: Any) -> Any:
    return repr(float(cell)) if isinstance(cell, float) else cell


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "unknown"
