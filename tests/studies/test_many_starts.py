"""Many starts on the one loop: the same bits wherever they run, none lost with a worker, none solved twice."""

from __future__ import annotations

import csv
import os
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from serpenoid.cli.main import main
from serpenoid.optimise import solve as front_door
from serpenoid.optimise.multistart import MultiStart
from serpenoid.optimise.solve import solve
from serpenoid.optimise.solver import GaitSolver
from serpenoid.parallel import Workers
from serpenoid.status import Status
from serpenoid.studies.many_starts import solve_starts, write_starts
from specimens import PROBLEMS, problem

STARTS = 4


def bits(result: MultiStart) -> list[bytes]:
    """All that a start tells of its gait and motion."""
    return [s.q.tobytes() + s.table.tobytes() + s.trajectory.poses.tobytes() for s in result.solutions] + [
        result.best.table.tobytes(), np.array([result.best.cost]).tobytes()]  # fmt: skip


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("starts")


@pytest.fixture(scope="module")
def alone(kept: Path) -> MultiStart:
    return solve(problem("purcell"), STARTS, folder=kept)


def children() -> list[int]:
    """Workers of this process that run a task: not the trackers of shared memory."""
    pids = [int(p) for t in Path("/proc/self/task").iterdir() for p in (t / "children").read_text().split()]
    return [pid for pid in pids if b"popen_loky" in Path(f"/proc/{pid}/cmdline").read_bytes()]


@pytest.mark.slow
def test_a_worker_killed_amid_the_starts_loses_nothing_and_changes_no_bit(alone: MultiStart, tmp_path: Path) -> None:
    killed: list[int] = []

    def kill(done: int, _best: object) -> None:
        if not killed:
            killed.append(children()[0])
            os.kill(killed[0], signal.SIGKILL)

    found = solve_starts(problem("purcell"), STARTS, 0, Workers(jobs=2), kill, tmp_path)
    assert killed
    assert bits(found) == bits(alone)


def test_what_was_solved_is_taken_from_the_folder_to_the_last_bit(
    alone: MultiStart, kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_args: object, **_options: object) -> None:
        raise AssertionError("solved again")

    monkeypatch.setattr(GaitSolver, "solve", refuse)
    again = solve(problem("purcell"), STARTS, folder=kept)
    assert bits(again) == bits(alone)
    assert (alone.kept, again.kept) == (0, sum(s.status.ok for s in alone.solutions))


def test_the_table_of_starts_has_a_line_a_start(alone: MultiStart, tmp_path: Path) -> None:
    write_starts(tmp_path / "starts.csv", alone)
    rows = list(csv.DictReader((tmp_path / "starts.csv").read_text(encoding="utf-8").splitlines()))
    assert [float(r["cost"]) for r in rows] == [s.cost for s in alone.solutions]
    assert {r["optimum"] for r in rows if r["status"] == "solved"} == {str(1 + i) for i in range(len(alone.optima))}


def test_an_interrupted_run_leaves_a_better_answer_where_it_is(
    alone: MultiStart, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["solve", str(PROBLEMS / "purcell.toml"), "--starts", "2", "--no-figures", "--out", str(tmp_path / "run")]
    assert main(asked) == 0
    before = (tmp_path / "run" / "joint_table.csv").read_bytes()
    stopped = replace(alone.best, status=Status.STOPPED, table=0 * alone.best.table, cost=alone.best.cost - 1)
    monkeypatch.setattr(front_door, "solve", lambda *_a, **_o: MultiStart((stopped,), ()))
    assert main(asked) == 130
    said = capsys.readouterr().err
    assert "keeps the answer of an earlier run, which is better" in said
    assert "goes on from there" in said
    assert (tmp_path / "run" / "joint_table.csv").read_bytes() == before
