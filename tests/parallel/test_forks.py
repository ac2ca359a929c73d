"""Forked workers end when they are told to, whatever they hold; none that is lost takes an answer with it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable

import numpy as np
import pytest

from serpenoid.parallel import Beside, forks, in_processes, limited, meanwhile

pytestmark = pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core: nothing is forked")
FIRST = os.getpid()


def at_term() -> tuple[int, bool]:
    """Process, and whether SIGTERM ends it at once; it takes so long that nobody has time for all."""
    time.sleep(0.1)
    return os.getpid(), signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


def killed_unless_first(number: int) -> int:
    """Any worker that gets an odd number is killed, as by a machine without memory."""
    if number % 2 and os.getpid() != FIRST:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def much(seed: int) -> np.ndarray:
    """More than a pipe holds: the worker is in the middle of its answer while nobody reads."""
    return np.full(2_000_000, float(seed))


def refused(number: int) -> int:
    if number == 3:
        raise ValueError("number 3 is refused.")
    return number


def late_if_three(number: int) -> int:
    """Refuses all from 3 on, 3 last."""
    if number > 3:
        raise ValueError(f"number {number} is refused.")
    time.sleep(0.05 * (number == 3))
    return refused(number)


def unsendable() -> Callable[[], int]:
    time.sleep(0.1)
    return lambda: 0


def strided() -> np.ndarray:
    """Every other column of an array that lies in columns: no process sends the gaps."""
    return np.asfortranarray(np.arange(24.0).reshape(4, 6))[:, ::2]


def test_answers_lie_in_memory_alike_wherever_they_are_found() -> None:
    """Sums go by it, in their last bits, and a search by sums: with one core and with two it must end the same."""
    several = in_processes([(strided, ())] * 4)
    with meanwhile(strided) as there:
        several.append(there())
    with limited(1):
        several += in_processes([(strided, ())])
        with meanwhile(strided) as here:
            several.append(here())
        with Beside(strided) as other:
            several.append(other.ask(strided)())
    assert len({answer.strides for answer in several}) == 1
    assert several[0].strides != strided().strides


def test_workers_do_not_inherit_a_handler_of_sigterm() -> None:
    before = signal.signal(signal.SIGTERM, lambda number, frame: None)
    try:
        found = in_processes([(at_term, ())] * 4)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert {process == FIRST for process, _ in found} == {True, False}  # the first process works, too
    assert all(ends for process, ends in found if process != FIRST)


def test_every_task_is_done_once_and_heard_of_in_order_however_many_they_are() -> None:
    heard: list[int] = []
    assert in_processes([(abs, (-n,)) for n in range(2501)], heard.append) == list(range(2501))
    assert heard == list(range(2501))


def test_what_a_killed_worker_had_begun_is_done_here() -> None:
    assert in_processes([(killed_unless_first, (n,)) for n in range(9)]) == list(range(9))


def test_a_stop_amid_large_answers_ends_all_workers_at_once() -> None:
    """A pool whose workers share a lock waited for ever, seldom, for the one that held it."""

    def stop(index: int) -> None:
        if index == 2:
            raise KeyboardInterrupt

    for _ in range(5):
        begun = time.monotonic()
        with pytest.raises(KeyboardInterrupt):
            in_processes([(much, (n,)) for n in range(8)], stop)
        assert not multiprocessing.active_children()
        assert time.monotonic() - begun < 60  # seconds where the old one waited for ever


def test_an_interrupt_that_got_lost_in_a_library_is_heard_before_the_next_piece(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    noted: list[int] = []
    monkeypatch.setattr(forks, "noted", noted)
    with pytest.raises(KeyboardInterrupt):
        in_processes([(time.sleep, (0.05,))] * 9, lambda index: noted.append(signal.SIGINT))
    assert not multiprocessing.active_children()


def test_of_several_faults_the_first_in_order_is_raised() -> None:
    for _ in range(5):
        with pytest.raises(ValueError, match="number 3 is refused"):
            in_processes([(late_if_three, (n,)) for n in range(8)])


def test_what_a_task_raises_arrives_with_its_place_and_ends_the_others() -> None:
    with pytest.raises(ValueError, match="number 3 is refused") as raised:
        in_processes([(refused, (n,)) for n in range(50)])
    assert "in refused" in "".join(raised.value.__notes__)
    assert not multiprocessing.active_children()


def test_an_answer_that_cannot_be_sent_is_an_error_and_no_wait() -> None:
    with pytest.raises(Exception, match="pickle|local object"):
        in_processes([(unsendable, ())] * 4)


def test_what_is_done_meanwhile_is_waited_for_and_done_here_if_its_process_was_killed() -> None:
    with meanwhile(at_term) as found:
        process, ends = found()
    assert process != os.getpid()
    assert ends
    with meanwhile(killed_unless_first, 1) as found:
        assert found() == 1
    with meanwhile(refused, 3) as found, pytest.raises(ValueError, match="number 3 is refused"):
        found()
    with limited(1), meanwhile(os.getpid) as found:
        assert found() == os.getpid()
    assert not multiprocessing.active_children()


def deaf_to_term() -> None:
    """As one whose SIGTERM came while it was forked, and was lost."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    time.sleep(60)


def test_a_worker_that_has_not_heard_sigterm_is_ended_all_the_same() -> None:
    begun = time.monotonic()
    with meanwhile(deaf_to_term):
        time.sleep(0.5)
    assert time.monotonic() - begun < 30
    assert not multiprocessing.active_children()
