"""First stage: which set-points the servos follow, of all ways to take them, and how noisy their readings are.

Every actuation effect that the reading shows is a law from set-point to angle, played by the same code that simulates
it: each way is tried as it is and with laws of all servos, so that no law passes for noise or for another way.

Legend: R log rows of all trials, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.inference.fits.prices import most_gained
from serpenoid.diagnose.stages.actuation.actuation_candidates import shown
from serpenoid.diagnose.stages.actuation.actuation_refit import in_turn
from serpenoid.diagnose.stages.actuation.actuation_together import fit_together
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.diagnose.stages.actuation.set_points import ways
from serpenoid.effects.base import ActuationEffect
from serpenoid.parallel import in_processes

ROUGHLY = 20  # steps of candidates that share all joints: fits go along a valley, one falls where the other rises


def plays(recordings: Sequence[Recording], held: bool | None = None) -> Plays:
    """Readings beside the set-points that they follow best, as they are or with a law for all servos, told later or
    not; held: whether rows are, where that is known.

    What servos do from some trial on no law of all trials tells: each way is tried with trials that are late by a time
    of their own, too. Noise is the least that readings have about any of it: about a smooth course, those of servos
    that jump scatter widely, and a way that is wrong is followed. Laws of several numbers are tried where those of
    fewer leave something of most joints: what one joint does by itself no law of all servos tells.
    """
    every = list(ways(recordings, held))
    noise = np.min([data.noise for data in every], axis=0)
    every = [replace(data, noise=noise) for data in every]
    few, *sets = _by_numbers(shown(every[0]))
    found = [(data, [*played, data.each_later()]) for data, played in zip(every, _by_each(every, few), strict=True)]
    for laws in sets:
        for data, played in found:
            if any(np.median(of.missed(p)) < VISIBLE**2 for of, known in found for p in known):
                break
            played += _by_each([data], laws)[0]
    if len(found) > 1:
        noise = np.min([data.measured(p).noise for data, played in found for p in played], axis=0)
        found = [(replace(data, noise=noise), played) for data, played in found]
    return _measured(*_simplest(found))


def _by_numbers(kinds: Sequence[ActuationEffect]) -> list[list[tuple[str, ...]]]:
    """Laws of all servos, by name, each also beside a dead time: that of no and one number first, then those of more.
    Rows that jump are late beside rows that run, so that it is a matter of time which of them servos follow."""
    laws = [k for k in kinds if k.place is None]
    late = [k for k in laws if k.dead_time]
    sets = [(), *((k,) for k in laws), *((k, law) for k in late for law in laws if not law.dead_time)]
    by_numbers: dict[int, list[tuple[str, ...]]] = {}
    for s in sets:
        by_numbers.setdefault(max(sum(len(k.parameters) for k in s), 1), []).append(tuple(k.name for k in s))
    return [by_numbers[n] for n in sorted(by_numbers)]


def _by_each(every: Sequence[Plays], laws: Sequence[tuple[str, ...]]) -> list[list[Floats]]:
    """What servos play with each of some sets of laws, in each way to take set-points."""
    played = in_processes([(_by_all, (data, names)) for data in every for names in laws])
    return [played[n * len(laws) : (n + 1) * len(laws)] for n in range(len(every))]


def _simplest(found: Sequence[tuple[Plays, list[Floats]]]) -> tuple[Plays, list[Floats]]:
    """The first way in which set-points may be taken, and what servos play in it with each law, that readings do not
    exclude: about noise that is hardly known no way is followed, and what is best may be so by chance."""
    misses = [min(_cost(data, data.alone(p)) for p in played) for data, played in found]
    band = most_gained(1, len(shown(found[0][0])) * len(found))
    return next(way for way, miss in zip(found, misses, strict=True) if miss - min(misses) <= band)


def _cost(data: Plays, played: Floats) -> float:
    """Twice the negative log likelihood of the readings of all joints, but for a constant: where one strays by more
    than noise, what it strays by is its noise, so that a joint that does something else decides nothing."""
    ratio = data.chi2(played) / data.often
    return float((data.often * np.where(ratio > 1, 1 + np.log(np.maximum(ratio, 1.0)), ratio)).sum())


def _measured(data: Plays, every: Sequence[Floats]) -> Plays:
    """With the noise that readings have about whatever all servos may play. Where rows jump, servos that lag are off
    for a reading here and there: that is no smooth law about which readings scatter, nor is it their noise."""
    for played in every:
        data = data.measured(played)
    return data


def _by_all(data: Plays, names: Sequence[str]) -> Floats:
    """What servos play (R, m), as they are told or with laws fitted to all of them."""
    laws = in_turn(data, (), names)
    return data.realised(fit_together(data, laws, ROUGHLY) if len(laws) > 1 else laws)
