"""Along the body, in which order are the named points of a table with a row for each, not all of them in each frame?"""

from __future__ import annotations

import re
from collections.abc import Sequence
from graphlib import CycleError, TopologicalSorter

import numpy as np
from numpy.typing import NDArray

DIGITS = re.compile(r"[0-9]+")


def along_body(names: Sequence[str], frame: NDArray[np.int64], point: NDArray[np.int64]) -> list[int] | None:
    """Indices of `names` in order; None where the table does not say. frame, point (R,): those of each row.

    By the numbers in names that differ in nothing else, ascending or descending as rows do; else as in the first frame
    that has all; else by what stands after what in any frame, where that leaves one order.
    """
    by_frame = np.argsort(frame, kind="stable")
    frame, point = frame[by_frame], point[by_frame]
    following = frame[1:] == frame[:-1]
    pairs = np.unique(np.stack([point[:-1], point[1:]], axis=1)[following], axis=0, return_counts=True)
    numbered = _by_number(names)
    if numbered:
        rank = np.argsort(numbered)
        upward = (np.sign(np.diff(rank[pairs[0]], axis=1)[:, 0]) * pairs[1]).sum()
        return numbered if upward >= 0 else numbered[::-1]
    first, count = np.unique(frame, return_index=True, return_counts=True)[1:]
    whole = np.flatnonzero(count == len(names))
    if len(whole):
        begin = first[whole[0]]
        return [int(k) for k in point[begin : begin + len(names)]]
    return _one_after_another(len(names), {(int(a), int(b)) for a, b in pairs[0]})


def _by_number(names: Sequence[str]) -> list[int]:
    """Indices by the numbers in names; none where names differ in more, or in no number."""
    numbers = [tuple(int(n) for n in DIGITS.findall(name)) for name in names]
    alike = len({DIGITS.sub("*", name) for name in names}) == 1
    if not alike or len(set(numbers)) < len(names):
        return []
    return sorted(range(len(names)), key=numbers.__getitem__)


def _one_after_another(count: int, pairs: set[tuple[int, int]]) -> list[int] | None:
    """The one order of all in which each pair stands as it is; None: there is none, or several."""
    sorter = TopologicalSorter[int]({k: [a for a, b in pairs if b == k] for k in range(count)})
    try:
        order = list(sorter.static_order())
    except CycleError:
        return None
    told = all(pair in pairs for pair in zip(order, order[1:], strict=False))
    return order if told else None
