"""Is it one body in all trials, and as long as it is said to be?

Where a campaign gives no lengths, each trial's own are laid beside the others':

    a = median over frames of ( median over edges of log(distance / the campaign's edge) )        of every trial

Two trials whose a differ by more than a calibrated camera explains (`geometry.SCALE_SD`) and the scatter of their own
parts are two bodies: lengths estimated from both together are those of neither.

Where it gives them, a film's scale shows in all edges alike, a marker beside its place in some:

    r = log(d / edge) of every edge, d^2 = median^2 - scatter^2 (noise across an edge lengthens it)
    gain = E / 2 log(1 + mean(r)^2 / var(r))        E edges that differ among each other by chance, scale free or not
    told: gain > ODDS, and mean(r) is more than noise was found to lengthen an edge by

Camera and ruler differ by up to `geometry.SCALE_SD`, so that is no contradiction; but it is counted as noise of markers
and moves every fit: it is said. So is one edge that is off while the others agree: its r lies farther from the others'
mean than their scatter explains (Student's t, any of E edges). A marker beside its place moves both edges that meet in
it by as many metres: where neighbours of such an edge certainly are as said, its length is wrong, and that is a
contradiction. Of a much longer neighbour too little is seen to say so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import ndtri, stdtr

from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.geometry import SCALE_SD
from serpenoid.measure.consistency.rivals import CERTAIN, ODDS
from serpenoid.wording import listed

NORMAL_MAD = float(ndtri(0.75))  # median absolute deviation over standard deviation
STEADY = 1.5  # times the scatter of any other edge: what noise makes; a marker 7 mm off a joint makes nine times
FAR_OFF = 0.2  # of an edge: markers are not put on as badly as that
PARTS = 4  # of a recording, whose scales show how far postures and noise move one


@dataclass(frozen=True)
class Longer:
    """`trial` is `factor` times as long as `other`, the middle one; `gain`: by how much another body is likelier."""

    trial: str
    other: str
    factor: float
    gain: float


def other_bodies(vertices: Mapping[str, Floats], edges: Floats) -> list[Longer]:
    """Trials (F, N, 2) whose body is another than in the middle one's, by the campaign's edges (N - 1,)."""
    scales = {trial: found for trial, points in vertices.items() if (found := _scale(points, edges)) is not None}
    if len(scales) < 2:
        return []
    ordered = sorted(scales, key=lambda trial: scales[trial])
    middle = ordered[(len(ordered) - 1) // 2]
    longer = []
    for trial, (scale, scatter) in scales.items():
        apart = scale - scales[middle][0]
        gain = 0.5 * apart**2 / (SCALE_SD**2 + scatter**2 + scales[middle][1] ** 2) - float(np.log(len(scales)))
        if gain > ODDS:
            longer.append(Longer(trial, middle, float(np.exp(apart)), gain))
    return longer


def wrong_edge(found: Shown, stated: Floats, names: Sequence[str], all_marked: bool) -> tuple[str, str, float] | None:
    """Words, cure and certainty [nats] where films show one of M - 1 stated distances other than said, which no marker
    beside its place explains."""
    one = one_longer(found)
    if one is None:
        return None
    (k, off), (_, _, chance) = one, _worst(found)
    certainty = -float(np.log(max(chance, np.finfo(float).tiny)))
    if certainty < ODDS or not (_unmoved(found, stated, k, off, k - 1) and _unmoved(found, stated, k, off, k + 1)):
        return None
    how = f"{100 * abs(off):.2g} % {'farther apart' if off > 0 else 'closer'}"
    words = (
        f"its film shows `{names[k]}` and `{names[k + 1]}` {how} "
        f"than `edge_lengths` says ({stated[k]:.4g}), and other links as said: a marker beside its place would move two"
    )
    shown = stated[k] * (1 + off)  # by the scale of the others
    return words, f"set what `edge_lengths` has between them to {shown:.4g}{_left_out(all_marked)}", certainty


def _unmoved(found: Shown, stated: Floats, k: int, off: float, neighbour: int) -> bool:
    """Whether a neighbour of edge k is certainly as said beside the others, which it would not be if a marker between
    the two stood beside its place: on their line it moves this one by as many metres (a share `off` of edge k), of
    which half would be seen; across it, the distance swings with the joint, and scatters more than others do."""
    if not 0 <= neighbour < len(found.known) or not found.known[neighbour]:
        return False
    at = np.cumsum(found.known) - 1
    others = np.delete(found.longer, [at[k], at[neighbour]])
    if len(others) < 2:
        return False
    moved = abs(off) * stated[k] / stated[neighbour] / 2 - abs(float(found.longer[at[neighbour]] - others.mean()))
    scatter = max(float(others.std(ddof=1)), np.finfo(float).tiny) * np.sqrt(1 + 1 / len(others))
    swing = np.sqrt(found.noise) * stated[found.known]
    steady = swing[at[neighbour]] < STEADY * np.delete(swing, [at[k], at[neighbour]]).max()
    return bool(steady and stdtr(len(others) - 1, -moved / scatter) < 1 - CERTAIN)


def beside_film(found: Shown, stated: Floats, names: Sequence[str], all_marked: bool) -> str:
    """What is said where films show all or one of M - 1 stated distances other than said, or ""."""
    share, one = all_longer(found), one_longer(found)
    if share is not None:
        what = _all(share)
    elif one is not None:
        (k, off), more = one, "longer" if one[1] > 0 else "shorter"
        where = f"from `{names[k]}` to `{names[k + 1]}` (`edge_lengths`: {stated[k]:.4g} m)"
        what = f"{where} it is {100 * abs(off):.2g} % {more} in the film, other links are as said: "
        what += "one of the two is off, or a marker beside its place"
    elif several := _several(found, stated, names):
        what = f"its film shows links of other lengths than `edge_lengths`: {several}; measure them"
    else:
        return ""
    return f"{what}. Left so it counts as marker noise and moves what is fitted. Correct it{_left_out(all_marked)}"


def _several(found: Shown, stated: Floats, names: Sequence[str]) -> str:
    """Which edges differ from the usual one by more than a marker that was put on badly makes of them; else ""."""
    if len(found.longer) < 3:
        return ""
    apart, shown = found.longer - np.median(found.longer), stated[found.known] * np.exp(found.longer)
    off = [
        f"`{names[k]}` to `{names[k + 1]}` {shown[at]:.4g} m, not {stated[k]:.4g}"
        for at, k in enumerate(np.flatnonzero(found.known).tolist())
        if abs(apart[at]) > FAR_OFF
    ]
    return listed(off) if len(off) > 1 else ""


def turned(found: Shown, stated: Floats, all_marked: bool) -> str:
    """What is said where films show distances (N - 1,) as stated from the other end, and other than as stated, or "".

    gain = E / 2 log(var(r) / var(r turned)): edges differ among each other by chance, scale free.
    """
    if not all_marked or not found.known.all() or len(stated) < 2:
        return ""
    back = found.longer + np.log(stated / stated[::-1])
    spread = float(found.longer.std())
    gain = len(stated) * np.log(max(spread, np.finfo(float).tiny) / max(float(back.std()), np.finfo(float).tiny))
    if gain < ODDS or spread < SCALE_SD:
        return ""
    return (
        "its film shows links as long as `edge_lengths` says from head to tail: turn `edge_lengths` round, or see "
        "whether `markers` begin at the tail. Left so it counts as marker noise and moves what is fitted"
    )


def taken_for_scale(share: float) -> str:
    """What is said where films are laid in the scale in which links are as long as stated."""
    return (
        f"{_all(share)}. Taken for the film's scale: if `edge_lengths` are off, so are lengths and speeds here, by as "
        "much. Correct it"
    )


def _all(share: float) -> str:
    more = "longer" if share > 0 else "shorter"
    return f"all links are {100 * abs(share):.2g} % {more} in the film than `edge_lengths`: one of the two is off"


def _left_out(all_marked: bool) -> str:
    return ", or leave `edge_lengths` out (not for `diagnose`): the film then tells them" if all_marked else ""


@dataclass(frozen=True)
class Shown:
    """Of which edges (N - 1,) lengths are known both ways; of these log(shown / said), and the relative variance by
    noise."""

    known: np.ndarray
    longer: Floats
    noise: Floats

    @classmethod
    def of(cls, vertices: Sequence[Floats], edges: Floats) -> Shown:
        """By recordings (F, N, 2) of edges that are said to have these lengths (N - 1,) [m]; NaN: not said."""
        distance = np.concatenate([np.linalg.norm(np.diff(points, axis=1), axis=2) for points in vertices])
        known = np.isfinite(distance).any(axis=0) & np.isfinite(edges)
        middle = np.nanmedian(distance[:, known], axis=0)
        scatter = np.nanmedian(np.abs(distance[:, known] - middle), axis=0) / NORMAL_MAD
        noise = scatter**2 / middle**2
        return cls(known, np.log(middle * np.sqrt(np.maximum(1 - noise, 0.5)) / edges[known]), noise)


def all_longer(found: Shown) -> float | None:
    """By which share all edges are longer than they are said to be; None: they agree, or differ among each other as
    much."""
    longer = found.longer
    if len(longer) < 2:
        return None
    mean = float(longer.mean())
    gain = len(longer) / 2 * np.log1p(mean**2 / max(float(longer.var()), np.finfo(float).tiny))
    return float(np.expm1(mean)) if gain > ODDS and abs(mean) > found.noise.max() / 2 else None


def one_longer(found: Shown) -> tuple[int, float] | None:
    """Which one edge is longer than it is said to be, and by which share, if the others agree."""
    if len(found.longer) < 3:
        return None
    worst, apart, chance = _worst(found)
    others = np.delete(found.longer, worst)
    agree = np.abs(others - others.mean()).max() < SCALE_SD
    if chance > 1 - CERTAIN or abs(apart) < SCALE_SD or not agree:
        return None
    return int(np.flatnonzero(found.known)[worst]), float(np.expm1(apart))


def _worst(found: Shown) -> tuple[int, float, float]:
    """The edge that differs most from the others, by how much, and how likely chance makes as much of any of them."""
    longer = found.longer
    worst = int(np.abs(longer - np.median(longer)).argmax())
    others = np.delete(longer, worst)
    apart = float(longer[worst] - others.mean())
    scatter = max(float(others.std(ddof=1)), np.finfo(float).tiny) * np.sqrt(1 + 1 / len(others))
    return worst, apart, float(len(longer) * 2 * stdtr(len(others) - 1, -abs(apart) / scatter))


def _scale(points: Floats, edges: Floats) -> tuple[float, float] | None:
    """Log scale of a trial against `edges`, and how far its parts scatter about it; None: no neighbours are seen."""
    distance = np.linalg.norm(np.diff(points, axis=1), axis=2)
    ratio = np.log(np.where(distance > 0, distance, np.nan) / edges)
    ratio = ratio[np.isfinite(ratio).any(axis=1)]
    if len(ratio) < PARTS:
        return None
    every = np.nanmedian(ratio, axis=1)
    return float(np.median(every)), float(np.std([np.median(part) for part in np.array_split(every, PARTS)]))
