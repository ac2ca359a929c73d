"""Forked workers end when they are told to, whatever the first process does with signals."""

from __future__ import annotations

import os
import signal

import pytest

from serpenoid.parallel import in_processes


def at_term() -> tuple[int, bool]:
    """Process, and whether SIGTERM ends it at once."""
    return os.getpid(), signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="one core: nothing is forked")
def test_workers_do_not_inherit_a_handler_of_sigterm() -> None:
    before = signal.signal(signal.SIGTERM, lambda number, frame: None)
    try:
        found = in_processes([(at_term, ())] * 4)
    finally:
        signal.signal(signal.SIGTERM, before)
    assert all(process != os.getpid() and ends for process, ends in found)
