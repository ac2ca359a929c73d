"""What an evaluation of servos' laws costs: films without a log, whose rows jump, of a robot with play in all joints.

    PYTHONPATH=src:tests python benchmarks/servo_fits.py

Processor time of each part, in alternation, and ratios: when trials began, in C beside NumPy; laws side by side beside
one after the other; and what laws are worth to first order beside fits without each of them (once: fits are kept).
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from blind.cameras import Instruments
from blind.campaign import COMBINATIONS, make
from blind.catalogue import Effect
from blind.folder import write
from blind.protocol import usual
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.shapes import beside_course
from serpenoid.diagnose.stages.actuation.actuation_refit import refined
from serpenoid.diagnose.stages.actuation.actuation_search import Played
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.actuation.set_points import by_table
from serpenoid.effects.active import ActiveEffect

SEED, GAITS, ROUNDS, WITH_A_GAP = 11, 3, 3, (1, 4, 7, 10)


def campaign(folder: Path) -> Plays:
    """Readings beside rows that jump."""
    hidden = [Effect("servo_lag", None, {"lag": 0.06}), Effect("servo_play", None, {"width": 0.05})]
    protocol = usual(SEED, COMBINATIONS[:GAITS])
    tools = Instruments(200.0, 4e-4, 0.0)
    write(make(SEED, hidden, protocol=replace(protocol, held=True, instruments=tools)), folder)
    data = by_table(read_recordings(folder)[1], held=True)
    return replace(data, noise=np.full_like(data.noise, 0.01))


def seconds(ways: dict[str, Callable[[], object]], rounds: int) -> dict[str, float]:
    """The least processor seconds of each, in turn."""
    least = dict.fromkeys(ways, np.inf)
    for _ in range(rounds):
        for name, way in ways.items():
            begun = time.process_time()
            way()
            least[name] = min(least[name], time.process_time() - begun)
    return least


def told(ways: dict[str, Callable[[], object]], rounds: int = ROUNDS) -> None:
    least = seconds(ways, rounds)
    first = next(iter(least.values()))
    for name, took in least.items():
        sys.stdout.write(f"| {name} | {1e3 * took:.1f} | {took / first:.2f} |\n")
        sys.stdout.flush()


def main() -> None:
    """A table in Markdown."""
    with tempfile.TemporaryDirectory() as folder:
        os.environ["SERPENOID_CACHE"] = folder  # no finished work
        compared(campaign(Path(folder) / "campaign"))


def compared(data: Plays) -> None:
    gaps = [ActiveEffect.of("backlash", joint, width=0.05) for joint in WITH_A_GAP]
    laws = [ActiveEffect.of("servo_lag", lag=0.05), *gaps]
    each = [[*laws[:k], laws[k].moved(0, 0.001), *laws[k + 1 :]] for k in range(len(laws))]
    library = beside_course._missed  # noqa: SLF001 what is switched off

    def by_numpy() -> None:
        beside_course._missed = lambda: None  # type: ignore[assignment] # noqa: SLF001
        try:
            data.realised(laws)
        finally:
            beside_course._missed = library  # noqa: SLF001

    sys.stdout.write("| | ms | ratio |\n| --- | --- | --- |\n")
    late = data.met(laws)[1]  # compiles
    told({"an evaluation, starts by NumPy": by_numpy, "in C": lambda: data.realised(laws)})
    told({
        "each law moved, one after the other": lambda: [data.begun_at([e], late) for e in each],
        "side by side": lambda: data.begun_at(each, late),
    })  # fmt: skip
    best = Played(data, refined(data, laws))
    some = range(best.size)

    def fitted() -> list[float]:
        return [
            Played(data, refined(data, [e for i, e in enumerate(best.effects) if i != k])).priced.chi2 for k in some
        ]

    told({"fits without each law": fitted, "to first order": lambda: best.worth(some)}, rounds=1)


if __name__ == "__main__":
    main()
