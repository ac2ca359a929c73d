"""Where a patch of the floor may lie: a grid over what was visited, scaled by the body."""

from __future__ import annotations

import numpy as np

from serpenoid.diagnose.medium import Motion
from serpenoid.effects.active import ActiveEffect

RADII, MARGIN = (0.14, 0.24, 0.38), 0.27  # body lengths


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
