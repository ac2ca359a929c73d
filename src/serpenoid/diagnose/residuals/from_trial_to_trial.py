"""Whether trials differ as floors do: by what another anisotropy ratio in each of them would make.

Differences of repeats are what chance is told by, so a floor that is another in every trial would hide in it. Of a pair
of repeats, in units of chance,

    (r_a - r_b) / sqrt 2 = J (eps_a - eps_b) / sqrt 2 + e,    J = d(displacement) / d(eps)

one number of each pair is held against all that is left (Fisher's F); successive windows of e tell how many numbers
that is worth. What repeats of a reference already differed by is no news. Where repeats agree, and gaits do not (they
were played on several days), one number of each trial is held against what is left: that is a hint, for gaits differ by
another law of the floor, too.

Beside a reference that was played twice, too, chance is known: paths of repeats that are farther apart than they were
then are news (`more_than_before`).

Legend: P pairs, K windows that were played twice.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np
from scipy.special import fdtri

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import LEFT, largest_factor
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.paths import apart_by_setting, differing, path_rms, total
from serpenoid.diagnose.data.noise.repeats import UNLIKE, laid_alike, pairs, repeats
from serpenoid.diagnose.data.windows.windows import Prediction, predictions
from serpenoid.diagnose.inference.fits.finding import Divided, alone
from serpenoid.model import Model
from serpenoid.simulation.sensitivity import EPS
from serpenoid.wording import listed

TINY = 1e-300
MOST = 0.5  # of the squares that repeats differ by: then it is what they differ by


def as_floors_do(motion: Motion, predicted: Sequence[Prediction], eps: float) -> tuple[str, ...]:
    """What is said of trials of one setting that differ so, or nothing; eps: of the model that predicts."""
    if any(t.noise is not None for t in motion.tracks) or not pairs(motion.tracks):
        return ()
    left, chance, moves = _parts(motion, predicted)
    explained, rest = 0.0, []
    for repeat in repeats(motion.tracks):
        (one, other), (sd, _), (by, _) = (repeat.both(x) for x in (left, chance, moves))
        d = (one - other) / np.sqrt(2)
        known = np.isfinite(d + by).all(axis=1) & motion.tracks[repeat.one].playing[repeat.here]
        d, by = (np.where(np.abs(d) > motion.unlike, d, 0.0) / sd)[known], (by / sd)[known]
        step, gained = _step(d, by)
        explained += gained
        rest.append(d - step * by)
    beyond = float(sum((e**2).sum() for e in rest))
    worth = _worth(rest) - len(rest)
    if worth < 1 or explained <= MOST * (explained + beyond):
        return ()
    if explained / len(rest) <= fdtri(len(rest), worth, 1 - LEFT) * beyond / worth:
        return ()
    found = [eps + _step(x / c, m / c)[0] for x, m, c in zip(left, moves, chance, strict=True)]
    return (
        f"{explained / (explained + beyond):.0%} of what trials of one setting differ by is an anisotropy ratio of its "
        f"own in each: {_ends(motion, found)}. Do floor, wheels or skin change from trial to trial? Diagnose those "
        "that are alike, with the others as `--reference`",
    )


def one_in_each(motion: Motion, predicted: Sequence[Prediction], eps: float) -> tuple[str, ...]:
    """What is said where something is left, and an anisotropy ratio of its own in each trial takes most of it away."""
    if any(t.noise is not None for t in motion.tracks):
        return ()
    parts = [(x / c, m / c) for x, c, m in zip(*_parts(motion, predicted), strict=True)]
    steps, gained = zip(*(_step(*p) for p in parts), strict=True)
    share = sum(gained) / max(sum(float(np.nansum(x**2)) for x, _ in parts), TINY)
    if share <= MOST:
        return ()
    return (
        f"an anisotropy ratio of its own in each trial would take away {share:.0%} of what is left: "
        f"{_ends(motion, [eps + step for step in steps])}. Were they played on several floors or days, or is the law "
        "another?",
    )


def more_than_before(motion: Motion, predicted: Sequence[Prediction], model: Model) -> Divided | None:
    """Where paths of repeats are much farther apart than those of the same settings were in an earlier campaign: a
    change acts in some trials, and what it does there is no chance. model: of which eps is fitted."""
    if motion.ratio is None or not motion.earlier.apart:
        return None
    now, then = ({s: told for s, *told in of} for of in (apart_by_setting(motion, predicted), motion.earlier.apart))
    both = now.keys() & then.keys()
    if not both:
        return None
    (level, pairs), (before, earlier) = (_pooled([told[s] for s in both]) for told in (now, then))
    ratio = level / max(before, TINY)
    if ratio <= max(UNLIKE, largest_factor(float(np.sqrt(0.5 / pairs + 0.5 / earlier)))):
        return None
    changed, others = _moving_as_then(motion, model, both)
    words = f"trials of one setting differ by {ratio:.{1 if ratio < 10 else 0}f} times as much as in the reference"
    if not changed or not others:
        return Divided(f"{words}: what has changed does not act in all of them alike")
    return Divided(
        f"{words}: something changed amid the campaign, and acts in {alone(changed, others)}", changed, others
    )


def after_some(motion: Motion, model: Model) -> Divided | None:
    """Where trials of settings that were played in an earlier campaign move as that predicts until one of them, and
    not from it on, or not in a run of them: that may be other gaits, too, so it is `perhaps`."""
    if motion.ratio is None or not motion.earlier.apart:
        return None
    changed, others = _moving_as_then(motion, model, {setting for setting, *_ in motion.earlier.apart})
    off = [t.recording.name in changed for t in motion.tracks if t.recording.name in {*changed, *others}]
    if not changed or not others or off[0] or sum(a != b for a, b in pairwise(off)) > 2:
        return None
    words = f"all of {listed([f'`{name}`' for name in others])} move as the reference predicts, and no other trial does"
    return Divided(words, changed, others, perhaps=True)


def _moving_as_then(
    motion: Motion, model: Model, settings: Collection[tuple[str, float]]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Names of trials of some settings whose paths stray from what an earlier campaign predicts by more than repeats
    strayed from each other then, and of the others. Repeats that stray from each other by less are told together."""
    before, earlier = _pooled([told for setting, *told in motion.earlier.apart if setting in settings])
    most = before * largest_factor(float(np.sqrt(0.5 / earlier + 0.5)))
    medium = model.medium if motion.ratio is None else model.medium.with_ratio(motion.ratio)
    as_then = predictions(Model(model.body, medium, motion.held), motion.tracks)
    rms = [path_rms(t, p) for t, p in zip(motion.tracks, as_then, strict=True)]
    off: dict[str, bool] = {}
    for group in _agreeing(motion, as_then, most):
        if motion.tracks[group[0]].recording.setting in settings:
            far = total([rms[i] for i in group]) > most
            off |= {motion.tracks[i].recording.name: far for i in group}
    off = {t.recording.name: off[t.recording.name] for t in motion.tracks if t.recording.name in off}
    changed, others = (tuple(name for name, is_off in off.items() if is_off is wanted) for wanted in (True, False))
    return changed, others


def _agreeing(motion: Motion, predicted: Sequence[Prediction], most: float) -> list[list[int]]:
    """Trials by number, with the repeats whose paths are no farther apart than `most` [m]."""
    apart = differing(motion, predicted, residuals(motion.tracks, predicted))
    groups = [[i] for i in range(len(motion.tracks))]
    for a, b in laid_alike(motion.tracks):  # each with the next: b is alone yet
        if np.sqrt(apart[a]) <= most:
            groups[a].append(b)
            groups[b] = groups[a]
    return [group for i, group in enumerate(groups) if group[0] == i]


def _pooled(told: Sequence[Sequence[float]]) -> tuple[float, int]:
    """RMS of several, and of how many pairs."""
    pairs = sum(count for _, count in told)
    return float(np.sqrt(sum(count * rms**2 for rms, count in told) / pairs)), int(pairs)


def _parts(motion: Motion, predicted: Sequence[Prediction]) -> tuple[list[Floats], list[Floats], list[Floats]]:
    """Of each track what is left, what chance makes, and what eps moves (W, 3)."""
    moves = [p.by((EPS,))[..., 0] for p in predicted]
    return residuals(motion.tracks, predicted), [motion.noise.chance(t) for t in motion.tracks], moves


def _step(left: Floats, by: Floats) -> tuple[float, float]:
    """By what eps is off, and what it takes away: of what is left and what eps moves, both in units of chance."""
    known = np.isfinite(left + by)
    power = max(float((by[known] ** 2).sum()), TINY)
    step = float((by[known] * left[known]).sum()) / power
    return step, step**2 * power


def _ends(motion: Motion, found: Sequence[float]) -> str:
    """The least and the largest of all trials' values."""
    names = [t.recording.name for t in motion.tracks]
    least, most = int(np.argmin(found)), int(np.argmax(found))
    return f"{found[least]:.3g} in `{names[least]}` to {found[most]:.3g} in `{names[most]}`"


def _worth(rest: Sequence[Floats]) -> float:
    """How many independent numbers windows (K, 3) of each pair are, by how alike successive ones are."""
    count = sum(e.size for e in rest)
    squares = sum(float((e**2).sum()) for e in rest)
    alike = sum(float((e[1:] * e[:-1]).sum()) for e in rest) / max(squares, 1e-300)
    alike = min(max(alike, 0.0), 1.0)
    return count * (1 - alike) / (1 + alike)
