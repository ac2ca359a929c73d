"""Counts for results/benchmarks/robustness.md: mutated files of every kind.

PYTHONPATH=tests python benchmarks/robustness_files.py 1000
"""

from __future__ import annotations

import contextlib
import io
import os
import random
import sys
import tempfile
from collections import Counter
from pathlib import Path


def mutations(count: int) -> None:
    """A line per kind of file: how many mutants were refused by name, how many gave the same and another answer."""
    os.environ["SERPENOID_COMPILE"] = "0"
    from fuzz.mutate import KINDS
    from fuzz.specimens import SPECIMENS
    from fuzz.test_fuzz import attack

    for name, specimen in SPECIMENS.items():
        path = Path(tempfile.mkdtemp()) / "deep" / "er" / specimen.file
        path.parent.mkdir(parents=True)
        specimen.write(path)
        rng, found, tried = random.Random(count), Counter(), count // 20 if name == "c3d" else count
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            place = path, path.read_bytes(), specimen.read(path)
            for _ in range(tried):
                kind, where, what = rng.choice(sorted(KINDS)), rng.random(), rng.randrange(1000)
                again = None if rng.random() < 0.5 else (rng.choice(sorted(KINDS)), rng.random())
                try:
                    found[attack(specimen, place, kind, where, what, again)] += 1
                except Exception as error:  # noqa: BLE001 - what must not happen is counted
                    found["traceback, hang or unnamed"] += 1
                    sys.__stdout__.write(f"{name}: {kind} {where!r} {what} {again}: {error!r}\n")
        order = ("refused", "the same answer", "another answer", "traceback, hang or unnamed")
        sys.stdout.write(f"| {name} | {tried} | {' | '.join(str(found[k]) for k in order)} |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    mutations(int(sys.argv[1]))
