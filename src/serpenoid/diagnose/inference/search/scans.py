"""Effects that lie somewhere on the floor: grids of where they may be, and what weak ones would do, to first order.

Legend: W windows, S steps and M vertices of a track, P columns of a fit, K candidates.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.frame import added_by, of_frame
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.shapes.geometry import turn
from serpenoid.diagnose.data.windows.windows import at_ends, by_track, columns_of
from serpenoid.diagnose.inference.fits.bounds import held_at_bounds
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.diagnose.inference.fits.medium import Fit, of_windows
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import motion_effects
from serpenoid.effects.scan import Grid, Scan
from serpenoid.simulation.sensitivity import EPS

FELT = float(np.exp(-2.0))  # of a spot's strength, all visits of all vertices together: two radii from the nearest
Ranked = tuple[ActiveEffect, float, np.ndarray]  # candidate, gain, where its full fit begins


@dataclass(frozen=True)
class Scanned:
    """Candidates of one effect: those of a grid that some vertex came near, by their numbers (K,)."""

    name: str
    scan: Scan
    grid: Grid
    near: np.ndarray

    @property
    def candidates(self) -> list[ActiveEffect]:
        """At their neutral strength."""
        return [ActiveEffect.neutral(self.name, None, **self.grid.values[i]) for i in self.near]

    def felt(self, places: Floats, by: Floats, first: np.ndarray) -> Floats:
        """What candidates of strength 1 do to windows (W, 3, K), from what the effect that they are made of does at
        vertices (S, 3, M), which are at `places` (S, M, 2); each window's steps, from `first` (W,) on, summed."""
        steps, _, vertices = by.shape
        one, two = self.grid.felt(places)
        windows = []
        for begin, end in zip(first, [*first[1:], steps], strict=True):
            rows = (end - begin) * vertices
            weighted = by[begin:end].transpose(1, 0, 2).reshape(3, 1, rows) * one[begin:end].reshape(rows, -1).T
            windows.append((weighted @ two[begin:end].reshape(rows, -1)).reshape(3, -1)[:, self.near])
        return np.stack(windows)


def on_offer(motion: Motion, base: Fit) -> list[Scanned]:
    """Grids over the floor that was visited, of every effect that may still be there. A spot of the floor has one law:
    beside one of them none is on offer.

    A grid spans all that lies between places that were visited; candidates there that nothing came near would do
    nothing, and on a large floor they are nearly all.
    """
    if any(e.effect.scan is not None for e in base.effects):
        return []
    length = motion.tracks[0].recording.body.total_length_m
    place = np.concatenate([t.on_floor[:, :2] for t in motion.tracks])
    low, high = place.min(axis=0), place.max(axis=0)
    ends = [(t.on_floor[t.boundaries], t.vertices[t.boundaries]) for t in motion.tracks]
    visited = np.concatenate([(p[:, None, :2] + turn(p[:, 2:], v)).reshape(-1, 2) for p, v in ends])
    found = []
    for kind in motion_effects():
        if kind.scan is not None and kind.name not in motion.untestable:
            for grid in kind.scan.grids(low, high, length):
                one, two = grid.felt(visited)
                found.append(Scanned(kind.name, kind.scan, grid, np.flatnonzero((one.T @ two).ravel() > FELT)))
    return found


def score_scanned(motion: Motion, base: Fit, grids: Sequence[Scanned]) -> list[Ranked]:
    """Each candidate of the grids: gain to first order, and where its full fit begins."""
    if not grids:
        return []
    own, evidence = range(len(base.coordinates)), with_scanned(motion, base, grids)
    candidates = [(c, g.scan.begins) for g in grids for c in g.candidates]
    gains = evidence.gains(own, [[len(own) + i] for i in range(len(candidates))])
    result = []
    for (candidate, begins), (gained, values) in zip(candidates, gains, strict=True):
        x = np.concatenate(
            [base.coordinates + values[:-1], [np.clip(values[-1], *begins)], candidate.coordinates[1:-1]]
        )
        toll = evidence.toll(len(candidate.effect.parameters))
        result.append((candidate, gained - toll, x))
    return result


def with_scanned(motion: Motion, base: Fit, grids: Sequence[Scanned]) -> Evidence:
    """Evidence about a fit: its own columns, then the strength of each candidate of the grids."""
    evidence = of_windows(motion, base.predictions, _columns(motion, base, grids))
    return held_at_bounds(base.model, base.effects, evidence)


def _columns(motion: Motion, base: Fit, grids: Sequence[Scanned]) -> Iterator[Floats]:
    """Of each track, derivatives (W, 3, P + K) by the fit's own coordinates and by the strengths of K weak candidates:
    sums of the vertices' own derivatives, by what is felt there."""
    length, weights = base.model.body.total_length_m, base.model.body.vertex_weights
    scale = np.array([[length], [length], [1.0]])
    parts = {g.scan.made_of: [ActiveEffect.neutral(g.scan.made_of, k) for k in range(len(weights))] for g in grids}
    unit = {g.scan.made_of: weights if g.scan.by_weight else np.ones_like(weights) for g in grids}
    frame = of_frame(base.model.effects)
    for track, own, _ in by_track(base.model, motion.tracks, [e for p in parts.values() for e in p], base.predictions):
        _, turned = at_ends(track, own.relative * scale[:, 0], own.jacobian * scale)
        first, ends = track.boundaries[:-1], (track.on_floor[track.boundaries], track.time[track.boundaries])
        by = {c: turned[..., i] for i, c in enumerate(own.columns)}
        mine = {c: np.add.reduceat(d, first, axis=0) for c, d in by.items()}
        for e in frame:
            derivatives = added_by(frame, e, *ends)
            mine |= {c: derivatives[..., i] for i, c in enumerate(columns_of([e]))}
        world = track.on_floor[:, None, :2] + turn(track.on_floor[:, 2:], track.vertices)
        middle = (world[1:] + world[:-1]) / 2
        alone = {n: np.stack([by[c] for c in columns_of(p)], axis=-1) * unit[n] for n, p in parts.items()}
        fitted = np.stack([mine[c] for c in (EPS, *columns_of(base.effects))], axis=-1)
        yield np.concatenate([fitted, *(g.felt(middle, alone[g.scan.made_of], first) for g in grids)], axis=2)
