"""What is asked before a file is written, and how an answer is read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from serpenoid.body import ANIMALS
from serpenoid.errors import InputError
from serpenoid.joint_range import as_range

Answers = Mapping[str, Any]
ONE_SIDED = "to one side farther: lower,upper, as --joint-limit=-20,60"


@dataclass(frozen=True)
class Question:
    """`name` is the option, `text` what is asked; `read` turns an answer into a value, or raises ValueError.

    unless, only: another question; where that has an answer (only: has none), this one is not looked at.
    refused: why, and what to do, where both are given.
    of_robots: not asked of an animal, whose answer is None unless it is given; animals: other defaults, by their kind.
    key: of the file; where it is not written, nothing was assumed. guess: the default by what is answered already.
    """

    name: str
    text: str
    default: str
    read: Callable[[str], Any]
    unless: str = ""
    only: str = ""
    refused: str = "says it already. Leave one of them out."
    of_robots: bool = False
    animals: Mapping[str, str] = field(default_factory=dict)
    key: str = ""
    guess: Callable[[Answers], str | None] | None = None

    def default_for(self, answers: Answers) -> str:
        """The default beside what is answered already."""
        guessed = self.guess(answers) if self.guess is not None else None
        return guessed or self.animals.get(answers.get("kind") or "", self.default)

    @property
    def help(self) -> str:
        """What is asked, and the defaults."""
        said = [f"default {self.default}"] if self.default else []
        said += ["of an animal none"] if self.of_robots else []
        said += [f"of a {kind} {default or 'none'}" for kind, default in self.animals.items()]
        return f"{self.text} ({', '.join(said)})" if said else self.text

    def passed_over(self, answers: Answers) -> bool:
        """Whether it is none of an animal's."""
        return self.of_robots and answers.get("kind") in ANIMALS

    def value(self, answer: str) -> Any:
        """The answer as a value; raises InputError that names the option."""
        try:
            return self.read(answer.strip())
        except ValueError as error:
            raise InputError(f"--{self.name}: {error}, got {answer!r}.") from None


@dataclass(frozen=True)
class Template:
    """A kind of file: its questions, the path where none is given, and what writes it and all that belongs to it."""

    default_path: str
    questions: tuple[Question, ...]
    write: Callable[[Path, Answers], str]  # returns what to try first


def number(low: float, high: float) -> Callable[[str], float]:
    """A number within limits."""

    def read(text: str) -> float:
        value = _float(text)
        if not low < value <= high:
            raise ValueError(f"needs a number above {low:g} and at most {high:g}")
        return value

    return read


def joint_limit(most: float) -> Callable[[str], float | tuple[float, float]]:
    """Degrees to either side, or from and to."""

    def read(text: str) -> float | tuple[float, float]:
        if "," not in text:
            return number(0, most)(text)
        try:
            low, high = map(float, text.split(","))
        except ValueError:
            raise ValueError("needs a number, or two with a comma between") from None
        return as_range(low, high, most)

    return read


def whole(low: int, high: int) -> Callable[[str], int]:
    """A whole number within limits."""

    def read(text: str) -> int:
        if not text.isascii() or not text.isdecimal() or not low <= int(text) <= high:
            raise ValueError(f"needs a whole number from {low} to {high}")
        return int(text)

    return read


def or_empty(read: Callable[[str], Any]) -> Callable[[str], Any]:
    """What `read` takes, or nothing: None."""
    return lambda text: read(text) if text else None


def one_of(*words: str) -> Callable[[str], str]:
    """One of some words."""

    def read(text: str) -> str:
        if text not in words:
            raise ValueError(f"needs one of {', '.join(filter(None, words))}")
        return text

    return read


def numbers(text: str) -> tuple[float, ...]:
    """Numbers above 0 with commas between; empty for none."""
    values = tuple(_float(part) for part in text.split(",")) if text else ()
    if not all(0 < value < 1e6 for value in values):
        raise ValueError("needs numbers above 0, with commas between")
    return values


def named(text: str) -> dict[str, str]:
    """Words with names, as `a=x,b=y`; empty for none."""
    pairs = [part.partition("=") for part in text.split(",")] if text else []
    if not all(name.strip() and word.strip() for name, _, word in pairs):
        raise ValueError("needs names and words as a=x,b=y")
    return {name.strip(): word.strip() for name, _, word in pairs}


def words(text: str) -> tuple[str, ...]:
    """Words with commas between, each once; empty for none."""
    found = tuple(part.strip() for part in text.split(",")) if text else ()
    if not all(found):
        raise ValueError("needs words with commas between")
    twice = next((word for word in found if found.count(word) > 1), None)
    if twice is not None:
        raise ValueError(f"has `{twice}` twice")
    return found


def existing(text: str) -> Path | None:
    """A file that is there; empty for none."""
    path = Path(text) if text else None
    if path is not None and not path.is_file():
        raise ValueError("needs a file that is there")
    return path


def _float(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise ValueError("needs a number") from None
