"""How long a diagnosis still takes, from what its stages took here before and what they take now.

What a stage took in the last diagnoses on this machine, in seconds a trial, is kept in the cache folder, robots and
animals apart; the first time, what was measured for 16 trials stands in. Where finished stages took longer than was
expected of them (a slower or loaded machine), so will the others, as far as the finished ones are a part of the work:
one short stage has delays of its own, and is not the pace of all.

    slower = (took + B w) / (expected + B w)    took, expected: of finished stages; w: expected of all; B: BELIEF

How often an effect is looked for is not known
before: as often as last time, until it is once more.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from contextlib import suppress

from serpenoid.files import store
from serpenoid.files.writing import write_json

READING, SEARCH, SEARCHES, FIGURES = "reading", "looking for effect", "searches", "figures"
SERVOS = "command against shape"
STAGES = (READING, SERVOS, "shape against markers", "shape against motion", SEARCH, "which law the medium follows",
          "what else it could be", "gain on held-out gaits")  # fmt: skip
# seconds a trial, measured from the log of a diagnosis of 16 trials (--log-file); figures in all
FIRST = dict(zip(STAGES, (0.12, 0.20, 0.05, 0.06, 0.10, 0.01, 0.02, 0.03), strict=True)) | {SEARCHES: 2.0, FIGURES: 1.0}
NEWEST = 0.5  # weight of the last diagnosis in what is expected of the next
REMEMBERED = 0.2  # of what was expected: a stage that took less was found in the cache and tells nothing
BELIEF = 0.15  # of all the work: finished stages that are as much are believed by half
KEPT = "diagnosis-times.json"
Tell = Callable[[float, str, float], None]  # seconds done, what is being done, seconds in all


class Work:
    """Progress of one campaign's diagnosis after another. kind: robot or animal; trials: of each campaign."""

    def __init__(
        self, kind: str, trials: list[int], figures: bool, clock: Callable[[], float] = time.monotonic
    ) -> None:
        self._kind, self._trials, self._figures, self._clock = kind, trials, figures, clock
        self._expected = FIRST | _kept().get(kind, {})
        self._begun = self._since = clock()
        self._stage, self._campaign, self._searched = READING, 0, 0
        self._took: dict[str, list[float]] = {}
        self._slower = (0.0, 0.0)  # seconds that finished stages took, and were expected to take
        self.tell: Tell = lambda done, text, total: None

    def read(self, _done: int, name: str) -> None:
        """Trials of the present campaign are being read."""
        self._say(name)

    def begin(self, stage: str) -> None:
        """Another stage: what was going on is finished."""
        self._end()
        self._stage = next((name for name in STAGES if stage.startswith(name)), stage)
        self._searched += self._stage == SEARCH
        self._say(stage)

    def campaign_done(self) -> None:
        """The next campaign begins, or nothing but figures is left."""
        self._end()
        if SEARCH in self._took:
            self._took.setdefault(SEARCHES, []).append(float(self._searched))
        self._stage, self._searched, self._campaign = READING, 0, self._campaign + 1

    def draw(self) -> None:
        """Only figures are left."""
        self._stage = FIGURES
        self._say(FIGURES)

    def finish(self) -> None:
        """All is done: what the stages took is expected of the next diagnosis."""
        self._end()
        spent = self._clock() - self._begun
        self.tell(spent, "", spent)
        for name, values in self._took.items():
            mean = sum(values) / len(values)
            self._expected[name] = NEWEST * mean + (1 - NEWEST) * self._expected.get(name, mean)
        with suppress(OSError):
            write_json(store.folder() / KEPT, _kept() | {self._kind: self._expected})

    def left(self) -> float:
        """Seconds until all is done, now."""
        took, expected = self._slower
        belief = BELIEF * (expected + self._seconds(self._stage) + self._after())
        slower = max(1.0, (took + belief) / (expected + belief)) if belief > 0 else 1.0
        now = slower * self._seconds(self._stage) - (self._clock() - self._since)
        return max(0.0, now) + slower * self._after()

    def _after(self) -> float:
        """Expected seconds of the stages that have not begun."""
        figures = self._seconds(FIGURES) * (self._figures and self._stage != FIGURES)
        if self._campaign >= len(self._trials):
            return figures
        at = STAGES.index(self._stage) if self._stage in STAGES else 0
        searches = max(0.0, self._expected[SEARCHES] - self._searched)
        mine = [self._seconds(name) for name in STAGES[at + 1 :] if name != SEARCH]
        here = sum(mine) + searches * self._seconds(SEARCH) * (at <= STAGES.index(SEARCH))
        whole = sum(self._expected[name] for name in STAGES) + (self._expected[SEARCHES] - 1) * self._expected[SEARCH]
        return here + whole * sum(self._trials[self._campaign + 1 :]) + figures

    def _seconds(self, stage: str) -> float:
        count = 1 if stage == FIGURES else self._trials[min(self._campaign, len(self._trials) - 1)]
        return self._expected.get(stage, 0.0) * count

    def _end(self) -> None:
        """The stage is finished: note what it took."""
        now, expected = self._clock(), self._seconds(self._stage)
        took, self._since = now - self._since, now
        if expected > 0 and took > REMEMBERED * expected:
            self._took.setdefault(self._stage, []).append(took * self._expected[self._stage] / expected)
            self._slower = self._slower[0] + took, self._slower[1] + expected

    def _say(self, text: str) -> None:
        done = self._clock() - self._begun
        self.tell(done, text, done + self.left())


def _kept() -> dict[str, dict[str, float]]:
    """What was kept before: numbers by kind and stage; nothing where the file is not whole."""
    with suppress(OSError, ValueError, AttributeError, TypeError):
        held = json.loads((store.folder() / KEPT).read_text(encoding="utf-8"))
        return {str(kind): {str(k): float(v) for k, v in times.items()} for kind, times in held.items()}
    return {}
