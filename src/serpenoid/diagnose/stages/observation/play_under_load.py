"""Play of a joint whose link lies where load pushes it, whatever its servo does.

The law of `loose_joint` has the servo push its link across the gap. Where load is larger than what holds the link, it
is the load that pushes it, to one end of the gap or to the other. No law says when; that there is play can be seen all
the same, for what markers show beyond readings takes two values, and within trials it goes from one to the other and
back:

    d_t = e(t) + left,    e(t) one of two ends,    RMS left < LAW_ERROR RMS (d - mean d)

of what lasts from frame to frame: the mean products of neighbours, in which white noise is not. An elastic link takes
all values between (of a sine the two ends leave 0.44), a horn that slips takes a new one and keeps it, and readings
that are off in proportion follow a line in the reading, which then leaves less than the two ends do.

Legend: F frames, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import stdtrit

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import CONFIDENCE
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Named, interval
from serpenoid.diagnose.stages.observation.beyond_readings import Beyond, OfJoint, lasting, noise_level
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.catalogue import marking

ROUNDS = 50  # in which two ends are found
TINY = 1e-12  # rad^2: of joints that stand still
BACK = 0.5  # of the trials in which a link crosses its gap: in more of them it comes back


def play_under_load(
    trials: Sequence[Beyond], joints: Sequence[int], without: frozenset[str] = frozenset()
) -> tuple[Named, ...]:
    """Play at those of some joints (from 0) where it is what markers show beyond readings."""
    kind = next((k for k in marking("gaps") if k.name not in without), None)
    if kind is None:
        return ()
    found = []
    for joint in joints:
        level = noise_level(trials, joint)
        width = ends_of([t.at(joint) for t in trials], level)
        if width is None:
            continue
        (gap,) = kind.parameters
        value, half = width
        half += gap.resolution
        effect = ActiveEffect.of(kind.name, joint + 1, **{gap.name: value})
        found.append(Named(effect, {gap.name: interval((value - half, value + half))}, value / 2 / level))
    return tuple(found)


def ends_of(trials: Sequence[OfJoint], level: float) -> tuple[float, float] | None:
    """Width of the gap between two ends [rad] and half of its 95 % interval: by how it scatters from trial to trial,
    and by what lasts about the ends, for a link on its way between them draws both to the middle.

    None where two ends are not what markers show, or all that lasts is below their noise level [rad].
    """
    every, read = (np.concatenate([getattr(t, name) for t in trials]) for name in ("shown", "read"))
    if len(every) < 2 or np.ptp(every) <= 0:
        return None
    ends = two_ends(every)
    left = [t.shown - nearest(t.shown, ends) for t in trials]
    moved = [t.shown - every.mean() for t in trials]
    swing = read - read.mean()
    slope = float(swing @ every / max(swing @ swing, TINY))
    straight = [t.shown - every.mean() - slope * (t.read - read.mean()) for t in trials]
    about, whole, by_line = (lasting(x, trials) for x in (left, moved, straight))
    if whole <= (VISIBLE * level) ** 2 or about >= LAW_ERROR**2 * whole or by_line <= about:
        return None
    sides = [crossings(t.shown, ends) for t in trials]
    crossed = [n for n in sides if n]
    if not crossed or sum(n > 1 for n in crossed) <= BACK * len(crossed):
        return None
    widths = [_width(t.shown, ends) for t, n in zip(trials, sides, strict=True) if n]
    value, count = float(np.mean(widths)), len(widths)
    spread = np.std(widths, ddof=1) / np.sqrt(count) if count > 1 else np.inf
    half = float(stdtrit(max(count - 1, 1), (1 + CONFIDENCE) / 2) * spread)
    return value, float(np.hypot(half, np.sqrt(max(about, 0.0))))


def two_ends(values: Floats) -> Floats:
    """The two values (2,) about which numbers leave least squares, from their extremes on."""
    ends = np.quantile(values, [0.05, 0.95])
    for _ in range(ROUNDS):
        upper = values > ends.mean()
        if upper.all() or not upper.any():
            break
        again = np.array([values[~upper].mean(), values[upper].mean()])
        if np.array_equal(again, ends):
            break
        ends = again
    return ends


def nearest(values: Floats, ends: Floats) -> Floats:
    """The nearer of two ends, of each number."""
    return np.where(values > ends.mean(), ends[1], ends[0])


def crossings(values: Floats, ends: Floats) -> int:
    """How often numbers go from the quarter of the gap at one end to that at the other."""
    quarter = np.ptp(ends) / 4
    side = np.where(values > ends.mean() + quarter, 1, np.where(values < ends.mean() - quarter, -1, 0))
    side = side[side != 0]
    return int((np.diff(side) != 0).sum())


def _width(values: Floats, ends: Floats) -> float:
    """Between the medians of what lies nearer to either end."""
    upper = values > ends.mean()
    return float(np.median(values[upper]) - np.median(values[~upper]))
