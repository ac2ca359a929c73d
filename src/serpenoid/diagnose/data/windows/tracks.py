"""Tracks: a recording's trials on meshes of their own, cut into windows.

Each cycle is cut into windows, each pause into two. Marker noise enters at their boundaries only, where poses are
averaged over a few frames about the predicted path; and so does the rounding of servos' readings.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.recordings.put_elsewhere import Puts, puts_of
from serpenoid.diagnose.data.recordings.recording import WINDOWS_PER_CYCLE, Recording
from serpenoid.diagnose.data.shapes.geometry import GYRATION, register, shapes
from serpenoid.diagnose.data.windows.meshes import COARSER, Mesh, evenly, mesh_of
from serpenoid.diagnose.data.windows.readings_noise import by_readings, of_shapes
from serpenoid.diagnose.data.windows.windows import Track, begun_anew, predicted_path
from serpenoid.group import compose, inverse, relative
from serpenoid.measure.clock import bridged
from serpenoid.measure.film.quality import ONE_MISSING
from serpenoid.measure.shapes.links import marker_angles
from serpenoid.model import Model
from serpenoid.parallel import in_processes

HALF_AVERAGE_S, HALF_AVERAGE_FRAMES = 0.045, 2.5  # poses at a boundary: frames within this distance, or so many,
MOST_OF_WINDOW = 0.4  # but neighbouring boundaries share none
LEAST_SHARE = 1 / 3  # of these frames that must be seen
FIRST = 5  # frames that say where a path begins
STILL = 1e-9  # body lengths: what rounding moves a body by that nothing pulls
GAP_S = 0.035  # of no marker at all: long enough for something to happen in it


class NoPath(ArithmeticError):
    """A model that has no path along a trial's shapes cannot guide its averages."""

    @property
    def trial(self) -> str:
        """Name of the trial."""
        return str(self.args[0])

    def __str__(self) -> str:
        return f"trial `{self.trial}`: steps of this model have no root"


@dataclass(frozen=True)
class Shown:
    """What a trial shows, whichever model guides its averages: its mesh, vertices (R, N, 2) [m] there, the true body's
    poses (F, 3), as if it had never been put elsewhere, when it was, and what of its shapes at boundaries is readings'
    noise, see `readings_noise.of_shapes`."""

    mesh: Mesh
    vertices: Floats
    poses: Floats
    puts: Puts
    noise: Floats

    @classmethod
    def of(cls, r: Recording, seen: Observation) -> Shown:
        """With the observation model's corrections applied."""
        mesh = mesh_of(r)
        markers = seen.unstretched(r.markers)
        begun = seen.begun(r.angles, marker_angles(r.body, markers))
        vertices = shapes(r.body, seen.angles(r.angles_at(mesh.time), begun))
        frame_angles = seen.angles(r.angles, begun)
        frame_poses, _ = register(seen.seen(r.body, frame_angles), markers)
        poses = _mapped_poses(seen, frame_poses)
        puts = puts_of(r, poses)
        noise = of_shapes(r, mesh.time[mesh.bounds], half_average(r))
        return cls(mesh, vertices, puts.laid_back(r.time, poses), puts, noise)


def make_tracks(recordings: Sequence[Recording], seen: Observation, model: Model) -> tuple[Track, ...]:
    """Tracks with the observation model's corrections applied; the model only guides averages over a few frames.

    Raises NoPath.
    """
    return tracker(recordings, seen)(model)


def tracker(recordings: Sequence[Recording], seen: Observation) -> Callable[[Model], tuple[Track, ...]]:
    """Makes them about one model after another: what trials show is found once."""
    shown: list[Shown] = []

    def about(model: Model) -> tuple[Track, ...]:
        if shown:
            return tuple(in_processes([(_track, (r, s, model)) for r, s in zip(recordings, shown, strict=True)]))
        found = in_processes([(_first, (r, seen, model)) for r in recordings])
        shown.extend(s for s, _ in found)
        return tuple(track for _, track in found)

    return about


def _first(r: Recording, seen: Observation, model: Model) -> tuple[Shown, Track]:
    shown = Shown.of(r, seen)
    return shown, _track(r, shown, model)


def _track(r: Recording, shown: Shown, model: Model) -> Track:
    mesh, vertices, plan = shown.mesh, shown.vertices, shown.poses
    time, bounds = mesh.time, mesh.bounds
    known = np.flatnonzero(np.isfinite(plan[:, 0]))
    begun_at = _start(r, plan, known)
    guess = _ran(r, model, vertices, time, begun_at)
    at_frames = _at_frames(r, mesh, guess)
    if r.time[known[0]] > 0:  # a film that begins late shows the pose of then
        ran = relative(guess[0], at_frames[known[:FIRST]]).mean(axis=0)
        guess = _ran(r, model, vertices, time, compose(begun_at, inverse(ran)))
        at_frames = _at_frames(r, mesh, guess)
    miss = plan - at_frames
    around, counts = _averaged(r, time[bounds], miss, waits=not _slides(model, vertices[0], guess[0]))
    gaps = _crossed(r.time[known], r.frame_s, time[bounds])
    path = guess + bridged(time[bounds], around, time)
    some = slice(None, None, COARSER)
    run, anew = _mesh_error(model, vertices, time, guess, path, bounds)
    return Track(
        r, time[some], vertices[some], bounds // COARSER, mesh.playing, mesh.cycle, mesh.phase, guess[bounds] + around,
        path[some], gaps, anew, strayed=run - anew,
        least=np.hypot(_least(r, counts), by_readings(r, model, time[bounds], shown.noise)),
        laid=shown.puts.away(time[some], path[some]), put=shown.puts.within(time[bounds]),
    )  # fmt: skip


def _ran(r: Recording, model: Model, vertices: Floats, time: Floats, begun_at: Floats) -> Floats:
    """The guiding path (R, 3) from a pose on."""
    path = predicted_path(model, vertices, time, begun_at)
    if not np.isfinite(path).all():
        raise NoPath(r.name)
    return path


def _mesh_error(
    model: Model, vertices: Floats, time: Floats, run: Floats, path: Floats, bounds: np.ndarray
) -> tuple[Floats, Floats]:
    """What the coarser mesh misses of each window (B - 1, 3): of a run from the first pose, and of steps that begin on
    the measured path. Where drag depends on the place, a run that strays by the mesh meets another floor."""
    some, coarse = slice(None, None, COARSER), bounds // COARSER
    more = COARSER**2 / (COARSER**2 - 1)  # second order: extrapolated to a mesh without error
    rough = predicted_path(model, vertices[some], time[some], run[0])
    free = relative(run[bounds[:-1]], run[bounds[1:]]) - relative(rough[coarse[:-1]], rough[coarse[1:]])
    if not model.knows("place") or model.knows("history"):
        return more * free, more * free
    fine = begun_anew(model, vertices, time, path, bounds)
    begun = fine - begun_anew(model, vertices[some], time[some], path[some], coarse)
    return more * free, more * np.where(np.isfinite(begun), begun, free)


def _slides(model: Model, resting: Floats, pose: Floats) -> bool:
    """Whether something pulls a body that does not bend (N, 2) away from a pose, as a slope does."""
    if not model.knows("place"):
        return False
    moved = predicted_path(model, np.stack([resting, resting]), np.array([0.0, HALF_AVERAGE_S]), pose)
    return bool(np.hypot(*(moved[1] - moved[0])[:2]) > STILL * model.body.total_length_m)


def _averaged(r: Recording, times: Floats, miss: Floats, waits: bool = True) -> tuple[Floats, Floats]:
    """Means (B, 3) of what frames (F, 3) miss about each boundary, NaN where too few are seen; their number (B,), where
    too few are seen that of a boundary at which enough are.

    Frames after the last boundary are left out: what is done after its end, a trial does not promise. Those before the
    first are, too, of a body that does not wait where it was laid: it may slide by then, or be held until it begins.
    """
    half = half_average(r)
    needed = max(1.0, LEAST_SHARE * 2 * half / r.frame_s)
    around, counts = np.full((len(times), 3), np.nan), np.full(len(times), np.nan)
    first = 0 if waits else int(np.searchsorted(r.time, times[0]))
    last = int(np.searchsorted(r.time, times[-1], side="right"))
    for i, t in enumerate(times):
        a, b = np.maximum(np.searchsorted(r.time[:last], [t - half, t + half]), first)
        good = np.isfinite(miss[a:b, 0])
        if good.sum() >= needed:
            around[i], counts[i] = miss[a:b][good].mean(axis=0), good.sum()
    typical = np.nanmedian(counts) if np.isfinite(counts).any() else 1.0
    return around, np.where(np.isfinite(counts), counts, typical)


def half_average(r: Recording) -> float:
    """Of the time over which poses at a boundary are averaged [s]."""
    half = max(HALF_AVERAGE_S, HALF_AVERAGE_FRAMES * r.frame_s)
    return min(half, MOST_OF_WINDOW * r.schedule.cycle_duration_s / WINDOWS_PER_CYCLE)


def _least(r: Recording, counts: Floats) -> Floats:
    """SD (B - 1, 3) of a window's displacement that the markers' own noise makes, its two ends averaged."""
    seen = np.maximum(np.isfinite(r.markers[..., 0]).sum(axis=1), 1)
    spread = r.body.total_length_m * GYRATION
    one = np.array([1.0, 1.0, 1 / spread]) * r.marker_noise / np.sqrt(np.median(seen))
    return np.sqrt(1 / counts[:-1] + 1 / counts[1:])[:, None] * one


def _crossed(seen: Floats, frame_s: float, times: Floats) -> np.ndarray:
    """Whether in each window (B - 1,) between times (B,) lies a gap between frames that were seen (K,) [s], long enough
    for something to happen in it, and more than a frame alone; whether its frames are blank or not in the file."""
    begin, end = seen[:-1], seen[1:]
    enough = max(GAP_S, (ONE_MISSING - 1) * frame_s)
    long = end - begin - frame_s > enough
    hidden = np.minimum(end[long], times[1:, None]) - np.maximum(begin[long], times[:-1, None]) - frame_s
    return np.asarray((hidden > enough).any(axis=1))


def _mapped_poses(seen: Observation, poses: Floats) -> Floats:
    """Poses of the true body: the length scale taken out."""
    mapped = poses.copy()
    mapped[:, :2] /= 1 + seen.scale
    return mapped


def _start(r: Recording, poses: Floats, known: np.ndarray) -> Floats:
    before = known[r.time[known] < 0]
    some = before if len(before) > 3 else known[:FIRST]
    return np.asarray(poses[some].mean(axis=0))


def _at_frames(r: Recording, mesh: Mesh, path: Floats) -> Floats:
    """The path at the frames: cubic wherever its rate does not jump, held outside.

    Where rows are held, a cubic in time would swing on while a body that has jumped rests: there it is one in what runs
    evenly with time and with what joints bend by, as the mesh's steps do.
    """
    at = np.clip(r.time, mesh.time[0], mesh.time[-1])
    along, here = mesh.time, at
    if mesh.followed:
        every = np.unique(np.concatenate([along, here]))
        grown = evenly(r, every)
        along, here = (np.interp(some, every, grown) for some in (along, here))
    result = np.empty((len(at), 3))
    part = np.clip(np.searchsorted(mesh.time[mesh.breaks], at - 1e-9) - 1, 0, len(mesh.breaks) - 2)
    for n in np.unique(part):
        rows = slice(mesh.breaks[n], mesh.breaks[n + 1] + 1)
        result[part == n] = CubicSpline(along[rows], path[rows])(here[part == n])
    return result
