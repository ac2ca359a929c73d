"""Rows of a long recording a few at a time: what is made of each and not kept stays small, and near the core."""

from __future__ import annotations

from collections.abc import Iterator

ROWS = 2048


def blocks(count: int) -> Iterator[slice]:
    """Slices that make up `count` rows."""
    return (slice(first, min(first + ROWS, count)) for first in range(0, count, ROWS))
