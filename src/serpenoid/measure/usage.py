"""How much of a recording an answer is made from: every piece without a hole counts, and what is left out is said."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from serpenoid.measure.trial import Motion, Passage, Trial
from serpenoid.wording import some_trials

SHORTEST = 4  # rows of a piece
ROUNDED = 1e-9  # of sums of seconds


@dataclass(frozen=True)
class Usage:
    """Seconds that were promised by the schedule (or recorded, without one), and how many of them are used."""

    promised_s: float
    used_s: float
    pieces: int

    @property
    def dropped_s(self) -> float:
        """Hidden for too long, cut by a jump, or not wholly recorded."""
        dropped = self.promised_s - self.used_s
        return dropped if dropped > ROUNDED * self.promised_s else 0.0

    def __str__(self) -> str:
        """`11.2 s used in 3 pieces, 0.8 s dropped`."""
        pieces = "1 piece" if self.pieces == 1 else f"{self.pieces} pieces"
        return f"{self.used_s:.4g} s used in {pieces}, {self.dropped_s:.4g} s dropped"


def whole_pieces(motion: Motion, passage: Passage) -> list[slice]:
    """The passage cut at long gaps and jumps."""
    pieces = []
    for run in motion.runs:
        first, stop = max(run.start, passage.first), min(run.stop, passage.last + 1)
        if stop - first >= SHORTEST:
            pieces.append(slice(first, stop))
    return pieces


def usage(trial: Trial) -> Usage:
    """Of one trial; nothing where it has no motion file."""
    motion, schedule = trial.motion, trial.schedule
    if motion is None:
        return Usage(0.0, 0.0, 0)
    pieces = [piece for passage in trial.passages for piece in whole_pieces(motion, passage)]
    used = sum(float(motion.time_s[piece.stop - 1] - motion.time_s[piece.start]) for piece in pieces)
    promised = float(motion.time_s[-1] - motion.time_s[0])
    if schedule is not None and trial.start_source != "none":
        windows = [schedule.window_s(cycle) for cycle in range(schedule.cycles)]
        promised = sum(end - begin for begin, end in windows)
    return Usage(promised, used, len(pieces))


def said_once(notes: Iterable[tuple[str, Sequence[str]]]) -> list[str]:
    """Every note of (trial, its notes), with the trials that it is about: `t00, t01: ...`, `all 16 trials: ...`."""
    said = list(notes)
    every = list(dict.fromkeys(trial for trial, _ in said))
    return [f"{some_trials(names, every)}: {note}" for note, names in trials_of(said).items()]


def trials_of(notes: Iterable[tuple[str, Sequence[str]]]) -> dict[str, list[str]]:
    """The trials that each note is about, of (trial, its notes)."""
    trials: dict[str, dict[str, None]] = {}
    for trial, own in notes:
        for note in own:
            trials.setdefault(note, {})[trial] = None
    return {note: list(names) for note, names in trials.items()}


def total(usages: Iterable[Usage]) -> Usage:
    """Of several trials together."""
    every = list(usages)
    return Usage(sum(u.promised_s for u in every), sum(u.used_s for u in every), sum(u.pieces for u in every))
