"""What cameras make of a motion whose frame moves: effects of observation by their own law (`on_view`).

Legend: B poses at the ends of windows, P coordinates.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect, seen
from serpenoid.effects.view import View
from serpenoid.group import relative

INVERTED = 8  # rounds, each far better than the last as long as a frame turns by less than a radian
PART = 0.1  # of a typical value: half a step of the derivatives; laws of observation are linear, or nearly so


def of_frame(effects: Iterable[ActiveEffect]) -> list[ActiveEffect]:
    """Those that change how the cameras' frame moves."""
    return [e for e in effects if e.effect.marks == "frame"]


def shifted(effects: Sequence[ActiveEffect], poses: Floats, time: Floats) -> Floats:
    """By how much effects of the frame show bodies elsewhere than they are (B, 3) [m, m, rad]; poses (B, 3): as they
    are seen. What they do is looked up at the true poses, which are found by and by."""
    away = np.zeros_like(poses)
    for _ in range(INVERTED if effects else 0):
        there = poses - away
        away = _seen_poses(effects, there, time) - there
    return away


def added(effects: Sequence[ActiveEffect], poses: Floats, time: Floats) -> Floats:
    """What effects of the frame add to the displacements (B - 1, 3) between true poses (B, 3) at times (B,)."""
    if not effects:
        return np.zeros((len(poses) - 1, 3))
    there = _seen_poses(effects, poses, time)
    return relative(there[:-1], there[1:]) - relative(poses[:-1], poses[1:])


def added_by(effects: Sequence[ActiveEffect], effect: ActiveEffect, poses: Floats, time: Floats) -> Floats:
    """Derivatives (B - 1, 3, P) of `added` by the coordinates of one of the effects, or of one more."""
    others = [e for e in effects if e.key != effect.key]
    columns = []
    for i, p in enumerate(effect.effect.parameters):
        half = PART * abs(p.coordinate(p.typical))
        ends = effect.moved(i, -half), effect.moved(i, half)
        low, high = (added([*others, e], poses, time) for e in ends)
        columns.append((high - low) / (ends[1].coordinates[i] - ends[0].coordinates[i]))
    return np.stack(columns, axis=-1)


def _seen_poses(effects: Sequence[ActiveEffect], poses: Floats, time: Floats) -> Floats:
    """Poses (B, 3) as two points of the body, one ahead of the other, show them."""
    ahead = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)
    points = seen(View.true(np.stack([poses[:, :2], poses[:, :2] + ahead], axis=1), time), effects).markers
    now = points[:, 1] - points[:, 0]
    turned = np.arctan2(ahead[:, 0] * now[:, 1] - ahead[:, 1] * now[:, 0], (ahead * now).sum(axis=1))
    return np.column_stack([points[:, 0], poses[:, 2] + turned])
