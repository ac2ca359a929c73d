"""How a diagnosis names things: effects with their places, numbers with their units, in words that fit the body."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from serpenoid.body import ANIMALS
from serpenoid.effects.base import Advice
from serpenoid.effects.catalogue import catalogue, find
from serpenoid.media import LAWS

Record = Mapping[str, Any]
SCALES = {
    "m": (1e3, "mm"), "m/s": (1e3, "mm/s"), "rad": (180 / math.pi, "°"), "rad/s": (180 / math.pi, "°/s"),
    "m/rad": (1e3, "mm/rad"), "bl/rad": (1.0, "body lengths/rad"),
    "bl": (1.0, "body lengths"), "bl/s": (1.0, "body lengths/s"),
    "s2/m": (1.0, "s²/m"), "s2/bl": (1.0, "s²/body length"),
    "m2/s2": (1.0, "m²/s²"), "bl2/s2": (1.0, "body lengths²/s²"),
}  # fmt: skip
SMALL_M = 1e-5
STAND_IN = ", perhaps a stand-in"
GONE = ", gone since the reference"
LISTED = 3  # of a list, before it says how many more there are


def law(record: Record) -> str:
    """What the floor or the water does, in the model that was fitted."""
    return LAWS[record["law"]["name"]].words


def advice(record: Record, effect: Record) -> Advice:
    """What a named effect looks like and what to do about it, in words that fit the kind of body."""
    return find(effect["name"]).words(record.get("kind") in ANIMALS)  # none in older answers


def title(effect: Record) -> str:
    """Name and place, as `worn_wheel at vertex 4`."""
    place = effect.get("place")
    return effect["name"] if place is None else f"{effect['name']} at {find(effect['name']).place} {place}"


def gone(effect: Record) -> bool:
    """Whether a cause was there before, and intervals of all its numbers hold those that do nothing."""
    if effect["stand_in"] or effect.get("gone"):
        return not effect["stand_in"]
    rests = {p.name: p.neutral for p in find(effect["name"]).parameters if p.neutral is not None}
    numbers = [(rests[name], p) for name, p in effect["parameters"].items() if name in rests]
    known = [(rest, *p["interval"]) for rest, p in numbers if "before" in p]
    return bool(known) and all(
        (-math.inf if low is None else low) <= rest <= (math.inf if high is None else high) for rest, low, high in known
    )


def what_to_do(effect: Record, record: Record) -> list[str]:
    """What to do about a cause; nothing about one that is gone."""
    return [] if effect["stand_in"] or gone(effect) else [advice(record, effect).what_to_do]


def own_place(effect: Record, record: Record) -> str:
    """Where drag amid edges makes vertices there: a vertex in the numbers of the campaign's own body."""
    place = effect.get("place")
    if place is None or not record.get("middles") or find(effect["name"]).place != "vertex":
        return ""
    pieces = int(record["middles"])
    edge, part = divmod(place, pieces + 1)
    amid = f"the middle of edge {edge}" if pieces == 1 else f"piece {part} of {pieces} of edge {edge}"
    return f"{amid if part else f'vertex {edge}'} of the campaign's body"


def foremost(record: Record) -> list[Record]:
    """What is named, as far as an answer lists it: causes, then the strongest stand-ins."""
    effects = record["effects"]
    stand_ins = sorted((e for e in effects if e["stand_in"]), key=lambda e: -e["strength_over_noise"])
    return [*(e for e in effects if not e["stand_in"]), *stand_ins[: _few(len(stand_ins))]]


def few(names: Sequence[str]) -> str:
    """The first of them, and how many more there are."""
    shown = _few(len(names))
    more = f", and {len(names) - shown} more in diagnosis.json" if len(names) > shown else ""
    return ", ".join(names[:shown]) + more


def _few(count: int) -> int:
    """How many of a list are told: all, rather than that there is one more."""
    return count if count <= LISTED + 1 else LISTED


def sentence(text: str) -> str:
    """With a full stop, and a capital unless it begins with a name of an effect or of anything in code."""
    first = text.split(maxsplit=1)[0].strip(",:")
    begun = text if "_" in first or first in catalogue() else text[0].upper() + text[1:]
    return begun if begun.endswith((".", "?")) else f"{begun}."


def shown(value: float | None, unit: str, digits: int = 3, size: float | None = None) -> str:
    """A number in the unit that people use, as `1.97 mm` (of a worm, in um), or of its `size`; `unbounded` for None."""
    if value is None:
        return "unbounded"
    scale, name = SCALES.get(unit, (1.0, "" if unit == "1" else unit))
    if name[:2] == "mm" and 0 < (abs(value) if size is None else size) < SMALL_M:
        scale, name = 1e6, f"\N{MICRO SIGN}m{name[2:]}"
    number = value * scale
    text = f"{number:.{digits}g}" if abs(number) < 1000 else f"{number:.0f}"
    return text + (name if name.startswith("°") else f" {name}" if name else "")


def parameter(p: Record) -> str:
    """Value and interval, as `0.398 (95 %: 0.393 .. 0.404)`, and what it was before a change."""
    if p["interval"] == [None, None] and "before" in p:
        return f"before {shown(p['before'], p['unit'])}"
    value, low, high = ends(p)
    bound = ", at its bound" if p.get("at_bound") else ""
    was = f", before {shown(p['before'], p['unit'])}" if "before" in p else ""
    return f"{value} (95 %: {low} .. {high}{bound}){was}"


def ends(p: Record) -> tuple[str, str, str]:
    """Value and ends of the interval, in one unit, with as many digits as tell them apart."""
    low, high = p["interval"]
    size = max(abs(x) for x in (p["value"], low, high) if x is not None)
    width = high - low if None not in (low, high) else size
    digits = 3 if width <= 0 or size == 0 else max(3, 2 + math.ceil(math.log10(size / width)))
    value, first, last = (shown(x, p["unit"], digits, size) for x in (p["value"], low, high))
    return value, first, last


def times(ratio: float) -> str:
    """A size beside the noise level, as `1.3 times the noise`."""
    return f"{multiple(ratio)} times the noise"


def multiple(ratio: float) -> str:
    """The number of that."""
    return f"{ratio:.1f}" if ratio < 10 else f"{ratio:.0f}"


def unseen(record: Record) -> str:
    """What is held out: gaits, settings, trials, or the parts of an animal's recording."""
    known = record.get("held_out") or ("gaits" if record["drag_ratio"] is None else "parts")  # none in older answers
    return "trials" if known == "nothing" else str(known)


def in_sample(record: Record) -> bool:
    """Whether there is nothing that could be held out."""
    return record.get("held_out") == "nothing"
