"""What windows add up to: paths, how far they stray, and how far chance makes them stray (the noise level F).

F: RMS over a trial's path of the distance that the noise of windows, strung together, adds up to, or that repeats show.
What a law gets wrong recurs in every cycle; what earlier trials showed in a window is as doubtful as their chance made
it, in each cycle anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import CONFIDENCE, largest_factor
from serpenoid.diagnose.data.noise.motion import Apart, Motion, Repeated
from serpenoid.diagnose.data.noise.noise import noise_uncertain, residuals
from serpenoid.diagnose.data.noise.repeats import laid_alike
from serpenoid.diagnose.data.shapes.geometry import GYRATION, turn
from serpenoid.diagnose.data.windows.windows import Prediction, Track
from serpenoid.group import accumulate, relative

DRAWS = 48


@dataclass(frozen=True)
class PathNoise:
    """How far chance makes paths stray: RMS over all trials [m] in each draw (DRAWS,).

    motion: whose windows tell how large the draws are; pairs: of repeats, if their paths do.
    """

    draws: Floats
    motion: Motion
    pairs: int = 0

    @cached_property
    def uncertain(self) -> float:
        """Standard deviation of the logarithm of what the draws' size is told by. A path that adds up, as a pair of
        them, is one number."""
        if self.pairs:
            return float(np.sqrt(0.5 / self.pairs + 0.5 / len(self.motion.tracks)))
        return noise_uncertain(self.motion)

    @cached_property
    def scatter(self) -> float:
        """Standard deviation of the logarithm of the draws."""
        return float(np.log(self.draws / self.level_m).std())

    @property
    def level_m(self) -> float:
        """F [m]."""
        return total(self.draws)

    @property
    def deviation(self) -> float:
        """Of the logarithm of how far paths stray: as draws of it scatter, and as well as is told how large it is."""
        return float(np.hypot(self.scatter, self.uncertain))

    @property
    def farthest(self) -> float:
        """How many noise levels paths stray by chance at most, at the stated error."""
        return largest_factor(self.deviation)


def path_noise(motion: Motion, predictions: Sequence[Prediction], left: Sequence[Floats] | None = None) -> PathNoise:
    """What the noise of windows adds up to; or what paths of trials that were laid alike differ by, where windows of
    these add up to less in 95 of 100 draws: a floor that differs from trial to trial shows little in a window, and adds
    up.

    left: residuals (W, 3) of each track that are compared, if not all.
    """
    left = residuals(motion.tracks, predictions) if left is None else left
    adding, made, here = _of_windows(motion, predictions, left)
    told = here.beside(motion.earlier)
    size = float(np.sqrt(told.square))
    beyond = float(np.log(size)) / ndtri(CONFIDENCE) if size > 1 else 0.0
    if beyond <= made.scatter or beyond <= made.deviation:  # in this order: the deviation costs more
        return adding
    return PathNoise(adding.draws * size, motion, told.pairs)


def repeated(motion: Motion, predictions: Sequence[Prediction]) -> Repeated:
    """What trials that were laid alike tell."""
    by_paths = _of_windows(motion, predictions, residuals(motion.tracks, predictions))[2]
    return by_paths._replace(scattered=motion.noise.memory.scattered, apart=apart_by_setting(motion, predictions))


def apart_by_setting(motion: Motion, predictions: Sequence[Prediction]) -> Apart:
    """Of trials that were laid alike."""
    found: dict[tuple[str, float], list[float]] = {}
    for number, squared in differing(motion, predictions, residuals(motion.tracks, predictions)).items():
        found.setdefault(motion.tracks[number].recording.setting, []).append(squared)
    return tuple((setting, float(np.sqrt(np.mean(squares))), len(squares)) for setting, squares in found.items())


def _of_windows(
    motion: Motion, predictions: Sequence[Prediction], left: Sequence[Floats]
) -> tuple[PathNoise, PathNoise, Repeated]:
    """What the noise of windows adds up to: with doubt about the baseline; without it, of trials that were repeated.
    And how far apart repeats are."""
    alone, whole = _squares(motion, predictions)
    differ = differing(motion, predictions, left)
    adding = PathNoise(np.sqrt(whole.mean(axis=0)), motion)
    made = PathNoise(np.sqrt(alone[list(differ)].mean(axis=0)), motion) if differ else adding
    if not differ or made.level_m <= 0:
        return adding, adding, Repeated()
    return adding, made, Repeated(sum(differ.values()) / len(differ) / made.level_m**2, len(differ))


def differing(motion: Motion, predictions: Sequence[Prediction], left: Sequence[Floats]) -> dict[int, float]:
    """By trial: half of the mean squared distance [m^2] between its path and that of the next one that was laid alike,
    of what residuals add up to on the predicted one."""
    differ = {}
    for a, b in laid_alike(motion.tracks):
        steps, count = np.nan_to_num(predictions[a].displacement), min(len(left[a]), len(left[b]))
        known = np.flatnonzero(np.isfinite(left[a][:count] + left[b][:count]).all(axis=1))
        ends = []
        for x in (left[a], left[b]):
            moved = steps.copy()
            moved[known] += x[known]
            ends.append(accumulate(moved, np.zeros(3))[:, :2])
        squared = ((ends[0] - ends[1]) ** 2).sum(axis=1) / 2
        differ[a] = float(_mean_in_time(motion.tracks[a], squared))
    return differ


def _squares(motion: Motion, predictions: Sequence[Prediction]) -> tuple[Floats, Floats]:
    """Squared path RMS [m^2] of each trial (trials, DRAWS) by the chance of its windows alone, and with doubt about the
    baseline."""
    rng = np.random.default_rng(0)
    alone, whole = np.empty((2, len(motion.tracks), DRAWS))
    for i, (track, p) in enumerate(zip(motion.tracks, predictions, strict=True)):
        chance = motion.noise.chance(track)
        if track.noise is None:
            chance[~track.playing] = np.broadcast_to(track.least, chance.shape)[~track.playing]
        window, phase = np.unique(track.phase, return_inverse=True)
        drawn = motion.noise.memory.draws(track, chance, rng, DRAWS)
        again = rng.normal(size=(DRAWS, len(window), 3))[:, phase]
        alone[i] = whole[i] = _strayed(track, p, drawn)
        if np.any(track.doubt):
            unlike = motion.noise.memory.draws(track, chance, rng, DRAWS)
            unlike = np.divide(unlike, chance, out=np.zeros_like(unlike), where=chance > 0)
            whole[i] = _strayed(track, p, drawn + np.where(track.recurs, again, unlike) * track.doubt)
    return alone, whole


def _strayed(track: Track, p: Prediction, drawn: Floats) -> Floats:
    """Mean square [m^2] of how far displacements (.., B - 1, 3) that are added to the predicted ones move the path."""
    steps = np.nan_to_num(p.displacement)
    true = accumulate(steps, np.zeros(3))[:, :2]
    drawn[..., : track.first_seen, :] = 0.0
    paths = accumulate(steps + drawn, np.zeros(3))[..., :2]
    return _mean_in_time(track, ((paths - true) ** 2).sum(axis=-1))


def _mean_in_time(track: Track, values: Floats) -> Floats:
    """Of values (..., B) at the boundaries."""
    weight = track.duration
    return np.asarray(((values[..., 1:] + values[..., :-1]) / 2 * weight).sum(axis=-1) / weight.sum())


def path_rms(track: Track, predicted: Prediction, mend: bool = False) -> float:
    """RMS distance [m] of the measured path from the predicted one, started at the first pose that was seen.

    mend: what the model does not account for across gaps of all markers is taken out first.
    """
    first, at_bounds = track.first_seen, track.poses[track.boundaries]
    path = at_bounds[:, :2].copy()
    path[first:] = accumulate(np.nan_to_num(predicted.displacement[first:]), at_bounds[first])[:, :2]
    measured = track.measured[:, :2].copy()
    if mend:
        for first, last, step in gap_steps(track, predicted):
            measured[last:] -= turn(track.measured[first, 2], step[:2])
    miss = ((measured - path) ** 2).sum(axis=1)
    known = np.isfinite(miss)
    return float(np.sqrt(_mean_in_time(track, np.interp(np.arange(len(miss)), np.flatnonzero(known), miss[known]))))


def path_error(motion: Motion, predictions: Sequence[Prediction], mend: bool = False) -> float:
    """The same over all trials [m]."""
    return total([path_rms(t, p, mend) for t, p in zip(motion.tracks, predictions, strict=True)])


def gap_steps(track: Track, predicted: Prediction) -> list[tuple[int, int, Floats]]:
    """(boundary before, boundary after, unaccounted displacement (3,)) of every gap of all markers, but where it was
    put elsewhere."""
    known = np.isfinite(track.measured[:, 0])
    found, i, last = [], 0, len(track.gap_windows)
    while i < last:
        if not track.gap_windows[i]:
            i += 1
            continue
        a = i
        while a > 0 and not known[a]:
            a -= 1
        b = i + 1
        while b < last and (not known[b] or track.gap_windows[b]):
            b += 1
        if known[a] and known[b] and not track.put_windows[a:b].any():
            said = accumulate(np.nan_to_num(predicted.displacement[a:b]), np.zeros(3))[-1]
            found.append((a, b, relative(track.measured[a], track.measured[b]) - said))
        i = b
    return found


def strays(track: Track, displacement: Floats, changes: Floats) -> float:
    """Mean square distance [m^2] of the path that displacements (B - 1, 3) add up to from those with each of several
    changes (B - 1, 3, K), all of one start, summed over K."""
    steps = np.nan_to_num(displacement)
    path = accumulate(steps, np.zeros(3))[:, :2]
    others = accumulate(steps + np.nan_to_num(np.moveaxis(changes, 2, 0)), np.zeros(3))[..., :2]
    return float(_mean_in_time(track, ((others - path) ** 2).sum(axis=-1)).sum())


def total(values: Sequence[float] | Floats) -> float:
    """RMS over trials."""
    return float(np.sqrt(np.mean(np.square(values))))


def strength(motion: Motion, full: Sequence[Prediction], without: Sequence[Prediction]) -> float:
    """Path RMS [m] between two models' paths on the same shapes, start poses fitted."""
    trios = zip(motion.tracks, full, without, strict=True)
    return total([apart(track, a.displacement, b.displacement) for track, a, b in trios])


def apart(track: Track, one: Floats, other: Floats) -> float:
    """Path RMS [m] between the paths that two trials' displacements (B - 1, 3) add up to, start poses fitted."""
    here, there = (accumulate(np.nan_to_num(x), np.zeros(3)) for x in (one, other))
    gyration = GYRATION * track.recording.body.total_length_m
    return float(np.sqrt(_mean_in_time(track, ((here[:, :2] - _registered(there, here, gyration)) ** 2).sum(axis=1))))


def _registered(path: Floats, target: Floats, gyration: float) -> Floats:
    """Centroids of `path` (B, 3) moved rigidly to lie closest to `target`, headings included."""

    def points(pose: Floats) -> Floats:
        arm = gyration * np.column_stack([np.cos(pose[:, 2]), np.sin(pose[:, 2])])
        return np.concatenate([pose[:, :2] + arm, pose[:, :2] - arm])

    p, q = points(path), points(target)
    a, b = p - p.mean(axis=0), q - q.mean(axis=0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    c, s = np.cos(angle), np.sin(angle)
    return np.asarray((path[:, :2] - p.mean(axis=0)) @ np.array([[c, s], [-s, c]]) + q.mean(axis=0))
