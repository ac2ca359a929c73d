"""What is said of a trial as it is read: the words, and beside them what they are about."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

Kind: TypeAlias = Literal["trial", "cameras", "scale"]


@dataclass(frozen=True)
class Remark:
    """words: for people. kind: `cameras` where cameras must be set right, and no entry of the campaign file mends it;
    `scale` where all links are longer or shorter in films than stated; `trial`: all else."""

    words: str
    kind: Kind = "trial"


def remarks_of(words: Iterable[str]) -> tuple[Remark, ...]:
    """Those that are not about cameras."""
    return tuple(Remark(text) for text in words)
