"""The one loop for all parallel work: a function of many tasks, here, in processes of this machine or on a cluster.

Whatever runs it, each task gives the same answer to the last bit: tasks share nothing, and their results are told apart
by their index, not by when they came. A task whose worker is killed runs again. Whoever stops listening stops the work.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from serpenoid.parallel.beside import Beside
from serpenoid.parallel.forks import in_processes, limited, meanwhile

T = TypeVar("T")
Task = tuple[Any, ...]

__all__ = ["Beside", "Workers", "in_processes", "limited", "meanwhile", "results"]


@dataclass(frozen=True)
class Workers:
    """Where tasks run: `jobs` processes of this machine, or a Dask cluster: a scheduler's address, or `local:8`."""

    jobs: int = 1
    cluster: str | None = None


def results(function: Callable[..., T], tasks: Sequence[Task], workers: Workers) -> Iterator[tuple[int, T]]:
    """(index, `function(*task)`) of every task, as they are finished. Function, tasks and results must be picklable."""
    if workers.cluster is not None:
        from serpenoid.parallel.cluster import on_cluster

        yield from on_cluster(_alone, [(function, *task) for task in tasks], workers.cluster)
    elif workers.jobs == 1 or len(tasks) < 2:
        for index, task in enumerate(tasks):
            yield index, function(*task)
    else:
        from serpenoid.parallel.local import in_pool

        yield from in_pool(_alone, [(function, *task) for task in tasks], workers.jobs)


def _alone(function: Callable[..., T], *task: Any) -> T:
    """A task in a process of its own, which starts no others: the cores are taken."""
    with limited(1):
        return function(*task)
