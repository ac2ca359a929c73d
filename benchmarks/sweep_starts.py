"""Sweeps over six values of c begun with 1 to 24 starts, of other bodies: processor time, and what each misses.

    python benchmarks/sweep_starts.py > results/benchmarks/sweep_starts.md

Missed: the largest excess of a cost over the best that any of them found at that c, where it is beyond 1e-6.
"""

from __future__ import annotations

import sys
import time

import numpy as np

from serpenoid import load
from serpenoid.studies.sweep import sweep

STARTS, VALUES = (1, 4, 8, 12), np.linspace(0, 2.5, 6)
UNEQUAL = {5: "[0.6,1.8,0.5,1.1,0.7,1.9]", 12: "[1.9,0.5,0.8,1.6,0.6,1.2,1.9,0.7,0.5,1.4,1.0,0.6,1.7]"}


def bodies() -> dict[str, list[str]]:
    """reference-optimum.toml with other bodies and ratios."""
    found = {}
    for joints in (5, 12, 20):
        for eps in (0.05, 0.1865, 0.5):
            limit = 60.0 * 10 / max(joints, 10)
            changes = [f"body.vertices={joints + 2}", f"body.joint_limit_deg={limit}"]
            found[f"{joints} joints, eps {eps}"] = [*changes, f"medium.anisotropy_ratio={eps}"]
    for joints, lengths in UNEQUAL.items():
        changes = [f"body.vertices={joints + 2}", f"body.edge_lengths={lengths}", "medium.anisotropy_ratio=0.3"]
        found[f"{joints} joints, unequal links, eps 0.3"] = changes
    return found


def main() -> None:
    write = sys.stdout.write
    write(
        "# Starts of a sweep\n\nSix values of c from 0 to 2.5, not polished: processor seconds, and the largest excess "
        "of a cost over the best that any\nof these found there (0: none beyond 1e-6). "
        "`python benchmarks/sweep_starts.py`.\n\n"
        "| body | " + " | ".join(f"{n} start{'s' * (n > 1)}" for n in STARTS) + " |\n"
    )
    write("| :-- |" + " --: |" * len(STARTS) + "\n")
    for name, changes in bodies().items():
        problem = load("problems/reference-optimum.toml", set=changes)
        costs, seconds = [], []
        for starts in STARTS:
            begin = time.process_time()
            found = sweep(problem, VALUES, starts, seed=0, polish=False)
            seconds.append(time.process_time() - begin)
            costs.append([p.solution.objective if p.solution else np.inf for p in found.points])
        missed = (np.array(costs) - np.min(costs, 0)).max(1)
        cells = [f"{s:.1f} s, {m:.1e}" if m > 1e-6 else f"{s:.1f} s, 0" for s, m in zip(seconds, missed, strict=True)]
        write(f"| {name} | " + " | ".join(cells) + " |\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
