"""A folder is held by one process at a time, whatever it is called; the lock stands in it, and is not left there."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from serpenoid.errors import InputError
from serpenoid.files.alone import LOCK, alone


def test_a_path_that_is_no_utf_8_is_held_as_any_other(tmp_path: Path) -> None:
    path = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9")
    with alone(path, "taken"), pytest.raises(InputError, match="taken"), alone(path, "taken"):
        pass
    with alone(path, "taken"):
        pass


def test_one_that_waits_is_refused_only_after_that(tmp_path: Path) -> None:
    begun = time.monotonic()
    with alone(tmp_path, ""), pytest.raises(InputError, match="taken"), alone(tmp_path, "taken", 0.3):
        pass
    assert time.monotonic() - begun >= 0.3


CONTENDER = """
import os, sys
from pathlib import Path
from serpenoid.errors import InputError
from serpenoid.files.alone import alone
folder, inside = Path(sys.argv[1]), Path(sys.argv[2])
done = 0
while done < 300:
    try:
        with alone(folder, "taken"):
            os.close(os.open(inside, os.O_CREAT | os.O_EXCL))  # fails where two are within
            inside.unlink()
            done += 1
    except InputError:
        continue
"""


def test_of_many_that_make_and_remove_the_same_folder_one_at_a_time_is_within(tmp_path: Path) -> None:
    words = [sys.executable, "-c", CONTENDER, str(tmp_path / "out"), str(tmp_path / "inside")]
    contenders = [subprocess.Popen(words, stderr=subprocess.PIPE, text=True) for _ in range(4)]
    said = [contender.communicate()[1] for contender in contenders]
    assert [contender.returncode for contender in contenders] == [0] * 4, said
    assert not list(tmp_path.glob("*/*"))


def test_a_folder_is_held_from_whatever_temporary_folder(tmp_path: Path) -> None:
    words = [sys.executable, "-c", f"from serpenoid.files.alone import alone\nwith alone({str(tmp_path)!r}, ''): pass"]
    with alone(tmp_path, ""):
        other = subprocess.run(words, env=os.environ | {"TMPDIR": str(tmp_path)}, capture_output=True, text=True)
    assert "InputError" in other.stderr
    assert not list(tmp_path.iterdir())


def test_a_folder_that_was_made_in_vain_goes_with_those_above_it(tmp_path: Path) -> None:
    with alone(tmp_path / "new" / "out", ""):
        assert (tmp_path / "new" / "out" / LOCK).exists()
    assert not list(tmp_path.iterdir())


def test_what_a_killed_process_left_holds_nobody_up_and_goes(tmp_path: Path) -> None:
    (tmp_path / LOCK).touch()
    with alone(tmp_path, "taken"):
        pass
    assert not list(tmp_path.iterdir())


def test_a_folder_that_cannot_be_written_to_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"^/dev/null/out: .* cannot be written there"), alone("/dev/null/out", ""):
        pass
