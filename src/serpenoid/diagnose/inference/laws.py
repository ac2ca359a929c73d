"""Which law the floor follows: where that which is fitted leaves more than chance, its rivals are fitted, too.

A law has eps and perhaps numbers of its own (the speed below which dry friction creeps): effects that say so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import chain, product

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import residuals
from serpenoid.diagnose.data.windows import Track
from serpenoid.diagnose.inference.medium import TO_THE_END, Fit, fit
from serpenoid.diagnose.inference.select import Selection, unclear
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import of_laws
from serpenoid.media import Law, rivals
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.parallel import in_processes

RATIOS, POLISHED = 8, 2  # ratios that are looked at, and fits that are begun there
CREEPING = (0.001, 0.03, 0.3)  # speeds of creep that are looked at, of the body's own
SOFTENING = Medium.model_fields["softening"].default


@dataclass(frozen=True)
class Rival:
    """A law that was fitted beside another: its model, with its own numbers and without what is named; how it does, in
    words, empty where it does worse; what it misses windows by, over the noise; better: whether that is less than what
    the other law does with what is named."""

    model: Model
    words: str
    misses: float
    better: bool


def rival_laws(found: Selection) -> dict[str, Rival]:
    """The law's rivals by their names; empty where there is no question."""
    if not unclear(found.best):
        return {}
    asked = [on_rival(found.null.model, law) for law in rivals(found.null.model.law)]
    said = {model.law.name: _beside(found, model) for model in asked if model is not None}
    return {name: rival for name, rival in said.items() if rival is not None}


def _beside(found: Selection, model: Model) -> Rival | None:
    """How a rival does by its own numbers alone, and with what is named: RMS of what is left of the windows that all
    predict, by the same noise; None where it has no root."""
    title, rival, alone = model.law.title, model.law.rival, _alone(found, model)
    if rival is None or alone is None:
        return None
    fits = (found.null, found.best, alone, _named(found, model, alone))
    own, own_named, its, its_named = misses(found.motion, [(found.motion.tracks, fit) for fit in fits])
    fitted, better = rival.of.title, min(its, its_named) < own_named
    if better:
        by_own = by_its = " with what is named" if found.best.effects else ""
        if by_its and its <= its_named:
            by_its = " alone"
        by = f"{min(its, its_named):.1f} times the noise, {fitted}{by_own} by {own_named:.1f}"
        words = f"{rival.title}{by_its} misses windows by {by}"
    else:
        words = (
            f"alone, {rival.title} misses windows by {its:.1f} times the noise and {fitted} by {own:.1f}; with what is "
            f"named, {title} by {its_named:.1f} and {fitted} by {own_named:.1f}: the medium may follow neither"
        )
    return Rival(alone.model, words if better or its < own else "", min(its, its_named), better)


def left_beyond_chance(found: Selection, other: Selection) -> tuple[float, float, float]:
    """What eps alone, what is named, and what is named beside another law leave of the windows that all predict: RMS
    beyond chance, by their noise."""
    ours, theirs = found.motion.tracks, other.motion.tracks
    left = misses(found.motion, [(ours, found.null), (ours, found.best), (theirs, other.best)])
    alone, named, beside = (float(np.sqrt(max(x**2 - 1, 0.0))) for x in left)
    return alone, named, beside


def on_rival(model: Model, law: Law) -> Model | None:
    """The same body and what is known of it under a rival of its law; None where that is no question."""
    medium, rival = model.medium, law.rival
    if rival is None or rival.of is not model.law or medium.anisotropy_ratio_bounds is not None:
        return None
    if not rival.needs <= model.body.parts or len(_acting(model.effects, law.name)) < len(model.effects):
        return None
    return replace(model, medium=medium.model_copy(update={"law": law.name, "softening": SOFTENING}))


def _acting(effects: Sequence[ActiveEffect], law: str) -> list[ActiveEffect]:
    """Effects that act in a medium of this law."""
    return [e for e in effects if e.effect.acts_in(law)]


def _alone(found: Selection, model: Model) -> Fit | None:
    """Rival law with its own numbers; None where no window has a root."""
    best = by_its_own_numbers(found.motion, model, found.null.model.medium.anisotropy_ratio)
    return best if np.isfinite(_missed(best)) else None


def numbers_of(model: Model) -> list[ActiveEffect]:
    """Numbers of a model's law besides eps that it does not give, as effects."""
    known, law = {e.name for e in model.effects}, model.law.name
    kinds = [k for k in of_laws() if k.acts_in(law) and k.needs <= model.body.parts and k.name not in known]
    return [ActiveEffect.typical(kind.name) for kind in kinds]


def by_its_own_numbers(motion: Motion, model: Model, least_ratio: float) -> Fit:
    """eps and what else are numbers of the model's law, where none of these is known.

    Dry friction has the square of its ratio where drag has the ratio, and where steps have no root a fit ends. So
    ratios from drag's to one are looked at first, each beside creep from none to a third of the body's own speed.
    """
    effects = numbers_of(model)
    speed = own_speed(motion)
    values = [[(share * speed, *e.coordinates[1:-1]) for share in CREEPING] for e in effects]
    ratios = np.geomspace(least_ratio, 1.0, RATIOS)
    starts = [(eps, *chain.from_iterable(rest)) for eps in ratios for rest in product(*values)]
    begun = in_processes([(_fit, (motion, model, effects, np.array(x), 0)) for x in starts])
    near = sorted(begun, key=_missed)[:POLISHED]
    fits = in_processes([(_fit, (motion, model, effects, f.coordinates, TO_THE_END)) for f in near])
    return min(fits, key=_missed)


def own_speed(motion: Motion) -> float:
    """RMS speed [m/s] of the vertices in the frame of the body while it changes shape."""
    moved = [np.linalg.norm(np.diff(t.vertices, axis=0), axis=2) / np.diff(t.time)[:, None] for t in motion.tracks]
    return float(np.sqrt(np.mean(np.concatenate([m.ravel() for m in moved]) ** 2)))


def _named(found: Selection, model: Model, alone: Fit) -> Fit:
    """The same with what is named, as far as it acts there; begun without the effects."""
    effects = _acting(found.best.effects, model.medium.law)
    own, resting = list(alone.effects), [p.resting for e in effects for p in e.effect.parameters]
    x = np.array([*alone.coordinates, *resting])
    both = _fit(found.motion, model, [*own, *effects], x, TO_THE_END) if effects else alone
    return both if np.isfinite(_missed(both)) else alone


def _missed(fit: Fit) -> float:
    """Chi squared of a window that has a root; infinite: none has."""
    count = float(fit.evidence.count.sum())
    return fit.chi2 / count if count else np.inf


def _fit(motion: Motion, model: Model, effects: list[ActiveEffect], x: Floats, steps: int) -> Fit:
    return fit(motion, model, effects, x, steps)


def misses(motion: Motion, fits: Sequence[tuple[Sequence[Track], Fit]]) -> list[float]:
    """RMS of what each fit leaves of the windows that all predict, by their noise; each on tracks of its own."""
    left: list[list[Floats]] = [[] for _ in fits]
    every = zip(*[residuals(tracks, fit.predictions) for tracks, fit in fits], strict=True)
    for white, several in zip(motion.white, every, strict=True):
        common = np.asarray(np.isfinite(several).all(axis=(0, 2)))
        for found, x in zip(left, several, strict=True):
            found.append(white.of(x, common))
    return [float(np.sqrt(np.mean(np.concatenate(found) ** 2))) for found in left]
