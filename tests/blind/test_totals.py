"""The counts over all keys: what they add up, and that the README says them."""

from __future__ import annotations

from pathlib import Path

from blind import table, totals
from blind.test_summary import ROWS, row

ROOT = Path(__file__).parents[2]


def test_the_readme_and_the_page_of_all_keys_say_what_the_tables_add_up_to() -> None:
    found = totals.page(ROOT / "results" / "blind")
    for document in (ROOT / "README.md", ROOT / "results" / "blind" / "totals.md"):
        assert found in document.read_text(encoding="utf-8")


def test_right_answers_of_all_keys_are_added_up_where_something_is_required(tmp_path: Path) -> None:
    nothing = row("right", 0.0, [], strengths=[], hidden=[], truth=[], cause="null")
    for key, rows in {"gates-11": ROWS, "gates-12": ROWS, "gates-23b": [*ROWS[:1], nothing]}.items():
        table.write(tmp_path / key / "random.csv", {"key": key}, [{"cause": "one"} | r for r in rows])
    found = totals.summed(tmp_path, ("random", "laid"))
    assert found.campaigns == len(ROWS) + 2
    assert found.keys == ("gates-12", "gates-23b")  # the method of gates-11 is another
    assert found.causes == {"one": (3, 4), "null": (1, 1)}  # S of 3 or more: two of three, and one
    assert found.intervals == (2, 4)


def test_robots_of_the_arena_are_counted_by_what_is_hidden(tmp_path: Path) -> None:
    healthy = {"robot": 1, "name": "healthy"}  # the reference, which nobody judges
    patch = {"name": "patch", "hidden": {"patch": {}}, "answers": [["grip_patch", None]], "path_repeats_m": 0.01}
    judged = [
        {"name": "nothing", "hidden": {}, "answers": [], "outcome": "right"},
        patch | {"path_change_m": 0.04, "outcome": "missed"},
        patch | {"path_change_m": 0.02, "outcome": "missed"},  # too weak for a name to be required
        {"name": "loose", "hidden": {"loose": {}}, "answers": [["loose_joint", 1]], "outcome": "right"},
        {"name": "tether", "hidden": {"tether": {}}, "answers": [], "outcome": "right"},
    ]
    table.write(tmp_path / "any-1" / "any-robot.csv", {"key": "any-1"}, [healthy, *judged])
    assert totals.in_the_arena(tmp_path).causes == {"null": (1, 1), "one": (1, 2), "outside": (1, 1)}
