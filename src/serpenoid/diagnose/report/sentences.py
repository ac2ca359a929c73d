"""What a diagnosis says, a sentence or two on each matter: its verdict, what stands beside it, what is not known."""

from __future__ import annotations

import math
from math import hypot

from serpenoid.diagnose.data.noise.repeats import UNLIKE
from serpenoid.diagnose.inference.doubt.laws import NEITHER
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS
from serpenoid.diagnose.inference.fits.finding import alone
from serpenoid.diagnose.inference.fits.held_out import fails
from serpenoid.diagnose.report.words import (
    Record,
    few,
    in_sample,
    law,
    multiple,
    parameter,
    shown,
    times,
    title,
    unseen,
)
from serpenoid.effects.catalogue import find
from serpenoid.media import DEFAULT, LAWS
from serpenoid.wording import GROWING, NOT_NAMED, OF_SHAPES, OTHER_LAW

UNSAID = (
    "the log does not say when rows were due: it has no labels, and its commands are not the table's",
    "held rows with servos that lag look like straight rows that begin later",
    "a lag is known only as far as rows are taken as they were: log the commands as they are sent",
)
WHOLE = "; joint table to path, not judged"
GROWS = "; it grows: errors of the servos and of the medium had cancelled"
MISSED_THEN = "how far any change may move what the reference's model of the servos missed"
SHOWN = 1.15  # times the noise: what reads more than 1.1
WITHIN = "; in so few windows noise may make as much; what repeats share of it is no more than noise"
ALIKE = 0.005  # of eps: what reads alike
SIDEWAYS = "above 1: the body slips more easily sideways than lengthwise, and moves the way its bends run"
TRACELESS = 0.05  # times the noise: what would read 0.0
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
SAID_OF_NAMES = {  # why they are in doubt, by how words on what is left end
    OTHER_LAW: "names that take at some places what they give at others may stand for another law",
    GROWING: "a cause that grows from trial to trial explains more than the stand-ins",
    OF_SHAPES: "a point beside the midline bends the shapes: stand-ins may mend what that does to the path",
}
SETTLED = {"nothing", "explained"}  # verdicts that leave nothing open
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
MIDDLES = 'dissipation = "edge"'


def meaning(record: Record) -> str:
    """The verdict in a sentence. Beside a reference nothing is said of the model's own errors."""
    if record["verdict"] == "explained" and not record["effects"]:
        return "only the anisotropy ratio has changed; that accounts for everything beyond the noise"
    if record["noise_from"] == "residuals" and record["verdict"] in UNREPEATED:
        return UNREPEATED[record["verdict"]]
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


def rival_law(record: Record) -> list[str]:
    """How the best other law of the floor does, or another place of the drag, and how to follow it, where it leaves
    less."""
    other, follow = record["law"], "to look for causes beside it: diagnose with a --model whose [medium] has"
    rivals, taken = other.get("rivals", {}), other.get("taken")  # neither in older answers
    told = [*((said, f'law = "{name}"') for name, said in [*rivals.items()][:1]), (other["drag_at"], MIDDLES)]
    keep = f'to keep {LAWS[DEFAULT].title}: a --model whose [medium] has law = "{DEFAULT}"'
    found = [taken, keep] if taken else []
    for said, key in told:
        found += [said, *([] if said.endswith(NEITHER) else [f"{follow} {key}"])] if said else []
    return found


def undetected(record: Record) -> list[str]:
    """Effects below detection: they improve the prediction, but noise makes traces as large, or they may be none."""
    kept = {True: ", in the extended model", False: ""}
    return [
        f"{title(e)} ({times(e['strength_over_noise'])}{_roughly(e)}{kept[e['in_extended_model']]})"
        for e in record.get("below_detection", [])
        if e["strength_over_noise"] >= TRACELESS
    ]


def _roughly(effect: Record) -> str:
    """Values of what has no name, with their intervals unless it is too weak to have any."""
    said = {
        name: parameter(p) if any(end is not None for end in p.get("interval", ())) else shown(p["value"], p["unit"])
        for name, p in effect.get("parameters", {}).items()
    }
    return "".join(f", {name} {value}" for name, value in said.items())


def instead(effect: Record, record: Record) -> list[str]:
    """What could stand in the place of an effect, and how far predictions then differ."""
    others = [e for e in record["alternatives"] if title(e.get("instead_of") or effect) == title(effect)]
    if not others:
        return []
    apart = [e["separation_over_noise"] for e in others]
    least = "" if multiple(min(apart)) == multiple(max(apart)) else f"{multiple(min(apart))} to "
    return [f"{few([title(e) for e in others])}; predictions differ by {least}{times(max(apart))}"]


def untestable(record: Record) -> list[str]:
    """Effects that a recording cannot speak about, reason by reason."""
    reasons = dict.fromkeys(record["untestable"].values())
    names = {why: [name for name, own in record["untestable"].items() if own == why] for why in reasons}
    return [f"{few(names[why])}: {why}" for why in reasons]


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
    said += rival_law(earlier)
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


def _told_beside(record: Record) -> float:
    """eps of the explanation of the reference that the change is told beside."""
    taken = record.get("baseline", {}).get("anisotropy_ratio")
    return float(taken or record["reference"]["anisotropy_ratio"]["after"])


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
    """An effect of the reference that is named again: of the motion, its value is all of it, as then."""
    values = ", ".join(f"{name} {parameter(p)}" for name, p in effect["parameters"].items())
    whole = ["its value now is all of it, not the change"] if find(effect["name"]).moves else []
    return [f"{title(effect)} was there already: {values}", *whole]


def _there_in_part(record: Record) -> list[str]:
    """Effects named now of which the reference is explained by some, though it was not named there."""
    guesses = {_key(e): e["parameters"] for e in record.get("baseline", {}).get("effects", [])}
    named = {_key(e) for e in record["reference"]["effects"]}
    found = []
    for e in record["effects"]:
        if (before := guesses.get(_key(e))) is not None and _key(e) not in named:
            values = ", ".join(f"{name} {shown(x, e['parameters'][name]['unit'])}" for name, x in before.items())
            found.append(f"{title(e)} may have been there already, too weak to be named: {values}")
            found.append("its value now is all of it; its interval allows that none of it was there")
    return found


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


def changed_trials(record: Record) -> list[str]:
    """Which trials were diagnosed alone, beside what, and what came of it."""
    told = record.get("changed_trials")  # none in older answers
    if not told:
        return []
    answer = told["diagnosis"]
    names, beside = alone(told["trials"], told["others"]), "the reference" if record["reference"] else "the others"
    causes = few([title(e) for e in answer["effects"]]) if answer["effects"] else "no effect named"
    by = answer.get("may_differ_by") or 0.0  # none in older answers
    size = f"it may grow from trial to trial: {1 - by:.2g} to {1 + by:.2g} times its mean in these, told of one of them"
    return [f"{names}, diagnosed beside {beside}: {answer['verdict']}", causes, *([size] if by else [])]


def changed_report(record: Record) -> str:
    """Where their own report is, empty where there are none."""
    told = record.get("changed_trials")
    return f"{told['folder']}/report.html" if told else ""


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


def seconds(record: Record) -> str:
    """How much of the recordings the answer is made from."""
    return f"{record['used_s']:.4g} s used, {record['dropped_s']:.4g} s dropped"


def rows(record: Record) -> list[str]:
    """How the tables' rows were taken, and who said so; nothing of animals, nor of records that do not say."""
    if not record.get("rows_from"):
        return []
    who = {
        "commands": "the log's commands say so",
        "goals": "the log's commands are goals; what servos read fits this best",
        "reference": "as in the reference",
        "readings": "what servos read fits this best",
        "markers": "what markers show of the joints fits this best",
    }
    how = "each held until the next is due" if record["rows_held"] else "played on straight lines from row to row"
    return [f"{how} ({who[record['rows_from']]})", *(UNSAID if record.get("lag_untold") else ())]


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


def chance(record: Record) -> list[str]:
    """How much of what repeats differ by is no noise of the markers: what is smaller than that hides in it."""
    ratio = record.get("noise_over_markers")
    if ratio is None:
        return []
    if record["noise_from"] == "residuals":
        return [f"what the model leaves is {ratio:.2g} times the markers' noise"]
    if record["noise_from"] == "cycles":
        return [f"cycles of one trial differ by {ratio:.2g} times the markers' noise"]
    hiding = record.get("hiding")  # none in older answers
    return [
        f"repeats differ by {ratio:.2g} times the markers' noise",
        "what acts on one repeat and not on the other counts as noise, and hides what is smaller",
        *(
            [f"{hiding}: less than most of it, and yet hardly chance; look at these trials and their repeats"]
            if hiding
            else []
        ),
    ]


def no_experiment(record: Record) -> str:
    """Why none is proposed."""
    if record["alternatives"]:
        return "none: no gait that was tried is expected to exclude one of the explanations"
    if record["verdict"] in SETTLED:
        return "none needed: no two explanations are left to tell apart"
    if record["drag_ratio"]:
        return "none: nothing commands an animal"
    return "none: there are no two explanations to tell apart, and what is left has none"


def start(pose: Record) -> str:
    """Where the next experiment begins."""
    x, y = (round(pose[k], 2) + 0.0 for k in ("x_m", "y_m"))  # -0.00 is 0.00
    return f"x = {x:.2f} m, y = {y:.2f} m, heading {shown(pose['heading_rad'], 'rad')}"


def experiment(record: Record) -> list[str]:
    """What to play next, and what it tells apart; of an animal nothing."""
    plan = record["next_experiment"]
    if plan is None:
        return [no_experiment(record)] if record["drag_ratio"] is None else []
    return [
        f"play {plan['joint_table']}, {plan['cycle_duration_s']:.2f} s per cycle, from {start(plan['start_pose'])}",
        f"to tell what is named apart from {few([title(e) for e in plan['tells_apart']])}",
    ]


def held_out(record: Record) -> list[str]:
    """How well paths are predicted without and with what was found, and what limits that."""
    rms, unit = record["gain"]["path_rms_m"], record["length_unit"]
    before, after, noise = (shown(x, unit) for x in (rms["before"], rms["after"], record["noise_level_m"]))
    better = "" if rms["before"] == rms["after"] else f" -> {after} by the extended model"
    said = [f"path RMS {before}{better} (noise level {noise})"]
    if record.get("only_predicts"):  # not in older answers
        said += [f"it holds what only predicts, and is no name: {few([title(e) for e in record['only_predicts']])}"]
    if in_sample(record):
        return [*said, "of one trial nothing can be held out"]
    return said + left_open(record) + unreliable(record)


def left_open(record: Record) -> list[str]:
    """How far held-out paths are expected to stray for want of other gaits that tell, where that is more than noise."""
    if record["left_open_m"] <= record["noise_level_m"]:
        return []
    size = _open_length(record) or "a larger error"
    of = f" of {few(gaits)}: play more of that kind" if (gaits := _open_gaits(record)) else ""
    return [f"{size} is expected, as the other {unseen(record)} tell too little{of}"]


def _open_length(record: Record) -> str:
    """What others leave open; empty where first order makes it more than held-out paths are off by."""
    rms, open_m = record["gain"]["path_rms_m"], record["left_open_m"]
    return shown(open_m, record["length_unit"]) if open_m <= max(rms["before"], rms["after"]) else ""


def unreliable(record: Record) -> list[str]:
    """Where what is named makes held-out paths stray farther, by more than noise and what other gaits leave open."""
    rms = record["gain"]["path_rms_m"]
    strays = fails(rms["before"], rms["after"], record["noise_level_m"], record["left_open_m"])
    if not record["effects"] or not strays:
        return []
    return [f"what is named does not carry over to other {unseen(record)}: do not rely on it without more trials"]


def _open_gaits(record: Record) -> list[str]:
    """Gaits of which the others leave more open than noise, where that is more than noise in all."""
    if record["left_open_m"] <= record["noise_level_m"]:
        return []
    return [name for name, open_m in record["left_open_by_gait_m"].items() if open_m > record["noise_level_m"]]


def stage_line(s: Record) -> str:
    """A stage of the ladder: its error before and after, beside its noise."""
    before, after, noise = (shown(s[k], s["unit"]) for k in ("before", "after", "noise_level"))
    beside = f" ({times(s['after'] / s['noise_level'])})" if s["noise_level"] > 0 else ""
    grows = GROWS if s["after"] > hypot(s["before"], s["noise_level"]) else ""
    whole = WHOLE + grows if s["stage"] == "whole" else ""
    doubt = s.get("doubt", 0.0)  # not in older answers
    mostly = f", of which {shown(doubt, s['unit'])} is {MISSED_THEN}" if 2 * doubt**2 > s["noise_level"] ** 2 else ""
    return f"{before} -> {after}, noise level {noise}{mostly}{beside}{whole}"


def left(record: Record) -> list[str]:
    """What is left on each stage, whether it matters, and what is known of it."""
    judged = [s for s in record["ladder"] if s["stage"] != "whole" and s["noise_level"] > 0]
    sizes = ", ".join(f"{s['stage']} {multiple(s['after'] / s['noise_level'])}" for s in judged)
    size = f": {sizes} times the noise" if sizes else ""
    return [_matters(record) + size, *map(in_short, record["residual_pattern"])]


def _matters(record: Record) -> str:
    """Whether what is left matters."""
    if record["verdict"] not in SETTLED:
        return "enough to matter" if record["residual_pattern"] else "no more than the noise, beside stand-ins"
    return "nobody can tell whether it matters" if record["noise_from"] == "residuals" else "nothing that matters"


def in_short(text: str) -> str:
    """A sentence about what is left, of long lists the first."""
    head, _, names = text.rpartition(": ")
    return f"{head}: {few(names.split(', '))}" if NOT_NAMED in head else text


def within_chance(s: Record, record: Record) -> str:
    """Of the motion's error that is larger than the noise, and not spoken of: why it is taken for chance."""
    told = any(text.startswith(f"{s['stage']}: ") for text in record["residual_pattern"])
    repeated = record["noise_from"] in {"trials", "cycles"}
    larger = s["stage"] == "motion" and s["after"] >= SHOWN * s["noise_level"]
    return WITHIN if repeated and larger and not told else ""
