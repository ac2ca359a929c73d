"""A process beside the first answers as the first would, whatever becomes of it, and leaves none behind."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from pathlib import Path

import pytest

from serpenoid.parallel import Beside, in_processes, limited

pytestmark = pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core: nothing is forked")
prepared: list[int] = []


def prepare() -> None:
    prepared.append(os.getpid())


def where(offset: int) -> tuple[int, list[int]]:
    """Process that works, and those that have prepared."""
    return os.getpid() + offset, prepared


def killed_unless_in(first: int) -> str:
    if os.getpid() != first:
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def refused() -> None:
    raise ValueError("this is refused.")


def pieces(folder: Path) -> None:
    """Forks pieces that say who they are, and never end."""
    in_processes([(piece, (folder,))] * 2)


def piece(folder: Path) -> None:
    (folder / str(os.getpid())).touch()
    time.sleep(600)


def test_what_is_asked_is_done_where_it_was_prepared() -> None:
    with Beside(prepare) as other:
        other.begin()
        other.begin()  # once is enough
        answers = [other.ask(where, 0)(), other.ask(where, 0)()]
    assert answers[0] == answers[1] == (answers[0][0], [answers[0][0]])
    assert answers[0][0] != os.getpid()
    assert not multiprocessing.active_children()


def test_what_was_never_begun_is_done_here() -> None:
    with Beside(prepare) as other:
        assert other.ask(where, 0)() == (os.getpid(), [])
    with limited(1), Beside(prepare) as other:
        other.begin()
        assert other.ask(where, 0)() == (os.getpid(), [])


def test_what_a_killed_process_was_asked_is_done_here() -> None:
    with Beside(prepare) as other:
        other.begin()
        assert other.ask(killed_unless_in, os.getpid())() == "done"
        assert other.ask(where, 0)() == (os.getpid(), [])  # and all that is asked later


def test_what_preparing_cannot_do_costs_no_answer() -> None:
    with Beside(sys.exit) as other:
        other.begin()
        assert other.ask(where, 0)() == (os.getpid(), [])


def test_what_is_raised_there_is_raised_here_with_its_place() -> None:
    with Beside(prepare) as other:
        other.begin()
        answer = other.ask(refused)
        with pytest.raises(ValueError, match="this is refused") as raised:
            answer()
    assert "in refused" in "".join(raised.value.__notes__)


def until(path: Path) -> str:
    """Busy until a file is there."""
    patience = time.monotonic() + 20
    while not path.exists():
        assert time.monotonic() < patience, "nobody goes on while this is busy"
        time.sleep(0.01)
    return "was busy"


def test_who_asks_goes_on_while_it_is_busy_however_much_is_asked(tmp_path: Path) -> None:
    with Beside(prepare) as other:
        other.begin()
        first, second = other.ask(until, tmp_path / "go"), other.ask(len, bytes(10**7))
        (tmp_path / "go").touch()
        assert (first(), second()) == ("was busy", 10**7)


def stopped_amid_pieces(folder: Path) -> None:
    with Beside(prepare) as other:
        other.begin()
        other.ask(pieces, folder)
        patience = time.monotonic() + 60
        while len(list(folder.iterdir())) < 2:
            assert time.monotonic() < patience
            time.sleep(0.01)
        raise KeyboardInterrupt


def test_a_stop_ends_it_and_the_pieces_that_it_has_forked(tmp_path: Path) -> None:
    with pytest.raises(KeyboardInterrupt):
        stopped_amid_pieces(tmp_path)
    assert not multiprocessing.active_children()
    for path in tmp_path.iterdir():
        with pytest.raises(ProcessLookupError):
            os.kill(int(path.name), 0)
