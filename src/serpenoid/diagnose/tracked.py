"""Recordings that have tracked points and nothing else (animals): their shapes are what the points show.

There is no command and no servo to compare with, so only the rung of motion is left. A recording is cut into parts, and
each is predicted by a fit to the others. Nothing is repeated, so chance is what the points' own noise makes of shapes,
poses and first velocity, drawn again and again; all else is a fault of the model.

Legend: R rows of a part's time mesh, B boundaries of windows, N vertices.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.geometry import relative
from serpenoid.diagnose.lead import Lead, Run
from serpenoid.diagnose.shapes_from_points import Smoothed, States, from_points
from serpenoid.diagnose.windows import Track, coasting, predict
from serpenoid.errors import InputError
from serpenoid.measure.campaign import CampaignFile
from serpenoid.measure.load import Campaign
from serpenoid.model import Model

PARTS = 4  # of all recordings together, at least
WINDOWS_PER_PERIOD = 8
STEPS_PER_WINDOW = 12
LEAST_FRAMES = 2  # in a window
LEAD = 2  # rows: what the momentum's rate looks back on
DRAWS = 24
LEAST_NOISE = 1e-6  # body lengths, rad: rounding


@dataclass(frozen=True)
class TrackedRecording:
    """One trial: time (F,) [s], smooth states with their noise; lengths in metres, or in body lengths (pixels)."""

    name: str
    gait: str
    body: Body
    smoothed: Smoothed

    @property
    def setting(self) -> tuple[str, float]:
        """No two recordings of an animal are repeats."""
        return self.name, 0.0


def is_tracked_only(file: CampaignFile) -> bool:
    """Whether no trial says what was commanded or what servos read."""
    return not any(t.servo_log or t.joint_table for t in file.trial)


def tracked_recordings(campaign: Campaign) -> tuple[TrackedRecording, ...]:
    """The longest stretch of every trial in which the body's shape is known."""
    found = []
    for trial in campaign.trials:
        if trial.motion is None or not trial.passages:
            raise InputError(f"trial `{trial.name}`: a diagnosis needs a motion file that shows the whole body.")
        frames = max(trial.motion.runs, key=lambda run: run.stop - run.start)
        body = trial.body if trial.metres is not None else _in_body_lengths(trial.body)
        time = trial.motion.time_s[frames]
        markers = trial.motion.markers[frames] * body.total_length_m
        found.append(TrackedRecording(trial.name, trial.gait, body, from_points(body, time - time[0], markers)))
    return tuple(found)


def _in_body_lengths(body: Body) -> Body:
    data = body.model_dump() | {"edge_lengths": tuple(body.edges.tolist()), "length_m": None}
    return Body.model_validate(data)


def tracker(recordings: Sequence[TrackedRecording]) -> Callable[[Model], tuple[Track, ...]]:
    """What makes the tracks of all parts, with their noise under a model."""
    pieces = -(-PARTS // len(recordings))
    return lambda model: tuple(t for r in recordings for t in _parts(r, pieces, model))


def _parts(recording: TrackedRecording, pieces: int, model: Model) -> list[Track]:
    states = recording.smoothed.states
    frame = float(np.median(np.diff(states.time)))
    window = max(states.period / WINDOWS_PER_PERIOD, LEAST_FRAMES * frame)
    step = window / STEPS_PER_WINDOW
    first, last = states.time[0] + LEAD * step, states.time[-1]
    each = int((last - first) / window / pieces)
    if each < WINDOWS_PER_PERIOD:
        raise InputError(
            f"trial `{recording.name}`: {last - first:.3g} s are too short to be cut into {pieces} parts of a "
            f"period ({states.period:.3g} s) each."
        )
    rng, draws = np.random.default_rng(0), []
    count = pieces * each
    tracks = _cut(recording, states, _run(states, first, step, count), pieces)
    base = [_missed(model, t) for t in tracks]
    for _ in range(DRAWS):
        drawn = recording.smoothed.draw(rng)
        again = _cut(recording, drawn, _run(drawn, first, step, count), pieces)
        draws.append([_missed(model, t) - b for t, b in zip(again, base, strict=True)])
    least = LEAST_NOISE * np.array([model.body.total_length_m, model.body.total_length_m, 1.0])
    noise = [np.maximum(np.sqrt(np.mean([np.square(d[i]) for d in draws], axis=0)), least) for i in range(pieces)]
    return [Track(**(vars(t) | {"noise": n})) for t, n in zip(tracks, noise, strict=True)]


def _run(states: States, first: float, step: float, windows: int) -> Run:
    """The recording on an even mesh, from LEAD rows before its first window on."""
    rows: Floats = first + step * np.arange(-LEAD, windows * STEPS_PER_WINDOW + 1, dtype=float)
    return Run(rows, states.vertices_at(rows), states.poses_at(rows), LEAD)


def _cut(recording: TrackedRecording, states: States, run: Run, pieces: int) -> list[Track]:
    """Parts of equal length; what has momentum runs free from the beginning of the run."""
    windows = (len(run.time) - 1 - LEAD) // STEPS_PER_WINDOW // pieces
    bounds, nothing = STEPS_PER_WINDOW * np.arange(windows + 1), np.zeros(windows, bool)
    found = []
    for i in range(pieces):
        lead = LEAD + i * windows * STEPS_PER_WINDOW
        part = slice(lead, lead + windows * STEPS_PER_WINDOW + 1)
        time, poses = run.time[part], run.poses[part]
        phase = np.mod((time[bounds[:-1]] + time[bounds[1:]]) / 2 / states.period, 1.0)
        inside = (states.time >= time[0]) & (states.time <= time[-1])
        track = Track(
            recording, time, run.vertices[part], bounds, ~nothing, np.zeros(windows, int), phase, poses[bounds], poses,
            states.time[inside], states.poses[inside], nothing, np.zeros((windows, 3)), Lead(run, lead),
        )  # fmt: skip
        found.append(track)
    return found


def _missed(model: Model, track: Track) -> Floats:
    """Measured minus predicted displacement of the windows (B - 1, 3)."""
    predicted = (coasting if model.knows("history") else predict)(model, track).displacement
    return np.asarray(relative(track.measured[:-1], track.measured[1:]) - predicted)
