"""What a command was given, as far as its answer depends on it: kept beside the answer, told where another differs."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

INPUTS = "problem", "problems", "model", "campaign", "reference", "protocol", "diagnosis"  # arguments that are read
# where an answer goes, how it is told and drawn, and who works at it: none of it changes the answer
NO_PART = frozenset(("verb", "run", "out", "truth", "force", "open", "no_figures", "quiet", "json", "jobs", "cluster",
                     "verbose", "log_file", "requests", "held", "kept_if_stopped"))  # fmt: skip
Asked = dict[str, Any]


def asked(args: argparse.Namespace) -> Asked:
    """Arguments of a verb, as JSON values; files by their names: where they lie is nobody else's business."""
    given = {name: value for name, value in vars(args).items() if name not in NO_PART and not callable(value)}
    return {name: _plain(name, value) for name, value in given.items()}


def _plain(name: str, value: Any) -> Any:
    if isinstance(value, list):
        return [_plain(name, item) for item in value]
    if isinstance(value, Path) or (name in INPUTS and isinstance(value, str)):
        return Path(value).name
    return value if isinstance(value, bool | int | float | None) else str(value)


def difference(there: object, here: Asked) -> str:
    """In brackets, in what a request differs from the one that is there; empty where that is not known."""
    if not isinstance(there, dict):
        return ""
    others = [name for name in {**there, **here} if there.get(name) != here.get(name)]
    if not others:
        return " (of the same words: what they read has changed since)"
    return f" (there {_words(there, others)}; here {_words(here, others)})"


def _words(given: Mapping[str, Any], names: list[str]) -> str:
    return ", ".join(_word(name, given.get(name)) for name in names)


def _word(name: str, value: Any) -> str:
    """An argument as it is written on a command line."""
    option = name if name in INPUTS else f"--{name.replace('_', '-')}"
    if value is None or value is False or value == []:
        return f"no {option}"
    if value is True:
        return option
    return " ".join(f"{option} {item}" for item in (value if isinstance(value, list) else [value]))
