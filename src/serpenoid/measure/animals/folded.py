"""Is a body folded back on itself at one point all the time, as points in another order than the body's show it?"""

from __future__ import annotations

import numpy as np

from serpenoid.measure.cells import Floats

BACK_DEG = 120.0  # a bend by more leads back; bodies do that in turns and coils, and not all the time
ALWAYS = 0.9  # of the frames that show it
LEAST_FRAMES = 8


def folded(points: Floats) -> str:
    """A sentence of points (F, N, 2) where neighbours lead back at one of them in nearly every frame; else ""."""
    steps = np.diff(points, axis=1)
    before, after = steps[:, :-1], steps[:, 1:]
    size = np.linalg.norm(before, axis=2) * np.linalg.norm(after, axis=2)
    cosine = np.where(size > 0, (before * after).sum(axis=2) / np.where(size > 0, size, 1.0), np.nan)
    seen = np.isfinite(cosine).sum(axis=0)
    share = (cosine < np.cos(np.deg2rad(BACK_DEG))).sum(axis=0) / np.maximum(seen, 1)
    share[seen < LEAST_FRAMES] = 0.0
    if share.max(initial=0.0) < ALWAYS:
        return ""
    at = int(share.argmax())
    how_often = f"by {BACK_DEG:g} degrees or more in {share[at]:.0%} of the frames"
    return (
        f"its body is folded back at vertex {at + 1} ({how_often}): points are not in the order of the body, and "
        "nothing that is found from them can be believed. Name them from tail to head (`markers`, or `columns`, in "
        "[motion])"
    )
