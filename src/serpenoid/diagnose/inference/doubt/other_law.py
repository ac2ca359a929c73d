"""What another law looks like: names that take at some places what they give at others, and a number at its limit, or
the two ends of the body as these places.

A cause at a place acts there. What mends a law acts wherever the law errs, here one way and there the other. Loads of
both signs may be there all the same, and fit a law that is right. So a second witness is needed beside one name at
several places to either side of what changes nothing. Either a number of the law, eps or one of a name that makes
another law of it, that data do not keep from its limit: the law reaches no farther, so others are fitted to what it
lacks. Or places that are the body's two ends and no others: a law that shifts every vertex's force F_i along the body
by the same share d gives

    sum_i d (F_(i+1) - F_i) = d (F_N - F_1)

so all between the ends cancels, and as much is given at one as is taken at the other.
"""

from __future__ import annotations

from collections.abc import Sequence

from serpenoid.diagnose.inference.doubt.laws import makes_no_law
from serpenoid.diagnose.inference.fits.bounds import AT_BOUND, LEAST_EPS, MOST_EPS
from serpenoid.diagnose.inference.fits.finding import Named
from serpenoid.medium import Medium
from serpenoid.wording import OTHER_LAW, listed


def of_another_law(medium: Medium, vertices: int, named: Sequence[Named], ratio: tuple[float, float]) -> str:
    """Why names of the motion may stand for another law, in words; empty: they need not. ratio: 95 % of eps."""
    sides, limits = _to_either_side(named), _at_limits(medium, named, ratio)
    if sides and limits:
        return f"{listed([*sides])} of both signs, beside {listed(limits)} that may be at its limit, {OTHER_LAW}"
    ends = [name for name, places in sides.items() if places == {0, vertices - 1}]
    if ends:
        return (
            f"{listed(ends)} at both ends of the body and nowhere else, more at one and less at the other, {OTHER_LAW}"
        )
    return ""


def _to_either_side(named: Sequence[Named]) -> dict[str, set[int]]:
    """Names at several places of the body, at some to one side of what changes nothing and at some to the other; and
    these places."""
    sides: dict[tuple[str, int], dict[int, bool]] = {}
    for e in (n.effect for n in named):
        if e.place is None or e.effect.site != "medium":
            continue
        for i, (x, p) in enumerate(zip(e.coordinates, e.effect.parameters, strict=False)):
            if p.neutral is not None:
                sides.setdefault((e.name, i), {})[e.place] = bool(x > p.resting)
    return {name: {*found} for (name, _), found in sorted(sides.items()) if len({*found.values()}) > 1}


def _at_limits(medium: Medium, named: Sequence[Named], ratio: tuple[float, float]) -> list[str]:
    """Numbers of the law whose intervals reach a limit that is not the value that changes nothing."""
    low, high = medium.limits(LEAST_EPS, MOST_EPS)
    found = ["the anisotropy ratio"] if ratio[0] <= low * (1 + AT_BOUND) or ratio[1] >= high * (1 - AT_BOUND) else []
    for n in named:
        if n.effect.place is None and not makes_no_law(n.effect):
            found += [f"`{n.effect.name}`"] if _reaches_a_limit(n) else []
    return found


def _reaches_a_limit(named: Named) -> bool:
    for p in named.effect.effect.parameters:
        low, high = named.intervals[p.name]
        near = AT_BOUND * abs(p.typical)
        at_least = low is not None and low <= p.lower + near and p.lower != p.neutral
        at_most = (high is None or high >= p.upper - near) and p.upper != p.neutral
        if at_least or at_most:
            return True
    return False
