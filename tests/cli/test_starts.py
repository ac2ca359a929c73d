"""What many starts found is said without contradiction, and better optima that were refused are named."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from serpenoid.cli.solve import _beside_status
from serpenoid.cli.starts import starts_lines


def record(steps: int, optima: list[dict[str, Any]]) -> dict[str, Any]:
    found = {"steps": 60, "optima": optima, "better_but_coarse": [{"cost": -1.354, "starts": 5}],
             "failures": ["mesh_too_coarse"] * 5}  # fmt: skip
    return {"cost": -1.5, "mesh": {"steps": [steps, 2 * steps, 4 * steps]}, "multi_start": found}


def test_better_optima_that_a_coarse_mesh_spoils_are_named_with_the_remedy() -> None:
    first, second = starts_lines(record(60, [{"cost": -1.0, "starts": 3}]))
    assert first == "optima found      -1.000000 (3x); failed starts: 5 mesh_too_coarse"
    assert second.startswith("better, refused   -1.354000 (5x): 60 steps are too coarse for them; solve with --refine")


def test_the_status_says_that_a_better_gait_was_refused_for_its_mesh() -> None:
    best: Any = SimpleNamespace(status=SimpleNamespace(ok=True), mesh=SimpleNamespace(steps=60), message="")
    told = ", but not the best: 60 steps are too coarse for cost -1.354000 (--refine)"
    assert _beside_status(best, record(60, [])) == told
    assert _beside_status(best, record(480, []) | {"refinement": {}}) == ""
    best.status.ok, best.message = False, "no start converged"
    assert _beside_status(best, record(60, [])) == ": no start converged"


def test_an_optimum_that_one_start_alone_found_may_not_be_the_best() -> None:
    once = starts_lines(record(60, [{"cost": -1.0, "starts": 1}, {"cost": -0.9, "starts": 2}]))
    told = f"{'':18}the best was found by one start alone; more starts may find a better one (--starts)"
    assert once[1] == told
    assert told not in starts_lines(record(60, [{"cost": -1.0, "starts": 2}, {"cost": -0.9, "starts": 1}]))


def test_an_optimum_of_many_starts_that_was_refined_is_not_said_to_be_of_one_alone() -> None:
    assert not [line for line in starts_lines(record(480, [{"cost": -0.07, "starts": 1}])) if "one start alone" in line]
    lines = starts_lines(record(480, [{"cost": -1.49, "starts": 1}]))  # the one of many starts did not hold
    assert [line for line in lines if "one start alone" in line]


def test_after_a_refinement_what_was_found_before_is_told_apart_from_it() -> None:
    lines = starts_lines(record(480, []))
    assert lines[0] == "optima found      none with 60 steps; failed starts: 5 mesh_too_coarse"
    assert lines[2] == "refined           -1.500000 with 480 steps"


def test_a_finer_mesh_that_failed_is_told_with_the_one_that_is_kept() -> None:
    failed = {"refinement": {"failed": {"steps": 960, "status": "not_converged"}}}
    said = "not refined       960 steps ended as not_converged; 480 steps are the finest that converged, and are kept"
    assert starts_lines(record(480, []) | failed)[-1] == said


def test_a_record_of_an_older_version_is_read() -> None:
    old = {"mesh": {"steps": [60, 120, 240]}, "multi_start": {"optima": [], "failures": []}}
    assert starts_lines(old) == ["optima found      none; failed starts: 0"]
