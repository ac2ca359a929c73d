"""Second stage: do markers stand where the servos' shapes put them?

Every frame's chain (joint angles from the servos) is laid rigidly over the markers seen; what is left is white marker
noise, unless a joint's zero, a marker or the length scale is off, or a joint has play behind its servo. The columns of
these effects are derivatives of that chain, with the rigid motions projected out frame by frame.

Legend: F frames (of all trials), N vertices, C columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.special import ndtri

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data import chance
from serpenoid.diagnose.data.cameras.columns import column_count
from serpenoid.diagnose.data.cameras.observation import Observation, across, lying
from serpenoid.diagnose.data.chance import ERROR
from serpenoid.diagnose.data.recordings.recording import Recording
from serpenoid.diagnose.data.shapes.geometry import LEAST_MARKERS, placed, register, turn
from serpenoid.diagnose.data.shapes.shape_in_time import ShapeInTime
from serpenoid.diagnose.data.shapes.smooth import AVERAGED_S
from serpenoid.diagnose.inference.fits.evidence import Evidence
from serpenoid.measure.servo_alignment import QUANTISATION_SD
from serpenoid.measure.shapes.links import link_of_edge, marker_angles

FRAMES_PER_TRIAL = 250
KEPT = 100  # ways of joints across gaps; of ten times as many joints are followed 5 % less often
LEAST_PLAY = 5e-3  # rad: a gap that jitter of the readings does not cross; narrower ones are followed as this one is


@dataclass(frozen=True)
class Sample:
    """Frames of all trials, thinned: markers (F, N, 2), readings (F, m), labels (F,) of gaits, noise [m].

    frame_s, reading_s: between frames and between readings [s]. trials: of each trial all readings and the joint angles
    that markers show (frames, m), and which frames were taken;
    names: of the trials. shapes: of each trial what its readings were smoothed by, the times of its frames and at which
    joints bends are what markers show.
    """

    body: Body
    markers: Floats
    readings: Floats
    labels: np.ndarray
    noise: float
    frame_s: float
    reading_s: float
    trials: tuple[tuple[Floats, Floats, np.ndarray], ...]
    names: tuple[str, ...]
    shapes: tuple[tuple[ShapeInTime, Floats, np.ndarray], ...]

    @cached_property
    def seen(self) -> np.ndarray:
        """Whether a marker was (F, N, 1)."""
        return np.isfinite(self.markers[..., 0])[..., None]

    @cached_property
    def weights(self) -> Floats:
        """One over the noise of each coordinate (F, 2 N); 0 of hidden ones."""
        return np.repeat(self.seen[..., 0] / self.noise, 2, axis=1)

    @cached_property
    def following(self) -> np.ndarray:
        """Whether each frame but the first follows one of its own trial (F - 1,)."""
        first = np.cumsum([len(taken) for *_, taken in self.trials])[:-1]
        return ~np.isin(np.arange(1, len(self.markers)), first)

    @cached_property
    def gaits(self) -> list[np.ndarray]:
        """The frames of each gait, as flags (F,)."""
        return [self.labels == gait for gait in np.unique(self.labels)]

    @cached_property
    def counts(self) -> Floats:
        """Degrees of freedom of each gait: coordinates seen, less the frames' poses."""
        return np.array([2.0 * self.seen[mine].sum() - 3 * mine.sum() for mine in self.gaits])

    @property
    def count(self) -> float:
        """Of all gaits."""
        return float(self.counts.sum())

    @cached_property
    def levels(self) -> Floats:
        """Noise of the averaged markers' joint angles beside readings that are rounded [rad], then of link lengths [m]
        (m + N - 1,)."""
        averaged = self.noise / np.sqrt(max(AVERAGED_S / self.frame_s, 1.0))
        rounded = QUANTISATION_SD / np.sqrt(max(AVERAGED_S / self.reading_s, 1.0))
        angles = np.hypot(averaged * angle_leverage(self.body), rounded)
        return np.concatenate([angles, np.full(self.body.vertices - 1, np.sqrt(2) * averaged)])

    @cached_property
    def readings_variance(self) -> Floats:
        """Of readings (F, m) [rad^2], smoothed as they are: large where few of them are. 0 where markers tell bends."""
        return np.concatenate([np.where(shown, 0.0, s.variance(time)) for s, time, shown in self.shapes])

    @cached_property
    def sums(self) -> dict[bytes, Evidence]:
        """What was asked of evidence of all columns, by the numbers of the observation model that it is about."""
        return {}

    def angles(self, now: Observation) -> Floats:
        """True joint angles (F, m)."""
        true = self.readings + now.zeros
        for joint in np.flatnonzero(now.gaps):
            true[:, joint] = self._across(int(joint), float(now.gaps[joint]), float(now.zeros[joint]))[0]
        return true

    def by_gap(self, now: Observation, joint: int) -> Floats:
        """What a joint's angle (F,) changes by with its gap."""
        gap, zero = float(now.gaps[joint]), float(now.zeros[joint])
        followed = (gap, zero) if gap > LEAST_PLAY else (LEAST_PLAY, 0.0)
        return self._across(joint, *followed)[1]

    def _across(self, joint: int, gap: float, zero: float) -> tuple[Floats, Floats]:
        """A joint's angle (F,) across a gap [rad], and its derivative by the gap. Most models that are tried differ at
        other joints: what this one does is kept."""
        known, numbers = self._crossed, (joint, gap, zero)
        if numbers not in known:
            if len(known) == KEPT:
                known.clear()
            true = [(read[:, joint] + zero, shown[:, joint], taken) for read, shown, taken in self.trials]
            parts = [[x[taken] for x in across(r, gap, lying(r, shown, gap))] for r, shown, taken in true]
            angles, slopes = (np.concatenate(x) for x in zip(*parts, strict=True))
            known[numbers] = angles, slopes
        return known[numbers]

    @cached_property
    def _crossed(self) -> dict[tuple[int, float, float], tuple[Floats, Floats]]:
        """By joint, gap and zero."""
        return {}


def sample(recordings: Sequence[Recording]) -> Sample:
    """Thin the recordings; the noise comes from neighbouring frames."""
    body = recordings[0].body
    markers, readings, labels, trials, splines = [], [], [], [], []
    gaits = {name: i for i, name in enumerate(dict.fromkeys(r.gait for r in recordings))}
    for r in recordings:
        seen = np.isfinite(r.markers[..., 0]).sum(axis=1)
        inside = np.flatnonzero((seen >= LEAST_MARKERS) & (r.time < r.end))
        some = inside[:: max(len(inside) // FRAMES_PER_TRIAL, 1)]
        markers.append(r.markers[some])
        readings.append(r.angles[some])
        trials.append((r.angles, marker_angles(body, r.markers), some))
        labels.append(np.full(len(some), gaits[r.gait]))
        splines.append((r.shape, r.time[some], r.by_markers))
    noise, frame_s = (float(np.median(x)) for x in zip(*((r.marker_noise, r.frame_s) for r in recordings), strict=True))
    reading_s = float(np.median([np.median(np.diff(r.log_time)) for r in recordings]))
    return Sample(
        body, np.concatenate(markers), np.concatenate(readings), np.concatenate(labels), noise, frame_s, reading_s,
        tuple(trials), tuple(r.name for r in recordings), tuple(splines),
    )  # fmt: skip


def misfit(data: Sample, now: Observation) -> float:
    """Chi squared of the sample at an observation model."""
    return float((left_over(data, now) ** 2).sum())


def left_over(data: Sample, now: Observation) -> Floats:
    """What an observation model leaves of all coordinates (2 F N,), in units of marker noise; 0 of hidden ones."""
    return _left_by(data, now, data.angles(now))[1].ravel()


def misfit_beside(data: Sample, now: Observation, joints: Sequence[int]) -> float:
    """The same where the angles of these joints are free in every frame."""
    angles = data.angles(now)
    base, rows, headings = _left_by(data, now, angles)
    by_gap = partial(data.by_gap, now)
    bends = now.derivatives(data.body, angles, by_gap, joints, headings)  # a zero's column: bends
    turned = np.where(data.seen, bends, 0.0).reshape(len(joints), *rows.shape)
    free = np.concatenate([np.swapaxes(_rigid(base, data.seen), 1, 2), np.moveaxis(turned, 0, -1)], axis=2)
    taken = np.swapaxes(np.linalg.qr(free)[0], 1, 2) @ rows[..., None]
    return float((rows**2).sum() - (taken**2).sum())


def beside_readings(data: Sample, now: Observation) -> float:
    """Mean square of what an observation model leaves of all coordinates, over what noise makes of it in each frame,
    that of the readings included:

    E_f = 1 + sum_j v_fj |z_fj|^2 / n_f     v: variance of a reading, z: what a bend moves of the markers, rigid motions
    taken away, in units of their noise, n: degrees of freedom of the frame
    """
    angles, joints = data.angles(now), range(data.body.joint_count)
    base, rows, headings = _left_by(data, now, angles)
    bends = now.derivatives(data.body, angles, partial(data.by_gap, now), joints, headings)  # a zero's column: bends
    moved = np.moveaxis(bends.reshape(len(joints), *rows.shape) * data.weights, 0, 1)
    inside = moved @ np.swapaxes(_rigid(base, data.seen), 1, 2)
    squares = (moved**2).sum(axis=2) - (inside**2).sum(axis=2)
    freedom = 2.0 * data.seen[..., 0].sum(axis=1) - 3
    expected = 1 + (data.readings_variance * squares).sum(axis=1) / freedom
    return float(((rows**2).sum(axis=1) / expected).sum() / freedom.sum())


def evidence(data: Sample, now: Observation, columns: Sequence[int] | None = None) -> Evidence:
    """Residuals and columns (all, or those given) of the sample at an observation model, in units of marker noise."""
    body, seen = data.body, data.seen
    chosen = range(column_count(body)) if columns is None else columns
    angles = data.angles(now)
    base, rows, headings = _left_by(data, now, angles)
    slopes = now.derivatives(body, angles, partial(data.by_gap, now), chosen, headings)
    flat = slopes.reshape(len(chosen), *rows.shape)
    flat *= data.weights
    rigid = np.moveaxis(flat, 0, 1) @ np.swapaxes(_rigid(base, seen), 1, 2)  # (F, C, 3): taken away, frame by frame
    matrices, vectors, constants = [], [], []
    for mine in data.gaits:
        x, r = flat.take(np.flatnonzero(mine), axis=1).reshape(len(chosen), -1), rows[mine].ravel()
        inside = np.moveaxis(rigid[mine], 1, 0).reshape(len(chosen), -1)
        matrices.append(x @ x.T - inside @ inside.T)
        vectors.append(x @ r)
        constants.append(r @ r)
    return Evidence(np.stack(matrices), np.stack(vectors), np.array(constants), data.counts)


def channels_left(data: Sample, now: Observation) -> Floats:
    """What an observation model leaves of the channels, marker angles and link lengths (F, 2 m + 1), over the noise
    level; NaN where markers do not show it."""
    return shown_otherwise(data.body, data.markers, data.angles(now), now) / data.levels


def by_trial(data: Sample, left: Floats, channel: int) -> tuple[Floats, float]:
    """What a joint is bent [rad], or an edge longer [m], than an observation model says, on average in each trial (T,),
    and what is left about these averages: its mean square without white noise, as a share. left: `channels_left`."""
    own = left[:, channel]
    trial, seen = _trial_of(data), np.isfinite(own)
    means = np.array([np.median(own[seen & (trial == t)]) if (seen & (trial == t)).any() else np.nan
                      for t in range(len(data.trials))])  # fmt: skip
    whole, about = (np.nanmean((x[1:] * x[:-1])[data.following]) for x in (own, own - means[trial]))
    return means * data.levels[channel], float(max(about, 0.0) / whole)


def structure_by_trial(data: Sample, left: Floats, channel: int) -> Floats:
    """`chance.structure` of one channel in each trial alone (T,); NaN where a trial shows nothing of it."""
    own, trial = left[:, [channel]], _trial_of(data)
    inside = [np.flatnonzero(trial == t) for t in range(len(data.trials))]
    found = np.concatenate([chance.structure(own[rows], data.following[rows[:-1]]) for rows in inside])
    shown = [bool(np.isfinite(own[rows]).any()) for rows in inside]
    return np.where(shown, found, np.nan)


def _trial_of(data: Sample) -> np.ndarray:
    """Number (F,) of each frame's trial."""
    return np.repeat(np.arange(len(data.trials)), [len(taken) for *_, taken in data.trials])


def shown_otherwise(body: Body, markers: Floats, angles: Floats, now: Observation) -> Floats:
    """Joint angles [rad] and edges [m] that markers (F, N, 2) show, less those of an observation model (F, m + N - 1);
    angles: the true ones."""
    seen, markers = now.seen(body, angles), now.unstretched(markers)
    angle = np.mod(marker_angles(body, markers) - marker_angles(body, seen) + np.pi, 2 * np.pi) - np.pi
    length = np.linalg.norm(np.diff(markers, axis=1), axis=2) - np.linalg.norm(np.diff(seen, axis=1), axis=2)
    return np.asarray(np.concatenate([angle, length], axis=1))


def along(data: Sample, now: Observation, columns: Sequence[int], amounts: Floats) -> tuple[float, float]:
    """Mean squares of what an observation model leaves in the direction in which these amounts of its columns move the
    markers of each frame, beyond noise and as much again, and of how far they move them; in units of marker noise.

    As of `chance.structure`, white noise is not in it, nor what chance alone makes of it.
    """
    angles = data.angles(now)
    base, rows, headings = _left_by(data, now, angles)
    slopes = now.derivatives(data.body, angles, partial(data.by_gap, now), columns, headings) * data.seen
    moved = np.tensordot(amounts, slopes, axes=1).reshape(rows.shape) / data.noise
    rigid = _rigid(base, data.seen)
    moved -= ((rigid @ moved[..., None]) * rigid).sum(axis=1)
    far = np.linalg.norm(moved, axis=1)
    off = (rows * moved).sum(axis=1) / np.maximum(far, 1e-12)
    products = (off[1:] * off[:-1])[data.following]
    by_chance = ndtri(1 - ERROR) * float((off**2).mean()) / np.sqrt(len(products))
    left = float(products.mean()) - by_chance - 1 / max(AVERAGED_S / data.frame_s, 1.0)
    return max(left, 0.0), float((far**2).mean())


def _left_by(data: Sample, now: Observation, angles: Floats) -> tuple[Floats, Floats, Floats]:
    """Chains (F, N, 2) in the body frame, what they leave of the markers there (F, 2 N), in units of noise, and their
    headings on the floor (F,)."""
    base = now.seen(data.body, angles)
    pose, left = register(base, now.unstretched(data.markers))
    residual = np.where(data.seen, turn(-pose[:, None, 2], np.where(data.seen, left, 0.0)), 0.0)
    return base, residual.reshape(len(base), -1) / data.noise, pose[:, 2]


def _rigid(points: Floats, seen: np.ndarray) -> Floats:
    """Orthonormal rigid motions of the visible points, (F, 3, 2 N): along x and y, and about the middle of them."""
    share = seen / np.sqrt(seen.sum(axis=1, keepdims=True))
    middle = (share**2 * points).sum(axis=1, keepdims=True)
    arm = np.where(seen, points - middle, 0.0)
    found = np.zeros((len(points), 3, *points.shape[1:]))
    found[:, 0, :, 0] = found[:, 1, :, 1] = share[..., 0]
    found[:, 2, :, 0], found[:, 2, :, 1] = -arm[..., 1], arm[..., 0]
    found[:, 2] /= np.sqrt((arm**2).sum(axis=(1, 2), keepdims=True))
    return found.reshape(len(points), 3, -1)


def signature(data: Sample, now: Observation, before: Observation) -> Floats:
    """RMS of what an observation model changes over noise (m + N,), from another one: marker angles over readings, link
    lengths, and by its axes the paths of trials."""
    return np.append(_changed(data, now, before), _along_paths(data, now, before))


def _along_paths(data: Sample, now: Observation, before: Observation) -> float:
    """RMS over trials of what axes change of the way from the first frame to the last, over the noise of its ends."""
    frames = np.array([len(taken) for *_, taken in data.trials])
    last = np.cumsum(frames)[frames > 0] - 1
    middle = np.nanmean(data.markers, axis=1)
    ways = middle[last] - middle[last - frames[frames > 0] + 1]
    longer, level = now.stretched(ways) - before.stretched(ways), data.levels[-1] / np.sqrt(data.body.vertices)
    return float(np.sqrt((longer**2).sum(axis=1).mean()) / level)


def apart(data: Sample, one: Observation, other: Observation) -> float:
    """How far two observation models' data differ: the worst joint's or link's RMS, over the noise level."""
    return float(_changed(data, one, other).max())


def _changed(data: Sample, one: Observation, other: Observation) -> Floats:
    """RMS (2 m + 1,) of what two observation models' joints and links differ by, over the noise level."""
    return np.asarray(np.sqrt(((_shown(data, one) - _shown(data, other)) ** 2).mean(axis=0)))


def _shown(data: Sample, effect: Observation) -> Floats:
    """Marker angles minus readings, and link lengths minus known ones, over the noise level (F, 2 m + 1)."""
    body = data.body
    seen = effect.seen(body, data.angles(effect))
    if effect.axes.any():
        seen = effect.stretched(placed(seen, register(seen, effect.unstretched(data.markers))[0]))
    angle = np.mod(marker_angles(body, seen) - data.readings + np.pi, 2 * np.pi) - np.pi
    length = np.linalg.norm(np.diff(seen, axis=1), axis=2) - body.edges_m
    return np.asarray(np.concatenate([angle, length], axis=1) / data.levels)


def angle_leverage(body: Body) -> Floats:
    """Noise of a joint's angle (m,) [rad] for each metre of a marker's, the three of its two links."""
    edge, link = body.edges_m, link_of_edge(body)
    a, b = (1 / np.bincount(link, edge)[part] for part in (slice(None, -1), slice(1, None)))
    return np.asarray(np.sqrt(a**2 + b**2 + (a + b) ** 2))
