"""Words about numbers, and words by which one room knows what another says."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

FEW = 4  # names that are read at a glance
OTHER_LAW = "may stand for another law of the floor or the water"  # ends what it says of names that mend one
GROWING = "play all gaits, then all of them again, to tell"  # ends what it says of names that something growing beats
OF_SHAPES = "names may stand in for what that does to the shapes"  # ends what it says of a point beside the midline
ANY_RATIO = "gaits do not exclude another anisotropy ratio in its place"  # ends what it says of such names
FOUND_ONCE = "found by one start alone; more starts may find a better one"  # of an optimum: nothing confirms it
NOT_NAMED = "not named, as "  # begins what a diagnosis says of effects that it tried and refused


def listed(words: Sequence[str], link: str = "and") -> str:
    """`one`, `one and another`, `one, another and a third`."""
    *first, last = words
    return f"{', '.join(first)} {link} {last}" if first else last


def warned(said: str, warnings: Iterable[str]) -> str:
    """A sentence, and warnings behind it."""
    return "; ".join([said, *(f"warning: {warning}" for warning in warnings)])


def some_trials(names: Sequence[str], every: Sequence[str]) -> str:
    """Which of all they are, in a few names: `a, b`, `all 16 trials`, `all 16 trials but a`, `a, b, c and 6 others`."""
    rest = [name for name in every if name not in names]
    if not rest and len(names) > 2:
        return f"all {counted(len(names), 'trial')}"
    if len(names) <= FEW:
        return ", ".join(names)
    if len(rest) < FEW:
        return f"all {counted(len(every), 'trial')} but {listed(rest)}"
    return f"{', '.join(names[: FEW - 1])} and {len(names) - FEW + 1} others"


def some_and_more(items: Sequence[str], most: int, more: str = "more") -> str:
    """The first of them, and how many more there are: `a, b and 4 more`."""
    rest = len(items) - most
    return ", ".join(items[:most]) + (f" and {rest} {more}" if rest > 0 else "")


def closest(word: str, known: Iterable[str]) -> str | None:
    """The one of the known words that looks most like a word; None where none does."""
    return next(iter(difflib.get_close_matches(word, list(known), n=1)), None)


def meant(word: str, known: Iterable[str]) -> str:
    """` Did you mean `close`?`; empty where none is."""
    close = closest(word, known)
    return "" if close is None else f" Did you mean `{close}`?"


def meant_or_all(word: str, known: Iterable[str], there: str) -> str:
    """`did you mean `close`?`; where none is, all: `there: one, another`."""
    close = closest(word, known)
    return f"{there}: {', '.join(known)}" if close is None else f"did you mean `{close}`?"


def counted(number: int, noun: str) -> str:
    """`1 joint`, `2 joints`; nouns whose plural ends in s."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def percent(share: float) -> str:
    """`0.61 %`, `12 %`, `350 %`: two digits, and no power of ten."""
    return f"{100 * share:.2g} %" if abs(100 * share) < 99.5 else f"{100 * share:.0f} %"


def up_to(most: float, unit: str) -> str:
    """`up to 12.3°`; of what one decimal does not show `below 0.1°`."""
    return f"up to {most:.1f}{unit}" if most >= 0.05 else f"below 0.1{unit}"
