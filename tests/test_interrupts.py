"""An interrupt that a callback swallows is heard all the same."""

from __future__ import annotations

import os
import signal
import time

import pytest

from serpenoid import interrupts


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
