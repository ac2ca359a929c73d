"""Which law the floor follows: where linear drag leaves more than chance, the explanation is fitted on dry friction."""

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
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.parallel import in_processes

RATIOS, POLISHED = 8, 2  # ratios that are looked at, and fits that are begun there
SOFTENING = Medium.model_fields["softening"].default


def dry_friction(found: Selection) -> str:
    """How dry friction does beside linear drag, in words; empty where it is no question, or does worse.

    By eps alone, and with what is named: RMS of what is left of the windows that all predict, by the same noise.
    """
    dry = on_dry_friction(found.null.model)
    if dry is None or not unclear(found.best):
        return ""
    alone = _alone(found, dry)
    if alone is None:
        return ""
    fits = (found.null, found.best, alone, _named(found, dry, alone))
    drag, drag_named, dry_alone, dry_named = misses(found.motion, [(found.motion.tracks, fit) for fit in fits])
    if min(dry_alone, dry_named) < drag_named:
        by_drag = by_dry = " with what is named" if found.best.effects else ""
        if by_dry and dry_alone <= dry_named:
            by_dry = " alone"
        by = f"{min(dry_alone, dry_named):.1f} times chance, linear drag{by_drag} by {drag_named:.1f}"
        return f"dry friction (Coulomb){by_dry} misses windows by {by}"
    if dry_alone >= drag:
        return ""
    return (
        f"alone, dry friction (Coulomb) misses windows by {dry_alone:.1f} times chance and linear drag by {drag:.1f}; "
        f"with what is named, dry friction by {dry_named:.1f} and linear drag by {drag_named:.1f}: the floor may "
        "follow neither"
    )


def on_dry_friction(model: Model) -> Model | None:
    """The same body and what is known of it on dry friction; None where that is no question."""
    medium = model.medium
    if medium.law != "viscous" or "ground" not in model.body.parts or medium.anisotropy_ratio_bounds is not None:
        return None
    if len(_acting(model.effects)) < len(model.effects):
        return None
    return replace(model, medium=medium.model_copy(update={"law": "coulomb", "softening": SOFTENING}))


def _acting(effects: Sequence[ActiveEffect]) -> list[ActiveEffect]:
    """Effects that act on dry friction."""
    return [e for e in effects if e.effect.acts_in("coulomb")]


def _alone(found: Selection, dry: Model) -> Fit | None:
    """eps alone on dry friction; None where no window has a root.

    Dry friction has the square of its ratio where drag has the ratio, and where steps have no root a fit ends. So the
    ratios from drag's to one are looked at first.
    """
    tried = np.geomspace(found.null.model.medium.anisotropy_ratio, 1.0, RATIOS)
    begun = in_processes([(_fit, (found.motion, dry, [], eps, 0)) for eps in tried])
    near = sorted(begun, key=_missed)[:POLISHED]
    ratios = [f.model.medium.anisotropy_ratio for f in near]
    fits = in_processes([(_fit, (found.motion, dry, [], eps, TO_THE_END)) for eps in ratios])
    best = min(fits, key=_missed)
    return best if np.isfinite(_missed(best)) else None


def _named(found: Selection, dry: Model, alone: Fit) -> Fit:
    """The same with what is named, as far as it acts there; begun without the effects."""
    effects = _acting(found.best.effects)
    both = _fit(found.motion, dry, effects, alone.model.medium.anisotropy_ratio, TO_THE_END) if effects else alone
    return both if np.isfinite(_missed(both)) else alone


def _missed(fit: Fit) -> float:
    """Chi squared of a window that has a root; infinite: none has."""
    count = float(fit.evidence.count.sum())
    return fit.chi2 / count if count else np.inf


def _fit(motion: Motion, dry: Model, effects: list[ActiveEffect], eps: float, steps: int) -> Fit:
    resting = [p.resting for e in effects for p in e.effect.parameters]
    return fit(motion, dry, effects, np.array([eps, *resting]), steps)


def misses(motion: Motion, fits: Sequence[tuple[Sequence[Track], Fit]]) -> list[float]:
    """RMS of what each fit leaves of the windows that all predict, by their noise; each on tracks of its own."""
    left: list[list[Floats]] = [[] for _ in fits]
    every = zip(*[residuals(tracks, fit.predictions) for tracks, fit in fits], strict=True)
    for white, several in zip(motion.white, every, strict=True):
        common = np.asarray(np.isfinite(several).all(axis=(0, 2)))
        for found, x in zip(left, several, strict=True):
            found.append(white.of(x, common))
    return [float(np.sqrt(np.mean(np.concatenate(found) ** 2))) for found in left]
