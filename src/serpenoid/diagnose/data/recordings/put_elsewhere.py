"""A robot that is put elsewhere between its cycles: lifted and laid down again, or carried back to where it began.

In a pause the joints rest, and a body that nothing bends goes no faster than when it plays. What moves it farther was a
hand. Behind a gap of all markers it may be a track that was lost and found elsewhere: that does not turn. Where one gap
of a campaign turned a body, others moved it by hand, too. What follows is laid where the body was before, so that paths
go on as if it had lain still:

    poses after the n-th time:  T_n pose,     T_n = T_(n-1) before_n after_n^-1,     T_0 = 1

Legend: F frames, K times that it was put elsewhere.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import GYRATION, register, shapes
from serpenoid.group import compose, inverse
from serpenoid.measure.film.quality import JUMP_SIGMA, stretches
from serpenoid.measure.remark import Remark
from serpenoid.wording import listed

SPAN_S = 0.1  # poses so far apart are compared, or those of neighbouring frames
SOME = 5  # frames before and after that say where it lay


@dataclass(frozen=True)
class Puts:
    """Between which times (K,) it was moved [s], after which cycles, whether no marker was seen meanwhile, and what
    lays poses afterwards where it was before (K + 1, 3), the first nothing."""

    first: Floats
    last: Floats
    cycles: tuple[int, ...]
    hidden: tuple[bool, ...]
    back: Floats

    def laid_back(self, time: Floats, poses: Floats) -> Floats:
        """Poses (F, 3) at times (F,) as if it had lain still; NaN while it was moved."""
        found = compose(self.back[self._after(time)], poses)
        held = np.any((time[:, None] > self.first) & (time[:, None] < self.last), axis=1)
        return np.where(held[:, None], np.nan, found)

    def away(self, time: Floats, laid: Floats) -> Floats:
        """By how much poses (F, 3) that are laid back differ from where the body is (F, 3) [m, m, rad]."""
        return np.asarray(laid - compose(inverse(self.back)[self._after(time)], laid))

    def within(self, times: Floats) -> np.ndarray:
        """Whether it was moved in each of the windows (B - 1,) between times (B,)."""
        return np.asarray(((self.first[:, None] < times[1:]) & (self.last[:, None] > times[:-1])).any(axis=0))

    def words(self) -> str:
        """For people, of one that was."""
        cycles = sorted(set(self.cycles))
        which = ("cycles " if len(cycles) > 1 else "cycle ") + listed([str(n + 1) for n in cycles])
        return (
            f"after {which} it was put elsewhere: no joint moved, and it went farther than it ever goes itself; what "
            "follows is judged from where it was laid"
        )

    def _after(self, time: Floats) -> np.ndarray:
        return np.asarray(np.searchsorted(self.last, time, side="right"))


def puts_of(r: Recording, poses: Floats | None = None) -> Puts:
    """When a robot was put elsewhere; poses (F, 3) on the recording's frames, if they are known already."""
    if poses is None:
        poses = register(shapes(r.body, r.angles), r.markers)[0]
    known = np.flatnonzero(np.isfinite(poses[:, 0]) & (r.time > 0) & (r.time < r.end))
    time, poses = r.time[known], poses[known]
    found = list(_moved(r, time, poses)) if len(known) > 1 and r.schedule.pause_s > 0 else []
    back = [np.zeros(3)]
    for m in found:
        mine = r.stretch(time) == 2 * m.cycle + 1
        there = poses[mine & (time <= m.first)][-SOME:].mean(axis=0)
        here = poses[mine & (time >= m.last)][:SOME].mean(axis=0)
        back.append(compose(compose(back[-1], there), inverse(here)))
    first, last = (np.array([getattr(m, end) for m in found]) for end in ("first", "last"))
    return Puts(first, last, tuple(m.cycle for m in found), tuple(m.hidden for m in found), np.array(back))


def with_puts(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """What is said of those that were put elsewhere, and whether gaps may hide that."""
    puts = [puts_of(r) for r in recordings]
    if any(any(p.hidden) for p in puts):
        recordings = [replace(r, put_unseen=True) for r in recordings]
        puts = [puts_of(r) for r in recordings]
    pairs = zip(recordings, puts, strict=True)
    return tuple(replace(r, remarks=(*r.remarks, Remark(p.words()))) if p.cycles else r for r, p in pairs)


@dataclass(frozen=True)
class _Moved:
    """Once: from a frame to another [s], after a cycle; hidden: no marker was seen meanwhile."""

    first: float
    last: float
    cycle: int
    hidden: bool


def _moved(r: Recording, time: Floats, poses: Floats) -> Iterator[_Moved]:
    """Every time that it was moved, by the known frames (F,)."""
    span = max(SPAN_S, r.frame_s)
    later = np.searchsorted(time, time + span)
    pairs = np.flatnonzero(later < len(time))
    ends, label = later[pairs], r.stretch(time)
    took, alike = time[ends] - time[pairs], label[pairs] == label[ends]
    length = r.body.total_length_m
    way = (poses[ends] - poses[pairs]) * [1.0, 1.0, GYRATION * length]
    far, turned = np.linalg.norm(way, axis=1), np.abs(way[:, 2])
    seen, plays = took < 2 * span, label[pairs] % 2 == 0
    speed, resting = far / took, alike & ~plays
    fastest = speed[alike & plays & seen].max(initial=0.0)
    noise = r.marker_noise / np.sqrt(np.median(np.isfinite(r.markers[..., 0]).sum(axis=1)))
    chance = JUMP_SIGMA * np.sqrt(2 * way.shape[1]) * noise
    angles = r.angles_at(time)
    bent = length * np.abs(angles[ends] - angles[pairs]).sum(axis=1)  # farther no bend moves it
    put = resting & (np.where(seen, far, turned) > chance + fastest * took)
    moves = put | (resting & seen & (far > chance + bent))
    if r.put_unseen and (resting & seen).any():  # and it may have been a little way
        put |= resting & ~seen & (far > chance + bent + np.median(speed[resting & seen]) * took)
        moves |= put
    for first, stop in stretches(moves):
        if put[first:stop].any():
            begun, cycle = pairs[first], int(label[pairs[first]] // 2)
            yield _Moved(float(time[begun]), float(time[ends[stop - 1]]), cycle, not seen[first:stop].all())
