"""Third stage: measured motion between window boundaries, and what a model makes of the same shapes.

Within a window a model's steps are strung together from the measured pose at its beginning; the residual is measured
minus modelled displacement, seen from there.

Legend: R rows of a trial's time mesh, B boundaries, F frames, P columns.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.cameras.frame import added, added_by, of_frame
from serpenoid.diagnose.data.windows.lead import Lead, Recorded, free_run, led
from serpenoid.effects.active import ActiveEffect
from serpenoid.group import accumulate, relative
from serpenoid.measure.film.quality import stretches
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.extended import solve_extended
from serpenoid.simulation.path import PathSensitivities, paths_of
from serpenoid.simulation.poses import body_frame
from serpenoid.simulation.sensitivity import Column, MeasuredSteps, StepSensitivities, sensitivities_of
from serpenoid.simulation.steps import elements_of_vertices


@dataclass(frozen=True)
class Track:
    """One trial on its (coarser) time mesh; offset (B - 1, 3): what a mesh without error would add
    to a window's displacement; doubt (B - 1, 3): SD of what the baseline is known to get wrong there, and whether that
    recurs in every cycle.

    time (R,), vertices (R, N, 2) in the body frame [m]; boundaries (B,): rows; measured (B, 3) poses there [m, rad],
    NaN in gaps; poses (R, 3): measured path at all rows, holes bridged; playing (B - 1,).
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
    gap_windows: np.ndarray  # (B - 1,) a gap of all markers lies inside
    offset: Floats
    lead: Lead | None = None  # how the body was moving before; None: it was at rest
    noise: Floats | None = None  # (B - 1, 3) SD of each window's residual, where it does not come from repeats
    doubt: Floats | float = 0.0
    recurs: np.ndarray | bool = True
    least: Floats | float = 0.0  # (B - 1, 3) SD of a window's displacement that the markers' own noise makes
    strayed: Floats | float = 0.0  # (B - 1, 3) what `offset` is more for who runs free from the first pose
    coarse: float = 0.0  # share of the motion by which straight links between an animal's points are off
    shifted: Floats | float = 0.0  # (R, 3) [m, m, rad] how far cameras show the body from where it is on the floor
    laid: Floats | float = 0.0  # (R, 3) [m, m, rad] the same of paths that go on as if it had not been put elsewhere
    put: np.ndarray | bool = False  # (B - 1,) windows in which it was

    @cached_property
    def steps(self) -> MeasuredSteps:
        """With those of the lead before them; the same in every evaluation."""
        model = Model(self.recording.body, Medium(anisotropy_ratio=1.0))
        time, vertices, poses, before = led(self.lead, self.time, self.vertices, self.poses)
        poses = np.concatenate([poses[:before], self.on_floor])
        return MeasuredSteps.of(model, vertices / model.body.total_length_m, time, poses / model.body.pose_units)

    @property
    def on_floor(self) -> Floats:
        """Poses (R, 3) on the floor, which does not move with the cameras' frame."""
        return np.asarray(self.poses - self.shifted - self.laid)

    @property
    def first_seen(self) -> int:
        """First boundary at which the pose was; the first where it never was."""
        return int(np.isfinite(self.measured[:, 0]).argmax())

    @property
    def duration(self) -> Floats:
        """Of each window [s]."""
        return np.diff(self.time[self.boundaries])

    @property
    def usable(self) -> np.ndarray:
        """(B - 1,) windows with both ends measured and no gap in between."""
        known = np.isfinite(self.measured[:, 0])
        return known[1:] & known[:-1] & ~self.gap_windows & ~self.put_windows

    @property
    def put_windows(self) -> np.ndarray:
        """(B - 1,) windows in which it was put elsewhere."""
        return np.broadcast_to(self.put, self.playing.shape)

    @property
    def displacement(self) -> Floats:
        """Measured, of each window, in the frame of its first pose (B - 1, 3)."""
        return relative(self.measured[:-1], self.measured[1:])


def predicted_path(model: Model, vertices: Floats, time: Floats, start: Floats) -> Floats:
    """Poses [m, rad] of a model, free running from a pose (3,), or from the last of its first poses (K + 1, 3); of a
    single shape the pose."""
    if len(time) == 1:
        return np.atleast_2d(start)
    scale = model.body.pose_units
    chains = body_frame(model, vertices / model.body.total_length_m)
    steps = solve_extended(model, elements_of_vertices(model, chains), time, start / scale)
    known = np.atleast_2d(start)
    return accumulate(steps.relative[len(known) - 1 :] * scale, known[-1])


def begun_anew(model: Model, vertices: Floats, time: Floats, poses: Floats, boundaries: np.ndarray) -> Floats:
    """Displacements (B - 1, 3) of windows by a model whose steps begin at poses (R, 3) [m, rad], each at its own."""
    scale = model.body.pose_units
    found = sensitivities_of(model, MeasuredSteps.of(model, vertices / model.body.total_length_m, time, poses / scale))
    path = accumulate(found.relative * scale)
    return relative(path[boundaries[:-1]], path[boundaries[1:]])


@dataclass(frozen=True)
class Prediction:
    """displacement (B - 1, 3) of each window [m, m, rad], jacobian (B - 1, 3, P) by the columns; steps (S, 3): relative
    poses of all steps [body lengths, rad], where a search for those of a model much like this one may begin."""

    displacement: Floats
    jacobian: Floats
    columns: tuple[Column, ...]
    steps: Floats | None = None

    def by(self, columns: Sequence[Column]) -> Floats:
        """Derivatives (B - 1, 3, K) by some of its columns."""
        at = {column: i for i, column in enumerate(self.columns)}
        return self.jacobian[..., [at[column] for column in columns]]


def predictions(
    model: Model,
    tracks: Sequence[Track],
    candidates: Sequence[ActiveEffect] = (),
    near: Sequence[Prediction] | None = None,
) -> list[Prediction]:
    """What a model makes of trials' shapes, window by window, as cameras see it, and its derivatives.

    near: what a model much like this one makes of them: where the search for roots begins.
    """
    inside = [c for c in candidates if c.effect.site == "medium"]
    found = (coasting if model.knows("history") else balanced)(model, tracks, inside, near)
    mine, keys = of_frame(model.effects), {e.key for e in model.effects}
    more = [c for c in of_frame(candidates) if c.key not in keys]
    found = [in_frame(t, p, mine, more) for t, p in zip(tracks, found, strict=True)] if mine or more else found
    return [as_put(t, p) if np.any(t.put) else p for t, p in zip(tracks, found, strict=True)]


def as_put(track: Track, p: Prediction) -> Prediction:
    """With the measured displacement of windows in which it was put elsewhere: of these a model says nothing."""
    put = track.put_windows
    displacement, jacobian = p.displacement.copy(), p.jacobian.copy()
    displacement[put], jacobian[put] = 0.0, 0.0
    for first, last in stretches(put):
        displacement[first] = np.nan_to_num(relative(track.measured[first], track.measured[last]))
    return replace(p, displacement=displacement, jacobian=jacobian)


def in_frame(track: Track, p: Prediction, mine: Sequence[ActiveEffect], more: Sequence[ActiveEffect]) -> Prediction:
    """With what a moving frame adds, and columns for it; more: effects that might be there."""
    ends = track.on_floor[track.boundaries], track.time[track.boundaries]
    by = [p.jacobian, *(added_by(mine, e, *ends) for e in (*mine, *more))]
    moved = p.displacement + added(mine, *ends)
    return replace(
        p, displacement=moved, jacobian=np.concatenate(by, axis=2), columns=(*p.columns, *columns_of((*mine, *more)))
    )


def columns_of(effects: Sequence[ActiveEffect]) -> tuple[Column, ...]:
    """Of their coordinates, in their order."""
    return tuple(Column(e.name, e.place, p.name) for e in effects for p in e.effect.parameters)


def balanced(
    model: Model,
    tracks: Sequence[Track],
    candidates: Sequence[ActiveEffect] = (),
    near: Sequence[Prediction] | None = None,
) -> list[Prediction]:
    """The same with every step begun at its measured pose: all steps of all trials at once."""
    scale = model.body.pose_units
    result = []
    for track, own, steps in by_track(model, tracks, candidates, near):
        p = windowed(track, own.relative * scale, own.jacobian * scale[:, None], own.columns)
        result.append(replace(p, displacement=p.displacement + track.offset, steps=steps))
    return result


def by_track(
    model: Model,
    tracks: Sequence[Track],
    candidates: Sequence[ActiveEffect] = (),
    near: Sequence[Prediction] | None = None,
) -> Iterator[tuple[Track, StepSensitivities, Floats]]:
    """Each track with its own steps, and the relative poses (S, 3) of these and its lead's."""
    begin = _steps(near)
    joined = None if begin is None else np.concatenate(begin)
    found = sensitivities_of(model, MeasuredSteps.joined([t.steps for t in tracks]), candidates, joined)
    end = 0
    for track in tracks:
        first, end = end, end + len(track.steps)
        own = found.part(slice(first + (track.lead.rows if track.lead else 0), end))
        yield track, own, found.relative[first:end]


def _steps(near: Sequence[Prediction] | None) -> list[Floats] | None:
    """Relative poses of all steps of each, if they are known."""
    known = [p.steps for p in near or () if p.steps is not None]
    return known if near is not None and len(known) == len(near) else None


def coasting(
    model: Model,
    tracks: Sequence[Track],
    candidates: Sequence[ActiveEffect] = (),
    near: Sequence[Prediction] | None = None,
) -> list[Prediction]:
    """The same for a model whose earlier steps matter: whole trials, free running."""
    scale = model.body.pose_units
    if any(t.lead for t in tracks):  # parts of one recording ask for the same run
        runs = [free_run(model, t.lead.run, tuple(candidates)) for t in tracks if t.lead]
    else:
        starts = [t.poses[0] / scale for t in tracks]
        runs = paths_of(model, [t.steps for t in tracks], starts, candidates, _steps(near))
    return [_coasted(track, run, scale) for track, run in zip(tracks, runs, strict=True)]


def _coasted(track: Track, found: PathSensitivities, scale: Floats) -> Prediction:
    """Windows of a track on a path [body lengths, rad]."""
    at = track.boundaries + (track.lead.rows if track.lead else 0)
    path, by = found.poses[at] * scale, found.jacobian[at] * scale[:, None]
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
    poses = found.poses[: len(track.steps) + 1]
    return Prediction(moved + track.offset + track.strayed, jacobian, found.columns, relative(poses[:-1], poses[1:]))


def windowed(track: Track, steps: Floats, by: Floats, columns: tuple[Column, ...]) -> Prediction:
    """String the steps of each window together: poses and their derivatives at its end, seen from its beginning."""
    displacement, turned = at_ends(track, steps, by)
    return Prediction(displacement, np.add.reduceat(turned, track.boundaries[:-1], axis=0), columns)


def at_ends(track: Track, steps: Floats, by: Floats) -> tuple[Floats, Floats]:
    """Displacement of each window (B - 1, 3), and what each step's derivatives (S, 3, P) add to its window's own."""
    heading = np.cumsum(np.concatenate([[0.0], steps[:, 2]]))
    c, s = np.cos(heading[:-1]), np.sin(heading[:-1])
    x = c * steps[:, 0] - s * steps[:, 1]
    y = s * steps[:, 0] + c * steps[:, 1]
    place = np.concatenate([np.zeros((1, 2)), np.cumsum(np.column_stack([x, y]), axis=0)])
    path = np.column_stack([place, heading])
    first, last = track.boundaries[:-1], track.boundaries[1:]
    long = last - first
    lever = np.repeat(place[last], long, axis=0) - place[first[0] + 1 : last[-1] + 1]
    away = heading[:-1] - np.repeat(heading[first], long)  # seen from the window's beginning
    c, s = np.cos(away)[:, None], np.sin(away)[:, None]
    start = np.repeat(heading[first], long)
    right = np.cos(start) * lever[:, 0] + np.sin(start) * lever[:, 1]
    up = np.cos(start) * lever[:, 1] - np.sin(start) * lever[:, 0]
    turned = np.stack(
        [
            c * by[:, 0] - s * by[:, 1] - up[:, None] * by[:, 2],
            s * by[:, 0] + c * by[:, 1] + right[:, None] * by[:, 2],
            by[:, 2],
        ],
        axis=1,
    )
    return relative(path[first], path[last]), turned
