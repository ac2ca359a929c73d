"""How long one diagnosis takes: the whole command, as users type it, figures and report included, on two cores.

The first campaigns of each kind of the blind study (`tests/blind/study.py`), and one campaign with ever more repeats.
Wall seconds hold only where nothing else runs; processor seconds stand beside them. Every run begins with compiled
functions (each campaign is diagnosed twice, and the second counts), with the package's byte code as Python keeps it
(a setting that keeps none is lifted: it costs 0.3 s), and without finished work (`SERPENOID_CACHE` in a folder of its
own).

    python benchmarks/diagnosis_time.py [campaigns of each kind [most repeats]]
"""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from bench import exponent, report, table

from blind.campaign import make
from blind.folder import write
from blind.protocol import usual
from blind.study import Study

COUNT = int(sys.argv[1]) if len(sys.argv) > 1 else 15
MEDIAN_S, LONGEST_S, LABORATORY_S = 5.0, 15.0, 30.0
KINDS = {
    "null": "nothing hidden",
    "one": "one effect",
    "two": "two effects",
    "outside": "outside the catalogue",
    "random": "any protocol",
}
MOST_PLAYS = int(sys.argv[2]) if len(sys.argv) > 2 else 8
PLAYS, SEED = [n for n in (1, 2, 4, 8) if n <= MOST_PLAYS], 11  # of each of eight settings
ROOT = Path(__file__).parents[1]
MODEL = ROOT / "problems" / "snake10.toml"


@dataclass(frozen=True)
class Took:
    """Wall and processor seconds of one command."""

    wall_s: float
    processor_s: float


def diagnosed(campaign: Path, out: Path, model: Path | None) -> Took:
    """One `serpenoid diagnose` on two cores."""
    words = ["diagnose", str(campaign), "--out", str(out), "--quiet", *(["--model", str(model)] if model else [])]
    cache = campaign.parent / "cache"
    shutil.rmtree(cache / "work", ignore_errors=True)
    cores = {*sorted(os.sched_getaffinity(0))[:2]}
    setting = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(
        [sys.executable, "-m", "serpenoid", *words],
        check=True,
        stdout=subprocess.DEVNULL,
        env=setting | {"SERPENOID_CACHE": str(cache), "PYTHONPYCACHEPREFIX": str(cache / "python")},
        preexec_fn=lambda: os.sched_setaffinity(0, cores),
    )
    took, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
    return Took(took, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def second(campaign: Path, out: Path, model: Path | None) -> Took:
    """The second of two: the first compiles what the effects that it tries need."""
    diagnosed(campaign, out.with_name(f"{out.name}-first"), model)
    return diagnosed(campaign, out, model)


def of_kind(kind: str, folder: Path) -> list[Took]:
    """The first campaigns of a kind."""
    model = None if kind == "random" else MODEL
    study = Study(kind, folder, str(model) if model else None)
    found = []
    for index in range(COUNT):
        name = study.identity(index)
        write(study.case(index).campaign, folder / name)
        found.append(second(folder / name, folder / f"out-{name}", model))
        sys.stderr.write(f"{kind} {index + 1}/{COUNT}: {found[-1].wall_s:.1f} s\n")
    return found


def kinds_table(folder: Path) -> str:
    """A line for each kind."""
    rows = []
    for kind, words in KINDS.items():
        found = of_kind(kind, folder)
        wall, processor = [t.wall_s for t in found], [t.processor_s for t in found]
        median, most = float(np.median(wall)), max(wall)
        met = "yes" if median <= MEDIAN_S and most <= LONGEST_S else "no"
        rows.append(
            [words, f"{median:.1f}", f"{most:.1f}", met, f"{np.median(processor):.1f}", f"{max(processor):.1f}"]
        )
    header = ["hidden", "median s", "longest s", "both targets", "processor s, median", "longest"]
    return table(header, rows)


def growth_table(folder: Path) -> str:
    """A line for each number of repeats."""
    rows, found = [], []
    for plays in PLAYS:
        c = make(SEED, 1, f"plays-{plays}", protocol=replace(usual(SEED), plays=plays))
        write(c, folder / c.identity)
        found.append(second(folder / c.identity, folder / f"out-{c.identity}", MODEL))
        rows.append([str(len(c.trials)), f"{found[-1].wall_s:.1f}", f"{found[-1].processor_s:.1f}"])
        sys.stderr.write(f"{len(c.trials)} trials: {found[-1].wall_s:.1f} s\n")
    limit = f"target for the last: {LABORATORY_S:.0f} s"
    if len(PLAYS) > 1:
        power = exponent([8.0 * p for p in PLAYS], [t.processor_s for t in found])
        limit += f"; processor time grows with trials to the power {power:.2f}"
    return table(["trials", "s", "processor s"], rows) + f"\n\n{limit}."


def main() -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        both = kinds_table(folder), growth_table(folder)
    report(
        "diagnosis_time",
        f"One diagnosis on two cores (targets: median {MEDIAN_S:.0f} s, longest {LONGEST_S:.0f} s)",
        f"{COUNT} campaigns each, 16 trials of 3 cycles at 120 frames a second but for those of any protocol; figures "
        "and report included.",
        *both,
        measure="wall seconds, two cores",
    )


if __name__ == "__main__":
    main()
