"""In which trials a joint strays from what is found of it: a law would act in all of them.

It strays in some alone if what those leave is far more than what the others do (`LAW_ERROR`): where all leave about as
much as noise, it is chance which leave a little more. A trial that leaves more than noise, but no more than the law's
error of the worst, is one of the others: servos that lag leave as much. When a trial began is asked of joints that
stray far less: one that does something else would move all of them. That it stands still no gait makes, whichever gaits
the trials are of.

Legend: R log rows of all trials, T trials, m joints.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR, ON_A_LINE, far_less
from serpenoid.diagnose.inference.fits.finding import VISIBLE, Divided
from serpenoid.diagnose.stages.actuation.plays import Plays
from serpenoid.measure.cells import listed

MOSTLY = 0.5  # of what is left: less is no matter of how far a joint goes
TINY = 1e-12  # rad^2: of joints that are told nothing


def trials_astray(data: Plays, played: Floats, joint: int) -> Divided | None:
    """The trials in which a joint (0 .. m - 1) does not do what is played (R, m), if it does in others, or does by less
    and less."""
    trials = [data.trials == t for t in range(len(data.recordings))]
    squares = _squares(data, data.left(played), trials)
    strays = np.where(squares[:, [joint]] > VISIBLE**2, squares, 0.0).sum(axis=0)
    steady = strays < LAW_ERROR**2 * strays[joint]
    left = data.left(played, steady if steady.any() else True)
    squares = _squares(data, left, trials)
    astray = squares > np.maximum(VISIBLE**2, LAW_ERROR**2 * squares.max(axis=0))
    mine = astray[:, joint]
    if not mine.any():
        return None
    trend = _trend(data, played, left, joint)  # a first trial that has little of it does as it was told
    if mine.all() or (trend is not None and _gains(played, left, mine[data.trials])[1][joint] > MOSTLY):
        return trend
    clear = far_less(squares[~mine], squares[mine])
    if not clear[joint]:
        return None
    names = [r.name for r in data.recordings]
    changed, others = (tuple(n for n, is_off in zip(names, of, strict=True) if is_off) for of in (mine, ~mine))
    words, still = _said(data, played, left, mine, clear, astray), _stands(played, left, mine[data.trials], joint)
    return Divided(words, changed, others, any_gait=still)


def _squares(data: Plays, left: Floats, trials: Sequence[np.ndarray]) -> Floats:
    """What each trial leaves of each joint (T, m), in units of noise."""
    return np.array([data.structure_of(left, mine) for mine in trials])


def _stands(played: Floats, left: Floats, rows: np.ndarray, joint: int) -> bool:
    """Whether a joint stands still in these rows (R,) where it is told to move: what it misses is the whole of that."""
    gains, shares = _gains(played, left, rows)
    return bool(abs(gains[joint]) < LAW_ERROR**2 and shares[joint] > 1 - LAW_ERROR**2)


def _said(data: Plays, played: Floats, left: Floats, mine: np.ndarray, clear: np.ndarray, astray: np.ndarray) -> str:
    """Which joints stray, of those whose trials (T,) are clear, in which trials, and how."""
    alike = [j for j in np.flatnonzero(clear).tolist() if (astray[:, j] == mine).all()]
    who = f"joint{'s' if len(alike) > 1 else ''} {listed([str(j + 1) for j in alike])}"
    who = "all joints" if len(alike) == astray.shape[1] > 1 else who
    one = len(alike) == 1
    if mine.sum() > len(mine) / 2:
        return f"{who} {'follows its command' if one else 'follow their commands'} in {_named(data, ~mine)} alone"
    if len(alike) == 2 and _exchanged(data, played, left, mine[data.trials], alike):
        return f"{who} do what the other is told in {_named(data, mine)} alone: wires or numbers exchanged?"
    gains, shares = (x[alike] for x in _gains(played, left, mine[data.trials]))
    far = f", {gains.mean():.2f} times as far as told" if shares.mean() > MOSTLY else ""
    return f"{who} {'strays' if one else 'stray'} in {_named(data, mine)} alone{far}"


def _exchanged(data: Plays, played: Floats, left: Floats, rows: np.ndarray, two: list[int]) -> bool:
    """Whether two joints read, in these rows (R,), what is played for each other, but for a law's error."""
    told, missed = played[rows][:, two], left[rows][:, two]
    other = missed + told - told[:, ::-1]
    return bool((other**2).sum() < LAW_ERROR**2 * (missed**2).sum())


def _trend(data: Plays, played: Floats, left: Floats, joint: int) -> Divided | None:
    """Where a straight line over the trials' order is nearly all that its gains differ by; with all joints of which
    that is so in the same way."""
    gains = np.array([_gains(played, left, data.trials == t)[0] for t in range(len(data.recordings))])
    order = np.arange(len(gains)) - (len(gains) - 1) / 2
    if len(gains) < ON_A_LINE:
        return None
    about = gains - gains.mean(axis=0)
    slopes = order @ about / (order @ order)
    straight = ((about - order[:, None] * slopes) ** 2).sum(axis=0) < LAW_ERROR**2 * (about**2).sum(axis=0)
    if not straight[joint]:
        return None
    alike = np.flatnonzero(straight & (np.abs(slopes - slopes[joint]) < LAW_ERROR * abs(slopes[joint]))).tolist()
    mean, (first, last) = gains[:, alike].mean(axis=1), (data.recordings[t].name for t in (0, -1))
    who = "all joints" if len(alike) == gains.shape[1] > 1 else f"joint {joint + 1}"
    who = f"joints {listed([str(j + 1) for j in alike])}" if 1 < len(alike) < gains.shape[1] else who
    more = "more" if slopes[joint] > 0 else "less"
    return Divided(
        f"{who} {'move' if alike[1:] else 'moves'} {more} from trial to trial: {mean[0]:.2f} times as far as told in "
        f"`{first}`, {mean[-1]:.2f} times in `{last}`"
    )


def _gains(played: Floats, left: Floats, rows: np.ndarray) -> tuple[Floats, Floats]:
    """How far each joint (m,) goes about its middle over how far it is told, in these rows (R,), and which share (m,)
    of what is left that is."""
    swing, missed = (x[rows] - x[rows].mean(axis=0) for x in (played, left))
    together, told = (swing * missed).sum(axis=0), np.maximum((swing**2).sum(axis=0), TINY)
    return np.asarray(1 + together / told), np.asarray(together**2 / told / np.maximum((missed**2).sum(axis=0), TINY))


def _named(data: Plays, chosen: np.ndarray) -> str:
    """Trials (T,) by name; all of a gait by its name. A repeat that tells no more is not among the data."""
    gaits = [r.gait for r in data.recordings]
    others = {gait for gait, c in zip(gaits, chosen, strict=True) if not c}
    trials = zip(data.recordings, gaits, chosen, strict=True)
    return listed([f"`{r.name if gait in others else gait}`" for r, gait, c in trials if c])
