"""Right or wrong: what a diagnosis said against what was hidden.

The answer is the chosen effects together with the alternatives. It is right if it contains every hidden effect that had
to be found and each other member has a separation S_ab < 3 from a hidden one. S >= 3: the name is required; S < 1:
"nothing" is right; between: reported, not scored.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from blind.catalogue import Effect

REQUIRED, UNSEEN = 3.0, 1.0
FAMILIES = ({"gain_loss", "stuck_joint"},)


@dataclass(frozen=True, order=True)
class Name:
    """What was named and where."""

    name: str
    place: int | None = None

    def __str__(self) -> str:
        return self.name if self.place is None else f"{self.name}@{self.place}"


def _place(value: Any) -> int | None:
    if value is None or isinstance(value, bool):
        return None
    if isinstance(value, (int, float)):
        return int(value)
    number = re.search(r"(\d+)$", str(value))
    return int(number.group(1)) if number else None


def names(items: Sequence[Mapping[str, Any]]) -> list[Name]:
    """Names in a list of effects; an item may be a combination `{effects: [...]}`."""
    found: list[Name] = []
    for item in items:
        found += names(item["effects"]) if "effects" in item else [Name(str(item["name"]), _place(item.get("place")))]
    return list(dict.fromkeys(found))


@dataclass(frozen=True)
class Answer:
    """verdict; chosen effects; the group = chosen and alternatives; stand_ins: those said to be no causes."""

    verdict: str
    chosen: tuple[Name, ...]
    group: tuple[Name, ...]
    stand_ins: tuple[Name, ...] = ()


def answer(diagnosis: Mapping[str, Any]) -> Answer:
    chosen = names(diagnosis.get("effects", []))
    others = names(diagnosis.get("alternatives", []))
    stand_ins = names([e for e in diagnosis.get("effects", []) if e.get("stand_in")])
    return Answer(str(diagnosis["verdict"]), tuple(chosen), tuple(dict.fromkeys([*chosen, *others])), tuple(stand_ins))


def odds(diagnosis: Mapping[str, Any]) -> dict[str, float]:
    """Stated probability of every effect that has one."""
    said = [*diagnosis.get("effects", []), *diagnosis.get("alternatives", [])]
    stated = [(n, e["probability"]) for e in said if e.get("probability") is not None for n in names([e])]
    return {str(n): float(p) for n, p in stated}


def same_family(a: Name, b: Name) -> bool:
    return a.place == b.place and any({a.name, b.name} <= family for family in FAMILIES)


# S_ab of a hidden effect (by index) from a named rival
Separation = Callable[[int, Name], float]


@dataclass(frozen=True)
class Judgement:
    """outcome and the separations that were needed.

    Outcomes: right, wrong, missed (nothing named), unscored; with nothing to be found: right (said "nothing"), false
    alarm (something named), false doubt (nothing named, yet not "nothing"), right name below the floor.
    """

    outcome: str
    separations: dict[str, float]


def judge(said: Answer, truth: Sequence[Effect], strengths: Sequence[float], separation: Separation) -> Judgement:
    """For catalogue effects; with no hidden effect, naming anything is a false alarm.

    A name that is said to be perhaps a stand-in, and no cause, is not wrong beside the right ones.
    """
    hidden = [Name(e.name, e.place) for e in truth]
    must = [h for h, s in zip(hidden, strengths, strict=True) if s >= REQUIRED]
    silent = not said.chosen
    if not hidden or all(s < UNSEEN for s in strengths):
        if silent:
            return Judgement("right" if said.verdict == "nothing" else "false doubt", {})
        named_truth = bool(hidden) and set(said.chosen) <= set(hidden)
        return Judgement("right name below the floor" if named_truth else "false alarm", {})
    needed: dict[str, float] = {}

    def near(member: Name, i: int) -> bool:
        if member == hidden[i]:
            return True
        key = f"{hidden[i]} / {member}"
        needed[key] = separation(i, member)
        return needed[key] < REQUIRED

    if silent:
        return Judgement("missed" if must else "unscored", {})
    found = all(
        h in said.group or any(same_family(m, h) and near(m, i) for m in said.group)
        for i, h in enumerate(hidden)
        if h in must
    )
    fitting = all(
        any(near(m, i) for i in range(len(hidden))) for m in said.group if m not in {*hidden, *said.stand_ins}
    )
    if not must:
        return Judgement("unscored", needed)
    return Judgement("right" if found and fitting else "wrong", needed)


def errors(diagnosis: Mapping[str, Any], truth: Sequence[Effect]) -> dict[str, float]:
    """Value minus truth over half the 95 % interval's width, for rightly named effects, parameters off their bounds.

    Within -1 .. 1 the interval covers the truth (if it is symmetric about the value; else the nearer end counts).
    """
    hidden = {Name(e.name, e.place): e.parameters for e in truth}
    found: dict[str, float] = {}
    for item in diagnosis.get("effects", []):
        true = hidden.get(Name(str(item["name"]), _place(item.get("place"))), {})
        for parameter, said in item.get("parameters", {}).items():
            if parameter not in true or said.get("at_bound"):
                continue
            interval = said.get("interval") or [None, None]
            low, high = (float(v) if v is not None else s * np.inf for v, s in zip(interval, (-1, 1), strict=True))
            miss = float(said["value"]) - true[parameter]
            width = float(said["value"]) - low if miss > 0 else high - float(said["value"])
            found[f"{item['name']}.{parameter}"] = miss / width if width > 0 else float(np.sign(miss) * np.inf)
    return found


def wilson(successes: int, trials: int, z: float = 1.959964) -> tuple[float, float]:
    """95 % interval of a proportion (Wilson 1927); (0, 1) without trials."""
    if trials == 0:
        return 0.0, 1.0
    p, n = successes / trials, trials
    centre = (p + z**2 / (2 * n)) / (1 + z**2 / n)
    half = z * np.sqrt(p * (1 - p) / n + z**2 / (4 * n**2)) / (1 + z**2 / n)
    return max(0.0, float(centre - half)), min(1.0, float(centre + half))


def confusion(pairs: Sequence[tuple[str, str]]) -> dict[str, dict[str, int]]:
    """How often each hidden name (outer key) was answered by each chosen name."""
    table: dict[str, dict[str, int]] = {}
    for (hidden, chosen), count in sorted(Counter(pairs).items()):
        table.setdefault(hidden, {})[chosen] = count
    return table
