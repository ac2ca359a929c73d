"""News of a start that lasts; none of one that does not."""

from __future__ import annotations

import pytest

from serpenoid.cli.iterations import Iterations
from serpenoid.optimise.solve import solve
from specimens import problem


def test_a_start_that_lasts_says_how_far_it_is() -> None:
    now, told = [0.0], list[tuple[int, str]]()
    news = Iterations(lambda done, words: told.append((done, words)), lambda: now[0])
    for now[0] in (0.4, 0.8, 1.2, 1.6):
        news(0.0)
    assert told == [(0, "start 1, iteration 3, 0.4 s each")]
    news.next_start(1)
    for now[0] in (1.7, 1.8, 3.6):
        news(0.0)
    assert told[1:] == [(1, "start 2, iteration 3, 0.67 s each")]


@pytest.mark.usefixtures("virtual_machine")
def test_every_iteration_is_watched() -> None:
    seen: list[float] = []
    found = solve(problem("reference-optimum"), starts=1, watch=seen.append)
    assert len(seen) >= found.best.iterations > 0
    assert seen[-1] == pytest.approx(found.best.objective, abs=1e-6)
