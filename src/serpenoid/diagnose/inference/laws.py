"""Which law the floor follows: where linear drag leaves more than chance, the explanation is fitted on dry friction."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.noise import residuals
from serpenoid.diagnose.inference.medium import TO_THE_END, Fit, fit
from serpenoid.diagnose.inference.select import Selection, unclear
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.parallel import in_processes

ROOTLESS = 0.02  # share of windows: a few steps about rest have no root on dry friction
SOFTENING = 0.1  # at the default 0.01 a few steps of pauses have no root; chi squared differs by 6 % (arena)


def dry_friction(found: Selection) -> str:
    """How dry friction does beside linear drag, in words; empty where it is no question, or does worse.

    By eps alone, and with what is named: RMS of what is left of the windows that all predict, by the same noise.
    """
    dry = on_dry_friction(found.null.model)
    if dry is None or not unclear(found.best):
        return ""
    on_dry = _fitted(found, dry, [(), found.best.effects] if found.best.effects else [()])
    alone, both = on_dry[0], on_dry[-1] or on_dry[0]
    if alone is None or both is None:
        return ""
    fits = (found.null, found.best, alone, both)
    left = [np.concatenate([x.ravel() for x in _white(found.motion, f)]) for f in fits]
    common = np.isfinite(left).all(axis=0)
    drag, drag_named, dry_alone, dry_named = (float(np.sqrt(np.mean(x[common] ** 2))) for x in left)
    if min(dry_alone, dry_named) < drag_named:
        named = "with what is named " if found.best.effects else ""
        by = f"{min(dry_alone, dry_named):.1f} times chance, linear drag by {drag_named:.1f}"
        return f"{named}dry friction (Coulomb) misses windows by {by}"
    if dry_alone >= drag:
        return ""
    return (
        f"alone, dry friction (Coulomb) misses windows by {dry_alone:.1f} times chance and linear drag by {drag:.1f}; "
        f"with what is named, linear drag by {drag_named:.1f} and dry friction by {dry_named:.1f}"
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


def _fitted(found: Selection, dry: Model, explanations: Sequence[Sequence[ActiveEffect]]) -> list[Fit | None]:
    """Of each explanation the best fit on dry friction, of those in which nearly all steps have roots.

    Begun without the effects, at the ratio of drag and at its root: dry friction's law has the square of its ratio.
    """
    eps = dry.medium.anisotropy_ratio
    begun = [(_acting(effects), x) for effects in explanations for x in (eps, np.sqrt(eps))]
    fits = in_processes([(_fit, (found.motion, dry, effects, x)) for effects, x in begun])
    size = (1 - ROOTLESS) * found.best.evidence.count.sum()
    pairs = zip(fits[::2], fits[1::2], strict=True)
    return [
        min((f for f in pair if f.evidence.count.sum() >= size), key=lambda f: f.chi2, default=None) for pair in pairs
    ]


def _fit(motion: Motion, dry: Model, effects: list[ActiveEffect], eps: float) -> Fit:
    resting = [p.resting for e in effects for p in e.effect.parameters]
    return fit(motion, dry, effects, np.array([eps, *resting]), TO_THE_END)


def _white(motion: Motion, found: Fit) -> list[Floats]:
    """What a fit leaves of each track's windows (B - 1, 3), by their noise."""
    left = residuals(motion.tracks, found.predictions)
    return [x / motion.noise.of(t) for x, t in zip(left, motion.tracks, strict=True)]
