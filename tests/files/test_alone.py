"""A path is held by one process at a time, whatever it is called."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from serpenoid.errors import InputError
from serpenoid.files.alone import alone


def test_a_path_that_is_no_utf_8_is_held_as_any_other(tmp_path: Path) -> None:
    path = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9")
    with alone("test", path, "taken"), pytest.raises(InputError, match="taken"), alone("test", path, "taken"):
        pass
    with alone("test", path, "taken"):
        pass


def test_one_that_waits_is_refused_only_after_that(tmp_path: Path) -> None:
    begun = time.monotonic()
    with alone("test", tmp_path, ""), pytest.raises(InputError, match="taken"), alone("test", tmp_path, "taken", 0.3):
        pass
    assert time.monotonic() - begun >= 0.3
