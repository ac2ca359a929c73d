"""How much of a diagnosis is done: its stages weighted by the time they take, so that the remaining time is true.

Weights are in the time that reading one trial takes, measured from the log of a diagnosis of 16 trials (--log-file).
How often an effect is looked for is not known before: twice, until a third search begins.
"""

from __future__ import annotations

from collections.abc import Callable

PER_TRIAL = {
    "command against shape": 0.1,
    "shape against markers": 0.5,
    "shape against motion": 1.6,
    "looking for effect": 9.4,
    "gain on held-out gaits": 1.0,
}
FIGURES = 85.0
SEARCH, SEARCHES = "looking for effect", 2
Tell = Callable[[float, str, float], None]  # done, what is being done, total


class Work:
    """Progress of one campaign's diagnosis after another; `tell` hears of it."""

    def __init__(self, trials: list[int], figures: bool, tell: Tell) -> None:
        self._tell, self._trials, self._done, self._now = tell, trials, 0.0, 0.0
        expected = sum(PER_TRIAL.values()) + (SEARCHES - 1) * PER_TRIAL[SEARCH] + 1
        self.total = expected * sum(trials) + FIGURES * figures
        self._campaign = self._searched = 0

    def read(self, done: int, name: str) -> None:
        """So many trials of the present campaign have been read."""
        self._say(name, self._done + done)

    def begin(self, stage: str) -> None:
        """Another stage: what was going on is finished."""
        trials = self._trials[self._campaign]
        self._done = self._done + (self._now or trials)
        self._now = trials * next((w for name, w in PER_TRIAL.items() if stage.startswith(name)), 0.0)
        if stage.startswith(SEARCH):
            self._searched += 1
            self.total += self._now * (self._searched > SEARCHES)
        self._say(stage, self._done)

    def campaign_done(self) -> None:
        """The next campaign begins; searches that were not needed are not to be waited for."""
        trials = self._trials[self._campaign]
        self._done += self._now
        self.total -= max(0, SEARCHES - self._searched) * PER_TRIAL[SEARCH] * trials
        self._now, self._searched, self._campaign = 0.0, 0, self._campaign + 1

    def draw(self) -> None:
        """Only figures are left."""
        self._done = self.total - FIGURES
        self._say("figures", self._done)

    def finish(self) -> None:
        """All is done."""
        self._say("", self.total)

    def _say(self, text: str, done: float) -> None:
        self._tell(min(done, self.total), text, self.total)
