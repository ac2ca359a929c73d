"""What a diagnosis says, a sentence or two on each matter: its verdict, what stands beside it, what is not known."""

from __future__ import annotations

from math import hypot

from serpenoid.diagnose.report.words import STAND_IN, Record, law, parameter, shown, times, title, unseen
from serpenoid.effects.catalogue import find

UNSAID = (
    "neither labels of the log nor commands that are the table's to within a servo's tick say when rows were due: rows "
    "that are held and servos that lag look like rows that run and begin later, so a lag is known only as far as rows "
    "are taken as they were. Log the commands as they are sent"
)
WHOLE = ": the joint table simulated beside what was filmed, what servos miss included; the verdict is not of it"
GROWS = "; it grows: errors of the servos and of the medium had cancelled"
SHOWN = 1.15  # times the noise: what reads more than 1.1
WITHIN = ": chance may make as much of so few windows, and what repeats share of it is no more than chance makes"
TRACELESS = 0.05  # times the noise: what would read 0.0
MEANINGS = {
    "nothing": "{law} alone explains this recording within its noise",
    "explained": "what is named accounts for all beyond chance; nothing here speaks for a cause outside the catalogue",
    "partly explained": "what is named below was found, and more is left than it and chance explain",
    "unexplained": "the model misses more than chance explains, and no effect of the catalogue accounts for it clearly",
}
SETTLED = {"nothing", "explained"}  # verdicts that leave nothing open
UNREPEATED = {
    "nothing": "nothing has a name; nothing was played twice, so nobody can tell whether what is left is chance",
    "explained": "what is named was missing; nothing was played twice, so nobody can tell whether the rest is chance",
}
OTHER_CHANCE = 2**0.5  # times the markers' noise: of chance that is larger, most is of another origin
HIDING = "; most of chance is no noise of the markers: a cause that acts on one repeat alone hides in it"
UNSEEN = {
    "nothing": "{law} alone explains all beyond chance" + HIDING,
    "explained": "what is named accounts for all beyond chance" + HIDING,
}


def meaning(record: Record) -> str:
    """The verdict in a sentence. Beside a reference nothing is said of the model's own errors."""
    if record["verdict"] == "explained" and not record["effects"]:
        return (
            f"the anisotropy ratio alone has changed since the reference: it is {_grown(record)} there, which accounts "
            "for all beyond chance"
        )
    if record["noise_from"] == "residuals" and record["verdict"] in UNREPEATED:
        return UNREPEATED[record["verdict"]]
    if record["verdict"] == "nothing" and record["reference"]:
        return "nothing has changed since the reference beyond the noise of either"
    hiding = (record.get("noise_over_markers") or 0.0) > OTHER_CHANCE
    words = UNSEEN if hiding and record["verdict"] in UNSEEN else MEANINGS
    return words[record["verdict"]].format(law=law(record))


def _stage(effect: Record) -> str:
    """Where an effect is looked for: its site, but for how the cameras' frame moves: that motion shows."""
    return "motion" if find(effect["name"]).marks in ("frame", "jumps") else effect["site"]


def inadequacy(record: Record) -> list[str]:
    """What is to be mended in the campaign, and where names may be stand-ins: by how much the model is inadequate;
    before all else."""
    stand_ins = [e for e in record["effects"] if e["stand_in"]]
    servos, seen = ([title(e) for e in stand_ins if _stage(e) == stage] for stage in ("actuation", "observation"))
    moves = len(stand_ins) > len(servos) + len(seen)
    said = list(record.get("mend_first", []))
    if moves and record["discrepancy_m"] == 0 and seen:
        said.append("names of the floor that are marked as stand-ins rest on markers whose errors are not understood")
    elif moves and record["discrepancy_m"] == 0 and record["verdict"] not in SETTLED and not _beside_wrong(record):
        said.append(
            "paths stray by more than chance beside what is named: names marked as stand-ins take a part of that away, "
            "but may be there for a cause that the catalogue does not hold"
        )
    elif moves and record["discrepancy_m"] == 0 and record.get("parts_differ_by"):
        said.append(
            f"parts that each differ a little (`{record['parts_differ_by']}`) do as well as names of the floor that "
            "are marked as stand-ins"
        )
    elif moves and record["discrepancy_m"] == 0:
        said.append(
            "the reference followed a law that the catalogue does not hold: names marked as stand-ins may mend it "
            "where the change moves it"
        )
    elif moves:
        size = shown(record["discrepancy_m"], record["length_unit"], 2)
        said.append(
            f"the model is inadequate by {size} a window beyond chance: names marked as stand-ins take a "
            "part of that away, but may be there for a cause that the catalogue does not hold"
        )
    said += [f"{name} is a part of what the servos do: their law is another" for name in servos]
    if seen:
        parts = "is a part" if len(seen) == 1 else "are parts"
        said.append(f"{', '.join(seen)} {parts} of what markers show beside the servos: its law is another")
    return said


def _beside_wrong(record: Record) -> bool:
    """Whether the reference followed a law that the catalogue does not hold."""
    return bool(record["reference"]) and record["reference"]["verdict"] not in SETTLED


def rival_law(record: Record) -> list[str]:
    """How another law of the floor does, or another place of the drag, and how to follow it."""
    other, follow = record["law"], "to look for causes beside it, diagnose with a --model whose [medium] has"
    rivals, taken = other.get("rivals", {}), other.get("taken")  # neither in older answers
    told = [*((said, f'law = "{name}"') for name, said in rivals.items()), (other["drag_at"], 'dissipation = "edge"')]
    instead = [taken, "a --model whose [medium] says its `law` keeps that"] if taken else []
    return [*instead, *(text for said, key in told if said for text in (said, f"{follow} {key}"))]


def undetected(record: Record) -> list[str]:
    """Effects below detection: they improve the prediction, but chance makes traces as large."""
    kept = {True: ", but in the extended model", False: ""}
    return [
        f"below detection{kept[e['in_extended_model']]}: {title(e)} ({times(e['strength_over_noise'])})"
        for e in record["below_detection"]
        if e["strength_over_noise"] >= TRACELESS
    ]


def untestable(record: Record) -> list[str]:
    """Effects that a recording cannot speak about, reason by reason."""
    reasons = dict.fromkeys(record["untestable"].values())
    names = {why: [name for name, own in record["untestable"].items() if own == why] for why in reasons}
    return [f"{', '.join(names[why])}: {why}" for why in reasons]


def reference(record: Record) -> list[str]:
    """What an earlier campaign, taken as the baseline, had shown."""
    earlier = record["reference"]
    if not earlier:
        return []
    name = earlier["campaign"]
    found = "; ".join(f"{title(e)}{STAND_IN if e['stand_in'] else ''}" for e in earlier["effects"])
    said = [f"the earlier campaign ({name}) was {earlier['verdict']}" + (f": {found}" if found else "")]
    said += _otherwise(record)
    said += [f"of it: {text}" for text in rival_law(earlier)]
    said += [_there_already(e) for e in earlier["effects"] if _key(e) in map(_key, record["effects"])]
    return said + _there_in_part(record)


def already(record: Record) -> list[str]:
    """What was left in the earlier campaign, taken as the baseline."""
    return [f"it already showed: {text}" for text in (record["reference"] or {}).get("residual_pattern", [])]


def already_in_short(record: Record) -> list[str]:
    """The same in a line, where it is more: it is no news."""
    every = already(record)
    if len(every) < 2:
        return every
    return [
        f"what was left there, {len(every)} sentences, is under `reference` in diagnosis.json and in its own answer"
    ]


def _told_beside(record: Record) -> float:
    """eps of the explanation of the reference that the change is told beside."""
    taken = record.get("baseline", {}).get("anisotropy_ratio")
    return float(taken or record["reference"]["anisotropy_ratio"]["after"])


def _otherwise(record: Record) -> list[str]:
    """Where the change is told beside another explanation of the reference than its own answer."""
    taken = record.get("baseline")  # none in older answers
    if taken is None or taken["anisotropy_ratio"] == record["reference"]["anisotropy_ratio"]["after"]:
        return []
    law = ", ".join(title(e) for e in taken["effects"]) or "nothing"
    named = {_key(e) for e in record["reference"]["effects"]}
    guessed = [title(e) for e in taken["effects"] if _key(e) not in named]
    which = "" if len(guessed) == len(taken["effects"]) else f": {', '.join(guessed)}"
    tried = f" (no findings, only stand-ins for the law of its floor{which})" if guessed else ""
    return [
        "the change is counted from another model of the earlier campaign than its own answer has, as both campaigns "
        f"fit better with it: {law}, anisotropy ratio {taken['anisotropy_ratio']:.4g}{tried}"
    ]


def _key(effect: Record) -> tuple[str, int | None]:
    return effect["name"], effect.get("place")


def _there_already(effect: Record) -> str:
    """An effect of the reference that is named again: of the motion, its value is all of it, as then."""
    values = ", ".join(f"{name} {parameter(p)}" for name, p in effect["parameters"].items())
    now = "; the value named now is all of it, not the change" if find(effect["name"]).moves else ""
    return f"{title(effect)} was there already: {values}{now}"


def _there_in_part(record: Record) -> list[str]:
    """Effects named now of which the reference is explained by some, though it was not named there."""
    guesses = {_key(e): e["parameters"] for e in record.get("baseline", {}).get("effects", [])}
    named = {_key(e) for e in record["reference"]["effects"]}
    found = []
    for e in record["effects"]:
        if (before := guesses.get(_key(e))) is not None and _key(e) not in named:
            values = ", ".join(f"{name} {shown(x, e['parameters'][name]['unit'])}" for name, x in before.items())
            found.append(
                f"{title(e)} is a part of its explanation, too weak to be named there: {values}; the value named now "
                "is all of it, and its interval holds that none of it was there"
            )
    return found


def ratio(record: Record) -> str:
    """eps: of the reference, with nothing named, with what is named. A calibration is no diagnosis, but may be news."""
    eps, earlier = record["anisotropy_ratio"], record["reference"]
    said = [f"{_told_beside(record):.4g} in the reference"] if earlier else []
    said.append(f"{eps['before']:.4g} with nothing named")
    if record["effects"] or eps["after"] != eps["before"]:
        said.append(f"{eps['after']:.4g} with what is {'named' if record['effects'] else 'below detection'}")
    low, high = eps["interval"]
    warning = " (at its bound: a warning that the law is another)" if eps["at_bound"] else ""
    how = ", by windows of smoothed points" if record.get("drag_ratio") else ""  # `fit` goes from frame to frame
    return f"{', '.join(said)} (95 %: {low:.4g} .. {high:.4g}{how}){warning}"


def ratio_change(record: Record) -> list[str]:
    """Where eps is another than in the reference: how much larger or smaller it is now."""
    change = record["anisotropy_ratio"].get("change")  # none in older answers
    if change is None:
        return []
    return [
        f"the anisotropy ratio is {_grown(record)} in the reference ({times(change['strength_over_noise'])}): what all "
        "wheels or scales have in common has changed, or eps makes up for a change that has no name"
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
        "goals": "the log's commands are goals, each run to until the next is given: what servos read fits this best",
        "reference": "as in the reference",
        "readings": "what servos read fits this best",
        "markers": "what markers show of the joints fits this best",
    }
    how = "held until the next is due" if record["rows_held"] else "run through on straight lines"
    unsaid = [UNSAID] if record.get("lag_untold") else []
    return [f"{how} ({who[record['rows_from']]})", *unsaid]


def drag_ratio(record: Record) -> str:
    """K of an animal with its interval, if its law of the floor is all there is."""
    ratio = record["drag_ratio"]
    low, high = ratio["interval"]
    alone = f"if {law(record)} is all there is: frame by frame, as in `fit`"
    return f"{ratio['value']:.4g} (95 %: {low:.4g} .. {high:.4g}) {alone}"


def chance(record: Record) -> list[str]:
    """How much of what repeats differ by is no noise of the markers: what is smaller than that hides in it."""
    ratio = record.get("noise_over_markers")
    if ratio is None:
        return []
    return [
        f"what was played again differs {ratio:.2g} times as much as the markers' noise makes it; what acts on one "
        "repeat and not on the other counts as chance, and hides what is smaller"
    ]


def no_experiment(record: Record) -> str:
    """Why none is proposed."""
    if record["alternatives"]:
        return "none is proposed: no gait that was tried is expected to exclude one of the explanations"
    if record["verdict"] in SETTLED:
        return "none needed: no two explanations are left to tell apart"
    if record["drag_ratio"]:
        return "none is proposed: nothing commands an animal"
    return "none is proposed: there are no two explanations to tell apart, and what is left has none"


def left_open(record: Record) -> str:
    """How far held-out paths are expected to stray for want of other gaits that tell, where that is more than noise."""
    if record["left_open_m"] <= record["noise_level_m"]:
        return ""
    size = open_length(record, record["left_open_m"]) or "more is"
    of = f" of {', '.join(gaits)}" if (gaits := open_gaits(record)) else ""
    return f" ({size} expected: what the other {unseen(record)} leave open{of})"


def open_length(record: Record, open_m: float) -> str:
    """What others leave open; empty where first order makes it more than held-out paths are off by."""
    rms = record["gain"]["path_rms_m"]
    return shown(open_m, record["length_unit"]) if open_m <= max(rms["before"], rms["after"]) else ""


def unreliable(record: Record) -> list[str]:
    """Where what is named makes held-out paths stray farther, by more than noise and what other gaits leave open."""
    rms = record["gain"]["path_rms_m"]
    allowed = hypot(rms["before"], record["noise_level_m"], record["left_open_m"])
    if not record["effects"] or rms["after"] <= allowed:
        return []
    return [f"what is named does not carry over to other {unseen(record)}: do not rely on it without further trials"]


def open_gaits(record: Record) -> list[str]:
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
    return f"{s['stage']:18}{before} -> {after}, noise {noise}{beside}{whole}"


def within_chance(s: Record, record: Record) -> str:
    """Of the motion's error that is larger than the noise, and not spoken of: why it is taken for chance."""
    told = any(text.startswith(f"{s['stage']}: ") for text in record["residual_pattern"])
    repeated = record["noise_from"] in {"trials", "cycles"}
    larger = s["stage"] == "motion" and s["after"] >= SHOWN * s["noise_level"]
    return WITHIN if repeated and larger and not told else ""
