"""Words about numbers, and words by which one room knows what another says."""

from __future__ import annotations

from collections.abc import Sequence

OTHER_LAW = "may stand for another law of the floor or the water"  # ends what it says of names that mend one
NOT_NAMED = "not named, as "  # begins what a diagnosis says of effects that it tried and refused


def listed(words: Sequence[str]) -> str:
    """`one`, `one and another`, `one, another and a third`."""
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def counted(number: int, noun: str) -> str:
    """`1 joint`, `2 joints`; nouns whose plural ends in s."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
