"""News of a start that lasts: how many iterations it has had, and how long one takes."""

from __future__ import annotations

import time
from collections.abc import Callable

NEWS_S = 1.0  # between two of them: what is over sooner is no news


class Iterations:
    """Called with the objective after each iteration of a solver; tells (starts done, words), at most once a second."""

    def __init__(self, tell: Callable[[int, str], None], clock: Callable[[], float] = time.monotonic) -> None:
        self._tell, self._clock = tell, clock
        self.next_start(0)

    def next_start(self, done: int, name: str = "") -> None:
        """So many starts are done; another begins, by default named by its number."""
        self._done, self._count, self._name = done, 0, name or f"start {done + 1}"
        self._begun = self._told = self._clock()

    def __call__(self, objective: float) -> None:
        """One more iteration."""
        self._count += 1
        now = self._clock()
        if now - self._told >= NEWS_S:
            self._told = now
            each = (now - self._begun) / self._count
            self._tell(self._done, f"{self._name}, iteration {self._count}, {each:.2g} s each")
