"""Effects that a first, poor campaign may not tell apart: for the follow-up study, where a group is wanted first.

Full campaigns (eight settings, two trials each) leave hardly a group: motion within a cycle tells effects apart long
before paths do. So the campaign is one gait, played twice, and what is hidden is weak and has a neighbour that nearly
coincides with it there once eps is fitted: slope and drift of the camera frame, wear of a wheel at either end and of
the next one, a gradient of friction and a wide patch. Parameters are drawn until S is between 1.5 and 2.8.
"""

from __future__ import annotations

import numpy as np

from blind.campaign import Campaign, make
from blind.catalogue import Effect, drawn
from blind.strength import floor, strength

ONE_GAIT = ((1, 0, 0),)  # gait, heading, duration
LEAST, MOST = 1.5, 2.8
ENDS = (0, 1, 10, 11)
WIDE = (0.3, 0.9)  # m, radius of patches
PAIRS = (("slope", "frame_drift"), ("worn_wheel", "worn_wheel"), ("friction_gradient", "friction_patch"))
DRAWS = 2000


def short(seed: int, effect: Effect, identity: str = "campaign") -> Campaign:
    """A campaign of one gait with one effect."""
    return make(seed, [effect], identity, ONE_GAIT)


def _draw(rng: np.random.Generator, name: str) -> Effect:
    place = int(rng.choice(ENDS)) if name == "worn_wheel" else None
    parameters = drawn(rng, name, place).parameters
    if name == "friction_patch":
        parameters["radius"] = float(np.exp(rng.uniform(*np.log(WIDE))))
    return Effect(name, place, parameters)


def draw_near(seed: int) -> Effect:
    """One effect of middling strength in the short campaign of this seed; ArithmeticError if none is found."""
    rng = np.random.default_rng([seed, 4])
    for _ in range(DRAWS):
        effect = _draw(rng, str(rng.choice(PAIRS[int(rng.integers(len(PAIRS)))])))
        c = short(seed, effect)
        if LEAST <= strength(c, effect, floor(c)) <= MOST:
            return effect
    raise ArithmeticError(f"no effect of middling strength in {DRAWS} draws")
