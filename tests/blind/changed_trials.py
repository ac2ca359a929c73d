"""Something that begins to act amid a campaign, in some of its trials alone: how it is drawn, and when it is found.

Any protocol that plays three gaits or more twice or more, round by round or gait by gait. A moment is drawn, and of
some campaigns a second one, at which the cause goes again; one campaign in four hides nothing. Every other campaign has
a healthy one of another day as its reference.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from blind.campaign import Campaign, make
from blind.protocol import Protocol
from blind.random_protocols import MOST_TRIALS, draw_protocol, effects_that_show
from blind.score import REQUIRED, UNSEEN, Name, answer, errors, judge
from blind.separation import separation
from blind.strength import floor, strength

GAITS, ANOTHER_DAY = 3, (1,)
EACH_ITS_OWN = ("position_jumps",)  # every recording has others, and a diagnosis tells each
BY_GAIT, GOES_AGAIN = 0.25, 0.2  # of campaigns: the order of their trials, and a second moment


def draw(index: int, seed: int, identity: str) -> tuple[Campaign, frozenset[str], Campaign | None]:
    """The campaign, trials in which its effects act, and its reference."""
    rng = np.random.default_rng([seed, 11])
    protocol = _played_again(seed)
    healthy = make(seed, 0, identity, protocol=protocol)
    among = [name for name in effects_that_show(protocol) if name not in EACH_ITS_OWN]
    changed = make(seed, int(index % 4 > 0), identity, protocol=protocol, among=among)
    count, plays = len(healthy.trials), protocol.plays
    rounds = sorted(range(count), key=lambda i: (i % plays, i // plays))
    order = list(range(count)) if rng.uniform() < BY_GAIT else rounds
    first = int(rng.integers(count // 4, count - count // 4))
    last = int(rng.integers(first + count // 4, count)) if first < count // 2 and rng.uniform() < GOES_AGAIN else count
    acts = order[first:last] if changed.effects else []
    trials = tuple((changed if i in acts else healthy).trials[i] for i in order)
    reference = make(seed, 0, "before", protocol=protocol, chance=ANOTHER_DAY) if index % 2 else None
    return replace(changed, trials=trials), frozenset(changed.trials[i].name for i in acts), reference


def _played_again(seed: int) -> Protocol:
    protocol = draw_protocol(seed)
    rng = np.random.default_rng([seed, 12])
    settings = protocol.settings
    more = draw_protocol(int(rng.integers(2**31)))
    while len(settings) < GAITS:  # gaits of the same robot, at other speeds
        again = settings[len(settings) % len(protocol.settings)]
        plan = replace(again.plan, cycle_s=float(np.round(again.plan.cycle_s * (1.3 + 0.3 * len(settings)), 2)))
        label = f"gait{len(settings) + 1:02d}-a"
        heading = float(more.settings[0].heading)
        settings = (*settings, replace(again, label=label, gait=len(settings), heading=heading, plan=plan))
    plays = max(2, min(protocol.plays, MOST_TRIALS // len(settings)))
    # rows that are held run where servos do not lag: a lag that begins would change the player, too
    return replace(protocol, settings=settings, plays=plays, held=False)


def score(c: Campaign, acts: frozenset[str], diagnosis: Mapping[str, Any]) -> dict[str, Any]:
    """The answer of the changed trials where there is one, else that of all; that all of them are explained by one
    cause, or by none, is wrong where it shows."""
    told = diagnosis.get("changed_trials")
    said = answer(told["diagnosis"] if told else diagnosis)
    row: dict[str, Any] = {
        "verdict": diagnosis["verdict"],
        "changed_verdict": told["diagnosis"]["verdict"] if told else None,
        "trials": len(c.trials), "changed": len(acts), "told": len(told["trials"]) if told else None,
        "chosen": [str(n) for n in said.chosen], "group": [str(n) for n in said.group],
        "stand_ins": [str(n) for n in said.stand_ins],
        "truth": [e.as_dict() for e in c.effects], "hidden": [str(Name(e.name, e.place)) for e in c.effects],
        "eps": c.eps, "odds": {},
    }  # fmt: skip
    if not c.effects:
        silent = not said.chosen and told is None
        right = silent and diagnosis["verdict"] == "nothing"
        return row | {"strengths": [], "outcome": "right" if right else "false doubt" if silent else "false alarm"}
    alone = replace(c, trials=tuple(t for t in c.trials if t.name in acts))
    f = floor(alone)
    strengths = [strength(c, e, f) for e in c.effects]  # as if it acted in all trials
    row |= {"noise_level_m": f, "strengths": strengths}
    if max(strengths) < UNSEEN:
        return row | {"outcome": "right" if not said.chosen else "unscored"}
    if told is None:
        if max(strengths) < REQUIRED:
            return row | {"outcome": "unscored"}
        named = set(said.chosen) - set(said.stand_ins) - {Name(e.name, e.place) for e in c.effects}
        settled = diagnosis["verdict"] in ("nothing", "explained")
        return row | {"outcome": "wrong" if named or settled else "missed"}
    verdict = judge(said, c.effects, strengths, lambda i, n: separation(c, c.effects[i], n.name, n.place, f))
    missed = errors(told["diagnosis"], c.effects)
    right = verdict.outcome == "right" and set(told["trials"]) <= acts  # in some of them it may not show
    return row | {
        "outcome": "right" if right else "wrong" if verdict.outcome == "right" else verdict.outcome,
        "separations": verdict.separations,
        "covered": {name: abs(error) <= 1 for name, error in missed.items()},
        "errors_over_half_width": missed,
    }
