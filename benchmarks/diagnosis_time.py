"""How long one diagnosis takes, alone on the machine: the whole command, as users type it, on hidden-effect campaigns.

The first campaigns of each kind of the blind study (`tests/blind/study.py`), whatever is hidden in them; some of them
on one core, too. Seconds are wall time, so nothing else may run beside it.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from bench import report, table

from blind.folder import write
from blind.study import Study

COUNT, ON_ONE_CORE = 15, 3
TARGET_S = 20.0
KINDS = {"null": "nothing hidden", "one": "one effect", "two": "two effects", "outside": "outside the catalogue"}
ROOT = Path(__file__).parents[1]
MODEL = ROOT / "problems" / "snake10.toml"


def diagnosed(campaign: Path, out: Path, cores: set[int]) -> float:
    """Wall time [s] of `serpenoid diagnose` on some of the cores, figures and report included."""
    words = ["diagnose", str(campaign), "--model", str(MODEL), "--out", str(out), "--quiet"]
    usual = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)  # children inherit it
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-m", "serpenoid", *words], check=True, stdout=subprocess.DEVNULL)
    took = time.perf_counter() - begin
    os.sched_setaffinity(0, usual)
    return took


def measured(kind: str, folder: Path) -> tuple[list[float], list[float]]:
    """Seconds on two cores of every campaign of a kind, and ratios one core / two of the first ones."""
    study = Study(kind, folder, str(MODEL))
    both = set(sorted(os.sched_getaffinity(0))[:2])
    took, ratios = [], []
    for index in range(COUNT):
        name = study.identity(index)
        write(study.case(index).campaign, folder / name)
        took.append(diagnosed(folder / name, folder / "out", both))
        if index < ON_ONE_CORE:
            ratios.append(diagnosed(folder / name, folder / "alone", {min(both)}) / took[-1])
        sys.stderr.write(f"{kind} {index + 1}/{COUNT}: {took[-1]:.1f} s\n")
    return took, ratios


def main() -> None:
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for kind, words in KINDS.items():
            took, ratios = measured(kind, Path(folder))
            within = sum(t <= TARGET_S for t in took)
            median, most = np.median(took), max(took)
            met = "yes" if within == COUNT else "no"
            one = f"{np.median(ratios):.2f}"
            rows.append(
                [words, f"{median:.1f}", f"{median / TARGET_S:.2f}", f"{most:.1f}", f"{within} of {COUNT}", met, one]
            )
    header = ["hidden", "median s", "of the target", "longest s", "within", "all within", "one core / two"]
    report(
        "diagnosis_time",
        f"One diagnosis on two cores (target {TARGET_S:.0f} s)",
        f"{COUNT} campaigns each, 16 trials of 3 cycles at 120 frames a second; figures and report included.",
        table(header, rows),
        measure="wall seconds, two cores",
    )


if __name__ == "__main__":
    main()
