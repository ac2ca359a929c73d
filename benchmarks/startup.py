"""Time to import the package and to show help, in fresh interpreters."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import numpy as np
from bench import in_units, report, table

ROUNDS = 15
WORK = {
    "the interpreter alone": ["-c", "pass"],
    "import serpenoid": ["-c", "import serpenoid"],
    "serpenoid --help": ["-m", "serpenoid", "--help"],
    "serpenoid solve --help": ["-m", "serpenoid", "solve", "--help"],
    "import serpenoid; serpenoid.solve (CasADi, SciPy)": ["-c", "import serpenoid; serpenoid.solve"],
}


def main() -> None:
    seconds: dict[str, list[float]] = {name: [] for name in WORK}
    for _ in range(ROUNDS):
        for name, words in WORK.items():
            begin = time.perf_counter()
            subprocess.run([sys.executable, *words], check=True, stdout=subprocess.DEVNULL, env=os.environ)
            seconds[name].append(time.perf_counter() - begin)  # wall: waiting for the disk is part of starting
    rows = [[name, in_units(min(s)), in_units(float(np.median(s)))] for name, s in seconds.items()]
    worst = max(float(np.median(seconds[name])) for name in list(WORK)[1:4])
    target = ["import and --help", "0.5 s", in_units(worst), "yes" if worst <= 0.5 else "no"]
    report(
        "startup",
        "Import and help (wall time)",
        table(["target", "asked", "found (slowest median)", "met"], [target]),
        table(["fresh interpreter", "fastest", "median"], rows),
    )


if __name__ == "__main__":
    main()
