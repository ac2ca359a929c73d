"""Which law the floor follows: where that which is fitted leaves more than chance, its rivals are fitted, too.

A law has eps and perhaps numbers of its own (the speed below which dry friction creeps): effects that say so.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from itertools import chain, product
from typing import NamedTuple

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.windows.windows import Track
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.bounds import LEAST_EPS, MOST_EPS, ratio_at_bound
from serpenoid.diagnose.inference.fits.medium import TO_THE_END, Fit, candidates_of, fit, fit_on
from serpenoid.diagnose.inference.fits.prices import gained_by_chance
from serpenoid.diagnose.inference.search.select import Selection
from serpenoid.diagnose.inference.search.tries import unclear
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import MediumEffect
from serpenoid.effects.catalogue import of_laws
from serpenoid.media import Law, rivals
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.parallel import in_processes

RATIOS, POLISHED = 8, 2  # ratios that are looked at, and fits that are begun there
CREEPING = (0.001, 0.03, 0.3)  # speeds of creep that are looked at, of the body's own
SEARCHED = 2 / 3  # of what the law leaves, alone or with what is named: what leaves more is not searched beside
NEITHER = "the medium may follow neither"
SOFTENING = Medium.model_fields["softening"].default


@dataclass(frozen=True)
class Rival:
    """A law that was fitted beside another: its model, with its own numbers and without what is named; how it does, in
    words, empty where it does worse; what it misses windows by, over the noise, and by itself; better: whether that is
    less than what the other law does with what is named; promising: whether it is worth a search beside it; nearly:
    whether by itself it leaves less than LAW_ERROR of what the other law does by itself."""

    model: Model
    words: str
    misses: float
    alone: float
    better: bool
    promising: bool
    nearly: bool


def rival_laws(found: Selection, without: Collection[str] = ()) -> dict[str, Rival]:
    """The law's rivals by their names, from the one that misses least; empty where there is no question: where little
    is left, and nothing is named that makes another law of it. without: names of effects that are no numbers of one."""
    if not unclear(found.best) and all(makes_no_law(e) for e in found.best.effects):
        return {}
    asked = [on_rival(found.null.model, law) for law in rivals(found.null.model.law)]
    tried = [_beside(found, model, without) for model in asked if model is not None]
    rivals_found = sorted((r for r in tried if r is not None), key=lambda r: r.misses)
    return {rival.model.law.name: rival for rival in _with_the_nearest(found, rivals_found)}


def _with_the_nearest(found: Selection, several: Sequence[Rival]) -> list[Rival]:
    """Rivals; where the law needs what mends one, that which by itself is nearest is promising, too: it may need fewer
    names. One search is all that this costs."""
    nearest = min((r for r in several if r.nearly), key=lambda r: r.alone, default=None)
    if nearest is None or nearest.promising or not mended(found):
        return list(several)
    return [replace(r, promising=r is nearest or r.promising) for r in several]


def mended(found: Selection) -> bool:
    """Whether a law needs one effect at several places, or eps at its bound, to explain what is there."""
    places = Counter(e.name for e in found.best.effects if e.place is not None)
    return max(places.values(), default=0) > 1 or any(ratio_at_bound(f.model) for f in (found.null, found.best))


def _beside(found: Selection, model: Model, without: Collection[str]) -> Rival | None:
    """How a rival does by its own numbers alone, and with what is named: RMS of what is left of the windows that all
    predict, by the same noise; None where it has no root."""
    title, rival, alone = model.law.title, model.law.rival, _alone(found, model, without)
    if rival is None or alone is None:
        return None
    fits = (found.null, found.best, alone, _named(found, model, alone))
    own, own_named, its, its_named = misses(found.motion, [(found.motion.tracks, fit) for fit in fits])
    fitted, better = rival.of.title, min(its, its_named) < own_named
    less = [beyond_chance(a) <= SEARCHED * beyond_chance(b) for a, b in ((its, own), (its_named, own_named))]
    if better:
        by_own = by_its = " with what is named" if found.best.effects else ""
        if by_its and its <= its_named:
            by_its = " alone"
        by = f"{min(its, its_named):.1f} times the noise, {fitted}{by_own} by {own_named:.1f}"
        words = f"{rival.title}{by_its} misses windows by {by}" + ("" if any(less) else f": {NEITHER}")
    else:
        words = (
            f"alone, {rival.title} misses windows by {its:.1f} times the noise and {fitted} by {own:.1f}; with what is "
            f"named, {title} by {its_named:.1f} and {fitted} by {own_named:.1f}: {NEITHER}"
        )
    said = words if better or its < own else ""
    nearly = beyond_chance(its) < LAW_ERROR * beyond_chance(own)
    return Rival(alone.model, said, min(its, its_named), its, better, better and any(less), nearly)


def beyond_chance(left: float) -> float:
    """What of an RMS over the noise is not noise."""
    return float(np.sqrt(max(left**2 - 1, 0.0)))


def makes_no_law(effect: ActiveEffect) -> bool:
    """Whether an effect leaves the floor's law as it is."""
    return not isinstance(effect.effect, MediumEffect) or effect.effect.of_degree is None


class Misfits(NamedTuple):
    """RMS over the noise of the windows that all predict: what the law alone, what is named beside it, and what is
    named beside another law miss them by."""

    alone: float
    named: float
    beside: float


def misfits(found: Selection, other: Selection) -> Misfits:
    """Of a selection, and of one beside another law."""
    ours, theirs = found.motion.tracks, other.motion.tracks
    return Misfits(*misses(found.motion, [(ours, found.null), (ours, found.best), (theirs, other.best)]))


def takes_its_place(found: Selection, other: Selection, left: Misfits, most: float) -> bool:
    """Whether what is named beside another law is likelier than what is named beside the law (Schwarz, as in
    prices.py), and leaves less than a share of what the law alone does beyond chance."""
    count = float(found.best.evidence.count.sum())
    dearer = max(1.0, min(left.named, left.beside) ** 2) * (_price(other, count) - _price(found, count))
    likelier = count * (left.named**2 - left.beside**2) > dearer
    return likelier and beyond_chance(left.beside) < most * beyond_chance(left.alone)


def _price(selection: Selection, count: float) -> float:
    """Of all numbers of an explanation, those of its law included."""
    own = [e for e in selection.motion.held if e.effect in of_laws()]
    effects = selection.best.effects
    return _of_numbers([*own, *effects], count) + len(effects) * gained_by_chance(len(candidates_of(selection.null)))


def on_rival(model: Model, law: Law) -> Model | None:
    """The same body and what is known of it under a rival of its law; None where that is no question."""
    medium, rival = model.medium, law.rival
    if rival is None or rival.of is not model.law or medium.limited_by_physics:
        return None
    if not rival.needs <= model.body.parts or len(_acting(model.effects, law.name)) < len(model.effects):
        return None
    return replace(model, medium=medium.model_copy(update={"law": law.name, "softening": SOFTENING}))


def _acting(effects: Sequence[ActiveEffect], law: str) -> list[ActiveEffect]:
    """Effects that act in a medium of this law."""
    return [e for e in effects if e.effect.acts_in(law)]


def _of_numbers(effects: Sequence[ActiveEffect], count: float) -> float:
    """Price of the effects' numbers, each ln n."""
    return sum(len(e.effect.parameters) for e in effects) * float(np.log(max(count, 2.0)))


def _alone(found: Selection, model: Model, without: Collection[str]) -> Fit | None:
    """Rival law with its own numbers; None where no window has a root."""
    best = by_its_own_numbers(found.motion, model, found.null.model.medium.anisotropy_ratio, without)
    return best if np.isfinite(missed(best)) else None


def numbers_of(model: Model, left_out: Collection[str] = ()) -> list[ActiveEffect]:
    """Numbers of a model's law besides eps that it does not give, as effects; left_out: of which names none."""
    known, law = {*left_out, *(e.name for e in model.effects)}, model.law.name
    kinds = [k for k in of_laws() if k.acts_in(law) and k.needs <= model.body.parts and k.name not in known]
    return [ActiveEffect.typical(kind.name) for kind in kinds]


def by_its_own_numbers(motion: Motion, model: Model, least_ratio: float, without: Collection[str] = ()) -> Fit:
    """eps and what else are numbers of the model's law, where none of these is known.

    Dry friction has the square of its ratio where drag has the ratio, and where steps have no root a fit ends. So
    ratios from drag's to one are looked at first, each beside creep from none to a third of the body's own speed.
    """
    effects = numbers_of(model, without)
    speed = own_speed(motion)
    values = [[(share * speed, *e.coordinates[1:-1]) for share in CREEPING] for e in effects]
    ratios = np.geomspace(least_ratio, model.medium.limits(LEAST_EPS, MOST_EPS)[1] if least_ratio < 1 else 1.0, RATIOS)
    starts = [(eps, *chain.from_iterable(rest)) for eps in ratios for rest in product(*values)]
    begun = in_processes([(fit, (motion, model, effects, np.array(x), 0)) for x in starts])
    near = sorted(begun, key=missed)[:POLISHED]
    fits = in_processes([(fit_on, (motion, f, TO_THE_END)) for f in near])
    return min(fits, key=missed)


def settled_numbers(found: Selection) -> Model | None:
    """A selection's model without what is named, whose law has the numbers that it has beside that; None where that
    gains no more than its numbers' price."""
    motion, best = found.motion, found.best
    own = [e for e in motion.held if e.effect in of_laws()]
    others = tuple(e for e in motion.held if e.effect not in of_laws())
    x = np.array([best.coordinates[0], *(c for e in own for c in e.coordinates[:-1]), *best.coordinates[1:]])
    again = fit(replace(motion, held=others), best.model, [*own, *best.effects], x, TO_THE_END) if own else best
    count = float(best.evidence.count.sum())
    if best.chi2 - again.chi2 <= _of_numbers(own, count) * max(1.0, again.chi2 / count):
        return None
    return replace(again.model, effects=(*others, *again.effects[: len(own)]))


def own_speed(motion: Motion) -> float:
    """RMS speed [m/s] of the vertices in the frame of the body while it changes shape."""
    moved = [np.linalg.norm(np.diff(t.vertices, axis=0), axis=2) / np.diff(t.time)[:, None] for t in motion.tracks]
    return float(np.sqrt(np.mean(np.concatenate([m.ravel() for m in moved]) ** 2)))


def _named(found: Selection, model: Model, alone: Fit) -> Fit:
    """The same with what is named, as far as it acts there; begun without the effects, and with moderate ones: where
    the law alone is far off, first order about none of them leads nowhere."""
    effects = _acting(found.best.effects, model.medium.law)
    if not effects:
        return alone
    resting = [p.resting for e in effects for p in e.effect.parameters]
    typical = [x for e in effects for x in ActiveEffect.typical(e.name, e.place).coordinates[:-1]]
    starts = [np.array([*alone.coordinates, *begun]) for begun in (resting, typical)]
    tasks = [(fit, (found.motion, model, [*alone.effects, *effects], x, TO_THE_END)) for x in starts]
    both = min(in_processes(tasks), key=missed)
    return both if np.isfinite(missed(both)) else alone


def missed(fit: Fit) -> float:
    """Chi squared of a window that has a root; infinite: none has."""
    count = float(fit.evidence.count.sum())
    return fit.chi2 / count if count else np.inf


def misses(motion: Motion, fits: Sequence[tuple[Sequence[Track], Fit]]) -> list[float]:
    """RMS of what each fit leaves of the windows that all predict, by their noise; each on tracks of its own."""
    left: list[list[Floats]] = [[] for _ in fits]
    every = zip(*[residuals(tracks, fit.predictions) for tracks, fit in fits], strict=True)
    for white, several in zip(motion.white, every, strict=True):
        common = np.asarray(np.isfinite(several).all(axis=(0, 2)))
        for found, x in zip(left, several, strict=True):
            found.append(white.of(x, common))
    return [float(np.sqrt(np.mean(np.concatenate(found) ** 2))) for found in left]
