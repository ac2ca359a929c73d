"""What the one parallel loop costs and gains: overhead of a task, tasks a second, and the same answers everywhere.

PYTHONPATH=src python benchmarks/cluster.py
"""

import os
import sys
import time
from pathlib import Path

from serpenoid import __version__
from serpenoid.parallel import Workers, results

TASKS, PIECES = 400, 16
WHERE = {
    "this process": Workers(),
    "2 processes": Workers(jobs=2),
    "cluster local:1": Workers(cluster="local:1"),
    "cluster local:2": Workers(cluster="local:2"),
}


def nothing(number: int) -> int:
    """The least there is to do."""
    return number


def work(number: int) -> float:
    """About a fifth of a second of one core: a gait simulated some hundred times."""
    import serpenoid as sp

    problem = sp.load(Path(__file__).parents[1] / "problems" / "reference.toml", set=[f"gait.a={4 + 0.05 * number}"])
    return sum(sp.simulate(problem).trajectory.displacement for _ in range(20))


def measured(function, tasks: list, workers: Workers) -> tuple[float, list]:
    """Wall seconds a task from the first answer to the last, so without the start of the workers; and the answers."""
    times, answers = [], {}
    for index, answer in results(function, tasks, workers):
        times.append(time.perf_counter())
        answers[index] = answer
    return (times[-1] - times[0]) / (len(tasks) - 1), [answers[i] for i in range(len(tasks))]


def main() -> None:
    """Write results/benchmarks/cluster.md."""
    rows, reference = [], None
    for name, workers in WHERE.items():
        overhead, _ = measured(nothing, [(n,) for n in range(TASKS)], workers)
        spent, answers = measured(work, [(n,) for n in range(PIECES)], workers)
        reference = reference or (answers, spent)
        same = "yes" if answers == reference[0] else "NO"
        rows.append(
            f"| {name} | {1e3 * overhead:.3f} | {1 / overhead:.0f} | {spent:.3f} | "
            f"{reference[1] / spent:.2f} | {same} |"
        )
        sys.stdout.write(rows[-1] + "\n")
    load = os.getloadavg()[0]
    head = [
        "# One loop for all parallel work",
        "",
        "    PYTHONPATH=src python benchmarks/cluster.py",
        "",
        f"serpenoid {__version__}, {os.cpu_count()} cores, load {load:.1f} when written; first answer to last.",
        "",
        f"{TASKS} tasks that do nothing tell the overhead, {PIECES} of some simulations each the gain.",
        "Where the load is above the number of cores, overheads are larger and gains smaller than on a quiet machine.",
        "",
        "| where | overhead of a task [ms] | tasks a second | simulations: s a task | times as fast | same bits |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    page = Path(__file__).parents[1] / "results" / "benchmarks" / "cluster.md"
    page.write_text("\n".join([*head, *rows]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
