"""Clocks of servos and cameras laid over each other again beside effects between the two, until neither moves.

Joints behind which there is play are late in every cycle. Where most of them have it, the clock of a trial takes up
what they share, and what is left of each joint follows no law: so where something is left, play at every joint is tried
at once, with clocks that are free to move. Each round leaves about half of what a clock is off by.
"""

from __future__ import annotations

from collections.abc import Sequence, Set

from serpenoid.diagnose.data.cameras.columns import all_keys
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.recordings.relaid import relaid
from serpenoid.diagnose.stages.observation.looked import Key, solved
from serpenoid.diagnose.stages.observation.marker_evidence import sample
from serpenoid.effects.catalogue import find
from serpenoid.files.store import remembered

ROUNDS = 12  # half of an error is left of each: of 100 ms they leave 0.02


@remembered
def laid_beside(
    recordings: Sequence[Recording], now: Observation, keys: Sequence[Key]
) -> tuple[tuple[Recording, ...], bool]:
    """Recordings by clocks that do not move any more where effects with these keys are fitted beside the model `now`;
    whether they moved at all."""
    laid, moved = tuple(recordings), False
    for _ in range(ROUNDS):
        laid, again = relaid(laid, solved(sample(laid), now, tuple(keys)))
        if not again:
            break
        moved = True
    return laid, moved


def of_play(recordings: Sequence[Recording], without: Set[str]) -> tuple[Key, ...]:
    """Keys of play at every joint."""
    every = all_keys(recordings[0].body)
    return tuple(key for key in every if find(key[0]).marks == "gaps" and key[0] not in without)
