"""Patches of the floor: where they may lie (a grid over what was visited), and what they would do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.geometry import turn
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.windows import by_track, windowed
from serpenoid.diagnose.inference.bounds import held_at_bounds
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.diagnose.inference.medium import Fit, drift_columns
from serpenoid.effects.active import ActiveEffect

RADII, MARGIN = (0.14, 0.24, 0.38), 0.27  # body lengths

Ranked = tuple[ActiveEffect, float, np.ndarray]  # candidate, gain, where its full fit begins


def patch_grid(motion: Motion) -> list[ActiveEffect]:
    """Friction patches, neutral, over the floor that was visited."""
    length = motion.tracks[0].recording.body.total_length_m
    place = np.concatenate([t.poses[:, :2] for t in motion.tracks])
    low, high = place.min(axis=0) - MARGIN * length, place.max(axis=0) + MARGIN * length
    found = []
    for radius in (length * r for r in RADII):
        counts = np.maximum(np.ceil((high - low) / radius).astype(int), 2)
        for x in np.linspace(low[0], high[0], counts[0]):
            for y in np.linspace(low[1], high[1], counts[1]):
                found.append(ActiveEffect.neutral("friction_patch", None, x=float(x), y=float(y), radius=radius))
    return found


def score_patches(motion: Motion, base: Fit, own: list[int]) -> list[Ranked]:
    """Each patch of the grid: gain to first order, and where its full fit begins."""
    grid = patch_grid(motion)
    evidence = with_patches(motion, base, grid)
    before, result = evidence.chi2(own), []
    for i, patch in enumerate(grid):
        index = [*own, len(own) + i]
        values, _ = evidence.solve(index)
        weak = float(np.clip(values[-1], -0.9, 3.0))
        x = np.concatenate([base.coordinates + values[:-1], [weak, *patch.coordinates[1:-1]]])
        result.append((patch, before - evidence.chi2(index) - evidence.toll(len(patch.effect.parameters)), x))
    return result


def with_patches(motion: Motion, base: Fit, grid: Sequence[ActiveEffect]) -> Evidence:
    """Evidence about a fit: its own columns, then the strength of each patch."""
    rows, columns, labels = [], [], []
    found = zip(motion.tracks, motion.labels, base.predictions, patch_columns(motion, base, grid), strict=True)
    for track, label, p, joined in found:
        noise, use = motion.noise.of(track), track.usable
        rows.append(((track.displacement - p.displacement) / noise)[use].ravel())
        columns.append((joined / noise[..., None])[use].reshape(-1, joined.shape[2]))
        labels.append(np.full(len(rows[-1]), label))
    return held_at_bounds(
        base.model, base.effects, Evidence.of(np.concatenate(rows), np.concatenate(columns), np.concatenate(labels))
    )


def patch_columns(motion: Motion, base: Fit, patches: Sequence[ActiveEffect]) -> Iterator[Floats]:
    """Of each track, derivatives (B - 1, 3, P + K) by the fit's own coordinates and by the strengths of K weak patches.

    A patch changes each vertex's weight in the drag by strength w_k exp(-|p_k - (x, y)|^2 / (2 radius^2)), so the
    derivatives by the loads of the vertices give its own.
    """
    length, weights = base.model.body.total_length_m, base.model.body.vertex_weights
    scale = np.array([[length], [length], [1.0]])
    loads = [ActiveEffect.neutral("load", k) for k in range(len(weights))]
    values = np.array([[e.parameters[p] for p in ("x", "y", "radius")] for e in patches])
    fitted = {e.key for e in base.effects}
    for track, own, _ in by_track(base.model, motion.tracks, loads, base.predictions):
        column = {(c.effect, c.place): i for i, c in enumerate(own.columns)}
        mine = [i for i, c in enumerate(own.columns) if c.effect is None or (c.effect, c.place) in fitted]
        world = track.poses[:, None, :2] + turn(track.poses[:, 2:], track.vertices)
        middle = (world[1:] + world[:-1]) / 2
        away = ((middle[:, :, None] - values[:, :2]) ** 2).sum(axis=-1)
        felt = weights[:, None] * np.exp(-away / (2 * values[:, 2] ** 2))
        by_load = own.jacobian[..., [column[e.key] for e in loads]]
        by = np.concatenate([own.jacobian[..., mine], by_load @ felt], axis=2)
        strung = windowed(track, own.relative * scale[:, 0], by * scale, ()).jacobian
        drift = [] if base.drift is None else [drift_columns(track)]
        yield np.concatenate([strung[..., : len(mine)], *drift, strung[..., len(mine) :]], axis=2)
