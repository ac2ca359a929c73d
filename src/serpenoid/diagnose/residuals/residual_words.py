"""What is left above chance, in words: where, when, which direction, which sign."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.paths import PathNoise
from serpenoid.diagnose.data.noise.shared import repeatable
from serpenoid.diagnose.data.noise.untold import Untold, untold
from serpenoid.diagnose.data.used import length_unit
from serpenoid.diagnose.data.windows.windows import Prediction
from serpenoid.diagnose.inference.fits.finding import VISIBLE
from serpenoid.diagnose.residuals.pushes import calm, pushed, trace

DIRECTIONS = ("forward or backward", "sideways", "in turning")
SIGNS = (
    ("moves", "farther forward", "less far forward"),
    ("moves", "farther to the left", "farther to the right"),
    ("turns", "more to the left", "more to the right"),
)
ONE_SIGN = 0.5  # mean over RMS from which a sign is spoken of
MOST = 0.5  # of the squares above chance


def pattern(motion: Motion, predictions: Sequence[Prediction], after_m: float) -> tuple[str, ...]:
    """Sentences about what is left, or none. after_m: RMS of paths."""
    left = residuals(motion.tracks, predictions)
    shared, pushes = repeatable(motion, left), pushed(motion, left)
    words = []
    if shared.news:
        worst = int(shared.by.argmax())
        tracked = motion.tracks[0].noise is not None  # points alone: no beat is as the next, and has no phases
        verb = "is" if tracked else "repeats:"
        size = f"{shared.ratio:.1f} times the noise in variance"
        words.append(f"what is left {verb} {size}, most of it {DIRECTIONS[worst]}")
        words += _moment(motion, left) or ([] if tracked else _when(motion, left, worst))
        words += _where(motion, left)
    room = untold(motion, left)
    if room is not None:
        words.append(laid_otherwise(room))
    noise = calm(motion, predictions, left, pushes)
    if _astray(noise, after_m):
        words.append(f"predicted paths are off by {after_m / noise.level_m:.1f} times the noise")
    if trace(motion, predictions, pushes) > VISIBLE * noise.level_m:
        words.append(
            "single trials were pushed as no law of the floor explains (a stone, a groove, a cable)"
            f"{where_pushed(motion, pushes)}"
        )
    return tuple(words)


def astray(motion: Motion, predictions: Sequence[Prediction], after_m: float) -> bool:
    """Whether paths stray from the measured ones by more than chance makes them. after_m: RMS of paths."""
    left = residuals(motion.tracks, predictions)
    return _astray(calm(motion, predictions, left, pushed(motion, left)), after_m)


def _astray(noise: PathNoise, after_m: float) -> bool:
    return after_m > noise.farthest * noise.level_m


def laid_otherwise(room: Untold) -> str:
    """Of trials that differ by more than chance, none of which was laid as another."""
    usual = "cycles of one trial do" if room.by_cycles else "the markers' noise makes them"
    return (
        f"trials of one setting differ by {room.ratio:.1f} times as much as {usual}, and none was laid as another was; "
        "something in the room is missing in the model, or trials vary: lay each twice alike to tell"
    )


def where_pushed(motion: Motion, pushes: Sequence[tuple[int, int, Floats]]) -> str:
    """Where the largest is to be looked for."""
    index, window, moved = max(pushes, key=lambda push: float(np.hypot(*push[2][:2])))
    track = motion.tracks[index]
    begin, end = track.time[track.boundaries[[window, window + 1]]]
    scale, unit = {"m": (1e3, "mm"), "bl": (1.0, "body lengths")}[length_unit(motion.tracks)]
    size = f"{scale * float(np.hypot(*moved[:2])):.3g} {unit}"
    return f": {size} between {begin:.1f} and {end:.1f} s of `{track.recording.name}` or of its repeat"


def _moment(motion: Motion, left: Sequence[Floats]) -> list[str]:
    """One moment, where a window and its neighbours hold most of what is above chance: no phase of the cycle."""
    beyond = [np.nansum((x / motion.noise.of(t)) ** 2 - 1, axis=1) for t, x in zip(motion.tracks, left, strict=True)]
    about = [np.convolve(b, np.ones(3), mode="same") for b in beyond]
    index = int(np.argmax([a.max(initial=-np.inf) for a in about]))
    if about[index].max(initial=0.0) <= MOST * sum(float(b.sum()) for b in beyond):
        return []
    track, window = motion.tracks[index], int(beyond[index].argmax())
    begin, end = track.time[track.boundaries[[window, window + 1]]]
    return [f"most of it between {begin:.1f} and {end:.1f} s of `{track.recording.name}` or just beside"]


def _when(motion: Motion, left: Sequence[Floats], component: int) -> list[str]:
    groups: dict[str, list[Floats]] = {}
    for track, x in zip(motion.tracks, left, strict=True):
        white = x / motion.noise.of(track)
        for i in range(len(x)):
            name = f"phase {track.phase[i]:.2f} of the cycle" if track.playing[i] else "pauses"
            groups.setdefault(name, []).append(white[i])
    sizes = {k: np.sqrt(np.nanmean(np.square(v))) for k, v in groups.items() if np.isfinite(v).any()}
    worst = max(sizes, key=lambda k: sizes[k])
    own = np.array(groups[worst])[:, component]
    mean, rms = float(np.nanmean(own)), float(np.sqrt(np.nanmean(own**2)))
    does, more, less = SIGNS[component]
    way = (more, less)[mean < 0] if abs(mean) > ONE_SIGN * rms else f"now {more}, now {less}"
    return [f"largest in {worst} ({sizes[worst]:.1f} times the noise): the body {does} {way} than modelled"]


def _where(motion: Motion, left: Sequence[Floats]) -> list[str]:
    place, size = [], []
    for track, x in zip(motion.tracks, left, strict=True):
        white = (x / motion.noise.of(track)) ** 2
        place.append(track.on_floor[track.boundaries[:-1], :2])
        size.append(white.mean(axis=1))
    p, s = np.concatenate(place), np.concatenate(size)
    good = np.isfinite(s)
    p, s = p[good], s[good]
    centre = (p * s[:, None]).sum(axis=0) / s.sum()
    spread = np.sqrt((((p - centre) ** 2).sum(axis=1) * s).sum() / s.sum())
    usual = np.sqrt(((p - p.mean(axis=0)) ** 2).sum(axis=1).mean())
    if spread < 0.75 * usual:
        unit = {"m": "m", "bl": "body lengths"}[length_unit(motion.tracks)]
        return [f"gathered on the floor about x = {centre[0]:.2f} {unit}, y = {centre[1]:.2f} {unit}"]
    return []
