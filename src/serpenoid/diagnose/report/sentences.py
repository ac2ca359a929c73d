"""What a diagnosis says, a sentence or two on each matter: its verdict, what stands beside it, what is not known."""

from __future__ import annotations

from math import hypot

from serpenoid.diagnose.inference.fits.finding import alone
from serpenoid.diagnose.report.words import Record, few, multiple, parameter, shown, times, title
from serpenoid.wording import NOT_NAMED

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
TRACELESS = 0.05  # times the noise: what would read 0.0
SETTLED = {"nothing", "explained"}  # verdicts that leave nothing open


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
