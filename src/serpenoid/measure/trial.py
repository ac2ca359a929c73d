"""A trial: one recording, aligned with what was commanded, as frozen values in body lengths and seconds.

Legend: F frames, N vertices, m joints.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.measure.animals.beat import Beat, beat
from serpenoid.measure.cells import Floats, listed
from serpenoid.measure.clock import interpolate
from serpenoid.measure.consistency.hypotheses import ROLLS
from serpenoid.measure.film.quality import Gap, Jump, find_gaps, find_holes, find_jumps
from serpenoid.measure.logs import PowerLog, ServoLog
from serpenoid.measure.remark import Remark
from serpenoid.measure.schedule import Schedule, start_by_log, start_by_shape
from serpenoid.measure.servo_alignment import (
    MIN_CORRELATION,
    ServoAlignment,
    align_commands,
    align_servo,
    assumed,
    joints_unseen,
)
from serpenoid.measure.shapes.chain import ChainEstimate, completed, estimate_about, estimate_chain
from serpenoid.measure.shapes.principal_bends import smooth_curves
from serpenoid.measure.shapes.smooth import smooth_states
from serpenoid.measure.shapes.strays import without_strays
from serpenoid.measure.shapes.stretches import Stretches, stretches, unstretched
from serpenoid.measure.shapes.wild import beyond_bridge, said_of_hidden

REPEATED = 2  # times that stretches are taken off: along the chain as it is with them, and as it is without
SHORTEST_RUN = 8  # frames: less is no motion


@dataclass(frozen=True)
class Motion:
    """What the cameras saw, as a rigid chain on the recording's own time grid."""

    time_s: Floats  # (F,)
    markers: Floats  # (F, N, 2) as seen, NaN hidden
    points: Floats  # (F, N, 2) what the chain is fitted to: the same, of an animal as if it did not stretch
    poses: Floats  # (F, 3) x, y [body lengths], heading [rad]
    joint_angles: Floats  # (F, m)
    covariance: Floats  # (F, 3 + m, 3 + m) of poses and joint angles; large in directions that nothing measured
    vertices: Floats  # (F, N, 2) of the rigid chain
    smooth_poses: Floats  # (F, 3) a smooth path through them: where to linearise, what to resimulate
    smooth_angles: Floats  # (F, m)
    measured: NDArray[np.bool_]  # (F,) determined by this frame's own data
    interpolated: NDArray[np.bool_]  # (F,) a short gap, filled
    marker_sd: float  # [body lengths]
    gaps: tuple[Gap, ...]
    jumps: tuple[Jump, ...]
    runs: tuple[slice, ...]  # frames between long gaps and whole-body jumps
    relabelled: tuple[tuple[str, int], ...]
    unused: tuple[str, ...]
    stretches: Stretches  # of an animal

    @cached_property
    def beat(self) -> Beat | None:
        """How it bends, if it repeats."""
        return beat(self)

    @property
    def known(self) -> NDArray[np.bool_]:
        """Measured or interpolated."""
        return self.measured | self.interpolated

    @property
    def hidden_share(self) -> float:
        """Share of positions that were not seen, of vertices that are seen at all."""
        seen = np.isfinite(self.markers[..., 0])
        return float(1 - seen[:, seen.any(axis=0)].mean()) if seen.any() else 1.0

    @property
    def never_seen(self) -> NDArray[np.int64]:
        """Vertices that no frame shows; inside a link they may have no marker."""
        return _never_seen(self.markers)

    @property
    def hidden_said(self) -> str:
        """Both in words."""
        never = len(self.never_seen)
        unmarked = f"; {never} of {self.markers.shape[1]} vertices are never seen" if never else ""
        return f"{self.hidden_share:.1%} of markers hidden{unmarked}"


@dataclass(frozen=True)
class Passage:
    """Frames first..last (inclusive) of one cycle (with half its pause), or of a whole unscheduled recording."""

    cycle: int
    first: int
    last: int

    @property
    def frames(self) -> slice:
        return slice(self.first, self.last + 1)


@dataclass(frozen=True)
class Trial:
    """One recording; everything that was not recorded is None."""

    name: str
    gait: str
    body: Body
    metres: float | None  # per body length; None where the scale is unknown (pixels)
    schedule: Schedule | None  # on the cameras' clock (the servo log's where there is no motion)
    start_source: str  # servo log | shape | none
    motion: Motion | None
    servo: ServoAlignment | None
    servo_log: ServoLog | None
    power_log: PowerLog | None
    passages: tuple[Passage, ...]
    dissipation_coefficient: float | None
    remarks: tuple[Remark, ...]
    scale_sd: float = 0.0  # standard error, as a share, of a scale that is found from the film; else 0

    @property
    def notes(self) -> tuple[str, ...]:
        """The words of all remarks."""
        return tuple(remark.words for remark in self.remarks)

    def displacement(self, passage: Passage) -> float:
        """Distance of the centroid over a passage [body lengths]."""
        if self.motion is None:
            return float("nan")
        first, last = self.motion.poses[passage.first], self.motion.poses[passage.last]
        return float(np.hypot(*(last - first)[:2]))


def build_motion(
    body: Body, time_s: Floats, markers: Floats, log: ServoLog | None, labels: tuple, like: Motion | None = None,
    told: Schedule | None = None,
) -> tuple[Motion, ServoAlignment | None, list[str]]:  # fmt: skip
    """Fit the chain (with the servos where they help), fill short gaps, look for jumps.

    like: the same recording, cut where another body's fit cut it. told: what joints that neither markers nor a log show
    are taken to do.
    """
    notes: list[str] = []
    filmed = markers
    estimate = estimate_chain(body, markers)
    strays: tuple[Jump, ...] = ()
    never = _never_seen(markers)
    # the polygon of the others fits as well with such a joint bent to the other side
    either_way = sorted({*never.tolist()} & {*body.joint_vertices})
    if not either_way:
        markers, strays = without_strays(body, time_s, markers, estimate)
        estimate = estimate_chain(body, markers) if strays else estimate
    servo = helped = None
    if log is not None:
        servo, complaint = align_servo(body, estimate, markers, time_s, log)
        helped, notes = servo, notes + complaint
    elif told is not None and (unseen := joints_unseen(body, markers)):
        helped, complaint = align_commands(body, estimate, markers, time_s, told)
        notes += complaint if helped is None else [assumed(unseen)]
    if helped is not None:
        estimate, by_markers = _helped(body, markers, helped, estimate), estimate
        if either_way:
            markers, strays = without_strays(body, time_s, markers, estimate)
            estimate = _helped(body, markers, helped, by_markers) if strays else estimate
    points, stretched = markers, Stretches(np.zeros((len(time_s), body.vertices - 1)))
    if helped is None:
        if body.is_animal:
            stretched = stretches(body, time_s, markers)
        for _ in range(REPEATED if stretched.any else 0):
            points = unstretched(body, markers, stretched, estimate.vertices)
            estimate = estimate_chain(body, points)
        estimate = completed(body, points, time_s, estimate)
    cuts = _cuts(estimate, markers, time_s, strays) if like is None else (like.gaps, like.jumps, like.runs)
    if (helped is None and either_way) or not cuts[2]:
        raise InputError(
            f"in no {SHORTEST_RUN} successive frames are enough markers seen to know the chain's shape"
            f"{_counted(never)}. Where a servo log or a joint table is given that fits them, three markers are enough."
        )
    holes = find_holes(time_s)
    if len(holes):
        longest = float((time_s[holes] - time_s[holes - 1]).max())
        places = "1 place" if len(holes) == 1 else f"{len(holes)} places"
        notes.append(f"frames are missing from the file in {places}, for {longest:.3g} s at most")
    motion = _motion(body, time_s, (markers, points), helped, estimate, cuts, (*labels, stretched))
    notes += said_of_hidden(filmed, motion.markers, time_s) if helped is None else []
    return motion, servo, notes


def _helped(body: Body, markers: Floats, servo: ServoAlignment, by_markers: ChainEstimate) -> ChainEstimate:
    """The fit to markers and what servos did together; noise and what is surely known are those of markers alone."""
    sd = by_markers.marker_sd if by_markers.determined.any() else None
    return estimate_chain(body, markers, servo.angles, servo.frame_sd, sd, by_markers.determined)


def _never_seen(markers: Floats) -> NDArray[np.int64]:
    return np.flatnonzero(~np.isfinite(markers[..., 0]).any(axis=0))


def _counted(never: NDArray[np.int64]) -> str:
    names = ", ".join(str(k) for k in never)
    return f" (never seen: vertices {names}; 0 is the tail)" if len(never) else ""


def _cuts(estimate: ChainEstimate, markers: Floats, time_s: Floats, strays: tuple[Jump, ...]) -> tuple:
    """Gaps, jumps, and the runs of frames between them; strays: markers that were left out, which cut nothing."""
    gaps = find_gaps(estimate.determined, time_s, np.asarray(np.isfinite(markers[..., 0]).any(axis=1)))
    jumps = find_jumps(estimate.poses, estimate.covariance, estimate.marker_residual, estimate.marker_sd, time_s)
    jumps = tuple(sorted((*jumps, *strays), key=lambda jump: jump.frame))
    return gaps, jumps, _runs(gaps, jumps, find_holes(time_s), len(time_s))


def _motion(
    body: Body,
    time_s: Floats,
    seen: tuple[Floats, Floats],
    servo: ServoAlignment | None,
    first: ChainEstimate,
    cuts: tuple,
    labels,
) -> Motion:
    """The final estimate, linear about the smooth path, on all frames of all runs; seen: markers, and what of them the
    chain is fitted to."""
    smooth_poses, smooth_angles = _smooth_runs(body, first, time_s, cuts[2])
    known = np.isfinite(smooth_poses[:, 0])
    wild = beyond_bridge(body, seen[1], smooth_poses, smooth_angles, known & ~first.determined, first.marker_sd)
    seen = np.where(wild[..., None], np.nan, seen[0]), np.where(wild[..., None], np.nan, seen[1])
    poses, angles, covariance, vertices = (
        np.full((len(time_s), *shape), np.nan)
        for shape in ((3,), (body.joint_count,), (3 + body.joint_count,) * 2, (body.vertices, 2))
    )
    readings = (None, None) if servo is None else (servo.angles[known], servo.frame_sd)
    about = estimate_about(body, seen[1][known], smooth_poses[known], smooth_angles[known], first.marker_sd, *readings)
    poses[known], angles[known], covariance[known] = about.poses, about.joint_angles, about.covariance
    vertices[known] = about.vertices
    return Motion(
        time_s, *seen, poses, angles, covariance, vertices, smooth_poses, smooth_angles,
        known & first.determined, known & ~first.determined, first.marker_sd, *cuts, *labels,
    )  # fmt: skip


def schedule_start(
    schedule: Schedule, log: ServoLog | None, servo: ServoAlignment | None, motion: Motion | None
) -> tuple[Schedule, str, list[str]]:
    """The schedule with its start on the recording's clock, and where that came from."""
    by_log = None
    if log is not None:
        by_log = start_by_log(log, schedule.cycle_duration_s, schedule.pause_s, len(schedule.table))
    if motion is None:
        return (schedule, "none", []) if by_log is None else (replace(schedule, start_s=by_log), "servo log", [])
    if by_log is not None and servo is not None:
        return replace(schedule, start_s=by_log + servo.offset.offset_s), "servo log", []
    found = start_by_shape(schedule, motion.time_s, motion.joint_angles)
    if found is None or found.correlation < MIN_CORRELATION:
        seen = "no overlap" if found is None else f"correlation {found.correlation:.2f}"
        return schedule, "none", [f"the commanded table is not found in the recording ({seen})"]
    return replace(schedule, start_s=found.offset_s), "shape", []


def log_covers(schedule: Schedule, log_s: Floats) -> list[str]:
    """What of a schedule a log at times (R,) on its clock leaves out, by more than a start is unsure."""
    least, found = schedule.cycle_duration_s / ROLLS, []
    late, early = log_s[0] - schedule.start_s, schedule.start_s + schedule.moving_s - log_s[-1]
    if late > least:
        found.append(f"begins {late:.3g} s after the first command")
    if early > least:
        found.append(f"ends {early:.3g} s before the last")
    return [f"its servo log {listed(found)}: there joints are what the markers show"] if found else []


def cut_passages(
    motion: Motion, schedule: Schedule | None, log: ServoLog | None = None
) -> tuple[tuple[Passage, ...], list[str]]:
    """Frames of each cycle; without a schedule the whole recording is one passage, whatever gaps it has.

    log: where its labels say that play ended within a cycle, that one is left out.
    """
    if schedule is None:
        return (Passage(0, motion.runs[0].start, motion.runs[-1].stop - 1),), []
    passages, notes = [], []
    outside: list[int] = []
    stopped = None if log is None else log.stopped_in(len(schedule.table))
    if stopped is not None and stopped < schedule.cycles:
        notes.append(f"the servo log says that play was stopped within cycle {stopped + 1}: it is left out")
    for cycle in range(schedule.cycles if stopped is None else min(schedule.cycles, stopped)):
        begin, end = schedule.window_s(cycle)
        inside = np.flatnonzero((motion.time_s >= begin - 1e-9) & (motion.time_s <= end + 1e-9) & motion.known)
        frame = float(np.median(np.diff(motion.time_s)))
        if (
            len(inside) < 8
            or motion.time_s[inside[0]] > begin + 3 * frame
            or motion.time_s[inside[-1]] < end - 3 * frame
        ):
            outside.append(cycle)
            continue
        if not motion.known[inside[0] : inside[-1] + 1].all():
            notes.append(
                f"cycle {cycle + 1} has a long gap: its displacement is used, its steps across the gap are not"
            )
        passages.append(Passage(cycle, int(inside[0]), int(inside[-1])))
    return tuple(passages), [*(_left_out(run) for run in _successive(outside)), *notes]


def _successive(cycles: list[int]) -> list[list[int]]:
    """Cut wherever one is missing between two."""
    cuts = 1 + np.flatnonzero(np.diff(cycles) > 1)
    return [run.tolist() for run in np.split(np.array(cycles, dtype=int), cuts) if len(run)]


def _left_out(cycles: list[int]) -> str:
    """A note on successive cycles."""
    if len(cycles) == 1:
        return f"cycle {cycles[0] + 1} is not wholly in the recording: left out"
    return f"cycles {cycles[0] + 1} to {cycles[-1] + 1} are not wholly in the recording: left out"


def _runs(gaps: tuple[Gap, ...], jumps: tuple[Jump, ...], holes: np.ndarray, frames: int) -> tuple[slice, ...]:
    """Frames between long gaps, holes of the file and whole-body jumps; a run neither begins nor ends in a gap."""
    known = np.ones(frames, dtype=bool)
    for gap in gaps:
        if not gap.short or gap.first == 0 or gap.last == frames - 1:
            known[gap.first : gap.last + 1] = False
    cuts = {jump.frame for jump in jumps if jump.vertex is None} | set(holes.tolist())
    runs, first = [], 0
    for frame in range(1, frames + 1):
        if frame == frames or frame in cuts or known[frame] != known[frame - 1]:
            if known[first] and frame - first >= SHORTEST_RUN:
                runs.append(slice(first, frame))
            first = frame
    return tuple(runs)


def _smooth_runs(body: Body, estimate: ChainEstimate, time_s: Floats, runs: tuple[slice, ...]) -> tuple[Floats, Floats]:
    """Smooth poses and joint angles on every frame of every run (short gaps bridged); NaN elsewhere.

    Where a run of another body begins or ends with frames that this one leaves open, the next that is known is held.
    """
    poses, angles = np.full_like(estimate.poses, np.nan), np.full_like(estimate.joint_angles, np.nan)
    smoothed = smooth_curves if body.is_animal else smooth_states
    for run in runs:
        rows = np.flatnonzero(estimate.determined[run]) + run.start
        smooth = smoothed(time_s[rows], estimate.poses[rows], estimate.joint_angles[rows], estimate.covariance[rows])
        asked = np.clip(time_s[run], time_s[rows[0]], time_s[rows[-1]])
        for target, values in zip((poses, angles), smooth, strict=True):
            target[run] = interpolate(time_s[rows], values, asked)
    return poses, angles
