"""Whether a picture shows all directions and all places alike: an animal's edges keep their lengths, wherever they are.

    seen along the smooth chain / length there - 1 = c_k + a cos 2 phi + b sin 2 phi + g . p + q |p|^2

of every edge k in every frame (phi: its direction, p: its place). A picture that shows one direction larger, by pixels
that are not square or a camera that looks aslant, has a and b: lengths along that direction are (1 + r) / (1 - r) times
those across, r = |(a, b)|. One that shows one place larger, by a lens, by perspective, or by a zoom on the way, has g
and q. Noise across the chain would lengthen edges, and is left out. What bends shorten chords by is counted, and as
bends change as directions do, a share of it (GUESSED) may be direction. Standard errors: a jackknife over blocks of
frames. A body that stretches as it turns has such numbers, too: they are no picture's where they leave more of how
lengths vary than they explain, nor where straight links between the points, which no bending shortens, explain as much.

Legend: F frames, N points, E edges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.consistency.signals import Signal
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.measure.trial import Motion

BLOCKS = 12
SURE = 5.0  # standard errors of few blocks
LEAST = 0.01  # of a length: less moves K by a percent or less
FEWEST = 4  # points
BOTH = 6.0  # over frames: the variance of a variance and of its noise by second differences
GUESSED = 0.25  # of what chords differ from the curve by: stated
AXIS = np.radians(12.0)  # within: pixels that are not square stretch along an axis
MIDDLE = 0.05, 0.95  # of edges: where scales are told
DIRECTION, PLACE = slice(0, 2), slice(2, 5)


@dataclass(frozen=True)
class Picture:
    """What it shows larger. numbers (5,): a, b, g, q, zero where not sure; by_place: its most over its least scale."""

    numbers: Floats
    ratio: float  # of its longest direction over its shortest; 1: none is sure
    by_place: float  # of its largest place over its smallest; 1: none is sure
    longer: Floats  # (F, E) than on the smooth chain

    @property
    def direction(self) -> float:
        """Its longest one [rad] from x, in (-pi / 2, pi / 2]."""
        return float(np.arctan2(self.numbers[1], self.numbers[0]) / 2)

    def said(self) -> list[str]:
        """With what to do."""
        found = []
        if self.ratio > 1:
            found.append(f"its edges are {self.ratio - 1:.1%} longer {self._where()}. It may move K by as much")
        if self.by_place > 1:
            found.append(
                f"its edges are {self.by_place - 1:.1%} longer at one place of the picture, or at one time, than at "
                "another: by a lens, a camera that looks aslant, or a zoom? Calibrate the camera"
            )
        return found

    def _where(self) -> str:
        off = abs(self.direction)
        if min(off, np.pi / 2 - off) >= AXIS:
            return (
                f"where they point along a line at {np.degrees(self.direction):.0f} degrees to x than where they point "
                "across it: does the camera look aslant? Calibrate it"
            )
        long, short = ("x", "y") if off < AXIS else ("y", "x")
        return (
            f"where they point along {long} than where they point along {short}: are pixels not square, or does the "
            f"camera look aslant? Calibrate it, or multiply {short} by {self.ratio:.4g} in the file"
        )


def picture(body: Body, motion: Motion) -> Picture | None:
    """What a picture surely shows larger; None: nothing, as far as can be told."""
    chain = chain_vertices(body, motion.smooth_poses, motion.smooth_angles)
    along, seen = np.diff(chain, axis=1), np.diff(motion.markers, axis=1)
    size = np.linalg.norm(along, axis=2)
    longer = (seen * along).sum(axis=2) / size**2 - 1
    columns = _columns(along, (chain[:, 1:] + chain[:, :-1]) / 2)
    there = np.isfinite(longer)
    blocks = [block for block in np.array_split(np.flatnonzero(there.any(axis=1)), BLOCKS) if len(block)]
    if len(blocks) < BLOCKS or body.vertices < FEWEST:
        return None
    found, covariance = _jackknifed(columns, longer, size, blocks)
    bent = _fitted(columns, np.where(there, size / np.asarray(body.edges), np.nan), size)
    r = _of_direction(found, covariance, bent)
    by = _of_places(columns[there][:, PLACE], found[PLACE], covariance[PLACE, PLACE])
    numbers = found * np.repeat([r > 0, by > 0], [2, 3])
    shown = columns @ numbers
    rigid = (1 + longer) * size / np.asarray(body.edges)
    if not numbers.any() or _stretches(motion, longer, shown) or not _better(longer - shown, rigid):
        return None
    return Picture(numbers, (1 + r) / (1 - r), 1 + by, shown)


def _of_direction(found: Floats, covariance: Floats, bent: Floats) -> float:
    """r of numbers (5,), where it is sure beside those that bends alone would make; else 0."""
    r = float(np.hypot(*found[DIRECTION]))
    error = _error(found[DIRECTION] / max(r, np.finfo(float).tiny), covariance[DIRECTION, DIRECTION])
    guessed = GUESSED * float(np.hypot(*bent[DIRECTION]))
    return r if r > max(LEAST / 2, SURE * error, guessed) else 0.0


def _of_places(places: Floats, found: Floats, covariance: Floats) -> float:
    """By how much an edge is longer at the largest of places (n, 3) than at the smallest, where it is sure; else 0."""
    order = np.argsort(places @ found)
    least, most = (places[order[int(share * (len(order) - 1))]] for share in MIDDLE)
    by = float((most - least) @ found)
    return by if by > max(LEAST, SURE * _error(most - least, covariance)) else 0.0


def as_if_alike(body: Body, motion: Motion, found: Picture) -> Motion:
    """With markers as a picture would show them that shows all directions and places alike, but for turns."""
    along = np.diff(chain_vertices(body, motion.smooth_poses, motion.smooth_angles), axis=1)
    shifts = np.cumsum(np.nan_to_num(along * (1 / (1 + found.longer) - 1)[..., None]), axis=1)
    return replace(motion, markers=motion.markers + np.concatenate([0 * shifts[:, :1], shifts], axis=1))


def _columns(along: Floats, places: Floats) -> Floats:
    """Of edges (F, E, 2) at places (F, E, 2): (F, E, 5)."""
    twice = 2 * np.arctan2(along[..., 1], along[..., 0])
    places = places - np.nanmean(places, axis=(0, 1))
    return np.stack([np.cos(twice), np.sin(twice), *np.moveaxis(places, 2, 0), (places**2).sum(axis=2)], axis=2)


def _fitted(columns: Floats, longer: Floats, size: Floats) -> Floats:
    """Numbers (c,) of columns (F, E, c), every edge beside a constant of its own, weighted by size (F, E)."""
    there = np.isfinite(longer)
    weight = np.where(there, size**2, 0.0)
    both = np.where(there[..., None], np.concatenate([columns, longer[..., None]], axis=2), 0.0)
    means = (weight[..., None] * both).sum(axis=0) / np.maximum(weight.sum(axis=0), np.finfo(float).tiny)[:, None]
    rows = ((both - means) * np.sqrt(weight)[..., None]).reshape(-1, both.shape[2])
    return np.asarray(np.linalg.lstsq(rows[:, :-1], rows[:, -1], rcond=None)[0])


def _jackknifed(
    columns: Floats, longer: Floats, size: Floats, blocks: Sequence[NDArray[np.int64]]
) -> tuple[Floats, Floats]:
    """Numbers (c,) and their covariance, by how they differ without one of some blocks of frames."""
    kept = [np.setdiff1d(np.arange(len(longer)), block) for block in blocks]
    found = np.array([_fitted(columns[rows], longer[rows], size[rows]) for rows in kept])
    apart = found - found.mean(axis=0)
    return _fitted(columns, longer, size), (len(blocks) - 1) / len(blocks) * apart.T @ apart


def _stretches(motion: Motion, longer: Floats, shown: Floats) -> bool:
    """Whether what a picture shows (F, E) surely leaves more of how lengths (F, E) vary beyond noise than it takes."""
    some = np.isfinite(longer).any(axis=0)
    longer, shown = longer[:, some], np.where(np.isfinite(longer), shown, np.nan)[:, some]
    noise = Signal(motion.time_s, longer).noise_variance
    left, taken = np.nanvar(longer - shown, axis=0) - noise, np.nanvar(shown, axis=0)
    error = np.linalg.norm(noise) * np.sqrt(BOTH / len(longer))
    return bool(left.sum() > taken.sum() + SURE * error)


def _better(left: Floats, rigid: Floats) -> bool:
    """Whether lengths (F, E) that a picture leaves surely vary less than those of straight links between the points."""
    there = np.isfinite(left)
    some = there.any(axis=0)
    squares = [(each - np.nanmean(each, axis=0)) ** 2 for each in (left[:, some], rigid[:, some])]
    gain = (squares[1] - squares[0])[there[:, some]]
    return bool(gain.mean() > SURE * gain.std() / np.sqrt(len(gain)))


def _error(combination: Floats, covariance: Floats) -> float:
    return float(np.sqrt(combination @ covariance @ combination))
