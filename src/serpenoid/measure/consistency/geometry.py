"""The same for markers: which marker is which vertex, which axis is up, which unit, which edge has another length.

    log evidence = - E log( rms of (distance - edge length) )             lengths given: links are rigid
                   - E log( rms of (distance - its mean) ) - E log( sum of mean distances )       not given
                   - 2 (N - 2) log( rms of the turning angles )           a body does not fold back on itself

rms over edges and frames, each with the tolerance of a marker put on by hand added. Counted once per edge and angle,
however many frames: errors of placing repeat in every frame. Legend: F frames, N vertices, E = N - 1 edges.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.tracks import floor_plane

MOST_FRAMES = 120  # evenly chosen: posture, not noise, decides
PLACED = 0.05  # of the median edge: a marker put on by hand
SCALE_SD = 0.03  # cameras are calibrated to this, and robots measured
UNITS = {
    1e6: "um", 1e3: "mm", 100.0: "cm", 39.37: "inches", 25.4: "mm, [body] in inches", 10.0: "mm, [body] in cm",
    1e-3: "m, [body] in mm", 0.01: "m, [body] in cm", 0.1: "cm, [body] in mm", 1e-6: "m, [body] in um",
}  # fmt: skip
NO_UNIT = 1e-9  # of the promised length: less than another unit makes of it
SWAPS = 3  # pairs exchanged at once that are looked for
KINDS = 4  # up axis, unit, order, one length
LARGEST = 40  # vertices up to which every pair is tried; beyond, pairs up to a tenth of the body apart


@dataclass(frozen=True)
class Layout:
    """Distances between all pairs in F frames (F, N, N), the positions (F, N, 2), and edges (N - 1,) or None."""

    points: Floats
    distance: Floats
    edges: Floats | None


@dataclass(frozen=True)
class MarkerFault:
    """`gain`: log evidence over the contract's, prior share taken off."""

    kind: str
    words: str
    cure: str
    gain: float


def layout(points: Floats, edges: Floats | None) -> Layout:
    """Of vertices (F, N, 2) in the unit of `edges`."""
    seen = np.isfinite(points[..., 0]).sum(axis=1) >= 3
    usable = np.flatnonzero(seen)
    some = usable[np.linspace(0, len(usable) - 1, min(len(usable), MOST_FRAMES)).astype(int)] if len(usable) else usable
    chosen = points[some]
    return Layout(chosen, np.linalg.norm(chosen[:, :, None] - chosen[:, None], axis=3), edges)


def evidence(plan: Layout, order: Sequence[int], scale: float = 1.0, edges: Floats | None = None) -> float:
    """Log evidence of vertices taken in `order`, their distances multiplied by `scale`."""
    chain = np.asarray(order)
    lengths = plan.edges if edges is None else edges
    distance = scale * plan.distance[:, chain[:-1], chain[1:]]
    with np.errstate(invalid="ignore"):
        seen = np.isfinite(distance).any(axis=0)
    if not seen.any():
        return -np.inf
    distance, count = distance[:, seen], int(seen.sum())
    mean = np.nanmean(distance, axis=0)
    typical = np.median(mean) if lengths is None else float(np.median(lengths))
    about = mean if lengths is None else lengths[seen]
    miss = float(np.sqrt(np.nanmean((distance - about) ** 2) + (PLACED * typical) ** 2))
    if lengths is not None:
        return float(-count * np.log(miss))
    order_of_body = -count * np.log(mean.sum()) - 2 * (len(chain) - 2) * np.log(_folding(plan, chain))
    return float(-count * np.log(miss) + order_of_body)


def flatness(plan: Layout) -> float:
    """Log evidence that these are all of a body's lengths and not a view of it from the side."""
    chain = np.arange(plan.points.shape[1])
    if plan.edges is not None:
        return evidence(plan, chain.tolist())
    distance = plan.distance[:, chain[:-1], chain[1:]]
    distance = distance[:, np.isfinite(distance).any(axis=0)]
    mean = np.nanmean(distance, axis=0)
    miss = np.sqrt(np.nanmean((distance - mean) ** 2) / mean.mean() ** 2 + PLACED**2)
    return float(-len(mean) * np.log(miss))


def _folding(plan: Layout, chain: np.ndarray) -> float:
    """RMS turning angle between successive edges, with the tolerance of placing."""
    edge = np.diff(plan.points[:, chain], axis=1)
    a, b = edge[:, :-1], edge[:, 1:]
    cross, dot = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], (a * b).sum(axis=2)
    turning = np.arctan2(cross, dot)
    if not np.isfinite(turning).any():
        return 1.0
    return float(np.sqrt(np.nanmean(turning**2) + (2 * PLACED) ** 2))


def marker_faults(plan: Layout, names: Sequence[str], plane: Plane | None) -> list[MarkerFault]:
    """All faults of one recording's markers that explain it better than the contract does, best first."""
    order = list(range(plan.points.shape[1]))
    base = evidence(plan, order)
    if not np.isfinite(base):  # no two neighbours are ever seen together
        return []
    if plan.edges is not None:
        base += _scale_belief(plan, order)
    found = [*_exchanged(plan, names, base), *_axes(plan, plane), *_lengths(plan, base)]
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
    distances = plan.distance[:, np.arange(len(plan.edges)), np.arange(1, len(plan.edges) + 1)]
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
    words = f"show neighbouring markers {common:.3g} times as far apart as [body] says{unit}"
    cure = "check `length_unit` and `edge_lengths`"
    found = [MarkerFault("scale", words, cure, evidence(plan, order, 1 / common) - base - np.log(2 * KINDS))]
    worst = int(np.nanargmax(np.abs(np.log(ratio / common))))
    corrected = plan.edges.copy()
    corrected[worst] = measured[worst]
    gain = evidence(plan, order, edges=corrected) - base - np.log(2 * KINDS * len(ratio))
    words = f"show edge {worst} {measured[worst]:.4g} long, and `edge_lengths` says {plan.edges[worst]:.4g}"
    found.append(MarkerFault("edge", words, f"set that length to {measured[worst]:.4g}", float(gain)))
    return found
