"""Patches of the floor: where they may lie (a grid over what was visited), and what they would do."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.geometry import turn
from serpenoid.diagnose.data.motion import Motion
from serpenoid.diagnose.data.windows import at_ends, by_track
from serpenoid.diagnose.inference.bounds import held_at_bounds
from serpenoid.diagnose.inference.evidence import Evidence
from serpenoid.diagnose.inference.medium import Fit, drift_columns
from serpenoid.effects.active import ActiveEffect

RADII, MARGIN = (0.14, 0.24, 0.38), 0.27  # body lengths

Ranked = tuple[ActiveEffect, float, np.ndarray]  # candidate, gain, where its full fit begins


@dataclass(frozen=True)
class Grid:
    """Places of patches of one radius [m]: every x (X,) with every y (Y,) [m]."""

    radius: float
    x: Floats
    y: Floats

    def patches(self) -> list[ActiveEffect]:
        """Neutral, y by y for each x."""
        return [
            ActiveEffect.neutral("friction_patch", None, x=float(x), y=float(y), radius=self.radius)
            for x in self.x
            for y in self.y
        ]

    def felt(self, places: Floats, by: Floats, first: np.ndarray) -> Floats:
        """What patches of strength 1 do to windows (B - 1, 3, X Y), from what loads at `places` (S, M, 2) do, `by`
        (S, 3, M), summed over the steps of each window; exp(-|p|^2 / (2 radius^2)) is a product of one of x, one of y.
        """
        steps, _, loads = by.shape
        over_x, over_y = (
            np.exp(-((places[..., i, None] - at) ** 2) / (2 * self.radius**2)) for i, at in enumerate((self.x, self.y))
        )
        windows = []
        for begin, end in zip(first, [*first[1:], steps], strict=True):
            rows = (end - begin) * loads
            along = over_x[begin:end].reshape(rows, -1)
            weighted = by[begin:end].transpose(1, 0, 2).reshape(3, 1, rows) * along.T
            windows.append((weighted @ over_y[begin:end].reshape(rows, -1)).reshape(3, -1))
        return np.stack(windows)


def patch_grids(motion: Motion) -> list[Grid]:
    """Friction patches over the floor that was visited."""
    length = motion.tracks[0].recording.body.total_length_m
    place = np.concatenate([t.poses[:, :2] for t in motion.tracks])
    low, high = place.min(axis=0) - MARGIN * length, place.max(axis=0) + MARGIN * length
    found = []
    for radius in (length * r for r in RADII):
        counts = np.maximum(np.ceil((high - low) / radius).astype(int), 2)
        sides = (np.linspace(low[i], high[i], counts[i]) for i in range(2))
        found.append(Grid(radius, *sides))
    return found


def score_patches(motion: Motion, base: Fit, own: list[int]) -> list[Ranked]:
    """Each patch of the grid: gain to first order, and where its full fit begins."""
    evidence, patches = with_patches(motion, base)
    before, result = evidence.chi2(own), []
    for i, patch in enumerate(patches):
        index = [*own, len(own) + i]
        values, _ = evidence.solve(index)
        weak = float(np.clip(values[-1], -0.9, 3.0))
        x = np.concatenate([base.coordinates + values[:-1], [weak, *patch.coordinates[1:-1]]])
        result.append((patch, before - evidence.chi2(index) - evidence.toll(len(patch.effect.parameters)), x))
    return result


def with_patches(motion: Motion, base: Fit) -> tuple[Evidence, list[ActiveEffect]]:
    """Evidence about a fit: its own columns, then the strength of each patch of the grids; the patches."""
    rows, columns, labels = [], [], []
    grids = patch_grids(motion)
    found = zip(motion.tracks, motion.labels, base.predictions, patch_columns(motion, base, grids), strict=True)
    for track, label, p, joined in found:
        noise, use = motion.noise.of(track), track.usable
        rows.append(((track.displacement - p.displacement) / noise)[use].ravel())
        columns.append((joined / noise[..., None])[use].reshape(-1, joined.shape[2]))
        labels.append(np.full(len(rows[-1]), label))
    evidence = Evidence.of(np.concatenate(rows), np.concatenate(columns), np.concatenate(labels))
    patches = [patch for grid in grids for patch in grid.patches()]
    return held_at_bounds(base.model, base.effects, evidence), patches


def patch_columns(motion: Motion, base: Fit, grids: Sequence[Grid]) -> Iterator[Floats]:
    """Of each track, derivatives (B - 1, 3, P + K) by the fit's own coordinates and by the strengths of K weak patches.

    A patch changes each vertex's weight in the drag by strength w_k exp(-|p_k - (x, y)|^2 / (2 radius^2)), so the
    derivatives by the loads of the vertices give its own.
    """
    length, weights = base.model.body.total_length_m, base.model.body.vertex_weights
    scale = np.array([[length], [length], [1.0]])
    loads = [ActiveEffect.neutral("load", k) for k in range(len(weights))]
    fitted = {e.key for e in base.effects}
    for track, own, _ in by_track(base.model, motion.tracks, loads, base.predictions):
        column = {(c.effect, c.place): i for i, c in enumerate(own.columns)}
        mine = [i for i, c in enumerate(own.columns) if c.effect is None or (c.effect, c.place) in fitted]
        listed = [*mine, *(column[e.key] for e in loads)]
        _, turned = at_ends(track, own.relative * scale[:, 0], (own.jacobian * scale)[..., listed])
        world = track.poses[:, None, :2] + turn(track.poses[:, 2:], track.vertices)
        first, by_load = track.boundaries[:-1], turned[..., len(mine) :] * weights
        felt = [grid.felt((world[1:] + world[:-1]) / 2, by_load, first) for grid in grids]
        drift = [] if base.drift is None else [drift_columns(track)]
        yield np.concatenate([np.add.reduceat(turned[..., : len(mine)], first, axis=0), *drift, *felt], axis=2)
