"""Third rung: measured motion between window boundaries, and what a model makes of the same shapes.

Each cycle is cut into windows, each pause into two. Within a window a model's steps are strung together from the
measured pose at its beginning; the residual is measured minus modelled displacement, seen from there. Marker noise
enters at the boundaries only, where poses are averaged over a few frames about the predicted path.

Legend: R rows of a trial's time mesh, W windows, F frames, P columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from serpenoid.body import Floats
from serpenoid.diagnose.geometry import filled, register, relative, shapes, travel, turn
from serpenoid.diagnose.lead import Lead, Recorded, free_run, led
from serpenoid.diagnose.observation import Observation
from serpenoid.diagnose.recording import Recording
from serpenoid.effects.active import ActiveEffect
from serpenoid.model import Model
from serpenoid.simulation.extended import solve_extended
from serpenoid.simulation.path import path_sensitivities
from serpenoid.simulation.poses import body_frame
from serpenoid.simulation.sensitivity import Column, step_sensitivities
from serpenoid.simulation.steps import elements_of_vertices

WINDOWS_PER_CYCLE = 8
STEPS_PER_WINDOW = 18  # 144 a cycle: the mesh's error is a tenth of the floor
STEPS_PER_PAUSE = 16
COARSER = 2  # fits take every second row; what that changes is known from the guiding model, and put back
HALF_AVERAGE_S = 0.045  # poses at a boundary: frames within this distance
LEAST_FRAMES = 4


@dataclass(frozen=True)
class Track:
    """One trial on its (coarser) time mesh; offset (B - 1, 3): what a mesh without error would add
    to a window's displacement.

    time (R,), vertices (R, N, 2) in the body frame [m]; boundaries (B,): rows; measured (B, 3) poses there [m, rad],
    NaN in gaps; poses (R, 3): measured path at all rows, holes bridged; playing (B - 1,); frame_time (F,), frame_poses
    (F, 3): measured.
    """

    recording: Recorded
    time: Floats
    vertices: Floats
    boundaries: np.ndarray
    playing: np.ndarray
    cycle: np.ndarray
    phase: Floats
    measured: Floats
    poses: Floats
    frame_time: Floats
    frame_poses: Floats
    gap_windows: np.ndarray  # (B - 1,) a gap of all markers lies inside
    offset: Floats
    lead: Lead | None = None  # how the body was moving before; None: it was at rest
    noise: Floats | None = None  # (B - 1, 3) SD of each window's residual, where it does not come from repeats

    @property
    def duration(self) -> Floats:
        """Of each window [s]."""
        return np.diff(self.time[self.boundaries])

    @property
    def usable(self) -> np.ndarray:
        """(B - 1,) windows with both ends measured and no gap in between."""
        known = np.isfinite(self.measured[:, 0])
        return known[1:] & known[:-1] & ~self.gap_windows

    @property
    def displacement(self) -> Floats:
        """Measured, of each window, in the frame of its first pose (B - 1, 3)."""
        return relative(self.measured[:-1], self.measured[1:])


def make_tracks(recordings: Sequence[Recording], seen: Observation, model: Model) -> tuple[Track, ...]:
    """Tracks with the observation model's corrections applied; the model only guides averages over a few frames."""
    return tuple(_track(r, seen, model) for r in recordings)


def _mesh(r: Recording) -> tuple[Floats, np.ndarray, np.ndarray, np.ndarray, Floats]:
    """Rows, boundaries, playing, cycle and phase of each window."""
    s = r.schedule
    time, bounds, playing, cycle, phase = [np.zeros(1)], [0], [], [], []
    play, rest = WINDOWS_PER_CYCLE * STEPS_PER_WINDOW, STEPS_PER_PAUSE
    for n in range(s.cycles):
        start = n * s.period_s
        time.append(start + np.arange(1, play + 1) / play * s.cycle_duration_s)
        bounds += [bounds[-1] + STEPS_PER_WINDOW * (i + 1) for i in range(WINDOWS_PER_CYCLE)]
        playing += [True] * WINDOWS_PER_CYCLE
        phase += [(i + 0.5) / WINDOWS_PER_CYCLE for i in range(WINDOWS_PER_CYCLE)]
        cycle += [n] * WINDOWS_PER_CYCLE
        if s.pause_s > 0:
            time.append(start + s.cycle_duration_s + np.arange(1, rest + 1) / rest * s.pause_s)
            bounds += [bounds[-1] + rest // 2, bounds[-1] + rest]
            playing += [False] * 2
            phase += [1.0] * 2
            cycle += [n] * 2
    rows = np.concatenate(time)
    last = int(np.searchsorted(rows[bounds], r.end + 1e-6))
    keep = bounds[:last]
    cut = slice(None, last - 1)
    mesh = rows[: keep[-1] + 1]
    return mesh, np.array(keep), np.array(playing)[cut], np.array(cycle)[cut], np.array(phase, dtype=float)[cut]


def _track(r: Recording, seen: Observation, model: Model) -> Track:
    time, bounds, playing, cycle, phase = _mesh(r)
    vertices = shapes(r.body, seen.angles(r.angles_at(time)))
    frame_angles = seen.angles(r.angles)
    frame_poses, _ = register(seen.seen(r.body, frame_angles), r.markers)
    plan = _mapped_poses(r, seen, frame_angles, frame_poses)
    known = np.flatnonzero(np.isfinite(plan[:, 0]))
    guess = predicted_path(model, vertices, time, _start(r, plan, known))
    at_frames = _spline(r, time, guess)
    miss = plan - at_frames
    around = np.full((len(bounds), 3), np.nan)
    for i, t in enumerate(time[bounds]):
        a, b = np.searchsorted(r.time, [t - HALF_AVERAGE_S, t + HALF_AVERAGE_S])
        good = np.isfinite(miss[a:b, 0])
        if good.sum() >= LEAST_FRAMES:
            around[i] = miss[a:b][good].mean(axis=0)
    hidden = r.time[~np.isfinite(plan[:, 0])]
    gaps = np.array([_crossed(hidden, *time[[a, b]]) for a, b in zip(bounds[:-1], bounds[1:], strict=True)])
    bridged = filled(around)
    path = guess + np.stack([np.interp(time, time[bounds], c) for c in bridged.T], axis=1)
    some = slice(None, None, COARSER)
    rough = predicted_path(model, vertices[some], time[some], guess[0])
    coarse = bounds // COARSER
    finer = relative(guess[bounds[:-1]], guess[bounds[1:]]) - relative(rough[coarse[:-1]], rough[coarse[1:]])
    offset = finer * COARSER**2 / (COARSER**2 - 1)  # second order: extrapolated to a mesh without error
    return Track(
        r, time[some], vertices[some], coarse, playing, cycle, phase, guess[bounds] + around, path[some], r.time, plan,
        gaps, offset,
    )  # fmt: skip


def _crossed(hidden: Floats, begin: float, end: float) -> bool:
    """Whether a gap of all markers, long enough for something to happen in it, lies in a window."""
    return bool(((hidden > begin) & (hidden < end)).sum() > LEAST_FRAMES)


def _mapped_poses(r: Recording, seen: Observation, angles: Floats, poses: Floats) -> Floats:
    """Poses of the true body: the length scale taken out."""
    mapped = poses.copy()
    mapped[:, :2] /= 1 + seen.scale
    return mapped


def _start(r: Recording, poses: Floats, known: np.ndarray) -> Floats:
    before = known[r.time[known] < 0]
    some = before if len(before) > 3 else known[:5]
    return np.asarray(poses[some].mean(axis=0))


def _spline(r: Recording, time: Floats, path: Floats) -> Floats:
    """The path at the frames: cubic within each stretch of playing or pause, held outside."""
    at = np.clip(r.time, time[0], time[-1])
    result = np.empty((len(at), 3))
    labels = r.stretch(np.maximum(at - 1e-9, 0.0))
    own = r.stretch(np.maximum(time - 1e-9, 0.0))
    for label in np.unique(labels):
        rows = np.flatnonzero(own == label)
        if label > 0 and rows[0] > 0:
            rows = np.concatenate([[rows[0] - 1], rows])
        result[labels == label] = CubicSpline(time[rows], path[rows])(at[labels == label])
    return result


def predicted_path(model: Model, vertices: Floats, time: Floats, start: Floats) -> Floats:
    """Poses [m, rad] of a model, free running from a pose (3,), or from the last of its first poses (K + 1, 3)."""
    scale = np.array([model.body.total_length_m, model.body.total_length_m, 1.0])
    chains = body_frame(model, vertices / model.body.total_length_m)
    steps = solve_extended(model, elements_of_vertices(model, chains), time, start / scale)
    known = np.atleast_2d(start)
    return travel(steps.relative[len(known) - 1 :] * scale, known[-1])


@dataclass(frozen=True)
class Prediction:
    """displacement (B - 1, 3) of each window [m, m, rad], jacobian (B - 1, 3, P) by the columns."""

    displacement: Floats
    jacobian: Floats
    columns: tuple[Column, ...]


def predict(model: Model, track: Track, candidates: Sequence[ActiveEffect] = ()) -> Prediction:
    """What a model makes of a trial's shapes, window by window, and its derivatives."""
    length = model.body.total_length_m
    scale = np.array([length, length, 1.0])
    time, vertices, poses, lead = led(track.lead, track.time, track.vertices, track.poses)
    found = step_sensitivities(model, vertices / length, time, poses / scale, candidates)
    p = _windowed(track, found.relative[lead:] * scale, found.jacobian[lead:] * scale[:, None], found.columns)
    return replace(p, displacement=p.displacement + track.offset)


def coasting(model: Model, track: Track, candidates: Sequence[ActiveEffect] = ()) -> Prediction:
    """The same for a model whose earlier steps matter: the whole trial, free running."""
    length = model.body.total_length_m
    scale = np.array([length, length, 1.0])
    if track.lead is None:
        found = path_sensitivities(model, track.vertices / length, track.time, track.poses[0] / scale, candidates)
    else:
        found = free_run(model, track.lead.run, tuple(candidates))
    at = track.boundaries + (track.lead.rows if track.lead else 0)
    path, by = found.trajectory.poses[at] * scale, found.jacobian[at] * scale[:, None]
    moved, change = relative(path[:-1], path[1:]), by[1:] - by[:-1]
    c, s = np.cos(path[:-1, 2])[:, None], np.sin(path[:-1, 2])[:, None]
    turned = by[:-1, 2]  # turning the frame that it is seen from
    jacobian = np.stack(
        [
            c * change[:, 0] + s * change[:, 1] + moved[:, 1, None] * turned,
            c * change[:, 1] - s * change[:, 0] - moved[:, 0, None] * turned,
            change[:, 2],
        ],
        axis=1,
    )
    return Prediction(moved + track.offset, jacobian, found.columns)


def _windowed(track: Track, steps: Floats, by: Floats, columns: tuple[Column, ...]) -> Prediction:
    """String the steps of each window together: poses and their derivatives at its end, seen from its beginning."""
    heading = np.cumsum(np.concatenate([[0.0], steps[:, 2]]))
    c, s = np.cos(heading[:-1])[:, None], np.sin(heading[:-1])[:, None]
    x = c[:, 0] * steps[:, 0] - s[:, 0] * steps[:, 1]
    y = s[:, 0] * steps[:, 0] + c[:, 0] * steps[:, 1]
    place = np.concatenate([np.zeros((1, 2)), np.cumsum(np.column_stack([x, y]), axis=0)])
    path = np.column_stack([place, heading])
    turned = np.stack([c * by[:, 0] - s * by[:, 1], s * by[:, 0] + c * by[:, 1], by[:, 2]], axis=1)
    first, last = track.boundaries[:-1], track.boundaries[1:]
    end = np.repeat(place[last], last - first, axis=0)  # where each step's window ends
    lever = end - place[first[0] + 1 : last[-1] + 1]
    turned[:, 0] -= lever[:, 1, None] * by[:, 2]
    turned[:, 1] += lever[:, 0, None] * by[:, 2]
    summed = np.add.reduceat(turned, first, axis=0)
    c, s = np.cos(heading[first])[:, None], np.sin(heading[first])[:, None]
    jacobian = np.stack(
        [c * summed[:, 0] + s * summed[:, 1], c * summed[:, 1] - s * summed[:, 0], summed[:, 2]], axis=1
    )
    return Prediction(relative(path[first], path[last]), jacobian, columns)


def patch_columns(model: Model, track: Track, patches: Sequence[ActiveEffect]) -> Floats:
    """Derivatives (B - 1, 3, K) by the strengths of K weak friction patches, from those by the loads of the vertices.

    A patch changes each vertex's weight in the drag by strength w_k exp(-|p_k - (x, y)|^2 / (2 radius^2)).
    """
    length, n = model.body.total_length_m, model.body.vertices
    scale = np.array([length, length, 1.0])
    loads = [ActiveEffect.neutral("load", k) for k in range(n)]
    found = step_sensitivities(model, track.vertices / length, track.time, track.poses / scale, loads)
    by_load = np.stack([found.jacobian[..., i] for i, c in enumerate(found.columns) if c.effect == "load"], axis=-1)[
        ..., -n:
    ]
    world = track.poses[:, None, :2] + turn(track.poses[:, 2:], track.vertices)
    middle = (world[1:] + world[:-1]) / 2
    values = np.array([[e.parameters[p] for p in ("x", "y", "radius")] for e in patches])
    away = ((middle[:, :, None] - values[:, :2]) ** 2).sum(axis=-1)
    felt = model.body.vertex_weights[:, None] * np.exp(-away / (2 * values[:, 2] ** 2))
    by = np.einsum("sck,skp->scp", by_load * scale[:, None], felt)
    return _windowed(track, found.relative * scale, by, ()).jacobian
