"""Which certain rivals are said of a campaign, and which of its three sources each of them accuses.

Sources: the joint table, the servo log, the markers. They are compared in pairs; the one that stands against both
others is to blame, and one that agrees with a third is not. What would be wrong everywhere (wiring, markers) is so in
every trial or in none, so what is said agrees over the gaits of a campaign.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from serpenoid.measure.consistency.hypotheses import BOTH, IN_ONE
from serpenoid.measure.consistency.rivals import ODDS, SAID, Rival, leads

TIED = 3.0  # nats: rivals as near as this to the best are named with it
OF_FILES = {"table", "log", "file"}  # kinds of what belongs to another trial
Pair = tuple[str, str]
Kind = tuple[Pair, str, str]


@dataclass(frozen=True)
class Contradiction:
    """What a witness shows instead, the likely cure, and by how much it is likelier [nats, beyond prior odds]."""

    trial: str
    kind: str
    words: str
    cure: str
    certainty: float

    @property
    def said(self) -> str:
        """Words and remedy, as sentences."""
        return f"{self.words}. Remedy: {self.cure}{'' if self.cure.endswith('?') else '.'}"


def certain(rivals: Sequence[Rival], leanings: Mapping[str, float] | None = None) -> list[Contradiction]:
    """The best certain rivals of every trial; what would be wrong in every trial has the evidence of them all.

    leanings: by how much the film of trials makes the table likelier than the log, where these contradict each other.
    """
    together: dict[Kind, float] = defaultdict(float)
    for rival in rivals:
        together[_kind(rival)] += rival.lead
    sure = [r for r in rivals if leads(r, together[_kind(r)] if r.everywhere else r.lead)]
    in_all = {(r.trial, r.pair, r.kind + one) for r in sure if r.everywhere for one in IN_ONE.values()}
    sure = [r for r in sure if (r.trial, r.pair, r.kind) not in in_all]
    compared = {(rival.trial, rival.pair) for rival in rivals}
    by_trial: dict[str, list[Rival]] = defaultdict(list)
    for rival in _agreed(sure, together):
        by_trial[rival.trial].append(rival)
    sided = _sided(by_trial, leanings or {})
    return [
        _contradiction(trial, found, [pair for name, pair in compared if name == trial], sided.get(trial))
        for trial, found in by_trial.items()
    ]


def _sided(by_trial: Mapping[str, Sequence[Rival]], leanings: Mapping[str, float]) -> dict[str, str]:
    """Which of table and log the markers of a trial are certain to follow; what is wrong in every trial is decided by
    them all."""
    together: dict[Kind, float] = defaultdict(float)
    for trial, found in by_trial.items():
        for kind in {_kind(rival) for rival in found if rival.everywhere}:
            together[kind] += leanings.get(trial, 0.0)
    sided = {}
    for trial, found in by_trial.items():
        best = max(found, key=lambda rival: rival.lead + rival.log_share)
        nats = together[_kind(best)] if best.everywhere else leanings.get(trial, 0.0)
        if abs(nats) > ODDS:
            sided[trial] = "table" if nats > 0 else "log"
    return sided


def _kind(rival: Rival) -> Kind:
    """The same in all trials, whatever their tables are called."""
    return rival.pair, rival.kind, rival.cure


def _agreed(sure: Sequence[Rival], together: dict[Kind, float]) -> list[Rival]:
    """Without what would be wrong everywhere where faults of single trials explain the campaign better, and without
    those faults where they do not."""
    single: dict[tuple[str, Pair], float] = defaultdict(float)
    for rival in sure:
        if not rival.everywhere:
            single[rival.trial, rival.pair] = max(single[rival.trial, rival.pair], rival.lead)
    kept = list(sure)
    for kind in dict.fromkeys(_kind(rival) for rival in sure if rival.everywhere):
        mine = {rival.trial for rival in sure if _kind(rival) == kind}
        if any((trial, kind[0]) not in single for trial in mine):
            continue  # some trial has no other explanation
        ahead = together[kind] - sum(lead for (_, pair), lead in single.items() if pair == kind[0])
        if ahead < -TIED:
            kept = [rival for rival in kept if _kind(rival) != kind]
        elif ahead > TIED:
            kept = [r for r in kept if r.everywhere or r.trial not in mine or r.pair != kind[0]]
    return kept


def _contradiction(trial: str, found: Sequence[Rival], compared: Iterable[Pair], sided: str | None) -> Contradiction:
    best = max(rival.lead + rival.log_share for rival in found)
    near = sorted(found, key=lambda rival: -rival.lead - rival.log_share)
    near = [rival for rival in near if rival.lead + rival.log_share > best - TIED][:3]
    against = {(rival.pair, _at_root(rival)) for rival in found}
    clean = set(compared) - {pair for pair, _ in against}
    if sided is not None:
        clean = {pair for pair in clean if "markers" not in pair} | {(sided, "markers")}
    blamed = [_blamed(rival, against, clean) for rival in near]
    told = [rival.words + _sides(rival, who) for rival, who in zip(near, blamed, strict=True)]
    words = "; or ".join(dict.fromkeys(told))
    cures = [cure for rival, who in zip(near, blamed, strict=True) for cure in rival.cured(who)]
    return Contradiction(trial, near[0].kind, words, "; or ".join(dict.fromkeys(cures)), float(best))


def _at_root(rival: Rival) -> str:
    """What is wrong: a file of another trial is another table to its commands, and another log to its film."""
    return "file" if rival.kind in OF_FILES else rival.kind


def _blamed(rival: Rival, against: set[tuple[Pair, str]], clean: set[Pair]) -> list[str]:
    """Sources that may be wrong: against both others in the same way, else those that agree with no other."""
    others = {pair for pair, kind in against if kind == _at_root(rival) and pair != rival.pair}
    twice = [source for source in rival.pair if any(source in pair for pair in others)]
    alone = [s for s in rival.pair if not any(s in pair for pair in clean)]
    if alone == ["markers"] and not twice:  # table and log agree, and may count joints alike in another way
        return ["markers", BOTH]
    return twice or alone or list(rival.pair)


def _sides(rival: Rival, blamed: Sequence[str]) -> str:
    """Which of the two that disagree the third source supports, where the remedy depends on it: one is blamed alone
    only if the other agrees with the third."""
    if not rival.cures or len(blamed) > 1:
        return ""
    right = next(source for source in rival.pair if source not in blamed)
    third = next(source for source in SAID if source not in rival.pair)
    return f", and {SAID[third]} sides with {SAID[right]}"
