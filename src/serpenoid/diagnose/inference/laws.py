"""Which law the floor follows: where that which is fitted leaves more than chance, its rivals are fitted, too."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import residuals
from serpenoid.diagnose.data.windows import Track
from serpenoid.diagnose.inference.medium import TO_THE_END, Fit, fit
from serpenoid.diagnose.inference.select import Selection, unclear
from serpenoid.effects.active import ActiveEffect
from serpenoid.media import Law, rivals
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.parallel import in_processes

RATIOS, POLISHED = 8, 2  # ratios that are looked at, and fits that are begun there
SOFTENING = Medium.model_fields["softening"].default


def rival_laws(found: Selection) -> dict[str, str]:
    """How the law's rivals do beside it, in words, by their names; without those that do worse; empty where there is no
    question."""
    if not unclear(found.best):
        return {}
    asked = [on_rival(found.null.model, law) for law in rivals(found.null.model.law)]
    said = {model.law.name: _beside(found, model) for model in asked if model is not None}
    return {name: words for name, words in said.items() if words}


def _beside(found: Selection, model: Model) -> str:
    """How a rival does by eps alone, and with what is named: RMS of what is left of the windows that all predict, by
    the same noise; empty where it does worse."""
    title, rival, alone = model.law.title, model.law.rival, _alone(found, model)
    if rival is None or alone is None:
        return ""
    fits = (found.null, found.best, alone, _named(found, model, alone))
    own, own_named, its, its_named = misses(found.motion, [(found.motion.tracks, fit) for fit in fits])
    fitted = rival.of.title
    if min(its, its_named) < own_named:
        by_own = by_its = " with what is named" if found.best.effects else ""
        if by_its and its <= its_named:
            by_its = " alone"
        by = f"{min(its, its_named):.1f} times the noise, {fitted}{by_own} by {own_named:.1f}"
        return f"{rival.title}{by_its} misses windows by {by}"
    if its >= own:
        return ""
    return (
        f"alone, {rival.title} misses windows by {its:.1f} times the noise and {fitted} by {own:.1f}; with what is "
        f"named, {title} by {its_named:.1f} and {fitted} by {own_named:.1f}: the medium may follow neither"
    )


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
    """eps alone under a rival law; None where no window has a root.

    Dry friction has the square of its ratio where drag has the ratio, and where steps have no root a fit ends. So the
    ratios from drag's to one are looked at first.
    """
    tried = np.geomspace(found.null.model.medium.anisotropy_ratio, 1.0, RATIOS)
    begun = in_processes([(_fit, (found.motion, model, [], eps, 0)) for eps in tried])
    near = sorted(begun, key=_missed)[:POLISHED]
    ratios = [f.model.medium.anisotropy_ratio for f in near]
    fits = in_processes([(_fit, (found.motion, model, [], eps, TO_THE_END)) for eps in ratios])
    best = min(fits, key=_missed)
    return best if np.isfinite(_missed(best)) else None


def _named(found: Selection, model: Model, alone: Fit) -> Fit:
    """The same with what is named, as far as it acts there; begun without the effects."""
    effects = _acting(found.best.effects, model.medium.law)
    both = _fit(found.motion, model, effects, alone.model.medium.anisotropy_ratio, TO_THE_END) if effects else alone
    return both if np.isfinite(_missed(both)) else alone


def _missed(fit: Fit) -> float:
    """Chi squared of a window that has a root; infinite: none has."""
    count = float(fit.evidence.count.sum())
    return fit.chi2 / count if count else np.inf


def _fit(motion: Motion, model: Model, effects: list[ActiveEffect], eps: float, steps: int) -> Fit:
    resting = [p.resting for e in effects for p in e.effect.parameters]
    return fit(motion, model, effects, np.array([eps, *resting]), steps)


def misses(motion: Motion, fits: Sequence[tuple[Sequence[Track], Fit]]) -> list[float]:
    """RMS of what each fit leaves of the windows that all predict, by their noise; each on tracks of its own."""
    left: list[list[Floats]] = [[] for _ in fits]
    every = zip(*[residuals(tracks, fit.predictions) for tracks, fit in fits], strict=True)
    for white, several in zip(motion.white, every, strict=True):
        common = np.asarray(np.isfinite(several).all(axis=(0, 2)))
        for found, x in zip(left, several, strict=True):
            found.append(white.of(x, common))
    return [float(np.sqrt(np.mean(np.concatenate(found) ** 2))) for found in left]
