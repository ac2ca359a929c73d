"""What `--help` says is whole, and fits a terminal."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

import pytest

from serpenoid.cli.main import VERBS, build_parser, main
from serpenoid.measure.formats.readers import NAMES


def help_of(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    with pytest.raises(SystemExit):
        main([*words, "--help"])
    return capsys.readouterr().out


@pytest.mark.parametrize("words", [("measure",), ("campaign", "add")])
def test_every_format_that_is_read_is_listed(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    said = " ".join(help_of(capsys, *words).split())
    assert ", ".join(NAMES) in said


def parsers(parser: argparse.ArgumentParser) -> Iterator[argparse.ArgumentParser]:
    """The program's, and those of all verbs and their actions."""
    yield parser
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for below in dict.fromkeys(action.choices.values()):
                yield from parsers(below)


@pytest.mark.parametrize("columns", [80, 120])
def test_no_line_is_wider_than_the_widest_text_or_ends_within_a_word(
    columns: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    for parser in parsers(build_parser(*VERBS)):
        assert parser.description, parser.prog
        for line in parser.format_help().splitlines():
            assert len(line) <= 120, (parser.prog, line)
            assert not line.endswith("-"), (parser.prog, line)


def test_every_verb_stands_beside_what_it_does(capsys: pytest.CaptureFixture[str]) -> None:
    lines = [line.split() for line in help_of(capsys).splitlines()]
    for verb in VERBS:
        assert [line for line in lines if line[:1] == [verb]][0][1:], verb
