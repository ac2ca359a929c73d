"""Which names may stand in for another cause: the law is known to be wrong, or they do no more than what is left."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from serpenoid.diagnose.data.chance import NORMAL, largest_factor
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import noise_uncertain, over_markers, residuals
from serpenoid.diagnose.data.noise.paths import path_error
from serpenoid.diagnose.data.noise.shared import discrepancy
from serpenoid.diagnose.data.noise.untold import untold
from serpenoid.diagnose.inference.doubt.explanations import acts
from serpenoid.diagnose.inference.doubt.law_doubt import Coordinate, Doubted, yielding
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.doubt.other_law import of_another_law
from serpenoid.diagnose.inference.fits.finding import Named, Stage
from serpenoid.diagnose.inference.fits.medium import Fit
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.stages.motion.values_of_motion import ratio_interval


def beside_what_is_left(motion: Motion, named: Sequence[Named]) -> list[Named]:
    """Names where nothing was played twice: what is left beyond the markers' noise may be an error of the law, and what
    does less than 1 / LAW_ERROR times as much may be a part of that."""
    beyond = beyond_markers(motion)
    return [
        replace(n, stand_in=n.stand_in or (n.effect.effect.moves and beyond > LAW_ERROR * n.strength)) for n in named
    ]


def beyond_markers(motion: Motion) -> float:
    """What of the noise is none of the markers', in noise levels; 0 where chance may make as much."""
    ratio = over_markers(motion) or 1.0
    return float(np.sqrt(1 - ratio**-2)) if ratio > largest_factor(noise_uncertain(motion)) else 0.0


def beside_paths(named: Sequence[Named], left: float) -> list[Named]:
    """Names beside the path error that is left over its noise level: what does less than that is beyond the noise may
    be a part of it, though in few windows noise may make as much."""
    beyond = float(np.sqrt(max(left**2 - 1, 0.0)))
    return [replace(n, stand_in=n.stand_in or (n.effect.effect.moves and beyond > n.strength)) for n in named]


def amid_points(motion: Motion, named: Sequence[Named]) -> list[Named]:
    """Names of a body that is known at points: what effects do is computed on straight links between them, and a name
    that does no more than the others are off by for that may mend it."""
    coarse = NORMAL * float(np.sqrt(np.mean([t.coarse**2 for t in motion.tracks])))
    squares = [n.strength**2 if n.effect.effect.moves else 0.0 for n in named]
    off = [coarse * float(np.sqrt(sum(squares[:i] + squares[i + 1 :]))) for i in range(len(named))]
    return [
        replace(n, stand_in=n.stand_in or (n.effect.effect.moves and 0 < x >= n.strength))
        for n, x in zip(named, off, strict=True)
    ]


def another_law(found: Selection, stage: Stage) -> Stage:
    """The stage; where names that are no stand-ins yet look like another law, all are marked, and it says why. With a
    reference eps is given, and names are changes."""
    if found.motion.ratio is not None or not any(n.effect.effect.moves and not n.stand_in for n in stage.named):
        return stage
    model = found.settled.model
    why = of_another_law(model.medium, model.body.vertices, stage.named, ratio_interval(found, stage))
    if not why:
        return stage
    named = tuple(replace(n, stand_in=n.stand_in or n.effect.effect.moves) for n in stage.named)
    return replace(stage, named=named, words=(*stage.words, why))


def left_of(before: float, after: float, noise: float) -> float:
    """How much of a path error remains, beyond noise."""
    was, remains = (float(np.sqrt(max(x**2 - noise**2, 0.0))) for x in (before, after))
    return remains / was if was > 0 else float(after >= before)


def mending(found: Selection, named: Sequence[Named], before: float, after: float) -> list[Named]:
    """Names, marked where they mend windows of a law that is wrong, and not the path: beside a reference, where of what
    all of them do there, or one of them does, LAW_ERROR remains or more; before, after: path errors [m]."""
    most = 1.0 if found.motion.ratio is None else LAW_ERROR
    bases = zip(found.best.effects, found.bases, strict=True)
    without = {e.key: path_error(found.motion, base.predictions) for e, base in bases}
    remains = [
        max(left_of(error, after, found.noise_level_m) for error in (before, without.get(n.effect.key, before)))
        for n in named
    ]
    return [
        replace(n, stand_in=n.stand_in or (n.effect.effect.moves and share >= most))
        for n, share in zip(named, remains, strict=True)
    ]


def of_a_law(named: Named, share: float, doubt: Mapping[Coordinate, Doubted]) -> Named:
    """A change beside a reference, where what repeats shares is left of what all changes do: it is another law's from
    LAW_ERROR on, as on the stages above; what acts by the floor's law may do more or less there for as much."""
    if share > LAW_ERROR and named.effect.effect.moves:
        named = replace(named, stand_in=True)
    return yielding(named, share, doubt) if acts(named.effect) else named


def explained(
    found: Selection, inadequate: bool, beside: Sequence[tuple[Motion, Fit, float]] = ()
) -> Sequence[tuple[Motion, Fit, float]]:
    """Where the law of what is named is known to be wrong, what is settled on beside every explanation of that."""
    motion, settled = found.motion, found.settled
    if not found.best.effects or not (inadequate or discrepancy(motion, settled.predictions) > 0):
        return ()
    alone = [(motion, found.best, 1.0)] if found.undetected else []  # what is below detection may mend the law, too
    return ((motion, settled, 1.0), *alone, *beside)


def with_stand_ins(found: Selection, named: Sequence[Named], inadequate: bool) -> list[Named]:
    """Names, and whether each may be there for a cause that the catalogue does not hold, if what the model misses
    repeats, or what its reference missed did.

    Of the floor, or of the cameras' frame, that may be all of it; with a reference, too, if that missed nothing. What
    a reference missed is no news, and what takes away most is the change; what stands beside it may mend the law about
    it, whose error is in proportion to what the change does. What trials that were not laid alike differ by is news.
    """
    motion = found.motion
    no_news = motion.ratio is not None and inadequate
    if not no_news or untold(motion, residuals(motion.tracks, found.settled.predictions)) is not None:
        return [replace(n, stand_in=n.effect.effect.moves) for n in named]
    gains = {e.key: base.chi2 - found.best.chi2 for e, base in zip(found.best.effects, found.bases, strict=True)}
    most = max(gains.values(), default=0.0)
    return [replace(n, stand_in=gains.get(n.effect.key, most) < most) for n in named]
