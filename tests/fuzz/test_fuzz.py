"""Every reader against mutated files: an InputError that names the file, or an answer; no traceback, hang, stray file.

An answer to a table in which a number has become what is none (`inf`, `1_000`, digits of another script) must be the
answer to the file as it was.
"""

from __future__ import annotations

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from fuzz.mutate import KINDS, NUMBER, mutate
from fuzz.specimens import SPECIMENS, Specimen
from serpenoid.errors import InputError

EXAMPLES = 118  # of each of 17 kinds of file, and fewer where a process is started for each: 2014 in the normal run
FEW = 8
MORE = 3000  # with --run-slow
HANG_S = 10
mutations = given(
    kind=st.sampled_from(sorted(KINDS)),
    where=st.floats(0, 1, exclude_max=True, width=32),
    what=st.integers(0, 999),
    again=st.none() | st.tuples(st.sampled_from(sorted(KINDS)), st.floats(0, 1, exclude_max=True, width=32)),
)


def bounded(count: int) -> settings:
    checks = [HealthCheck.function_scoped_fixture, HealthCheck.too_slow, HealthCheck.data_too_large]
    phases = [Phase.explicit, Phase.generate, Phase.shrink]
    return settings(
        max_examples=count, derandomize=True, database=None, deadline=None, suppress_health_check=checks, phases=phases
    )


@contextmanager
def no_hang() -> Iterator[None]:
    def ring(*_: Any) -> None:
        raise TimeoutError(f"no answer within {HANG_S} s")

    previous = signal.signal(signal.SIGALRM, ring)
    signal.alarm(HANG_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, previous)


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory, virtual_machine: None) -> dict[str, tuple[Path, bytes, Any]]:
    """Of every kind: its file, the file's bytes, and the answer to it."""
    found = {}
    for name, specimen in SPECIMENS.items():
        path = tmp_path_factory.mktemp("fuzz") / "deep" / "er" / specimen.file
        path.parent.mkdir(parents=True)
        specimen.write(path)
        found[name] = path, path.read_bytes(), specimen.read(path)
    return found


def attack(specimen: Specimen, place: tuple[Path, bytes, Any], kind: str, where: float, what: int, again: Any) -> str:
    """Read one mutant; what came of it."""
    path, data, answer = place
    mutant = mutate(data, kind, where, what)
    if again is not None:
        mutant = mutate(mutant.data, *again, what)
    if len(mutant.data) > 1_000_000:
        return "skipped"
    path.write_bytes(mutant.data)
    try:
        with no_hang():
            found = specimen.read(path)
    except InputError as error:
        said = str(error)
    else:
        said = ""
    finally:
        path.write_bytes(data)
    if said:
        assert path.name in said, f"{mutant.how}: which file? {said}"
        return "refused"
    if specimen.table and mutant.never_a_number and again is None:
        assert found == answer, f"{mutant.how}: another answer"
    return "the same answer" if found == answer else "another answer"


def _tried(name: str, places: dict[str, tuple[Path, bytes, Any]], count: int) -> None:
    specimen, place = SPECIMENS[name], places[name]
    before = sorted(p for p in place[0].parents[2].rglob("*") if p.is_file())

    @bounded(count)
    @mutations
    def run(kind: str, where: float, what: int, again: Any) -> None:
        attack(specimen, place, kind, where, what, again)

    run()
    assert sorted(p for p in place[0].parents[2].rglob("*") if p.is_file()) == before


@pytest.mark.parametrize("name", SPECIMENS)
def test_a_mutated_file_is_refused_by_name_or_read(name: str, places: dict[str, tuple[Path, bytes, Any]]) -> None:
    _tried(name, places, FEW if name == "c3d" else EXAMPLES)


@pytest.mark.parametrize("name", [name for name, specimen in SPECIMENS.items() if specimen.file.endswith(".toml")])
def test_a_boolean_is_no_number_anywhere(name: str, places: dict[str, tuple[Path, bytes, Any]]) -> None:
    path, data, _ = places[name]
    tried = 0
    for found in NUMBER.finditer(data):
        before = data[: found.start()].rpartition(b"\n")[2]
        if b"#" in before or before.count(b'"') % 2:  # a comment, a word
            continue
        path.write_bytes(data[: found.start()] + b"true" + data[found.end() :])
        tried += 1
        with pytest.raises(InputError, match=path.name):
            SPECIMENS[name].read(path)
    path.write_bytes(data)
    assert tried > 2


@pytest.mark.slow
@pytest.mark.parametrize("name", SPECIMENS)
def test_many_mutated_files_are_refused_by_name_or_read(name: str, places: dict[str, tuple[Path, bytes, Any]]) -> None:
    _tried(name, places, EXAMPLES if name == "c3d" else MORE)
