"""What is wrong with markers: which is which vertex, which axis is up, which unit, which edge has another length, which
is not on the body. Each is weighed by the evidence of the layout it makes (`layout`).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.hypotheses import rounded
from serpenoid.measure.consistency.layout import PLACED, Layout, evidence, flatness, layout
from serpenoid.measure.tracks import floor_plane

SCALE_SD = 0.03  # cameras are calibrated to this, and robots measured
UNITS = {
    1e6: "um", 1e3: "mm", 100.0: "cm", 39.37: "inches", 25.4: "mm, [body] in inches", 10.0: "mm, [body] in cm",
    1e-3: "m, [body] in mm", 0.01: "m, [body] in cm", 0.1: "cm, [body] in mm", 1e-6: "m, [body] in um",
}  # fmt: skip
NO_UNIT = 1e-9  # of the promised length: less than another unit makes of it
SWAPS = 3  # pairs exchanged at once that are looked for
KINDS = 5  # up axis, unit, order, one length, one marker elsewhere
LARGEST = 40  # vertices up to which every pair is tried; beyond, pairs up to a tenth of the body apart


@dataclass(frozen=True)
class MarkerFault:
    """`gain`: log evidence over the contract's, prior share taken off."""

    kind: str
    words: str
    cure: str
    gain: float


def marker_faults(plan: Layout, names: Sequence[str], plane: Plane | None) -> list[MarkerFault]:
    """All faults of one recording's markers that explain it better than the contract does, best first."""
    order = list(range(plan.points.shape[1]))
    base = evidence(plan, order)
    if not np.isfinite(base):  # no two neighbours are ever seen together
        return []
    if plan.edges is not None:
        base += _scale_belief(plan, order)
    found = [*_exchanged(plan, names, base), *_axes(plan, plane), *_lengths(plan, base), *_elsewhere(plan, names)]
    return sorted((fault for fault in found if fault.gain > 0), key=lambda fault: -fault.gain)


def _scale_belief(plan: Layout, order: list[int]) -> float:
    """What a free scale within `SCALE_SD` adds to the evidence: cameras and rulers differ by so much."""
    best = max(evidence(plan, order, 1 + s) - 0.5 * (s / SCALE_SD) ** 2 for s in np.linspace(-0.12, 0.12, 25))
    return best - evidence(plan, order)


def _exchanged(plan: Layout, names: Sequence[str], base: float) -> list[MarkerFault]:
    """Pairs exchanged, one after the other while each is better than the last."""
    count = len(names)
    reach = count if count <= LARGEST else max(2, count // 10)
    pairs = [(i, j) for i, j in itertools.combinations(range(count), 2) if j - i <= reach]
    order, best, done = list(range(count)), base, []
    for _ in range(SWAPS):
        tried = [(evidence(plan, _swapped(order, pair)), pair) for pair in pairs]
        value, pair = max(tried)
        if value - np.log(len(pairs)) <= best:
            break
        order, best = _swapped(order, pair), value - np.log(len(pairs))
        done.append(pair)
    if not done:
        return []
    which = ", ".join(f"`{names[i]}` and `{names[j]}`" for i, j in done)
    cure = f"exchange {which} in `markers` (or their columns)"
    return [MarkerFault("markers", f"have {which} exchanged along the body", cure, best - base - np.log(KINDS))]


def _swapped(order: list[int], pair: tuple[int, int]) -> list[int]:
    i, j = pair
    new = order.copy()
    new[i], new[j] = new[j], new[i]
    return new


@dataclass(frozen=True)
class Plane:
    """A recording in its own axes (F, M, 3), the axis taken as up, and the way from any floor to vertices."""

    space: Floats
    up_axis: str
    vertices: Callable[[Floats], Floats]  # floor positions of all markers (F, M, 2) -> vertices (F, N, 2)


def _axes(plan: Layout, plane: Plane | None) -> list[MarkerFault]:
    if plane is None:
        return []
    found = []
    for axis in sorted({"x", "y", "z"} - {plane.up_axis}):
        other = layout(plane.vertices(floor_plane(plane.space, axis)), plan.edges)
        if not np.isfinite(other.distance).any():
            continue
        gain = flatness(other) - flatness(plan) - np.log(2 * KINDS)
        words = f"lie on a floor whose upward axis is {axis}, and `up_axis` says {plane.up_axis}"
        found.append(MarkerFault("up_axis", words, f'set `up_axis = "{axis}"` in [motion]', float(gain)))
    return found


def _lengths(plan: Layout, base: float) -> list[MarkerFault]:
    """A wrong unit or scale, and single lengths that are wrong."""
    if plan.edges is None:
        return []
    order = range(plan.points.shape[1])
    distances = plan.neighbours
    ever = np.asarray(np.isfinite(distances).any(axis=0))  # neighbours that are never seen together say nothing
    measured = np.full(len(plan.edges), np.nan)
    measured[ever] = np.nanmedian(distances[:, ever], axis=0)
    ratio = measured / plan.edges
    common = float(np.nanmedian(ratio))
    together = np.flatnonzero(ever & ~(ratio > NO_UNIT))
    if len(together):
        words = f"of vertices {together[0]} and {together[0] + 1} lie in one place"
        return [MarkerFault("place", words, "is one of them a copy, or was it never tracked?", np.inf)]
    near = min(UNITS, key=lambda factor: abs(np.log(common / factor)))
    unit = f" (is the file in {UNITS[near]}?)" if abs(np.log(common / near)) < 0.1 else ""
    words = f"show neighbouring markers {rounded(common)} times as far apart as [body] says{unit}"
    cure = "check `length_unit`, `edge_lengths` and, of a film in pixels, `metres_per_pixel`"
    found = [MarkerFault("scale", words, cure, evidence(plan, order, 1 / common) - base - np.log(2 * KINDS))]
    worst = int(np.nanargmax(np.abs(np.log(ratio / common))))
    corrected = plan.edges.copy()
    corrected[worst] = measured[worst]
    gain = evidence(plan, order, edges=corrected) - base - np.log(2 * KINDS * len(ratio))
    words = f"show edge {worst} {measured[worst]:.4g} long, and `edge_lengths` says {plan.edges[worst]:.4g}"
    found.append(MarkerFault("edge", words, f"set that length to {measured[worst]:.4g}", float(gain)))
    return found


def _elsewhere(plan: Layout, names: Sequence[str]) -> list[MarkerFault]:
    """A marker that most of the time misses its place by more than an edge: whatever was tracked, it is not that one.

    Its edges have a miss of their own, the others one together; a marker that is badly placed misses by less.
    """
    count = plan.points.shape[1]
    distances = plan.neighbours
    ever = np.flatnonzero(np.isfinite(distances).any(axis=0))
    distances = distances[:, ever]
    usual = np.nanmedian(distances, axis=0)
    about = usual if plan.edges is None else plan.edges[ever]
    longest = float(np.median(about) if plan.edges is None else about.max())
    missed = np.abs(distances - about)
    squares = np.nanmean(missed**2, axis=0) + (PLACED * np.median(about)) ** 2
    far = np.nanmedian(missed, axis=0) > longest
    found = []
    for k in range(count):
        own = (ever == k - 1) | (ever == k)
        if not far[own].any() or own.all():
            continue
        apart = [0.5 * part.sum() * np.log(squares[part].mean()) for part in (own, ~own)]
        gain = 0.5 * len(ever) * np.log(squares.mean()) - sum(apart) - np.log(KINDS * count)
        times = np.nanmedian(missed[:, own], axis=0).max() / longest
        words = (
            f"have `{names[k]}` where it cannot be: most of the time its distance to a neighbour is wrong by "
            f"{rounded(times)} times the {'median' if plan.edges is None else 'longest'} edge"
        )
        cure = f"is a column of `{names[k]}` in another unit, or of another point?"
        found.append(MarkerFault("elsewhere", words, cure, float(gain)))
    return found
