"""How well some of a trial's readings tell when it began, beside all of them, and what they cost.

    python benchmarks/late_starts.py > results/benchmarks/late_starts.md

Films without a servo log whose joints jump from row to row of the table and follow with a lag: nothing says when a
trial began. Rates of frames, noise, numbers of joints and rows are drawn at random; the servos' lag is known to 50 %,
so that the course is that of a model which is wrong, as in a search.
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.shapes import course as courses
from serpenoid.diagnose.data.shapes.course import Course, Readings

TRIALS = 60
MESH = 24  # moments a row


def drawn(rng: np.random.Generator) -> tuple[Readings, Course, float]:
    """Readings, a course that they are held against, and by how much later they were read than it says [s]."""
    joints, rows, cycle = int(rng.integers(3, 14)), int(rng.integers(20, 60)), rng.uniform(2.0, 7.0)
    fps, noise, lag = rng.uniform(25.0, 200.0), rng.uniform(0.002, 0.02), rng.uniform(0.02, 0.1)
    apart, cycles = cycle / rows, 3
    phase = 2 * np.pi * (np.arange(rows)[:, None] / rows + np.arange(joints) / joints)
    table = np.tile(rng.uniform(0.2, 0.8) * np.sin(phase), (cycles, 1))
    mesh = apart / MESH * np.arange(cycles * rows * MESH)
    late, wrong = rng.uniform(-0.4, 0.4) * apart * 3, lag * (1 + rng.uniform(-0.5, 0.5))

    def followed(by: float) -> np.ndarray:
        held, angles = np.repeat(table, MESH, axis=0), np.zeros((len(mesh), joints))
        angles[0] = table[0]
        for k in range(1, len(mesh)):
            angles[k] = held[k - 1] + (angles[k - 1] - held[k - 1]) * np.exp(-apart / MESH / by)
        return angles

    at = np.arange(0.5, cycles * cycle - 0.5, 1 / fps)
    seen = Course(mesh, followed(lag)).at(at - late) + rng.normal(0, noise, (len(at), joints))
    return Readings(at, seen, 0.25 * cycle, apart), Course(mesh, followed(wrong)), late


def found(trials: list[tuple[Readings, Course, float]], looked_at: int) -> tuple[np.ndarray, float]:
    """By how much later [s] each is found to begin, and the seconds that took."""
    courses.LOOKED_AT, begun = looked_at, time.perf_counter()
    late = np.array([replace(readings).late(course) for readings, course, _ in trials])
    return late, time.perf_counter() - begun


def main() -> None:
    """A table in Markdown."""
    rng = np.random.default_rng(0)
    trials = [drawn(rng) for _ in range(TRIALS)]
    every, seconds = found(trials, 10**9)
    sizes = [len(r.time) for r, _, _ in trials]
    lines = [
        "# When a trial began, by some of its readings\n\n`python benchmarks/late_starts.py`\n",
        f"{TRIALS} trials of {min(sizes)} to {max(sizes)} readings; differences from what all readings say.\n",
        "| readings looked at | trials that differ by > 0.1 ms | largest difference [ms] | time, of that for all |",
        "| --- | --- | --- | --- |",
    ]
    for looked_at in (50, 100, 200, 500, 1000):
        late, took = found(trials, looked_at)
        off = 1e3 * np.abs(late - every)
        lines.append(f"| {looked_at} | {(off > 0.1).sum()} | {off.max():.3f} | {took / seconds:.2f} |")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
