"""One witness of one trial: the contract and all its rivals laid over it, and how far each rival is ahead.

Where a rival is ahead, all are laid anew as servos that are late or slow play them: what such servos explain as well is
said, and accuses nobody.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.measure.consistency.hypotheses import Fault, wiring_faults
from serpenoid.measure.consistency.match import Course, Match, Prior, gains_meanwhile, match, match_at
from serpenoid.measure.consistency.signals import Sampled, Signal, sample

FAULTY = 0.05  # of campaigns have something wrong in their file
CERTAIN = 0.99  # posterior probability of a rival at which the contract is not believed
ODDS = float(np.log(CERTAIN / (1 - CERTAIN)) + np.log((1 - FAULTY) / FAULTY))  # nats that a rival must be ahead
POINTS = 40  # of the grid in a cycle
PERIODS = 8  # of a recording that are looked at, from where it begins to move
SURE = 0.95  # of it is explained by what was really played; a rival with less accuses nobody (a damaged robot)
HOPELESS = 50.0  # nats behind at the contract's rate: other rates are not tried
WIRING = "wiring"  # the kind of rivals that turn a joint round, or exchange two
SAID = {"table": "the joint table", "log": "the servo log", "markers": "the film"}
SOURCES = {"the servo log's commands": "log", "the servo log's positions": "log", "the recorded shapes": "markers"}


@dataclass(frozen=True)
class Rival:
    """One hypothesis' lead over the contract in one trial [nats], its prior share taken off separately.

    pair: the two sources that were compared; cures: see `Fault`.
    """

    trial: str
    witness: str
    kind: str
    words: str
    cure: str
    lead: float
    log_share: float
    everywhere: bool
    explained: float  # of the motion's variance
    pair: tuple[str, str]
    cures: Mapping[str, str]

    def cured(self, sources: Sequence[str]) -> list[str]:
        """What to do if one of these sources is wrong."""
        return [self.cures[source] for source in sources if source in self.cures] or [self.cure]


@dataclass(frozen=True)
class Compared:
    """What a witness says: the contract's match, all rivals, and which of them servos explain as well."""

    contract: Match
    rivals: list[Rival]
    witness: str
    doubts: list[tuple[str, str]]


def compared(
    trial: str, signal: Signal, course: Course, own: float | None, faults: list[Fault], witness: str, prior: Prior
) -> Compared:
    """The contract and all rivals laid over one witness; rivals ahead of it, and it, as servos' laws play them, too."""
    pair = ("table" if course.told else "log", SOURCES[witness])
    grid = window(signal, min(course.period_s, own or np.inf), max(course.period_s, own or 0.0))
    contract = match(grid, course, prior)
    laid = [(fault, _laid(grid, fault, contract, prior)) for fault in faults]
    plain = rivals = _rivals(trial, grid, contract, laid, witness, pair, prior)
    if any(rival.lead + rival.log_share > 0 for rival in plain):
        from serpenoid.measure.consistency.servos import with_servos  # CasADi, long to import and seldom asked

        ahead = [found.evidence + fault.log_share > contract.evidence for fault, found in laid]
        contract = with_servos(grid, contract, prior)
        laid = [(f, with_servos(grid, m, prior) if first else m) for (f, m), first in zip(laid, ahead, strict=True)]
        rivals = _rivals(trial, grid, contract, laid, witness, pair, prior)
    contract = replace(contract, gain=gains_meanwhile(grid, contract))
    return Compared(contract, rivals, witness, _doubts(plain, rivals))


def _doubts(plain: Sequence[Rival], rivals: Sequence[Rival]) -> list[tuple[str, str]]:
    """The best rival that would be certain of servos that do as they are told, if none is of servos that need not."""
    certain = [rival for rival in plain if leads(rival, rival.lead)]
    if not certain or any(leads(rival, rival.lead) for rival in rivals):
        return []
    best = max(certain, key=lambda rival: rival.lead + rival.log_share)
    cure = "; or ".join(best.cured(best.pair))
    return [(best.trial, f"{best.words}; servos that are late or slow explain that as well, else: {cure}")]


def leads(rival: Rival, lead: float) -> bool:
    """Whether a rival so far ahead of the contract [nats] is certain, and explains what was seen."""
    return rival.lead > 0 and lead + rival.log_share > ODDS and rival.explained > SURE


def _laid(grid: Sampled, fault: Fault, contract: Match, prior: Prior) -> Match:
    """A rival at the contract's rate, and at others unless that is hopeless."""
    found = match_at(grid, fault.course, contract.rate, prior)
    if found.evidence > contract.evidence - HOPELESS or fault.timed is not None:
        found = match(grid, fault.course, prior)
    return found


def _rivals(
    trial: str,
    grid: Sampled,
    contract: Match,
    laid: Sequence[tuple[Fault, Match]],
    witness: str,
    pair: tuple[str, str],
    prior: Prior,
) -> list[Rival]:
    """How far all are ahead of the contract, those with words."""
    rivals = []
    for fault, found in laid:
        said = (fault.words, fault.cure) if fault.timed is None else fault.timed(found.rate)
        if said is not None:
            rivals.append(
                Rival(trial, witness, fault.kind, f"{witness} {said[0]}", said[1],
                      found.evidence - contract.evidence, fault.log_share, fault.everywhere, found.explained,
                      pair, fault.cures)
            )  # fmt: skip
    for wiring in wiring_faults(grid, contract, prior):
        rivals.append(
            Rival(trial, witness, WIRING, f"{witness} {wiring.words} compared with {SAID[pair[0]]}", wiring.cure,
                  wiring.gain, wiring.log_share, True, wiring.explained, pair, wiring.cures)
        )  # fmt: skip
    return rivals


def window(signal: Signal, shortest: float, longest: float) -> Sampled:
    """On a grid fine enough for the shorter period, from a period before the motion begins and as long as needed."""
    whole = sample(signal, shortest / POINTS)
    if whole.span_s <= PERIODS * longest:
        return whole
    away = np.abs(whole.values - whole.values[: POINTS // 4].mean(axis=0)).max(axis=1) * whole.weight
    begin = whole.start_s + whole.step_s * int(np.argmax(away > 0.2 * away.max())) - longest
    return sample(signal, shortest / POINTS, begin, begin + PERIODS * longest)
