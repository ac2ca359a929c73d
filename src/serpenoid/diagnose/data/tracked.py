"""Recordings that have tracked points and nothing else (animals): their shapes are what the points show.

There is no command and no servo to compare with, so only the stage of motion is left. A recording is cut into parts,
and each is predicted by a fit to the others. Nothing is repeated, so chance is what the points' own noise makes of
shapes, poses and first velocity, drawn again and again; all else is a fault of the model. What noise does to the pose
between two windows is in both with the other sign: draws tell how much of it that is, and it does not add up.

Legend: R rows of a part's time mesh, B boundaries of windows, N vertices.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.body_curve import PLAIN, SMOOTH
from serpenoid.diagnose.data.noise.memory import share_of_poses
from serpenoid.diagnose.data.shapes.shapes_from_points import Smoothed, States, from_points
from serpenoid.diagnose.data.still import refuse_still
from serpenoid.diagnose.data.windows.lead import Lead, Run
from serpenoid.diagnose.data.windows.windows import Track, predictions
from serpenoid.errors import InputError
from serpenoid.group import relative
from serpenoid.measure.cells import clock
from serpenoid.measure.load import Campaign
from serpenoid.measure.remark import Remark
from serpenoid.measure.shapes.chain import UNCERTAIN
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.measure.trial import SHORTEST_RUN, Motion, Trial
from serpenoid.measure.trial_files import of_every_trial
from serpenoid.model import Model
from serpenoid.simulation.curve import simulate_curve
from serpenoid.simulation.rollout import simulate_vertices

PARTS = 4  # of all recordings together, at least
LEAST_PART = 0.5  # periods
WINDOWS_PER_PERIOD = 8
MOST_WINDOWS = 160  # of all recordings together: 20 periods, more where frames are few and windows longer for it
STEPS_PER_WINDOW = 12
LEAST_FRAMES = 2  # in a window
LEAD = 2  # rows: what the momentum's rate looks back on
FINER = 2  # steps in one, from which a mesh without error is extrapolated
DRAWS = 24
LEAST_NOISE = 1e-6  # body lengths, rad: rounding


@dataclass(frozen=True)
class TrackedRecording:
    """One piece of a trial without a hole, smooth, with its noise; lengths in `length_unit`: metres, or body lengths.

    shortened: what is said of a trial that is too long to be used whole, empty otherwise.

    promised_s: seconds of the trial that it stands for; those that no piece shows are counted with the first.
    """

    name: str
    gait: str
    body: Body
    smoothed: Smoothed
    promised_s: float
    remarks: tuple[Remark, ...] = ()
    shortened: str = ""
    length_unit: str = "m"

    @property
    def setting(self) -> tuple[str, float]:
        """No two recordings of an animal are repeats."""
        return self.name, 0.0


def tracked_recordings(campaign: Campaign) -> tuple[TrackedRecording, ...]:
    """Every stretch of every trial in which the body's shape is known for a period of its motion or longer.

    Of more than MOST_WINDOWS together the beginnings: work goes with their number, errors only with its square root.
    """
    own = {trial.name: trial for trial in campaign.trials}
    of_every_trial(campaign.file.trial, lambda entry: _refuse_still(own[entry.name]))
    found = [piece for trial in campaign.trials for piece in _pieces(trial)]
    share = MOST_WINDOWS / sum(_mesh(p.smoothed.states)[2] for p in found)
    cut = [piece for trial in campaign.trials for piece in _pieces(trial, share)] if share < 1 else []
    return tuple(cut or found)


def _refuse_still(trial: Trial) -> None:
    if trial.motion is not None:
        refuse_still(trial.motion.time_s, trial.motion.markers)


def _pieces(trial: Trial, share: float = 1.0) -> list[TrackedRecording]:
    if trial.motion is None or not trial.passages:
        raise InputError(f"trial `{trial.name}`: a diagnosis needs a motion file that shows the whole body.")
    body, unit = (trial.body, "m") if trial.metres is not None else (_in_body_lengths(trial.body), "bl")
    runs = [slice(run.start, run.start + int(share * (run.stop - run.start))) for run in trial.motion.runs]
    times = [trial.motion.time_s[run] for run in runs if run.stop - run.start >= SHORTEST_RUN]
    runs = [run for run in runs if run.stop - run.start >= SHORTEST_RUN]
    smoothed = [_smoothed(body, trial.motion, run) for run in runs]
    long = [i for i, piece in enumerate(smoothed) if _mesh(piece.states)[2] >= WINDOWS_PER_PERIOD]
    if not long and share < 1:
        return []
    if not long:
        longest = max(smoothed, key=lambda piece: piece.states.time[-1]).states
        raise InputError(
            f"trial `{trial.name}`: {longest.time[-1]:.3g} s at most are seen without a hole: too short for the "
            f"time that its bends take to change once over ({longest.period:.3g} s); `fit` needs less."
            f"{_too_near(trial.body, trial.motion)}"
        )
    spans = [float(time[-1] - time[0]) for time in times]
    promised = [spans[i] for i in long]
    promised[0] += float(trial.motion.time_s[-1] - trial.motion.time_s[0]) - sum(promised)
    cut = _shortened(trial, sum(spans[i] for i in long)) if share < 1 else ""
    remarks = (*trial.remarks, Remark(cut)) if cut else trial.remarks
    names = [trial.name if len(long) == 1 else f"{trial.name}, from {clock(times[i][0])} s" for i in long]
    return [
        TrackedRecording(
            name, trial.gait, body, smoothed[i], seconds, remarks if i == long[0] else (), cut * (i == long[0]), unit
        )
        for name, i, seconds in zip(names, long, promised, strict=True)
    ]


def _smoothed(body: Body, motion: Motion, run: slice) -> Smoothed:
    near = chain_vertices(body, motion.smooth_poses[run], motion.smooth_angles[run])
    return from_points(
        body, motion.time_s[run] - motion.time_s[run.start],
        motion.points[run] * body.total_length_m, near * body.total_length_m,
    )  # fmt: skip


def _too_near(body: Body, motion: Motion) -> str:
    """What frames without a hidden point are left out for: of a link a quarter as long as it is, the direction is four
    times as vague as usual, and such frames count as not seen."""
    left = ~motion.measured
    lengths = np.linalg.norm(np.diff(motion.markers[left], axis=1), axis=2)
    near = int((lengths < body.edges / UNCERTAIN).any(axis=1).sum())
    if not near:
        return ""
    return (
        f" In {near} of the {left.sum()} frames that are left out neighbouring points are so near each other that "
        "nobody knows which way the body runs between them. Does it shorten so far (no model here does), or are points "
        "exchanged? Fewer points, farther apart, may do."
    )


def _shortened(trial: Trial, used_s: float) -> str:
    whole = float(trial.motion.time_s[-1] - trial.motion.time_s[0]) if trial.motion is not None else used_s
    return (
        f"the first {used_s:.3g} s of {whole:.3g} s are used, about {MOST_WINDOWS} windows in all recordings together: "
        "more would take longer and tell little more; `from_s` and `to_s` choose others"
    )


def _in_body_lengths(body: Body) -> Body:
    data = body.model_dump() | {"edge_lengths": tuple(body.edges.tolist()), "length_m": None}
    return Body.model_validate(data)


def tracker(recordings: Sequence[TrackedRecording]) -> Callable[[Model], tuple[Track, ...]]:
    """What makes the tracks of all parts, with their noise under a model; each recording has its share of the parts."""
    spans = [r.smoothed.states.time[-1] for r in recordings]
    parts = [int(np.ceil(PARTS * span / sum(spans) - 1e-9)) for span in spans]
    parts = [min(n, _most_parts(r.smoothed.states)) for n, r in zip(parts, recordings, strict=True)]
    if sum(parts) < PARTS:
        names = " and ".join(f"`{r.name}`" for r in recordings)
        raise InputError(
            f"{names}: {sum(spans):.3g} s are too short to be cut into {PARTS} parts of half a period "
            f"({recordings[0].smoothed.states.period:.3g} s) each; `fit` needs less."
        )
    return lambda model: tuple(t for r, n in zip(recordings, parts, strict=True) for t in _parts(r, n, model))


def _mesh(states: States) -> tuple[float, float, int]:
    """First moment [s] of the windows, their steps [s], and how many windows there are: none of a shape that stays."""
    frame = float(np.median(np.diff(states.time)))
    window = max(states.period / WINDOWS_PER_PERIOD, LEAST_FRAMES * frame)
    step = window / STEPS_PER_WINDOW
    first = float(states.time[0] + LEAD * step)
    return first, step, int((states.time[-1] - first) / window) if np.isfinite(window) else 0


def _most_parts(states: States) -> int:
    """Parts of half a period each that a stretch has."""
    return int(_mesh(states)[2] // (LEAST_PART * WINDOWS_PER_PERIOD))


def _parts(recording: TrackedRecording, pieces: int, model: Model) -> list[Track]:
    states = recording.smoothed.states
    first, step, windows = _mesh(states)
    rng, draws = np.random.default_rng(0), []
    count = windows // pieces * pieces
    tracks = _cut(recording, states, _run(states, first, step, count), pieces)
    base = [_missed(model, t) for t in tracks]
    for _ in range(DRAWS):
        drawn = recording.smoothed.draw(rng)
        again = _cut(recording, drawn, _run(drawn, first, step, count), pieces)
        draws.append([_missed(model, t) - b for t, b in zip(again, base, strict=True)])
    finer = _cut(recording, states, _run(states, first, step, count, FINER), pieces, FINER)
    tracks = [replace(t, offset=e) for t, e in zip(tracks, _mesh_error(model, tracks, finer), strict=True)]
    least = LEAST_NOISE * model.body.pose_units
    squares = _filled([_variance([d[i] for d in draws], model.body.total_length_m) for i in range(pieces)])
    noise = [np.maximum(np.sqrt(q), least) for q in squares]
    share = share_of_poses([np.stack([d[i] for d in draws]) / own for i, own in enumerate(noise)])
    return [
        _along_curve(model, replace(t, noise=own, least=np.sqrt(share) * own))
        for t, own in zip(tracks, noise, strict=True)
    ]


def _variance(draws: Sequence[Floats], length_m: float) -> Floats:
    """Mean squares (B - 1, 3) of draws of windows; NaN where one of them has no root, or one more than a body length
    away, to which no window moves a body: near a straight body a step's equations may have such roots, too."""
    every = np.stack(draws)
    away = np.abs(every[..., :2]).max(axis=-1, keepdims=True) > length_m
    return np.asarray(np.where(away, np.nan, every**2).mean(axis=0))


def _filled(squares: Sequence[Floats]) -> list[Floats]:
    """Variances of windows (B - 1, 3) a part; the mean of the others where a model has no root and tells none."""
    known = np.concatenate(squares)
    known = known[np.isfinite(known).all(axis=1)]
    return [np.where(np.isfinite(q), q, known.mean(axis=0) if len(known) else 0.0) for q in squares]


def _mesh_error(model: Model, tracks: Sequence[Track], finer: Sequence[Track]) -> list[Floats]:
    """What the mesh misses of each window (B - 1, 3), by the same on a finer one; of an animal, whose curve is without
    error by drag alone, what it misses beyond that."""
    found = _missed_by(model, tracks, finer)
    if not model.body.is_animal:
        return found
    plain = Model(model.body, model.medium)
    return [e - p for e, p in zip(found, _missed_by(plain, tracks, finer), strict=True)]


def _missed_by(model: Model, tracks: Sequence[Track], finer: Sequence[Track]) -> list[Floats]:
    """By a model; nothing where it has no root on one of the meshes."""
    more = FINER**2 / (FINER**2 - 1)  # second order: extrapolated to a mesh without error
    pairs = zip(predictions(model, finer), predictions(model, tracks), strict=True)
    return [np.nan_to_num(more * (fine.displacement - rough.displacement)) for fine, rough in pairs]


def _along_curve(model: Model, track: Track) -> Track:
    """The track with what drag along the smooth curve through an animal's points adds, and what is not known of it.

    What effects do is computed on the links between the points, and off by the same share of it.
    """
    if not model.body.is_animal:
        return track
    scale = model.body.pose_units
    plain, chains = Model(model.body, model.medium), track.vertices / model.body.total_length_m
    curve, other = (simulate_curve(plain, chains, degree=degree).poses for degree in (SMOOTH, PLAIN))
    paths = [poses[track.boundaries] * scale for poses in (simulate_vertices(plain, chains).poses, curve, other)]
    moved = [relative(p[:-1], p[1:]) for p in paths]
    added = moved[1] - moved[0]
    coarse = float(np.sqrt((added[:, :2] ** 2).sum() / (moved[1][:, :2] ** 2).sum()))
    return replace(track, offset=track.offset + added, doubt=np.abs(moved[2] - moved[1]), coarse=coarse)


def _run(states: States, first: float, step: float, windows: int, finer: int = 1) -> Run:
    """The recording on an even mesh, from LEAD steps before its first window on; finer: into how many each is cut."""
    rows: Floats = first + step / finer * np.arange(-LEAD * finer, windows * STEPS_PER_WINDOW * finer + 1, dtype=float)
    return Run(rows, states.vertices_at(rows), states.poses_at(rows), LEAD * finer)


def _cut(recording: TrackedRecording, states: States, run: Run, pieces: int, finer: int = 1) -> list[Track]:
    """Parts of equal length; what has momentum runs free from the beginning of the run."""
    steps = STEPS_PER_WINDOW * finer
    windows = (len(run.time) - 1 - run.given) // steps // pieces
    bounds, nothing = steps * np.arange(windows + 1), np.zeros(windows, bool)
    found = []
    for i in range(pieces):
        lead = run.given + i * windows * steps
        part = slice(lead, lead + windows * steps + 1)
        time, poses = run.time[part], run.poses[part]
        phase = np.mod((time[bounds[:-1]] + time[bounds[1:]]) / 2 / states.period, 1.0)
        track = Track(
            recording, time, run.vertices[part], bounds, ~nothing, np.zeros(windows, int), phase, poses[bounds], poses,
            nothing, np.zeros((windows, 3)), Lead(run, lead),
        )  # fmt: skip
        found.append(track)
    return found


def _missed(model: Model, track: Track) -> Floats:
    """Measured minus predicted displacement of the windows (B - 1, 3)."""
    predicted = predictions(model, [track])[0].displacement
    return np.asarray(relative(track.measured[:-1], track.measured[1:]) - predicted)
