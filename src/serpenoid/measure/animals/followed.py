"""A film that moves with an animal, or an animal that is held: its bends are seen, and its way over the floor is not.

    held    if  SD of a place over time  <  HELD  times the SD of points about their centroid, each about its mean

A place: the centroid of the points, or one of them. Legend: F frames, N points.
"""

from __future__ import annotations

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.signals import LEAST_ROWS

HELD = 0.05  # of what points swing by about the centroid: in two beats with K = 1.05 that moves by 0.08


def followed(points: Floats) -> str:
    """What is said where the centroid of points (F, N, 2), NaN hidden, or a single one stays where it is while the body
    bends; else ""."""
    whole = points[np.isfinite(points).all(axis=(1, 2))]
    if len(whole) < LEAST_ROWS:
        return ""
    centre = whole.mean(axis=1)
    swing = float(np.median(_spread(whole - centre[:, None])))
    if _spread(centre[:, None])[0] < HELD * swing:
        return (
            f"the centroid of its points stays where it is, within {HELD:.0%} of what they swing by: are they counted "
            "from there, or does the film move with the animal (a stage, a picture cut out about it)? Then its way on "
            "the floor is not in this file, and no K can be told: add to every frame's points where its picture was"
        )
    still = np.flatnonzero(_spread(whole) < HELD * swing)
    if not len(still):
        return ""
    number, count = int(still[0]) + 1, whole.shape[1]
    which = {1: " (the tail)", count: " (the head)"}.get(number, "")
    return (
        f"its point {number} of {count}{which} stays where it is while the body bends: are positions counted from it, "
        "or is the animal held there? Then nothing shows how it would move over the floor, and no K can be told"
    )


def _spread(tracks: Floats) -> Floats:
    """SD (K,) of tracks (F, K, 2), of both coordinates together: a body that rests most of the time and then goes on
    has moved."""
    return np.asarray(np.sqrt(tracks.var(axis=0).sum(axis=1)))
