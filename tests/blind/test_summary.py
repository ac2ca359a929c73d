"""What a study adds up to, by hand-made rows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from blind import table
from blind.pages import page, write_page
from blind.summary import quantiles, summarise

SLOPE = {"name": "slope", "place": None, "parameters": {"pull_x": 0.002, "pull_y": 0.0}}


def row(
    outcome: str, strength: float, chosen: list[str], others: list[str] | None = None, **more: Any
) -> dict[str, Any]:
    said = {"verdict": "explained" if chosen else "nothing", "chosen": chosen, "group": [*chosen, *(others or [])]}
    return {
        "identity": f"{outcome}-{strength}",
        "outcome": outcome,
        "processor_s": 10.0,
        "strengths": [strength],
        "hidden": ["slope"],
        "truth": [SLOPE],
        "held_out_over_floor": 1.0,
        **said,
        **more,
    }


ROWS = [
    row("right", 7.0, ["slope"], covered={"slope.pull_x": True, "slope.pull_y": False}),
    row("right", 4.0, ["frame_drift"], ["slope"], held_out_over_floor=1.5, processor_s=30.0),
    row("wrong", 5.0, ["toe"]),
    row("unscored", 2.0, []),
    row("false alarm", 0.5, ["toe"]),
]


def test_unscored_trials_are_left_out_of_the_share() -> None:
    s = summarise("one", ROWS)
    assert (s["right"]["good"], s["right"]["of"]) == (2, 4)
    assert (s["right_where_required"]["good"], s["right_where_required"]["of"]) == (2, 3)
    assert [r["outcome"] for r in s["misses"]] == ["wrong", "false alarm"]


def test_success_is_counted_by_strength_and_group() -> None:
    s = summarise("one", ROWS)
    middle = next(b for b in s["by_strength"] if b["from"] == 3.0)
    assert (middle["right"]["good"], middle["right"]["of"], middle["truth_in_group"]["good"]) == (1, 2, 1)
    assert middle["mean_group_size"] == 1.5
    assert s["mean_group_size"] == 1.25
    assert s["group_sizes"] == {"1": 3, "2": 1}


def test_a_group_of_two_named_effects_without_alternatives_counts_one_each() -> None:
    assert summarise("two", [row("right", 7.0, ["slope", "toe"])])["mean_group_size"] == 1.0


def test_times_held_out_errors_and_intervals_are_summed_up() -> None:
    s = summarise("one", ROWS)
    assert s["seconds"]["median"] == 10.0
    assert (s["held_out_within_1.2_floors"]["good"], s["held_out_within_1.2_floors"]["of"]) == (1, 2)
    assert s["intervals_cover"]["missed"] == {"slope.pull_y": 1}
    assert quantiles([]) is None


def test_held_out_paths_are_judged_by_what_the_other_gaits_tell_one_who_knows_the_law() -> None:
    told = {"noise_level_m": 1e-3, "held_out_over_floor": 3.0, "left_open_m": 9.0}
    rows = [row("right", 7.0, ["slope"], held_out_known_m=known, **told) for known in (0.5e-3, 2.4e-3, 2.6e-3)]
    near = told | {"held_out_over_floor": 1.1}
    s = summarise("one", [*rows, row("right", 7.0, ["slope"], held_out_known_m=0.5e-3, **near)])
    assert (s["held_out_as_far_as_told"]["good"], s["held_out_as_far_as_told"]["of"]) == (2, 4)


def test_held_out_paths_of_older_tables_are_judged_by_what_is_expected_to_be_open() -> None:
    told = {"noise_level_m": 1e-3, "held_out_over_floor": 3.0}
    rows = [row("right", 7.0, ["slope"], left_open_m=open_m, **told) for open_m in (0.0, 1e-3, 2e-3)]
    s = summarise("one", [*rows, *ROWS])  # rows of older tables do not say what is open
    assert (s["held_out_as_far_as_told"]["good"], s["held_out_as_far_as_told"]["of"]) == (1, 3)
    assert (s["held_out_within_1.2_floors"]["good"], s["held_out_within_1.2_floors"]["of"]) == (1, 5)


FOLLOWED = [
    {
        "group_before": 2,
        "truth_before": True,
        "group_proposed": 1,
        "truth_proposed": True,
        "members_proposed": ["slope"],
    },
    {
        "group_before": 2,
        "truth_before": True,
        "group_proposed": 1,
        "truth_proposed": False,
        "members_proposed": ["toe"],
    },
    {"group_before": 3, "truth_before": True, "group_random": 3, "truth_random": True, "members_random": ["slope"]},
    {"group_before": 2, "truth_before": False, "group_proposed": 1, "truth_proposed": False, "members_proposed": []},
    {},
]


def test_an_experiment_succeeds_if_the_group_is_smaller_and_the_truth_still_in_it() -> None:
    rows = [row("unscored", 2.0, ["slope"], ["toe"], **more) for more in FOLLOWED]
    after = summarise("followup", rows)["after_experiment"]
    assert after["groups"] == 4
    assert (after["truth_in_group"]["good"], after["truth_in_group"]["of"]) == (3, 4)
    assert (after["proposed"]["good"], after["proposed"]["of"]) == (1, 3)  # never proposed: counts against it
    assert (after["random"]["good"], after["random"]["truth_kept"]["good"]) == (0, 1)
    assert after["mean_size"] == pytest.approx(2.25)


def test_the_page_shows_shares_targets_confusion_and_misses(tmp_path: Path) -> None:
    followed = [row("unscored", 2.0, ["slope"], ["toe"], **more) for more in FOLLOWED]
    kinds = {"one": ROWS, "followup": followed}
    for kind, rows in kinds.items():
        table.write(tmp_path / f"{kind}.csv", {"command": f"run {kind}", "commit": "abc", "key": "k"}, rows)
    write_page(tmp_path)
    text = (tmp_path / "summary.md").read_text()
    assert "| One effect | 2 | 4 | 50 % | 15 - 85 % | 95 % |" in text
    assert "| wrong-5.0 | slope (pull_x 0.002, pull_y 0) | 5.0 | wrong | toe |  |" in text
    assert "| proposed experiment: smaller, truth kept | 1 | 3 | 33 % |" in text
    assert "| slope (pull_x 0.002, pull_y 0) | 2.0 | slope, toe | toe | - |" in text
    assert page([]).startswith("# Hidden-effect trials")


def test_a_table_keeps_rows_as_they_are(tmp_path: Path) -> None:
    rows = [*ROWS, row("failed", 1.0, [], stderr="line one\nline, two")]
    above = {"command": "run: it", "commit": "abc", "key": "k"}
    table.write(tmp_path / "one.csv", above, rows)
    assert table.read(tmp_path / "one.csv")[0] == above
    again = table.read(tmp_path / "one.csv")[1]
    assert again[:-1] == ROWS
    assert again[-1]["stderr"] == "line one | line, two"
    assert table.read(tmp_path / "none.csv") == ({}, [])


def test_a_study_with_several_causes_is_summed_up_cause_by_cause(tmp_path: Path) -> None:
    rows = [{**row("right", 7.0, ["slope"]), "cause": "one"}, {**row("right", 0.0, []), "cause": "null"}]
    table.write(tmp_path / "random.csv", {"command": "c", "commit": "abc", "key": "k"}, rows)
    write_page(tmp_path)
    text = (tmp_path / "summary.md").read_text()
    assert "| Random protocols: one effect | 1 | 1 |" in text
    assert "| Random protocols: nothing hidden | 1 | 1 |" in text


def test_stated_odds_stand_beside_the_frequency_that_was_found() -> None:
    rows = [row("right", 7.0, ["slope"], odds={"slope": 0.95, "toe": 0.05}) for _ in range(3)]
    rows.append(row("wrong", 7.0, ["toe"], odds={"toe": 0.92, "slope": 0.08}))
    low, high = summarise("one", rows)["odds"]
    assert (low["good"], low["of"]) == (1, 4)
    assert (high["good"], high["of"]) == (3, 4)
    assert high["stated"] == pytest.approx((3 * 0.95 + 0.92) / 4)
