"""What the one parallel loop costs and gains: overhead of a task, tasks a second, and the same answers everywhere.

PYTHONPATH=src python benchmarks/cluster.py
"""

import os
import sys
import time
from pathlib import Path

from serpenoid import __version__
from serpenoid.parallel import Workers, in_order

TASKS, PIECES = 400, 24
WHERE = {
    "this process": Workers(),
    "1 process": Workers(jobs=1),
    "2 processes": Workers(jobs=2),
    "4 processes": Workers(jobs=4),
    "cluster local:1": Workers(cluster="local:1"),
    "cluster local:2": Workers(cluster="local:2"),
    "cluster local:4": Workers(cluster="local:4"),
}


def nothing(number: int) -> int:
    """The least there is to do."""
    return number


def work(number: int) -> float:
    """About a fifth of a second of one core: a gait simulated some hundred times."""
    import serpenoid as sp

    problem = sp.load(Path(__file__).parents[1] / "problems" / "reference.toml", set=[f"gait.a={4 + 0.05 * number}"])
    return sum(sp.simulate(problem).trajectory.displacement for _ in range(4))


def measured(function, tasks: list, workers: Workers) -> tuple[float, list]:
    """Wall seconds and answers; what it takes to start the workers is known from a single pair of tasks."""
    begun = time.perf_counter()
    in_order(nothing, [(0,), (1,)], workers)
    start = time.perf_counter() - begun
    begun = time.perf_counter()
    answers = in_order(function, tasks, workers)
    return max(time.perf_counter() - begun - start, 0.0), answers


def main() -> None:
    """Write results/benchmarks/cluster.md."""
    del WHERE["1 process"]
    rows, reference = [], None
    for name, workers in WHERE.items():
        seconds, _ = measured(nothing, [(n,) for n in range(TASKS)], workers)
        spent, answers = measured(work, [(n,) for n in range(PIECES)], workers)
        reference = reference or (answers, spent)
        same = "yes" if answers == reference[0] else "NO"
        rows.append(
            f"| {name} | {1e3 * seconds / TASKS:.2f} | {TASKS / max(seconds, 1e-9):.0f} | {spent:.2f} | "
            f"{reference[1] / spent:.2f} | {same} |"
        )
        sys.stdout.write(rows[-1] + "\n")
    load = os.getloadavg()[0]
    head = [
        "# One loop for all parallel work",
        "",
        "    PYTHONPATH=src python benchmarks/cluster.py",
        "",
        f"serpenoid {__version__}, {os.cpu_count()} cores, load {load:.1f} when written; wall time without the start.",
        "",
        f"{TASKS} tasks that do nothing tell the overhead, {PIECES} of some simulations each the gain.",
        "",
        "| where | overhead of a task [ms] | tasks a second | simulations [s] | times as fast | same to the last bit |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    page = Path(__file__).parents[1] / "results" / "benchmarks" / "cluster.md"
    page.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
