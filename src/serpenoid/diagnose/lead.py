"""How a body was moving just before its track begins: what has momentum must know it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from serpenoid.body import Body, Floats


class Recorded(Protocol):
    """What is asked of a track's recording; those with equal settings are repeats."""

    @property
    def gait(self) -> str:
        """Label."""

    @property
    def body(self) -> Body:
        """Lengths and weights."""

    @property
    def setting(self) -> tuple[str, float]:
        """Gait and cycle duration."""


@dataclass(frozen=True)
class Lead:
    """Rows before a track's first: time (K,), vertices (K, N, 2), measured poses (K, 3)."""

    time: Floats
    vertices: Floats
    poses: Floats


def led(lead: Lead | None, time: Floats, vertices: Floats, poses: Floats) -> tuple[Floats, Floats, Floats, int]:
    """Time, vertices and poses of a track with its lead before them, and the number of rows K that this is."""
    if lead is None:
        return time, vertices, poses, 0
    own = (time, vertices, poses)
    before = (lead.time, lead.vertices, lead.poses)
    joined = [np.concatenate(pair) for pair in zip(before, own, strict=True)]
    return joined[0], joined[1], joined[2], len(lead.time)
