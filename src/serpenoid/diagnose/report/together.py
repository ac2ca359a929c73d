"""Causes of one name at several places are told together, and whether one value would do for all of them."""

from __future__ import annotations

import numpy as np

from serpenoid.diagnose.report.sentences import instead
from serpenoid.diagnose.report.words import Record, foremost, gone, multiple, own_place, shown, times, title
from serpenoid.effects.catalogue import find
from serpenoid.wording import listed

MANY = 3  # places: fewer are told one by one


def together(record: Record) -> list[list[Record]]:
    """What is named, as far as an answer lists it: causes of one name and one number at MANY places or more side by
    side, by place, where the first of them stands; everything else alone."""
    effects = foremost(record)
    groups: dict[str, list[Record]] = {}
    for e in (e for e in effects if _plain(e, record)):
        groups.setdefault(e["name"], []).append(e)
    many = {name: sorted(own, key=lambda e: e["place"]) for name, own in groups.items() if len(own) >= MANY}
    found, told = [], set()
    for e in effects:
        own = many.get(e["name"]) if _plain(e, record) else None
        if own is None:
            found.append([e])
        elif e["name"] not in told:
            told.add(e["name"])
            found.append(own)
    return found


def _plain(effect: Record, record: Record) -> bool:
    """Whether a cause has a place, one number, and nothing more to be said of it."""
    alone = effect["stand_in"] or instead(effect, record) or own_place(effect, record) or gone(effect)
    return not alone and effect.get("place") is not None and len(effect["parameters"]) == 1


def title_of(group: list[Record]) -> str:
    """Name and places, as `gain_loss at joints 1 to 3`."""
    if len(group) == 1:
        return title(group[0])
    name, places = group[0]["name"], [e["place"] for e in group]
    kind = {"vertex": "vertices", "joint": "joints"}[str(find(name).place)]
    in_a_row = places == list(range(places[0], places[-1] + 1))
    which = f"{places[0]} to {places[-1]}" if in_a_row else listed([str(p) for p in places])
    return f"{name} at {kind} {which}"


def titles(group: list[Record]) -> str:
    """Name and places of several, and how strong they are."""
    strengths = [e["strength_over_noise"] for e in group]
    least, most = min(strengths), max(strengths)
    size = times(most) if multiple(least) == multiple(most) else f"{multiple(least)} to {times(most)}"
    return f"{title_of(group)} ({size})"


def in_common(group: list[Record]) -> str:
    """The value that all intervals hold, if there is one; empty: there is none."""
    (name,) = group[0]["parameters"]
    own = [e["parameters"][name] for e in group]
    if any(None in p["interval"] for p in own):
        return ""
    low, high = np.array([p["interval"] for p in own], float).T
    weights = np.maximum(high - low, 1e-12) ** -2.0
    mean = float(weights @ [p["value"] for p in own] / weights.sum())
    if not (low.max() <= mean <= high.min()):
        return ""
    return f"{name} {shown(mean, own[0]['unit'])} lies in every interval: what they share may be the one cause of all"
