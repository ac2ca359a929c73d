"""The studies: which campaign has which number, what is hidden in it, and how the diagnosis is asked.

null, one, two, outside   the usual protocol of the ten-servo snake
followup, handful         see near.py and handful.py
random                    protocols drawn at random; of six, two hide nothing, two one effect, one two, one a cause
                          outside the catalogue
laid                      the same six; every setting is played at least twice, each time laid anew
weather                   the same six; eps and each wheel's drag differ a little from trial to trial
physics                   a law of the generator's floor is taken out of the catalogue; of three campaigns of a law,
                          one is healthy, and two are changed, with the healthy one as their reference
dry                       the same on floors of dry friction: forces in an ellipse, in a box, or along those of drag
                          that set in as a root, a hyperbolic or an arc tangent does; nothing is taken out
same                      healthy, and as the reference the same gaits on another day
once                      protocols drawn at random, where not even a cycle is played twice, beside the healthy robot; a
                          law of the floor is taken out of the catalogue; of three campaigns one hides nothing, one an
                          effect, one a cause outside the catalogue
amid                      something begins amid a campaign that plays gaits twice, and acts in some trials alone
days                      the same of any protocol that plays gaits twice, on floors that differ from trial to trial
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from blind import changed_trials
from blind.campaign import COMBINATIONS, Campaign, Hide, make
from blind.catalogue import FLOORS, ON_WHEELS, Effect, drawn
from blind.handful import HANDFUL, HANDFUL_COMBINATIONS
from blind.near import draw_near, short
from blind.protocol import usual
from blind.random_protocols import draw_protocol, effects_that_show, laid_anew, once

HIDDEN: dict[str, int | str] = {"null": 0, "one": 1, "two": 2, "outside": "outside"}
SIX = ("null", "one", "outside", "null", "one", "two")
# What the floor of another physics does all the time, at a strength that is drawn between these.
LAWS: dict[str, tuple[str, float, float]] = {
    "grip_saturation": ("saturation_speed", 0.03, 0.1),
    "rolling_resistance": ("crossover_speed", 0.02, 0.1),
    "wheel_mount": ("share", 0.5, 1.0),
    "contact_offset": ("offset", 0.015, 0.02),
    "dry_friction": ("crossover_speed", 0.5, 2.0),  # far above the speeds of a body: Coulomb's law
}
ANOTHER_DAY = (1,)
DAYS = (("now", ()), ("before", ANOTHER_DAY))
RANDOM = ("random", "laid", "weather", "days")
KINDS = (*HIDDEN, "followup", "handful", "random", "laid", "weather", "physics", "dry", "same", "once", "days", "amid")


@dataclass(frozen=True)
class Case:
    """One campaign of a study. cause: null, one, two or outside; reference: an earlier one; without: effects that the
    catalogue must not have; acts: names of trials in which effects act, if not in all."""

    campaign: Campaign
    cause: str
    reference: Campaign | None = None
    without: tuple[str, ...] = ()
    acts: frozenset[str] | None = None


def case(kind: str, index: int, seed: int, identity: str) -> Case:
    """Number `index` of a study."""
    if kind == "followup":
        return Case(short(seed, draw_near(seed), identity), "one")
    if kind == "handful":
        return Case(make(seed, HANDFUL[index], identity, COMBINATIONS[:HANDFUL_COMBINATIONS]), "one")
    if kind == "days":
        again = replace(draw_protocol(seed), plays=2)
        now, before = (make(seed, 0, name, protocol=again, chance=day, weather=True) for name, day in DAYS)
        return Case(replace(now, identity=identity), "null", before)
    if kind in RANDOM:
        cause, protocol = SIX[index % len(SIX)], draw_protocol(seed)
        protocol = laid_anew(protocol, seed) if kind == "laid" else protocol
        among, weather = effects_that_show(protocol), kind == "weather"
        return Case(make(seed, HIDDEN[cause], identity, protocol=protocol, among=among, weather=weather), cause)
    if kind == "amid":
        campaign, acts, before = changed_trials.draw(index, seed, identity)
        return Case(campaign, "one" if campaign.effects else "null", before, acts=acts)
    if kind == "physics":
        return _another_physics(index, seed, identity)
    if kind == "dry":
        return _on_a_dry_floor(index, seed, identity)
    if kind == "once":
        return _once(index, seed, identity)
    if kind == "same":
        return Case(make(seed, 0, identity), "null", make(seed, 0, "before", chance=ANOTHER_DAY))
    return Case(make(seed, HIDDEN[kind], identity), kind)


# What a floor of dry friction does not have besides: what makes dry friction of drag, and what has another unit there.
OF_DRAG = ("dry_friction", "rolling_resistance", "power_law_drag", "grip_saturation", "inertia", "added_mass")


def _on_a_dry_floor(index: int, seed: int, identity: str) -> Case:
    rng = np.random.default_rng([seed, 7])
    base = [drawn(rng, list(FLOORS)[index % len(FLOORS)], None)]
    among = sorted(set(ON_WHEELS) - set(OF_DRAG))
    changed = (index // len(FLOORS)) % 3 > 0
    found = make(seed, int(changed), identity, protocol=usual(seed), base=base, among=among)
    before = make(seed, 0, "before", protocol=usual(seed), base=base, chance=ANOTHER_DAY) if changed else None
    return Case(found, "one" if changed else "null", before)


def _once(index: int, seed: int, identity: str) -> Case:
    protocol, cause = once(draw_protocol(seed)), ("null", "one", "outside")[index % 3]
    base, law = _taken_out(index // 3, seed)
    among = sorted(set(effects_that_show(protocol)) - {law})
    before = make(seed, 0, "before", protocol=protocol, base=base, chance=ANOTHER_DAY)
    now = make(seed, HIDDEN[cause], identity, protocol=protocol, base=base, among=among)
    return Case(now, cause, before, (law,))


def _taken_out(index: int, seed: int) -> tuple[list[Effect], str]:
    """A law of the floor, by its number, and its name."""
    law = list(LAWS)[index % len(LAWS)]
    parameter, low, high = LAWS[law]
    rng = np.random.default_rng([seed, 7])
    return [Effect(law, None, {parameter: float(np.exp(rng.uniform(np.log(low), np.log(high))))})], law


def _another_physics(index: int, seed: int, identity: str) -> Case:
    base, law = _taken_out(index, seed)
    among = sorted(set(ON_WHEELS) - {law})
    changed = (index // len(LAWS)) % 3 > 0
    hide: Hide = int(changed)
    found = make(seed, hide, identity, protocol=usual(seed), base=base, among=among)
    before = make(seed, 0, "before", protocol=usual(seed), base=base, chance=ANOTHER_DAY) if changed else None
    return Case(found, "one" if changed else "null", before, (law,))
