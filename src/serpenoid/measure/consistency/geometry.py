"""What is wrong with markers: which is which vertex, which axis is up, which unit, which link has another length, which
is not on the body. Each is weighed by the evidence of the layout it makes (`layout`). Successive markers are looked at,
whatever lies between them: a body that is marked at every vertex is one of them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.errors import InputError
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.hypotheses import rounded
from serpenoid.measure.consistency.layout import PLACED, Layout, beside, evidence, flatness, layout, middles
from serpenoid.measure.consistency.reach import Reach
from serpenoid.measure.tracks import floor_plane

SCALE_SD = 0.03  # cameras are calibrated to this, and robots measured
UNITS = {
    1e6: "um", 1e3: "mm", 100.0: "cm", 39.37: "inches", 25.4: "mm, [body] in inches", 10.0: "mm, [body] in cm",
    1e-3: "m, [body] in mm", 0.01: "m, [body] in cm", 0.1: "cm, [body] in mm", 1e-6: "m, [body] in um",
}  # fmt: skip
NO_UNIT = 1e-9  # of the promised length: less than another unit makes of it
AXES = "xyz"
LEVEL = 0.02  # rad: cameras are levelled to this
SWAPS = 3  # pairs exchanged at once that are looked for
KINDS = 6  # up axis, unit, order, one length, one marker elsewhere, its columns exchanged
LARGEST = 40  # markers up to which every pair is tried; beyond, pairs up to a tenth of the body apart


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
    if not np.isfinite(base):  # no two successive ones are ever seen together
        return []
    if plan.reach is not None:
        base += _scale_belief(plan, order)
    found = [
        *_exchanged(plan, names, base),
        *_axes(plan, plane),
        *_lengths(plan, names, base),
        *_elsewhere(plan, names),
        *_transposed(plan, names, base),
    ]
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
    aside = ", or leave out points that are beside the midline (eyes, fins, feet)" if len(done) > 1 else ""
    cure = f"exchange {which} in `markers` (or their columns){aside}"
    return [MarkerFault("markers", f"have {which} exchanged along the body", cure, best - base - np.log(KINDS))]


def _swapped(order: list[int], pair: tuple[int, int]) -> list[int]:
    i, j = pair
    new = order.copy()
    new[i], new[j] = new[j], new[i]
    return new


@dataclass(frozen=True)
class Plane:
    """A recording in its own axes (F, M, 3), the axis taken as up, and the way from any floor to a layout's markers."""

    space: Floats
    up_axis: str
    placed: Callable[[Floats], Floats]  # floor positions of all in the file (F, M, 2) -> the layout's (F, N, 2)


def _axes(plan: Layout, plane: Plane | None) -> list[MarkerFault]:
    if plane is None:
        return []
    found, swings, pairs = [], _swings(plane.space), plan.points.shape[1] - 1
    for axis in sorted(set(AXES) - {plane.up_axis}):
        try:
            other = layout(plane.placed(floor_plane(plane.space, axis)), plan.reach)
        except InputError:  # seen like that, points without names are no chain
            continue
        if not np.isfinite(other.distance).any():
            continue
        flatter = pairs * np.log(swings[AXES.index(plane.up_axis)] / swings[AXES.index(axis)])
        gain = flatness(other) - flatness(plan) + flatter - np.log(2 * KINDS)
        words = f"lie on a floor whose upward axis is {axis}, and `up_axis` says {plane.up_axis}"
        found.append(MarkerFault("up_axis", words, f'set `up_axis = "{axis}"` in [motion]', float(gain)))
    return found


def _swings(space: Floats) -> Floats:
    """How far points (F, M, 3) move against each other along each axis, RMS (3,): least along that which is up. Heights
    at which markers were put on are no motion."""
    apart = np.diff(space, axis=1)
    often = np.isfinite(apart).sum(axis=0)
    mean = np.nansum(apart, axis=0) / np.maximum(often, 1)
    swings = np.sqrt(np.nansum((apart - mean) ** 2, axis=(0, 1)) / max(int(often[:, 0].sum()), 1))
    return np.asarray(np.hypot(swings, max(LEVEL * swings.max(), np.finfo(float).tiny)))


def _lengths(plan: Layout, names: Sequence[str], base: float) -> list[MarkerFault]:
    """A wrong unit or scale, and single lengths that are wrong."""
    if plan.reach is None:
        return []
    order = range(plan.points.shape[1])
    distances = plan.neighbours
    measured = middles(distances)
    ever = np.isfinite(measured)  # neighbours that are never seen together say nothing
    together = np.flatnonzero(ever & ~(measured > NO_UNIT * plan.reach.high))
    if len(together):
        words = f"have `{names[together[0]]}` and `{names[together[0] + 1]}` in one place"
        return [MarkerFault("place", words, "is one of them a copy, or was it never tracked?", np.inf)]
    told = ever & plan.reach.rigid
    ratio = measured / plan.reach.nearest(measured)
    common = float(np.median(ratio[told if told.any() else ever]))
    near = min(UNITS, key=lambda factor: abs(np.log(common / factor)))
    unit = f" (is the file in {UNITS[near]}?)" if abs(np.log(common / near)) < 0.1 else ""
    words = f"show neighbouring markers {rounded(common)} times as far apart as [body] says{unit}"
    cure = "check `length_unit`, `edge_lengths` and, of a film in pixels, `metres_per_pixel`"
    found = [MarkerFault("scale", words, cure, evidence(plan, order, 1 / common) - base - np.log(2 * KINDS))]
    if not told.any():
        return found
    worst = int(np.argmax(np.where(told, np.abs(np.log(ratio / common)), -1.0)))
    stated, shown = plan.reach.high[worst], measured[worst]
    corrected = plan.reach.with_length(worst, shown)
    gain = evidence(plan, order, reach=corrected) - base - np.log(2 * KINDS * told.sum())
    words = f"show `{names[worst]}` and `{names[worst + 1]}` {shown:.4g} apart, and `edge_lengths` says {stated:.4g}"
    cure = f"set what `edge_lengths` has between them to {shown:.4g}"
    found.append(MarkerFault("edge", words, cure, float(gain)))
    return found


def _elsewhere(plan: Layout, names: Sequence[str]) -> list[MarkerFault]:
    """A marker that most of the time misses its place by more than an edge: whatever was tracked, it is not that one.

    Its edges have a miss of their own, the others one together; a marker that is badly placed misses by less.
    """
    count = plan.points.shape[1]
    distances = plan.neighbours
    ever = np.flatnonzero(np.isfinite(distances).any(axis=0))
    distances = distances[:, ever]
    allowed = None if plan.reach is None else Reach(plan.reach.low[ever], plan.reach.high[ever])
    usual = np.nanmedian(distances, axis=0)
    scale = usual if allowed is None else allowed.high
    longest = float(np.median(scale) if allowed is None else scale.max())
    missed = np.abs(distances - (usual if allowed is None else allowed.nearest(distances)))
    squares = np.nanmean(missed**2, axis=0) + (PLACED * np.median(scale)) ** 2
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
            f"{rounded(times)} times the {'median' if allowed is None else 'longest'} edge"
        )
        cure = f"is a column of `{names[k]}` in another unit, or of another point?"
        found.append(MarkerFault("elsewhere", words, cure, float(gain)))
    return found


def _transposed(plan: Layout, names: Sequence[str], base: float) -> list[MarkerFault]:
    """A marker whose x stands where its y belongs; where a floor's axes run against the file's, both change sign."""
    found, order = [], range(len(names))
    for k in beside(plan):
        name = names[k]
        for sign in (1.0, -1.0):
            points = plan.points.copy()
            points[:, k] = sign * points[:, k, ::-1]
            gain = evidence(layout(points, plan.reach), order) - base - np.log(2 * KINDS * len(names))
            words, cure = f"have x and y of `{name}` exchanged", f"exchange the two columns of `{name}`"
            found.append(MarkerFault("transposed", words, cure, float(gain)))
    return found
