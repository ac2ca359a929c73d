"""Where an animal's points are along its body, against the lengths that are stated: said where places differ."""

from __future__ import annotations

import warnings

import numpy as np

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import ROBUST
from serpenoid.measure.shapes.lengths import shown_lengths

SURE = 3.0  # standard errors of a median
OF_MEDIAN = 1.2533  # standard error of a median over that of a mean, of normal numbers
BESIDE = 0.05  # of an edge against the others: less is a marker put on by hand
BY_NOISE = 10.0  # times the square of what an edge scatters by: noise lengthens those at the ends by several times that


def uneven(body: Body, points: Floats) -> str:
    """What is said where points (F, N, 2) show edges in another proportion than stated, with what to do; else ""."""
    lengths = shown_lengths(body, points) / body.edges
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # an edge that is never seen
        middle = np.nanmedian(lengths, axis=0)
        scatter = ROBUST * np.nanmedian(np.abs(lengths - middle), axis=0)
    often = np.maximum(np.isfinite(lengths).sum(axis=0), 1)
    longer = middle / np.nanmedian(middle)
    share = scatter / middle
    limit = np.maximum(SURE * OF_MEDIAN * share / np.sqrt(often), BY_NOISE * share**2)
    if not (np.abs(longer - 1) > np.maximum(BESIDE, limit)).any():
        return ""
    least, most = np.nanmin(longer), np.nanmax(longer)
    told = "`length_m`, which makes them equal," if body.edge_lengths is None else "`edge_lengths`"
    key = "`length_m`" if body.edge_lengths is None else "them"
    return (
        f"its points stand {least:.2f} to {most:.2f} times as far apart along the body as {told} says: this counts as "
        f"noise of the points and moves what is fitted. Leave {key} out, and lengths are found from the film; or give "
        "`edge_lengths` as they are, along the body"
    )
