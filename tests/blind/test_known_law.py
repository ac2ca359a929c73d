"""What other gaits leave open: all of what only one of them tells, little of what each tells."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from blind.campaign import COMBINATIONS, Campaign, make
from blind.catalogue import Effect
from blind.gaits import random_table
from blind.known_law import held_out_together, known_law
from blind.protocol import Combination, usual
from blind.strength import floor

BACKWARD = Effect("forward_backward_asymmetry", None, {"asymmetry": -0.1})
TOE = Effect("toe", None, {"angle": 0.05})
FIRST = COMBINATIONS[:4]  # the first gait alone goes tail first


def campaign(*effects: Effect, tails: int = 1, seed: int = 2) -> Campaign:
    """Four gaits, of which the first ones go tail first."""
    protocol, rng = usual(seed, FIRST), np.random.default_rng(seed)
    fastest = min(s.plan.cycle_s for s in protocol.settings)
    turned = [
        replace(s, plan=replace(s.plan, table=random_table(rng, -1, fastest))) if 0 < s.gait < tails else s
        for s in protocol.settings
    ]
    return make(seed, effects, protocol=replace(protocol, settings=tuple(turned)))


@pytest.mark.slow
def test_what_one_gait_alone_tells_is_open_without_it() -> None:
    alone, again = campaign(BACKWARD), campaign(BACKWARD, tails=2)
    one, two = known_law(alone), known_law(again)
    assert one.left_open > 10 * floor(alone) > 10 * two.left_open
    assert one.held_out > 2 * floor(alone)
    assert two.held_out < 1.2 * floor(again)


def test_what_every_gait_tells_is_known_without_one() -> None:
    c = campaign(TOE)
    assert known_law(c).left_open < 0.5 * floor(c)
    assert known_law(c).held_out == pytest.approx(floor(c), rel=0.1)


def test_of_what_nothing_is_told_the_effect_itself_is_open() -> None:
    """Two gaits, one of them tail first: without it nobody knows of so weak an asymmetry."""
    few = COMBINATIONS[:2]
    weak, weaker = (make(2, [Effect(BACKWARD.name, None, {"asymmetry": a})], combinations=few) for a in (2e-3, 1e-3))
    assert known_law(weak).left_open == pytest.approx(2 * known_law(weaker).left_open, rel=0.1)


def test_gaits_are_held_out_else_settings_else_trials() -> None:
    def held_out(*combinations: Combination) -> list[object]:
        return held_out_together(make(5, [TOE], combinations=combinations))

    assert held_out((0, 0, 0), (1, 1, 1)) == [0, 0, 1, 1]
    assert held_out((0, 0, 0), (0, 1, 2)) == ["gait01-a"] * 2 + ["gait01-b"] * 2
    assert held_out((0, 0, 0)) == [0, 1]
