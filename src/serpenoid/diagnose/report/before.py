"""What is said of a reference: what it was found to be, and what is so since then."""

from __future__ import annotations

from serpenoid.diagnose.report.drag import rival_law
from serpenoid.diagnose.report.words import Record, few, parameter, shown, title

WHOLE = "its value now is the whole of it, not what was added since"


def reference(record: Record) -> list[str]:
    """What an earlier campaign, taken as the baseline, had shown."""
    earlier = record["reference"]
    if not earlier:
        return []
    causes, stand_ins = ([title(e) for e in earlier["effects"] if e["stand_in"] == kind] for kind in (False, True))
    said = [f"{earlier['campaign']} was {earlier['verdict']}" + (f": {few(causes)}" if causes else "")]
    said += [f"perhaps stand-ins: {few(stand_ins)}"] if stand_ins else []
    said += since(record)
    said += _otherwise(record)
    said += rival_law(earlier, of_reference=True)
    again = [e for e in earlier["effects"] if _key(e) in map(_key, record["effects"])]
    said += [text for e in again for text in _there_already(e)]
    return said + _there_in_part(record)


def since(record: Record) -> list[str]:
    """By how much joint angles and paths of the same gaits are otherwise than then, and repeats than each other."""
    found = record.get("since_reference")  # not in older answers
    if not found or found["path_m"] is None:
        return []
    unit = record["length_unit"]
    most = max(found["gaits"], key=lambda g: g["path_m"] or 0.0)
    of_one = f", most in `{most['gait']}`: {shown(most['path_m'], unit)}" if len(found["gaits"]) > 1 else ""
    size = shown(found["path_m"], unit) + _repeats(found["repeats_m"], unit)
    said = [f"without any model, paths differ from it by {size}{of_one}"]
    if not (turned := found["joints_rad"]):
        return said
    joint = turned.index(max(turned))
    chance = (found["joints_repeats_rad"] or [None] * len(turned))[joint]
    others = turned[:joint] + turned[joint + 1 :]
    beside = f"; the other joints by up to {shown(max(others), 'rad')}" if others else ""
    return [*said, f"joint {joint + 1} by {shown(turned[joint], 'rad')}{_repeats(chance, 'rad')}{beside}"]


def _repeats(size: float | None, unit: str) -> str:
    """What repeats differ by."""
    return " (no setting was played twice)" if size is None else f" (repeats by {shown(size, unit)})"


def already(record: Record) -> list[str]:
    """What was left in the earlier campaign, taken as the baseline."""
    return [f"it already showed: {text}" for text in (record["reference"] or {}).get("residual_pattern", [])]


def already_in_short(record: Record) -> list[str]:
    """The same in a line, where it is more: it is no news."""
    every = already(record)
    if len(every) < 2:
        return every
    return [f"what was left there: {len(every)} sentences under `reference` in diagnosis.json"]


def _otherwise(record: Record) -> list[str]:
    """Where the change is told beside another explanation of the reference than its own answer."""
    taken = record.get("baseline")  # none in older answers
    if taken is None or taken["anisotropy_ratio"] == record["reference"]["anisotropy_ratio"]["after"]:
        return []
    names = [title(e) for e in taken["effects"]]
    named = {_key(e) for e in record["reference"]["effects"]}
    guessed = [title(e) for e in taken["effects"] if _key(e) not in named]
    said = [
        "the change is counted from another model of the reference, which fits both campaigns better",
        f"that model: anisotropy ratio {taken['anisotropy_ratio']:.4g}, {few(names) or 'nothing else'}",
    ]
    which = "" if len(guessed) == len(names) else f": {few(guessed)}"
    return said + ([f"no findings, only stand-ins for the law of its floor{which}"] if guessed else [])


def _key(effect: Record) -> tuple[str, int | None]:
    return effect["name"], effect.get("place")


def _there_already(effect: Record) -> list[str]:
    """An effect of the reference that is named again: its value is all of it, as then."""
    values = ", ".join(f"{name} {parameter(p)}" for name, p in effect["parameters"].items())
    return [f"{title(effect)} was there already: {values}", WHOLE]


def _there_in_part(record: Record) -> list[str]:
    """Effects named now of which the reference is explained by some, though it was not named there."""
    guesses = {_key(e): e["parameters"] for e in record.get("baseline", {}).get("effects", [])}
    named = {_key(e) for e in record["reference"]["effects"]}
    found = []
    for e in record["effects"]:
        if (before := guesses.get(_key(e))) is not None and _key(e) not in named:
            values = ", ".join(f"{name} {shown(x, e['parameters'][name]['unit'])}" for name, x in before.items())
            found.append(f"{title(e)} may have been there already, too weak to be named: {values}")
            found.append(f"{WHOLE}: an interval that holds 0 means that it may be gone")
    return found
