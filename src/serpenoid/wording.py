"""Words about numbers."""

from __future__ import annotations


def counted(number: int, noun: str) -> str:
    """`1 joint`, `2 joints`; nouns whose plural ends in s."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
