"""What a command was given is kept in plain words, without where files lie, and told where another differs."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

from serpenoid.cli.asked import asked, difference


def test_only_what_the_answer_depends_on_is_kept_and_of_files_their_names() -> None:
    table = Path("/home/somebody/table.csv")
    given = Namespace(verb="sweep", problems=["a/one.toml", "two.toml"], model=None, gaits=3, table=table,
                      truth=Path("x/y"), out="o", quiet=True, run=print)  # fmt: skip
    kept = {"problems": ["one.toml", "two.toml"], "model": None, "gaits": 3, "table": "table.csv"}
    assert asked(given) == kept


def test_a_difference_is_told_as_it_is_written_on_a_command_line() -> None:
    there = {"problem": "p.toml", "set": [], "no_polish": True, "c": None, "seed": 0}
    here = {"problem": "q.toml", "set": ["a=1", "b=2"], "no_polish": False, "c": 0.5, "seed": 0}
    assert difference(there, here) == (
        " (there problem p.toml, no --set, --no-polish, no --c; here problem q.toml, --set a=1 --set b=2, "
        "no --no-polish, --c 0.5)"
    )


def test_what_an_older_version_wrote_is_told_without_a_difference() -> None:
    assert difference(None, {"seed": 1}) == ""
