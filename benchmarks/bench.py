"""What all benchmarks share: timing side by side, switching compilation, and a Markdown report with its versions.

What is timed with `clock` runs on one core, and seconds are processor seconds of the process: on a machine that others
use, wall time measures them. What is left of their noise goes upwards only, so alternatives are timed in turn, round
after round, and both the fastest and the median round are kept. Ratios are of the fastest rounds.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import casadi
import numpy as np
import scipy

from serpenoid.files.writing import write_text
from specimens import forget_functions

clock = time.process_time
REPORTS = Path(__file__).parents[1] / "results" / "benchmarks"


@dataclass(frozen=True)
class Timing:
    """Seconds per call over all rounds."""

    fastest: float
    median: float

    @property
    def shown(self) -> str:
        """Fastest and median in fitting units."""
        return f"{in_units(self.fastest)} ({in_units(self.median)})"


def in_units(seconds: float) -> str:
    """1.23 ms and the like."""
    for scale, unit in ((1.0, "s"), (1e-3, "ms"), (1e-6, "us")):
        if seconds >= scale or unit == "us":
            return f"{seconds / scale:.3g} {unit}"
    return ""


def side_by_side(work: Mapping[str, tuple[Callable[[], object], int]], rounds: int) -> dict[str, Timing]:
    """Time each (function, calls per round) in turn, `rounds` times; every function is warmed up once."""
    for function, _ in work.values():
        function()
    seconds: dict[str, list[float]] = {name: [] for name in work}
    for _ in range(rounds):
        for name, (function, calls) in work.items():
            begin = clock()
            for _ in range(calls):
                function()
            seconds[name].append((clock() - begin) / calls)
    return {name: Timing(min(values), float(np.median(values))) for name, values in seconds.items()}


@contextmanager
def evaluation(compiled: bool) -> Iterator[None]:
    """Inside: functions are prepared anew, compiled or interpreted."""
    before = os.environ.get("SERPENOID_COMPILE")
    os.environ["SERPENOID_COMPILE"] = "1" if compiled else "0"
    forget_functions()
    try:
        yield
    finally:
        if before is None:
            del os.environ["SERPENOID_COMPILE"]
        else:
            os.environ["SERPENOID_COMPILE"] = before
        forget_functions()


@contextmanager
def empty_cache() -> Iterator[None]:
    """Inside: nothing has been compiled yet."""
    before = os.environ.get("SERPENOID_CACHE")
    with tempfile.TemporaryDirectory() as folder:
        os.environ["SERPENOID_CACHE"] = folder
        forget_functions()
        yield
    forget_functions()
    if before is None:
        del os.environ["SERPENOID_CACHE"]
    else:
        os.environ["SERPENOID_CACHE"] = before


def exponent(sizes: Sequence[float], seconds: Sequence[float]) -> float:
    """Slope of log time over log size."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A Markdown table."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(str(cell) for cell in line) + " |" for line in lines) + "\n"


def commit() -> str:
    """Of the sources that ran."""
    found = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True)
    return found.stdout.strip()


def report(name: str, title: str, *parts: str, measure: str = "processor seconds, one core") -> None:
    """Print the report and write it to results/benchmarks/<name>.md; measure: what seconds are."""
    load = f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"
    versions = f"Python {platform.python_version()}, CasADi {casadi.__version__}, NumPy {np.__version__}"
    versions += f", SciPy {scipy.__version__}; {os.cpu_count()} cores, load {load} when written;"
    versions += f" {measure}; at commit {commit()}"
    command = f"    PYTHONPATH=src:tests python benchmarks/{name}.py"
    text = "\n\n".join([f"# {title}", command, versions, *(part.strip() for part in parts)]) + "\n"
    write_text(REPORTS / f"{name}.md", text)
    sys.stdout.write(text)
