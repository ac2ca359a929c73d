"""The lead of the report: three cards, each a question and its answer: the verdict, the cause, what it is worth."""

from __future__ import annotations

from serpenoid.diagnose.report.drag import drag_ratio, ratio_change, rival_law
from serpenoid.diagnose.report.next_trial import left_open, unreliable
from serpenoid.diagnose.report.sentences import SETTLED, changed_trials, instead, undetected
from serpenoid.diagnose.report.together import in_common, title_of, titles, together
from serpenoid.diagnose.report.verdicts import inadequacy, meaning
from serpenoid.diagnose.report.words import (
    GONE,
    STAND_IN,
    Record,
    advice,
    few,
    foremost,
    gone,
    in_sample,
    law,
    own_place,
    parameter,
    sentence,
    shown,
    times,
    title,
    unseen,
    what_to_do,
)
from serpenoid.report.pages import Card

GAINS = {
    "path_rms_m": ("path RMS", "m"), "displacement_error_m": ("displacement error, RMS", "m"),
    "heading_error_rad": ("heading error, RMS", "rad"), "s": ("s (spread of ln ratio of displacements)", "1"),
    "log_likelihood": ("log-likelihood per trial", "1"),
}  # fmt: skip
WORSE = 1.02  # an error that does not come closer
VISIBLY = 0.05  # of a log-likelihood: less is not seen
NOT_WORSE = {False: "Nothing became worse.", True: "Nothing became visibly worse."}
IN_SAMPLE = "Of one trial nothing can be held out: it is predicted from the fit to itself."


def cards(record: Record) -> list[Card]:
    """Verdict; cause and place; gain on gaits that were not fitted, with what got worse."""
    return [_verdict(record), _cause(record), _gain(record)]


def _verdict(record: Record) -> Card:
    mend = record.get("mend_first", [])
    said = [
        meaning(record),
        *changed_trials(record),
        *ratio_change(record),
        *mend,
        *inadequacy(record),
        *rival_law(record),
    ]
    rows = [(s["stage"], times_noise(s["after"], s["noise_level"])) for s in record["ladder"]]
    rows += [(stage, "skipped") for stage in record["skipped"] if record["drag_ratio"] is None]
    return Card("Verdict", record["verdict"], [*map(sentence, said), "What is left, stage by stage:"], rows,
                "good" if record["verdict"] in SETTLED else "warn")  # fmt: skip


def _cause(record: Record) -> Card:
    effects = foremost(record)
    several = together(record)
    rows = [
        (name if len(group) == 1 else title(e), parameter(p))
        for group in several for e in group for name, p in e["parameters"].items()
    ]  # fmt: skip
    said = [text for group in several for text in _about(group, record)]
    said += [f"Below detection: {few(weak)}."] if (weak := undetected(record)) else []
    if record["drag_ratio"]:
        what = law(record)
        said.append(f"{what.capitalize()} across over {what} along the body, K = 1 / eps: {drag_ratio(record)}.")
    elif not effects:
        said.append(f"The anisotropy ratio was calibrated to {record['anisotropy_ratio']['after']:.4g}.")
    answer = few([*map(title_of, several), *(title(e) for e in record["effects"] if e not in effects)])
    return Card("Cause and place", answer or "none named", said, rows)


def _about(group: list[Record], record: Record) -> list[str]:
    """What an effect looks like and, where it is a cause, what to do; of several causes of one name, of all of them."""
    effect = group[0]
    if len(group) > 1:
        words, shared = advice(record, effect), in_common(group)
        said = [f"{titles(group)}: {words.looks_like}.", *([sentence(shared)] if shared else [])]
        return [*said, f"What to do: {words.what_to_do}."]
    words, own = advice(record, effect), own_place(effect, record)
    place = f"{title(effect)}, which is {own}" if own else title(effect)
    strength = f"{place} ({times(effect['strength_over_noise'])}){GONE if gone(effect) else ''}"
    others = [f"Or instead: {text}." for text in instead(effect, record)]
    doubt = STAND_IN if effect["stand_in"] else ""
    to_do = [f"What to do: {text}." for text in what_to_do(effect, record)]
    return [f"{strength}{doubt}: {words.looks_like}.", *others, *to_do]


def _gain(record: Record) -> Card:
    rows = [(GAINS[key][0].partition(",")[0].partition(" (")[0], _change(record, key)) for key in GAINS]
    rows.append(("noise level", shown(record["noise_level_m"], record["length_unit"])))
    alone = in_sample(record)
    said = [IN_SAMPLE if alone else f"Every {unseen(record)[:-1]} predicted from a fit to the others."]
    said += map(sentence, left_open(record))
    bad = worse(record)
    unsure = _overlap(record["gain"]["path_rms_m"])
    if unsure:
        said.append("The intervals of path RMS before and after overlap: the gain is not certain.")
    said.append(f"Worse with the extension: {', '.join(bad)}." if bad else NOT_WORSE[unsure])
    said += map(sentence, unreliable(record))
    answer = f"path RMS {_change(record, 'path_rms_m')}"
    asks = "Gain in sample" if alone else f"Gain on unseen {unseen(record)}"
    return Card(asks, answer, said, rows, "warn" if bad or unsure else "good")


def _overlap(gain: Record) -> bool:
    """Whether before and after differ by less than their intervals are wide."""
    if gain["before"] == gain["after"]:
        return False
    (low, high), (first, last) = gain["before_interval"], gain["after_interval"]
    return bool(max(low, first) < min(high, last))


def worse(record: Record) -> list[str]:
    """Measures of the prediction that the extension leaves farther off."""
    found = []
    for key, (name, _) in GAINS.items():
        before, after = (record["gain"][key][side] for side in ("before", "after"))
        if before is None or after is None:
            continue
        if after < before - VISIBLY if key == "log_likelihood" else after > WORSE * before:
            found.append(name)
    return found


def unit_of(key: str, record: Record) -> str:
    """Of one of GAINS; lengths are in the recording's own."""
    unit = GAINS[key][1]
    return record["length_unit"] if unit == "m" else unit


def _change(record: Record, key: str) -> str:
    unit = unit_of(key, record)
    before, after = (shown(record["gain"][key][side], unit) for side in ("before", "after"))
    return f"{before} \N{RIGHTWARDS ARROW} {after}"


def times_noise(error: float, noise: float) -> str:
    """An error beside its noise level, as `1.3 times the noise`."""
    if noise <= 0:
        return "no noise level"
    return times(error / noise)
