"""What the other gaits leave open of a gait that is held out, to one who knows every law and fits its values to them.

The only tail-first gait of a campaign tells how wheels roll backward: head-first gaits confuse that with eps. Held
out, its path strays by what they leave open, whoever predicts it.

    A_g = sum over windows of gait g of J^T J / sd^2
    covariance without g = (sum over the others of A + 1 / away^2)^-1
    values without g = true values + covariance (sum over the others of J^T left / sd^2 + (neutral - true) / away^2)

Values: eps, and those of hidden effects of floor and frame. J: derivatives of a window's displacement by them, in the
generator's mechanics; sd: of what the true law leaves of windows; away: from the value that changes nothing, for that
is what anybody takes for granted of an effect of which nothing is told; left: of windows by the true law.

What is left open is one normal number for every value, and may come out twice as large. So held-out paths are held
against those of one who knows the law and was told as much, by the same records: their chance is the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from blind.cameras import resample
from blind.campaign import Campaign, Trial
from blind.catalogue import CATALOGUE, MEDIUM, Effect, world
from blind.motion import Drive
from blind.records import Record, record
from blind.snake import Floats
from blind.strength import clean_drives, path_rms

WINDOWS_PER_CYCLE = 8
HALF_AVERAGE_S, HALF_AVERAGE_FRAMES = 0.045, 2.5
STEP = 1e-3  # of a value, for derivatives
NEUTRAL = {"exponent": 1.0}  # else 0, or nothing: then a value is known to its own size


@dataclass(frozen=True)
class KnownLaw:
    """RMS over all trials [m] of the paths of gaits that are held out.

    left_open: by which predictions are expected to be off, on top of the floor; 0 where nothing is held out.
    held_out: how far these paths, as recorded, stray from what one who knows every law says after a fit to the other
    gaits' windows as recorded; the floor where nothing is held out.
    """

    left_open: float
    held_out: float


def known_law(c: Campaign) -> KnownLaw:
    """What the other gaits leave open, and what they have in fact told."""
    labels = held_out_together(c)
    records = [record(c.world, t) for t in c.trials]
    drives = [replace(d, start=r.drive.start) for d, r in zip(clean_drives(c), records, strict=True)]
    values, certainty = _values(c), _certainty(c)
    true = _paths(c, values, drives)
    if len(set(labels)) == 1:
        return KnownLaw(0.0, _strayed(records, drives, true))
    changed = [_paths(c, v, drives) for v in values * (1 - STEP * np.eye(len(values)))]
    windows = [_windows(t, d, r, p) for t, d, r, p in zip(c.trials, drives, records, true, strict=True)]
    deviation = np.sqrt(np.concatenate([w.left**2 for w in windows]).mean(axis=0))
    told = {label: np.zeros((len(values), len(values))) for label in labels}
    seen = {label: np.zeros(len(values)) for label in labels}
    for i, (label, w) in enumerate(zip(labels, windows, strict=True)):
        by = np.stack([w.displacement(true[i]) - w.displacement(path[i]) for path in changed], axis=-1)
        by = (by / (STEP * values) / deviation[:, None]).reshape(-1, len(values))
        told[label] += by.T @ by
        seen[label] += by.T @ (w.left / deviation).ravel()
    squares, predicted = [], dict(enumerate(true))
    for label in told:
        own = [i for i, other in enumerate(labels) if other == label]
        root = _root(sum(a for k, a in told.items() if k != label), certainty)
        without = sum(b for k, b in seen.items() if k != label) + certainty * (_neutral(c) - values)
        paths = _paths(c, values + root @ (root.T @ without), [drives[i] for i in own])
        predicted |= dict(zip(own, paths, strict=True))
        for i in own:
            moved = np.stack([(true[i] - path[i])[:, :2] for path in changed], axis=-1) / (STEP * values)
            squares.append(((moved @ root) ** 2).sum(axis=(1, 2)).mean())
    strayed = _strayed(records, drives, [predicted[i] for i in range(len(labels))])
    return KnownLaw(float(np.sqrt(np.mean(squares))), strayed)


def _strayed(records: Sequence[Record], drives: Sequence[Drive], paths: Sequence[Floats]) -> float:
    """Path RMS [m] of records about paths."""
    seen = [resample(r.time, d.time, p) for r, d, p in zip(records, drives, paths, strict=True)]
    return path_rms([p[:, :2] - r.pose[:, :2] for p, r in zip(seen, records, strict=True)])


def held_out_together(c: Campaign) -> list[object]:
    """Of each trial: its gait; with a single gait its setting; else itself."""
    kinds = [[t.setting.gait for t in c.trials], [t.setting.label for t in c.trials]]
    return next((list(k) for k in kinds if len(set(k)) > 1), list(range(len(c.trials))))


@dataclass(frozen=True)
class _Windows:
    """time of the path's nodes, boundaries (B,) [s], which of the B - 1 are used, and what the true law leaves of these
    (W, 3) [m, m, rad]."""

    time: Floats
    boundaries: Floats
    used: np.ndarray
    left: Floats

    def displacement(self, path: Floats) -> Floats:
        """Of a path (n + 1, 3), in the frame of each window's first pose (W, 3)."""
        return _relative(resample(self.boundaries, self.time, path))[self.used]


def _windows(trial: Trial, drive: Drive, r: Record, true: Floats) -> _Windows:
    plan, frame = trial.setting.plan, float(np.median(np.diff(r.time)))
    eighths = np.arange(WINDOWS_PER_CYCLE) / WINDOWS_PER_CYCLE * plan.cycle_s
    within, period = np.append(eighths, plan.cycle_s + plan.pause_s * np.array([0, 0.5])), plan.cycle_s + plan.pause_s
    boundaries = np.unique([*(n * period + t for n in range(plan.cycles) for t in within), plan.cycles * period])
    half = max(HALF_AVERAGE_S, HALF_AVERAGE_FRAMES * frame)
    miss = r.pose - resample(r.time, drive.time, true)
    miss[:, 2] = (miss[:, 2] + np.pi) % (2 * np.pi) - np.pi
    near = (np.abs(r.time - boundaries[:, None]) <= half) & np.isfinite(miss[:, 0])
    around = (near @ np.nan_to_num(miss)) / np.maximum(near.sum(axis=1), 1)[:, None]
    seen = near.any(axis=1)
    used, path = seen[1:] & seen[:-1], resample(boundaries, drive.time, true)
    return _Windows(drive.time, boundaries, used, (_relative(path + around) - _relative(path))[used])


def _relative(poses: Floats) -> Floats:
    """Poses (B, 3) -> displacements (B - 1, 3), each seen from where it begins."""
    d, c, s = np.diff(poses, axis=0), np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
    return np.column_stack([c * d[:, 0] + s * d[:, 1], -s * d[:, 0] + c * d[:, 1], d[:, 2]])


def _moving(e: Effect) -> list[str]:
    """Parameters that move paths on given shapes; none where they are zero."""
    shown = CATALOGUE[e.name].site == MEDIUM or e.name == "frame_drift"
    return [p for p, v in e.parameters.items() if v] if shown else []


def _values(c: Campaign) -> Floats:
    return np.array([c.eps, *(e.parameters[p] for e in c.effects for p in _moving(e))])


def _neutral(c: Campaign) -> Floats:
    """What changes nothing; of eps its value."""
    return np.array([c.eps, *(NEUTRAL.get(p, 0.0) for e in c.effects for p in _moving(e))])


def _certainty(c: Campaign) -> Floats:
    """Inverse squares of the distances to what changes nothing; 0 for eps."""
    return np.array([0.0, *(1 / a**2 for a in (_values(c) - _neutral(c))[1:])])


def _paths(c: Campaign, values: Floats, drives: Sequence[Drive]) -> list[Floats]:
    """Paths (n + 1, 3) as cameras show them, with other values of the hidden effects."""
    given, effects = iter(values[1:]), []
    for e in c.effects:
        effects.append(replace(e, parameters={**e.parameters, **{p: float(next(given)) for p in _moving(e)}}))
    w = world(float(values[0]), [*c.base, *effects], c.world.ground.robot)
    drift = np.array([*w.cameras.drift, 0.0]) - np.array([*c.world.cameras.drift, 0.0])
    return [p + d.time[:, None] * drift for p, d in zip(w.paths(drives), drives, strict=True)]


def _root(told: Floats, certainty: Floats) -> Floats:
    """A root of the covariance."""
    scale = np.sqrt(np.maximum(np.diag(told) + certainty, 1e-300))
    values, vectors = np.linalg.eigh((told + np.diag(certainty)) / np.outer(scale, scale))
    return vectors / np.sqrt(np.maximum(values, 1e-12)) / scale[:, None]
