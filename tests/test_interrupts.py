"""An interrupt that a callback swallows is heard all the same."""

from __future__ import annotations

import os
import signal
import threading
import time

import pytest

from serpenoid import interrupts
from serpenoid.cli.campaigns import KEPT
from serpenoid.cli.main import main
from serpenoid.errors import InputError
from serpenoid.parallel.local import interrupts_held


class _Interrupting:
    """Ctrl-C comes as this goes, where Python drops exceptions."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)
        time.sleep(0)  # Python looks for signals between instructions


def _interrupted() -> None:
    with interrupts.listening() as noted:
        lost = _Interrupting()
        del lost
        assert noted == [signal.SIGINT]  # noted, not raised
        patience = time.monotonic() + 30
        try:
            while time.monotonic() < patience:
                time.sleep(0.01)
        finally:
            assert noted == [signal.SIGINT, signal.SIGINT]


def test_ctrl_c_in_a_destructor_is_heard_a_moment_later(capsys: pytest.CaptureFixture[str]) -> None:
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        _interrupted()
    assert interrupts.noted == []
    assert "Traceback" not in capsys.readouterr().err
    assert signal.getsignal(signal.SIGINT) is before


def test_what_else_python_cannot_raise_is_still_told(monkeypatch: pytest.MonkeyPatch) -> None:
    told: list[type] = []
    monkeypatch.setattr("sys.unraisablehook", lambda lost: told.append(lost.exc_type))

    class Broken:
        def __del__(self) -> None:
            raise ValueError

    with interrupts.listening():
        lost = Broken()
        del lost
    assert told == [ValueError]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_another_thread_is_sent_amid_a_fork_waits_for_its_end(number: signal.Signals) -> None:
    """The mask is a thread's own; Python raises in the first thread what any of them is sent."""
    reached = []

    def send() -> None:
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
        signal.pthread_kill(threading.get_ident(), number)

    def held() -> None:
        with interrupts_held(tracked=False):
            other = threading.Thread(target=send)
            other.start()
            other.join()
            time.sleep(0.01)
            reached.append("the end")

    with pytest.raises(KeyboardInterrupt), interrupts.listening() as noted:
        held()
    assert reached == ["the end"]
    assert not noted
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("turned_into", [SystemError, RuntimeError, InputError, OSError])
def test_whatever_a_library_makes_of_ctrl_c_the_command_is_stopped_without_a_traceback(
    turned_into: type[Exception], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def lose(_args: object) -> int:
        try:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(1)
        except KeyboardInterrupt as interrupt:
            raise turned_into("returned a result with an exception set") from interrupt
        return 0

    monkeypatch.setattr("serpenoid.cli.fit.run", lose)
    assert main(["fit", "somewhere"]) == 130
    assert capsys.readouterr().err == f"serpenoid: stopped. {KEPT}\n"
