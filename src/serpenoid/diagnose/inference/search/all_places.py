"""All places of one effect at once: of several worn wheels the first that is found may lie between two of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.inference.fits.evidence import SILENT
from serpenoid.diagnose.inference.fits.medium import (
    TO_THE_END,
    Fit,
    candidates_of,
    coordinates_of,
    fit,
    fit_guided,
    fit_without,
    moved,
)
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.inference.fits.rules import choose
from serpenoid.diagnose.inference.search.discrepancy import information_criterion
from serpenoid.diagnose.inference.search.tries import pruned, unclear
from serpenoid.effects.active import ActiveEffect
from serpenoid.parallel import in_processes


def all_at_once(motion: Motion, best: Fit, tries: int) -> Fit:
    """Where much is left, with all places of one effect, less those that earn nothing, if that is likelier, errors of
    the law included, and foretells gaits better: of several wheels that are worn together the first that is found may
    be a place between two. So many numbers fit any law on one gait alone, and mend any law's error; so do more places
    than a body of so many joints has vertices, if none lie between its joints."""
    if not unclear(best) or len(best.evidence.constant) < 2:
        return best
    everywhere = [c for c in (*best.effects, *candidates_of(best)) if c.name not in motion.untestable]
    waiting = sorted({c.name for c in everywhere if c.place is not None and len(c.effect.parameters) == 1})
    while waiting:
        found = in_processes([(_of_all_places, (motion, best, everywhere, name, tries)) for name in waiting])
        likelier = [i for i, f in enumerate(found) if f is not None and _foretells(motion, best, f, tries)]
        if not likelier:
            break
        best, waiting = pruned(motion, found[likelier[0]], tries), waiting[likelier[0] + 1 :]  # fitted anew beside it
    return best


def _of_all_places(motion: Motion, best: Fit, everywhere: Sequence[ActiveEffect], name: str, tries: int) -> Fit | None:
    """A fit with all places of one effect, less those that earn nothing; None where more than a body may have do."""
    others, most = [e for e in best.effects if e.name != name], best.model.body.joint_count + 2  # without middles
    effects = [*others, *(c for c in everywhere if c.name == name)]
    found = fit(motion, best.model, effects, coordinates_of(best.model, effects), TO_THE_END, best.predictions)
    if len(effects) - len(others) > most and _telling(motion, found, name, tries) > most:
        return None
    return told(motion, found, tries)


def _foretells(motion: Motion, best: Fit, other: Fit, tries: int) -> bool:
    """Whether another fit is likelier, errors of the law included, and foretells gaits better."""
    better = choose(best, [other], tries) is not None and _foretold(other) < _foretold(best)
    return better and information_criterion(motion, other) < information_criterion(motion, best)


def _telling(motion: Motion, found: Fit, name: str, tries: int) -> int:
    """How many effects of a name gain more than their price beside those that are left, without the least first: all to
    first order, in which what a bound holds gains nothing."""
    silent = np.diagonal(found.evidence.matrix.sum(axis=0)) < SILENT
    left = [i for i, own in enumerate(found.columns) if found.effects[i].name != name or not silent[own[0]]]
    own = [i for i in left if found.effects[i].name == name]
    while own:
        gains = dict(zip(left, _gained(motion, found, left), strict=True))
        least = min(own, key=gains.__getitem__)
        if gains[least] - found.evidence.toll(1) > gained_by_chance(tries):
            break
        left.remove(least)
        own.remove(least)
    return len(own)


def _foretold(found: Fit) -> float:
    """Chi squared of each gait by what the others tell, to first order."""
    return found.evidence.held_out(range(len(found.coordinates)))


def told(motion: Motion, found: Fit, tries: int) -> Fit:
    """Without effects that gain no more than their price (prices.py) beside those that are left, the least first: which
    it is, to first order; the others are fitted again."""
    while found.effects:
        gains = _gained(motion, found, range(len(found.effects)))
        excess = [g - found.evidence.toll(len(e.effect.parameters)) for g, e in zip(gains, found.effects, strict=True)]
        least = int(np.argmin(excess))
        if excess[least] > gained_by_chance(tries):
            break
        found = fit_without(motion, found, found.effects[least])
    return fit_guided(motion, found, TO_THE_END)


def _gained(motion: Motion, found: Fit, some: Sequence[int]) -> list[float]:
    """Chi squared that each of some effects takes away beside the others of them, to first order, in units of what is
    left; of one that its bound holds first order says nothing, and it stays."""
    resting = [x for e in found.effects for x in motion.unchanged(e)]
    bare = found.evidence.about(
        found.coordinates - [found.coordinates[0], *resting]
    )  # chi squared of some, others none
    silent = np.diagonal(bare.matrix.sum(axis=0)) < SILENT
    columns = [found.columns[i] for i in some]
    every = [0, *(c for own in columns for c in own)]
    now = bare.chi2(every)
    spread, gains = max(1.0, now / float(bare.count.sum())), []
    for own in columns:
        held = bool(silent[list(own)].all() and any(moved(motion, found, c) for c in own))
        gains.append(np.inf if held else (bare.chi2([c for c in every if c not in own]) - now) / spread)
    return gains
