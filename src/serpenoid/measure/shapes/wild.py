"""Points that are where no body goes: what is said of those that are left out, and those of bridged frames.

A frame whose shape its own points do not tell is bridged by those about it. What it shows of single points is used all
the same, by one linear step from the bridged path. A body does not leave its path for so short a time by more than it
goes meanwhile, so what is farther from it than that, and noise, is no point of the body:

    |point - path| > the largest way of a vertex from the frame before to the frame after + limit of noise

Legend: F frames, N vertices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.measure.cells import Floats, clock
from serpenoid.measure.film.quality import misfit_limit, stretches
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.wording import counted

MOST_TOLD = 3  # moments


def beyond_bridge(
    body: Body, points: Floats, poses: Floats, angles: Floats, bridged: NDArray[np.bool_], marker_sd: float
) -> NDArray[np.bool_]:
    """Which points (F, N, 2) of bridged frames (F,) are none of the body's, by its smooth path."""
    found = np.zeros(points.shape[:2], dtype=bool)
    if not bridged.any() or not np.isfinite(marker_sd):
        return found
    about = bridged.copy()
    about[1:] |= bridged[:-1]
    about[:-1] |= bridged[1:]
    path = np.full_like(points, np.nan)
    path[about] = chain_vertices(body, poses[about], angles[about])
    off = np.linalg.norm(points - path, axis=2)
    for first, stop in stretches(bridged):
        before, after = path[max(first - 1, 0)], path[min(stop, len(path) - 1)]
        way = float(np.linalg.norm(after - before, axis=1).max())
        found[first:stop] = np.nan_to_num(off[first:stop]) > way + misfit_limit(marker_sd)
    return found


def said_of_hidden(seen: Floats, kept: Floats, time_s: Floats) -> list[str]:
    """How many of the points that a film shows (F, N, 2) were taken for wild: those that are not kept (F, N, 2)."""
    wild = np.isfinite(seen[..., 0]) & ~np.isfinite(kept[..., 0])
    if not wild.any():
        return []
    moments = [clock(float(time)) for time in time_s[wild.any(axis=1)]]
    more = f" and {counted(len(moments) - MOST_TOLD, 'moment')} more" if len(moments) > MOST_TOLD else ""
    share = wild.sum() / np.isfinite(seen[..., 0]).sum()
    return [
        f"{counted(int(wild.sum()), 'point')} ({share:.2%}) taken for wild, by where the rest of the body is, and "
        f"hidden: at {', '.join(moments[:MOST_TOLD])} s{more}"
    ]
