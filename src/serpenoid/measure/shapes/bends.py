"""Joint angles that a frame's own markers do not show: read by servos, or what the frames about it show.

The straight line between known values z of a joint, a before and b after [frames], misses the one between by

    e(t) = z(t) - (b z(t - a) + a z(t + b)) / (a + b),    SD^2 = max(<e^2> - s^2, s^2 (a^2 + b^2) / (a + b)^2)

<> over all t where the three are known: how smooth the motion is over such a time, the recording says itself. Of it
noise s of single values is z(t)'s own, and as much as that of the two others is there at least. Beyond the first and
the last known value the line through the two that are a and 2 a frames away is the one that is tried, alike:

    e(t) = z(t) - (2 z(t + a) - z(t + 2 a)),    SD^2 = max(<e^2> - s^2, 5 s^2)

Legend: F frames, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.measure.cells import Floats
from serpenoid.measure.clock import bridged, unwrapped
from serpenoid.measure.shapes.links import marker_angles, wrapped

LONGEST = 32  # frames that a bend is bridged over: work goes with its square


@dataclass(frozen=True)
class Bends:
    """Joint angles (F, m) [rad] and their standard deviations (F, m); NaN where nothing says them."""

    angles: Floats
    sd: Floats

    @classmethod
    def of(cls, angles: Floats | None, sd: float | None) -> Bends | None:
        """What servos read (F, m), all as well; None where there are none."""
        return None if angles is None or sd is None else cls(angles, np.where(np.isfinite(angles), sd, np.nan))

    def of_rows(self, rows: slice | NDArray[np.int64]) -> Bends:
        """Of some frames."""
        return Bends(self.angles[rows], self.sd[rows])

    def weights(self, marker_sd: float) -> Floats:
        """Of each (F, m), beside a marker's of 1; 0 where nothing is said."""
        return np.where(np.isfinite(self.angles), np.nan_to_num((marker_sd / self.sd) ** 2), 0.0)


def bends_in_time(
    body: Body,
    time_s: Floats,
    markers: Floats,
    angles: Floats,
    variance: Floats,
    determined: NDArray[np.bool_],
    beyond: bool = False,
) -> Bends:
    """Of frames that are not determined (F,), joints that their own markers (F, N, 2) do not show, by those about them;
    beyond: before the first and after the last of them, too.

    angles, variance (F, m): of frames that are determined.
    """
    shown = np.where(determined[:, None], angles, marker_angles(body, markers))
    known = np.isfinite(shown)
    if not determined.any():
        return Bends(np.full_like(shown, np.nan), np.full_like(shown, np.nan))
    at = time_s / float(np.median(np.diff(time_s)))
    shown = unwrapped(shown)
    noise = np.nanmedian(variance[determined], axis=0)
    before, after = (np.round(np.minimum(d, 2.0 * LONGEST)).astype(int) for d in _distances(at, known))
    wanted = ~known & ~determined[:, None] & (before + after <= LONGEST)
    missed = np.full_like(shown, np.nan)
    for a, b in np.unique(np.column_stack([before[wanted], after[wanted]]), axis=0).tolist():
        rows, joints = np.nonzero(wanted & (before == a) & (after == b))
        missed[rows, joints] = _missed(shown, noise, a, b)[joints]
    within = bridged(at, shown)
    if beyond:
        _extended(at, shown, noise, wanted=~known & ~determined[:, None], within=within, missed=missed)
    return Bends(np.where(np.isfinite(missed), wrapped(within), np.nan), missed)


def _extended(
    at: Floats, shown: Floats, noise: Floats, wanted: NDArray[np.bool_], within: Floats, missed: Floats
) -> None:
    """Puts in place what values (F, m) before the first and after the last known one are, and how far that is off."""
    for toward in (1, -1):  # from a film's beginning, from its end
        places, values, needed = toward * at[::toward], shown[::toward], wanted[::toward]
        for joint in np.flatnonzero(np.isfinite(values).any(axis=0)).tolist():
            first = int(np.isfinite(values[:, joint]).argmax())
            for frame in np.flatnonzero(needed[:first, joint]).tolist():
                apart = round(float(places[first] - places[frame]))
                two = first + apart
                if (
                    not 1 <= apart <= LONGEST / 2
                    or two >= len(values)
                    or round(float(places[two] - places[first])) != apart
                ):
                    continue
                within[::toward][frame, joint] = 2 * values[first, joint] - values[two, joint]
                missed[::toward][frame, joint] = _missed_beyond(values[:, joint], float(noise[joint]), apart)


def _missed_beyond(values: Floats, noise: float, apart: int) -> float:
    """SD of the error of a line through the values (F,) so many frames on, and twice as many."""
    miss = values[: -2 * apart] - 2 * values[apart:-apart] + values[2 * apart :]
    known = miss[np.isfinite(miss)]
    return float(np.sqrt(max(float((known**2).mean()) - noise, 5 * noise))) if len(known) else float("nan")


def _distances(at: Floats, known: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Frames (F, m) since each joint was known last, and until it is known next; infinite: never."""
    times = np.broadcast_to(at[:, None], known.shape)
    last = np.maximum.accumulate(np.where(known, times, -np.inf), axis=0)
    following = np.minimum.accumulate(np.where(known, times, np.inf)[::-1], axis=0)[::-1]
    return times - last, following - times


def _missed(shown: Floats, noise: Floats, before: int, after: int) -> Floats:
    """SD (m,) of the straight line's error so many frames after the last known value and before the next; noise (m,):
    variance of a value. NaN where the three are nowhere known together."""
    between = shown[before : len(shown) - after]
    line = (after * shown[: len(between)] + before * shown[before + after :]) / (before + after)
    miss = between - line
    known = np.isfinite(miss)
    count = known.sum(axis=0)
    mean = np.where(known, miss**2, 0.0).sum(axis=0) / np.maximum(count, 1)
    least = noise * (before**2 + after**2) / (before + after) ** 2
    return np.where(count > 0, np.sqrt(np.maximum(mean - noise, least)), np.nan)
