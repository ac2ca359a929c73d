"""Tracks: marker positions over time on the floor plane, as the file had them, in metres (or pixels, body lengths)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from serpenoid.errors import InputError
from serpenoid.measure.cells import LARGEST, clock
from serpenoid.wording import counted

Floats = NDArray[np.float64]
End = Literal["tail", "head"]
LengthUnit = Literal["m", "cm", "mm", "um", "px", "bl"]

LEAST_S = 1e-8  # between frames: the fastest cameras take ten million a second
DOWN = np.array([1.0, -1.0])  # image rows count downwards
METRES: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "um": 1e-6, "px": 1.0, "bl": 1.0}
LENGTHS = {name: unit for unit, names in {
    "m": ("metre", "meter"), "cm": ("centimetre", "centimeter"), "mm": ("millimetre", "millimeter"),
    "um": ("\u00b5m", "\u03bcm", "micron", "micrometre", "micrometer"), "px": ("pixel",),
}.items() for name in (unit, *names, *(f"{long}s" for long in names))}  # fmt: skip

SECONDS = {name: seconds for seconds, names in {
    1.0: ("s", "sec", "second", "seconds"), 1e-3: ("ms", "msec", "millisecond", "milliseconds"),
    60.0: ("min", "minute", "minutes"), 3600.0: ("h", "hour", "hours"),
}.items() for name in names}  # fmt: skip


class NoTime(InputError):
    """A track file that does not say when its frames were taken."""


def no_time(path: Path, why: str) -> NoTime:
    """With the remedy."""
    return NoTime(f"{path}: {why}: give `frames_per_second` in [motion].")


def upright(floor: Floats, unit: str) -> Floats:
    """Points (..., 2) of a file that does not say which way its y axis points: of pixels down, else up."""
    return floor * DOWN if unit == "px" else floor


def in_places(count: int) -> tuple[str, ...]:
    """Names of points that a file gives none, by their places in it."""
    return tuple(f"vertex_{k}" for k in range(count))


@dataclass(frozen=True)
class Tracks:
    """F frames of M named markers. NaN: not seen. `scale_known` is False for pixels."""

    time_s: Floats  # (F,)
    names: tuple[str, ...]  # (M,)
    floor: Floats  # (F, M, 2) [m, or px if not scale_known]
    source: str
    unlabelled: tuple[bool, ...]  # (M,): a fragment without identity
    scale_known: bool = True
    space: Floats | None = None  # (F, M, 3) in the file's own axes, where it has three
    first_point: End | None = None  # which end of the body the file says its first point is
    in_order: bool = True  # False: the file does not say in which order its points are along the body

    def __post_init__(self) -> None:
        frames, markers = len(self.time_s), len(self.names)
        if self.floor.shape != (frames, markers, 2):
            raise InputError(
                f"{self.source}: {self.floor.shape} positions for {counted(frames, 'frame')} and {markers} markers."
            )
        if not np.isfinite(self.floor).any():
            raise InputError(
                f"{self.source}: no marker is seen in any frame: all cells are empty, or zeros that say the same."
            )
        if np.nanmax(np.abs(self.floor)) > LARGEST:
            raise InputError(
                f"{self.source}: a position is {np.nanmax(np.abs(self.floor)):.3g}, which is no measurement."
            )
        if (np.diff(self.time_s) < LEAST_S).any():
            first = int((np.diff(self.time_s) < LEAST_S).argmax())
            raise InputError(
                f"{self.source}: frames {first + 1} and {first + 2} are less than {LEAST_S:g} s apart, which no camera "
                "is. Are `time_unit` and `frames_per_second` right?"
            )

    @property
    def seen(self) -> NDArray[np.bool_]:
        """Shape (F, M)."""
        return np.asarray(np.isfinite(self.floor).all(axis=2))

    @property
    def frame_s(self) -> float:
        """Median time between frames."""
        return float(np.median(np.diff(self.time_s))) if len(self.time_s) > 1 else 0.0

    def between(self, from_s: float | None, to_s: float | None) -> Tracks:
        """The frames of an interval of the recording's own clock."""
        keep = np.ones(len(self.time_s), dtype=bool)
        if from_s is not None:
            keep &= self.time_s >= from_s
        if to_s is not None:
            keep &= self.time_s <= to_s
        if keep.sum() < 2:
            first, last = self.time_s[0], self.time_s[-1]
            raise InputError(
                f"{self.source}: under 2 frames in from_s..to_s (it runs {clock(first)}..{clock(last)} s)."
            )
        return self.of_frames(keep)

    def of_frames(self, keep: NDArray[np.bool_]) -> Tracks:
        """Some of the frames (F,)."""
        space = None if self.space is None else self.space[keep]
        return replace(self, time_s=self.time_s[keep], floor=self.floor[keep], space=space)

    def without(self, hidden: NDArray[np.bool_]) -> Tracks:
        """With these points (F, M) as not seen."""
        cells = hidden[..., None]
        space = None if self.space is None else np.where(cells, np.nan, self.space)
        return replace(self, floor=np.where(cells, np.nan, self.floor), space=space)


def floor_plane(positions: Floats, up_axis: str) -> Floats:
    """(..., 3) file axes to (..., 2) floor, right-handed seen from above: z up -> (x, y)."""
    return positions[..., {"y": [2, 0], "z": [0, 1], "x": [1, 2]}[up_axis]]


def heights(positions: Floats, up_axis: str) -> Floats:
    """(..., 3) file axes to what lies along the upward one (...)."""
    return positions[..., "xyz".index(up_axis)]
