"""One loop for all parallel work: the same answers anywhere, none lost with a worker, none begun after a stop."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

from serpenoid.errors import InputError
from serpenoid.parallel import Workers, in_processes, limited, results

pytest.importorskip("distributed", reason="needs the extra `cluster`")
T = TypeVar("T")
ANYWHERE = [Workers(), Workers(jobs=2), Workers(cluster="local:2")]


def in_order(function: Callable[..., T], tasks: Sequence[tuple[Any, ...]], workers: Workers) -> list[T]:
    """All results, in the order of their tasks."""
    return [result for _, result in sorted(results(function, tasks, workers), key=lambda pair: pair[0])]


def chaos(seed: int) -> list[float]:
    """Numbers in which any difference in the order of operations would show."""
    x = np.random.default_rng(seed).normal(size=500)
    for _ in range(50):
        x = np.sin(3.9 * x) + x.mean()
    return [float(x[0]), float(x.sum())]


def dies_once(folder: str, number: int) -> int:
    """Kills its own process the first time that number 3 is asked for."""
    mark = Path(folder) / "died"
    if number == 3 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return number * number


def always_dies(_number: int) -> None:
    os.kill(os.getpid(), signal.SIGKILL)


def fails(number: int) -> int:
    if number == 1:
        raise InputError("number 1 is refused.")
    return number


def inner_cores(_number: int) -> list[int]:
    """Processes that a task's own pieces ran in."""
    return sorted({pid for pid in in_processes([(os.getpid, ())] * 4)} - {os.getpid()})


def interrupted(number: int) -> tuple[bool, int]:
    """Whether this process was started deaf to Ctrl-C, and a number, in spite of an interrupt let in meanwhile."""
    deaf = signal.SIGINT in signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(0.01)
    return deaf, number


def deaf(_number: int) -> bool:
    """Whether an interrupt is kept from the thread that runs this."""
    return signal.SIGINT in signal.pthread_sigmask(signal.SIG_BLOCK, [])


def slow(folder: str, number: int) -> int:
    (Path(folder) / str(number)).touch()
    time.sleep(0.2)
    return number


def test_answers_are_equal_to_the_last_bit_wherever_tasks_run() -> None:
    tasks = [(seed,) for seed in range(6)]
    alone, *others = [in_order(chaos, tasks, workers) for workers in ANYWHERE]
    assert others == [alone, alone]


@pytest.mark.parametrize(  # processes of this machine: tests/studies/test_many_starts.py, too
    "workers", [pytest.param(ANYWHERE[1], marks=pytest.mark.slow), ANYWHERE[2]], ids=["local", "cluster"]
)
def test_a_killed_worker_loses_nothing(tmp_path: Path, workers: Workers) -> None:
    assert in_order(dies_once, [(str(tmp_path), n) for n in range(8)], workers) == [n * n for n in range(8)]
    assert (tmp_path / "died").exists()


def test_workers_are_deaf_to_an_interrupt_from_their_start_to_their_end() -> None:
    """A terminal sends it to all: whoever started the workers stops them, and they have nothing to say."""
    found = in_order(interrupted, [(n,) for n in range(6)], Workers(jobs=2))
    assert [number for _, number in found] == list(range(6))
    assert any(deaf for deaf, _ in found)  # a process's first task still has the mask it was started with


def test_workers_of_a_cluster_of_this_machine_are_deaf_to_an_interrupt() -> None:
    assert in_order(deaf, [(0,), (1,)], ANYWHERE[2]) == [True, True]


@pytest.mark.slow
def test_a_task_that_kills_every_worker_is_given_up_with_a_sentence() -> None:
    with pytest.raises(InputError, match="workers were killed 4 times"):
        in_order(always_dies, [(0,), (1,)], Workers(jobs=2))


@pytest.mark.parametrize(
    "workers",
    [ANYWHERE[0], pytest.param(ANYWHERE[1], marks=pytest.mark.slow), ANYWHERE[2]],
    ids=["alone", "local", "cluster"],
)
def test_what_a_task_complains_of_arrives(workers: Workers) -> None:
    with pytest.raises(InputError, match="number 1 is refused"):
        in_order(fails, [(n,) for n in range(3)], workers)


def test_who_stops_listening_stops_the_work(tmp_path: Path) -> None:
    found = results(slow, [(str(tmp_path), n) for n in range(40)], Workers(jobs=2))
    next(found)
    found.close()
    begun = len(list(tmp_path.iterdir()))
    time.sleep(0.5)
    assert len(list(tmp_path.iterdir())) == begun < 40


@pytest.mark.parametrize(
    "workers", [ANYWHERE[1], pytest.param(ANYWHERE[2], marks=pytest.mark.slow)], ids=["local", "cluster"]
)
def test_a_task_among_others_starts_no_processes_of_its_own(workers: Workers) -> None:
    assert in_order(inner_cores, [(0,), (1,)], workers) == [[], []]


def test_pieces_of_a_task_keep_to_the_cores_that_are_allowed() -> None:
    with limited(1):
        assert inner_cores(0) == []


def test_a_cluster_that_does_not_answer_is_named() -> None:
    for address, said in (("local:0", "number of workers"), ("nowhere", "no scheduler answers")):
        with pytest.raises(InputError, match=said):
            in_order(chaos, [(0,)], Workers(cluster=address))
