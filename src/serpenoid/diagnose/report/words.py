"""How a diagnosis names things: effects with their places, numbers with their units, in words that fit the body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from serpenoid.body import ANIMALS
from serpenoid.effects.base import Advice
from serpenoid.effects.catalogue import find
from serpenoid.media import LAWS

Record = Mapping[str, Any]
SCALES = {
    "m": (1e3, "mm"), "m/s": (1e3, "mm/s"), "rad": (180 / math.pi, "°"), "rad/s": (180 / math.pi, "°/s"),
    "bl": (1.0, "body lengths"), "bl/s": (1.0, "body lengths/s"),
    "s2/m": (1.0, "s²/m"), "s2/bl": (1.0, "s²/body length"),
    "m2/s2": (1.0, "m²/s²"), "bl2/s2": (1.0, "body lengths²/s²"),
}  # fmt: skip
SMALL_M = 1e-5
STAND_IN = ", perhaps a stand-in"


def law(record: Record) -> str:
    """What the floor or the water does, in the model that was fitted."""
    return LAWS[record["law"]["name"]].words


def advice(record: Record, effect: Record) -> Advice:
    """What a named effect looks like and what to do about it, in words that fit the kind of body."""
    return find(effect["name"]).words(record["kind"] in ANIMALS)


def title(effect: Record) -> str:
    """Name and place, as `worn_wheel at vertex 4`."""
    place = effect.get("place")
    return effect["name"] if place is None else f"{effect['name']} at {find(effect['name']).place} {place}"


def own_place(effect: Record, record: Record) -> str:
    """Where drag in the middles of edges makes vertices of them: a vertex in the numbers of the campaign's own body."""
    place = effect.get("place")
    if place is None or not record.get("middles") or find(effect["name"]).place != "vertex":
        return ""
    half = place // 2
    return f"{f'the middle of edge {half}' if place % 2 else f'vertex {half}'} of the campaign's body"


def alternative(effect: Record) -> str:
    """What could stand in the place of what is named."""
    instead = effect.get("instead_of")
    return f"{title(effect)} in the place of {title(instead)}" if instead else title(effect)


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
    """Value and interval, as `0.398 (95 %: 0.393 .. 0.404)`."""
    value, low, high = ends(p)
    bound = ", at its bound" if p.get("at_bound") else ""
    return f"{value} (95 %: {low} .. {high}{bound})"


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
    return f"{ratio:.1f} times the noise" if ratio < 10 else f"{ratio:.0f} times the noise"


def unseen(record: Record) -> str:
    """What is held out: gaits, settings, trials, or the parts of an animal's recording."""
    known = record.get("held_out") or ("gaits" if record["drag_ratio"] is None else "parts")  # none in older answers
    return "trials" if known == "nothing" else str(known)


def in_sample(record: Record) -> bool:
    """Whether there is nothing that could be held out."""
    return record.get("held_out") == "nothing"
