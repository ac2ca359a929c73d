"""What is said of drag: its ratio, whether that has changed, an animal's K, and other laws."""

from __future__ import annotations

import math

from serpenoid.diagnose.inference.doubt.laws import NEITHER
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS
from serpenoid.diagnose.report.words import Record, law, times
from serpenoid.media import DEFAULT, LAWS

ALIKE = 0.005  # of eps: what reads alike
MIDDLES = 'dissipation = "edge"'
SIDEWAYS = "above 1: the body slips more easily sideways than lengthwise, and moves the way its bends run"


def rival_law(record: Record, of_reference: bool = False) -> list[str]:
    """How the best other law of the floor does, or another place of the drag, and how to follow it, where it leaves
    less; of_reference: as it is said of an earlier campaign."""
    other, follow = record["law"], "to look for causes beside it: diagnose with a --model whose [medium] has"
    rivals, taken = other.get("rivals", {}), other.get("taken")  # neither in older answers
    keep = f'to keep {LAWS[DEFAULT].title}: a --model whose [medium] has law = "{DEFAULT}"'
    found = [taken, keep] if taken else []
    for name, said in [*rivals.items()][:1]:
        found += [said, *([] if said.endswith(NEITHER) else [f'{follow} law = "{name}"'])] if said else []
    if not other["drag_at"]:
        return found
    file = other.get("drag_at_model")  # not in older answers
    where = "that its answer writes if it is diagnosed by itself" if of_reference else "in the folder of this answer"
    beside = f"to look for causes beside it: diagnose with --model {file}, {where}" if file else f"{follow} {MIDDLES}"
    return [*found, other["drag_at"], beside]


def _told_beside(record: Record) -> float:
    """eps of the explanation of the reference that the change is told beside."""
    taken = record.get("baseline", {}).get("anisotropy_ratio")
    return float(taken or record["reference"]["anisotropy_ratio"]["after"])


def ratio(record: Record) -> str:
    """eps: of the reference, with nothing named, with what is named. A calibration is no diagnosis, but may be news."""
    eps = record["anisotropy_ratio"]
    low, high = eps["interval"]
    how = ", window by window" if record.get("drag_ratio") else ""  # `fit` goes from frame to frame
    said = [f"{eps['after']:.4g} (95 %: {low:.4g} .. {high:.4g}{how})"]
    if not record["effects"] and eps["after"] != eps["before"]:
        said[0] += " fitted beside what is below detection"
    if record["effects"] or eps["after"] != eps["before"]:
        said.append(f"{eps['before']:.4g} {'with nothing named' if record['effects'] else 'fitted alone'}")
    said += _in_reference(record) if record["reference"] else []
    said += [SIDEWAYS] if eps["after"] > 1 else []
    said += ["at its bound: a warning that the law is another"] if eps["at_bound"] else []
    if not eps["at_bound"] and low <= LEAST_EPS:
        said.append("its interval begins at the bound: a warning that the law is another")
    return "; ".join(said)


def _in_reference(record: Record) -> list[str]:
    """eps of the model that the change is told beside, and of the earlier answer, where that is another."""
    beside, answer = _told_beside(record), record["reference"]["anisotropy_ratio"].get("answer")  # not in older answers
    if answer is None or abs(answer["value"] - beside) < ALIKE * beside:
        return [f"{beside:.4g} in the reference"]
    low, high = answer["interval"]
    told = f"{answer['value']:.4g} ({low:.4g} .. {high:.4g})"
    return [f"{beside:.4g} in the model that predicts the reference best; its answer was {told}"]


def ratio_change(record: Record) -> list[str]:
    """Where eps is another than in the reference: how much larger or smaller it is now."""
    change = record["anisotropy_ratio"].get("change")  # none in older answers
    if change is None:
        return []
    return [
        f"the anisotropy ratio is {_grown(record)} in the reference ({times(change['strength_over_noise'])})",
        "all wheels or scales, or the medium, have changed alike, or the ratio makes up for a change that has no name",
    ]


def _grown(record: Record) -> str:
    factor = record["anisotropy_ratio"]["change"]["factor"]
    return f"{factor:.3g} times as large as" if factor > 1 else f"smaller by a factor of {1 / factor:.3g} than"


def drag_ratio(record: Record) -> str:
    """K of an animal with its interval, if its law of the floor is all there is; else beside what is named, too."""
    ratio = record["drag_ratio"]
    low, high = ratio["interval"]
    how = ", frame by frame as in `fit`" if ratio.get("by_frames", True) else ""  # older answers do not say
    value = "not determined" if ratio["value"] is None else f"{ratio['value']:.4g}"
    interval = f"(95 %: {low:.4g} .. {high:.4g}{how})"
    if not record["effects"]:
        return f"{value} {interval} if {law(record)} is all there is{_of_dry_friction(record)}"
    eps = record["anisotropy_ratio"]
    least, most = eps["interval"]
    named = f"{1 / eps['after']:.4g} (95 %: {1 / most:.4g} .. {1 / least:.4g}) beside what is named"
    return f"{named}; {value} if {law(record)} were all there is"


def _of_dry_friction(record: Record) -> str:
    """K of forces that dry friction would have, where no file says which law it is and windows had no reason to ask. At
    small slip angles dry friction with forces 1 to K is drag of 1 to K^2 (`media/coulomb.py`)."""
    asked = record["law"]
    in_water = record.get("kind") == "swimmer"
    if in_water or asked["name"] != DEFAULT or not asked.get("open") or asked.get("rivals"):  # older answers: not said
        return ""
    if record["drag_ratio"]["value"] is None:
        return ""
    root = math.sqrt(record["drag_ratio"]["value"])
    return f"; about {root:.2g}, its root, if dry friction is, which may leave as little here"
