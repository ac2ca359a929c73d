"""Rows of a long recording a few at a time: what is made of each and not kept stays small, and near the core."""

from __future__ import annotations

from collections.abc import Iterator

NEAR = 320_000  # numbers, 2.5 MB: of 49 points a chain is fitted five times as fast with 64 frames at once as with 2048
USUAL = 156  # numbers that a row needs


def blocks(count: int, numbers: int = USUAL) -> Iterator[slice]:
    """Slices that make up `count` rows, each of which needs so many numbers."""
    rows = max(NEAR // numbers, 1)
    return (slice(first, min(first + rows, count)) for first in range(0, count, rows))
