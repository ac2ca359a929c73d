"""What a verdict means, and why names are in doubt."""

from __future__ import annotations

from serpenoid.diagnose.data.noise.repeats import UNLIKE
from serpenoid.diagnose.report.sentences import SETTLED, undetected
from serpenoid.diagnose.report.words import Record, few, law, shown, title
from serpenoid.effects.catalogue import find
from serpenoid.wording import ANY_RATIO, GROWING, OF_SHAPES, OTHER_LAW

MEANINGS = {
    "nothing": "{law} explains this recording within its noise",
    "explained": "what is named accounts for everything beyond the noise",
    "partly explained": "what is named accounts for a part; more than the noise is left",
    "unexplained": "more than the noise is left, and no effect of the catalogue clearly explains it",
}
PATH_ALONE = "{law} explains the path within its noise"  # of a recording whose windows show more
LINKS = (
    "what effects do is computed on straight links between the points; stand-ins do no more than what else is named is "
    "off by for that, or than paths are off by"
)
OPEN = "what is named accounts for everything beyond the noise, and so does another cause"
SAID_OF_NAMES = {  # why they are in doubt, by how words on what is left end
    OTHER_LAW: "names that take at some places what they give at others may stand for another law",
    GROWING: "a cause that grows from trial to trial explains more than the stand-ins",
    ANY_RATIO: "another anisotropy ratio may have changed in the place of stand-ins",
    OF_SHAPES: "a point beside the midline bends the shapes: stand-ins may mend what that does to the path",
}
UNREPEATED = {
    "nothing": "nothing is named; nothing was played twice, so nobody can tell whether what is left is noise",
    "explained": "what is named was missing; nothing was played twice, so nobody can tell whether the rest is noise",
}
OTHER_CHANCE = 2**0.5  # times the markers' noise: of noise that is larger, most is of another origin
UNPLAYED = (
    "; {more:.2g} times as much counts as noise as in the reference, though repeats are as alike: what the model "
    "misses, where that played no such trial. Play the same gaits in both"
)
HIDING = "; most of the noise is not that of the markers: a cause that acts on one repeat alone hides in it"
DOUBT = "a stand-in may be there for a cause that the catalogue lacks: change nothing for its sake"


def meaning(record: Record) -> str:
    """The verdict in a sentence. Beside a reference nothing is said of the model's own errors."""
    if record["verdict"] == "explained" and not record["effects"]:
        return "only the anisotropy ratio has changed; that accounts for everything beyond the noise"
    if record["noise_from"] == "residuals" and record["verdict"] in UNREPEATED:
        return UNREPEATED[record["verdict"]]
    left = record.get("residual_pattern", [])
    if left and all(w.endswith(ANY_RATIO) for w in left):
        return OPEN
    if record.get("changed_trials"):
        return "something acts in some of the trials alone: see `changed trials`"
    weak = undetected(record) if record["verdict"] == "nothing" else []
    if record["verdict"] == "nothing" and record["reference"]:
        said = "nothing has changed since the reference beyond the noise of either"
    else:
        known = few([e["name"] for e in record.get("baseline", {}).get("effects", [])])  # not in older answers
        words = PATH_ALONE if weak else MEANINGS[record["verdict"]]
        said = words.format(law=law(record) + (f" with {known}" if known else " alone"))
    weaker = f"; what windows show besides moves the path by less than its noise: {few(weak)}" if weak else ""
    hiding = record["verdict"] in SETTLED and (record.get("noise_over_markers") or 0.0) > OTHER_CHANCE
    which = f" ({record['hiding']})" if record.get("hiding") else ""
    return said + weaker + f"{HIDING}{which}" * hiding + noisier(record)


def noisier(record: Record) -> str:
    """Where repeats differ far more than in the reference, though by no more than chance may make of so few; or where
    they do not, and yet more counts as noise: what the model misses in gaits that the reference did not play."""
    before = (record["reference"] or {}).get("noise_level_m")
    if not before or record["noise_from"] != "trials" or record["verdict"] not in SETTLED:
        return ""
    more, then = record["noise_level_m"] / before, record["reference"].get("noise_over_markers")  # not in older answers
    alike = bool(then) and (record.get("noise_over_markers") or 0.0) <= UNLIKE * then
    said = f"; repeats differ by {more:.2g} times as much as in the reference: look at what one of them met"
    return (UNPLAYED.format(more=more) if alike else said) if more > UNLIKE else ""


def _stage(effect: Record) -> str:
    """Where an effect is looked for: its site, but for how the cameras' frame moves: that motion shows."""
    return "motion" if find(effect["name"]).marks in ("frame", "jumps") else effect["site"]


def inadequacy(record: Record) -> list[str]:
    """Where names may be stand-ins: why, and what follows; where drag is more unlike than water makes it."""
    stand_ins = [e for e in record["effects"] if e["stand_in"]]
    servos, seen = ([title(e) for e in stand_ins if _stage(e) == stage] for stage in ("actuation", "observation"))
    said = [_why_doubted(record, bool(seen))] if len(stand_ins) > len(servos) + len(seen) else []
    for names, whose in ((servos, "what the servos do"), (seen, "what markers show beside the servos")):
        said += [f"{whose} follows another law; parts of it: {few(names)}"] if names else []
    return said + [DOUBT] * bool(stand_ins) + record.get("beyond_water", [])  # not in older answers


def _why_doubted(record: Record, seen: bool) -> str:
    """Why names of the motion may be stand-ins. seen: others stand in for what markers show."""
    if record["discrepancy_m"] != 0:
        size = shown(record["discrepancy_m"], record["length_unit"], 2)
        return f"the model is off by {size} a window beyond the noise; stand-ins take away a part of that"
    if seen or any(w.startswith("observation: ") for w in record["residual_pattern"]):
        return "stand-ins of the floor rest on markers whose errors are not understood"
    for ending, why in SAID_OF_NAMES.items():
        if any(w.endswith(ending) for w in record["residual_pattern"]):
            return why
    if record["noise_from"] == "residuals" and not record["reference"]:
        return (
            "nothing was played twice, and what is left is more than the markers' noise: names that do less than three "
            "times as much may be parts of an error of the law"
        )
    if record["verdict"] not in SETTLED and not _beside_wrong(record):
        return "beside what is named, paths are off by more than the noise"
    if record.get("parts_differ_by"):
        return f"parts that differ a little (by {record['parts_differ_by']}) explain as much as the stand-ins"
    if record.get("may_differ_by"):
        return "what acts may grow from trial to trial: stand-ins may mend what one size of it for all of these leaves"
    if record["noise_from"] == "points":
        return LINKS
    if not record["reference"]:
        return "stand-ins do less than paths are off by beside them, though in so few windows noise may make as much"
    return "the reference follows a law that the catalogue lacks: stand-ins may mend only that law"


def _beside_wrong(record: Record) -> bool:
    """Whether the reference followed a law that the catalogue does not hold."""
    return bool(record["reference"]) and record["reference"]["verdict"] not in SETTLED
