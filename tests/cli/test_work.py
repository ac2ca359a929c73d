"""The time a diagnosis still takes: right at every moment, once a few like it have been seen here."""

from __future__ import annotations

from pathlib import Path

import pytest

from serpenoid.cli.work import FIRST, KEPT, SEARCH, STAGES, Work
from serpenoid.files import store

TRIALS = 4
TOOK = dict(zip(STAGES, (3.0, 1.0, 2.0, 5.0, 40.0, 4.0, 3.0, 6.0), strict=True))  # s a campaign; a search each
SEARCHES, FIGURES = 3, 11.0


class Clock:
    """Time as a test sets it."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture(autouse=True)
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SERPENOID_CACHE", str(tmp_path))


def diagnosis(pace: float = 1.0) -> list[tuple[float, float]]:
    """(seconds left as said, as it was) at the beginning and in the middle of every stage."""
    clock, seen = Clock(), []
    work = Work("robot", [TRIALS], True, clock)

    def runs(seconds: float) -> None:
        for _ in range(2):
            seen.append((work.left(), clock.now))
            clock.now += pace * seconds / 2

    work.read(0, "first")
    runs(TOOK["reading"])
    for stage in STAGES[1:]:
        for number in range(SEARCHES if stage == SEARCH else 1):
            work.begin(f"{stage} {number + 1}" if stage == SEARCH else stage)
            runs(TOOK[stage])
    work.campaign_done()
    work.draw()
    runs(FIGURES)
    work.finish()
    return [(left, clock.now - at) for left, at in seen]


def test_after_a_few_diagnoses_the_time_left_is_what_it_is() -> None:
    for _ in range(12):  # what is expected halves its error each time
        diagnosis()
    for said, true in diagnosis():
        assert said == pytest.approx(true, rel=0.02, abs=0.5)


def test_a_machine_at_half_its_pace_is_noticed_as_its_stages_end() -> None:
    for _ in range(12):
        diagnosis()
    slow = diagnosis(pace=2.0)
    off = [(true - said) / true for said, true in slow[::2]]  # as stages begin
    assert 0.4 < off[0] < 0.51
    assert off == sorted(off, reverse=True)
    assert 0 < off[len(STAGES) + SEARCHES - 1] < 0.1


def test_one_short_stage_is_not_taken_for_the_pace() -> None:
    for _ in range(12):
        diagnosis()
    clock = Clock()
    work = Work("robot", [TRIALS], True, clock)
    before = work.left()
    clock.now += 12 * TOOK["reading"]  # a busy machine in the first seconds
    work.begin(STAGES[1])
    assert before < work.left() < 2.5 * before  # and not twelve times


def test_what_was_found_in_the_cache_teaches_nothing() -> None:
    diagnosis()
    before = (store.folder() / KEPT).read_text()
    diagnosis(pace=1e-3)
    assert (store.folder() / KEPT).read_text() == before


@pytest.mark.parametrize("content", ["", "[]", '{"robot": 3}', '{"robot": {"reading": "x"}}', "\x00"])
def test_a_broken_note_of_earlier_times_counts_as_none(content: str) -> None:
    store.folder().mkdir(parents=True, exist_ok=True)
    (store.folder() / KEPT).write_text(content)
    assert Work("robot", [1], True, Clock()).left() == pytest.approx(
        sum(FIRST[s] for s in STAGES) + FIRST[SEARCH] + FIRST["figures"])  # fmt: skip
