"""Level: points in space are measured in the plane that their heights show, where that is not the floor of `up_axis`.

Cameras that were set up on another plane than the floor, or a floor that slopes, show a body from aslant: what it does
down the slope is shorter by the cosine. Heights of markers tell,

    z(f, k) = h_k + a x(f, k) + b y(f, k) + e        h_k: how high marker k is put

by least squares, if that is nearly all that heights do: parts that a body lifts as it bends go with the place, too.
How unsure the slopes a, b are, blocks of successive frames say: what lasts in e counts once. A direction in which they
are beyond chance is turned into the plane, another is left as it is. To turn for nothing costs half the square of the
angle of a length.

Legend: F frames, M markers.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from serpenoid.measure.cells import Floats
from serpenoid.measure.tracks import Tracks, floor_plane, heights

BLOCKS = 10
UP = 2  # of the axes along the floor and up
SURE = 5.0  # standard errors, which ten blocks know by a fifth: 7 of 10,000 are beyond by chance (Student's t)
ROUNDED = 1e-9  # of a coordinate: what moves by less is the last digits of a number
ALL_BUT = 0.02  # of what heights vary by is left beyond noise: more is no plane
FLAT = 0.01  # rad: lengths change by 5e-5, less than a ruler shows


def levelled(tracks: Tracks, up_axis: str) -> tuple[Tracks, str]:
    """Tracks in the plane of their floor, and by how much it is tilted; unchanged and '' where nothing says it is."""
    if tracks.space is None:
        return tracks, ""
    flat, height = floor_plane(tracks.space, up_axis), heights(tracks.space, up_axis)
    slopes = _slopes(flat, height)
    angle = float(np.arctan(np.hypot(*slopes)))
    if angle < FLAT:
        return tracks, ""
    return replace(tracks, floor=_turned(flat, height, slopes)), (
        f"its markers move in a plane that is tilted by {np.degrees(angle):.1f} degrees to the floor that `up_axis` "
        "tells, and are measured in that plane. Were the cameras set up on another plane than the floor, or does it "
        "slope?"
    )


def _turned(flat: Floats, height: Floats, slopes: Floats) -> Floats:
    """Points (F, M, 2) of a plane that rises with slopes (2,), laid flat about the level line through the origin."""
    rise = float(np.hypot(*slopes))
    uphill = slopes / rise
    along = flat @ uphill
    return np.asarray(flat + ((along + rise * height) / np.hypot(1.0, rise) - along)[..., None] * uphill)


def _slopes(flat: Floats, height: Floats) -> Floats:
    """Slopes (2,) of the plane in which markers at places (F, M, 2) and heights (F, M) move, in the directions in which
    they are sure; else, and where another axis is nearer to being up, 0."""
    points = np.concatenate([flat, height[..., None]], axis=2)
    seen = np.isfinite(points).all(axis=2, keepdims=True)
    points = np.where(seen, points, 0.0)
    points = np.where(seen, points - points.sum(axis=0) / np.maximum(seen.sum(axis=0), 1), 0.0)
    blocks = np.stack([np.einsum("fki,fkj->ij", p, p) for p in np.array_split(points, BLOCKS)])
    whole = blocks.sum(axis=0)
    sizes, axes = np.linalg.eigh(whole)
    moves = sizes[1] / seen.sum() > (np.nanmax(np.abs(flat)) * ROUNDED) ** 2
    if np.abs(axes[:, 0]).argmax() != UP or sizes[1] <= sizes[0] or not moves:
        return np.zeros(2)
    found = np.linalg.solve(whole[:2, :2], whole[:2, 2])
    second = np.diff(height - flat @ found, n=2, axis=0)
    known = np.isfinite(second)
    noise = float((second[known] ** 2).mean()) / 6 if known.any() else 0.0
    if whole[2, 2] - found @ whole[:2, 2] - noise * seen.sum() > ALL_BUT * whole[2, 2]:
        return np.zeros(2)
    off = blocks[:, :2, 2] - blocks[:, :2, :2] @ found  # what each block's heights are off, summed by place
    away = np.linalg.solve(whole[:2, :2], off.T)  # (2, blocks)
    variance, directions = np.linalg.eigh(away @ away.T)
    along = directions.T @ found
    return np.asarray(directions @ np.where(along**2 > SURE**2 * variance, along, 0.0))
