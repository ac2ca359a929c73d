"""Whether something changed amid a campaign: one cause, which acts from some trial on, or in a run of trials, alone.

Differences of repeats are what chance is told by, so what acts in one of the two hides in it. It shows by its moment:
of a pair of repeats, in units of chance,

    r_b - r_a = (s_b - s_a) J theta + e,    J = d(displacement) / d(theta),    s: 1 where it acts, else 0

with one theta for all pairs. Every cause is tried at every moment. That which takes away most of what repeats differ by
is held against what pairs make of it one by one (Fisher's F): chance that lasts a whole trial is one number of each
pair, so pairs are weighed as in a model of random effects (DerSimonian and Laird, Controlled Clinical Trials 7, 177,
1986), by how far their numbers scatter beside what windows tell of each. The error is stated for all moments together.
Trials are taken to be listed in the order in which they were played. A cause that began takes one moment; what takes
its place must leave less than LAW_ERROR of what that leaves, of all or of what pairs do not agree about: one that went
again, or that grows evenly from trial to trial (s: how many were before it). Repeats that were all played as many
trials later do not tell growth from a beginning if there are two of each setting; of three rounds the middle one does,
and the last is held against the first. Gait by gait, what differs by as much from one repeat to the next need not grow
from gait to gait: nothing is told.
What is no chance, though every cause that was tried counts, and less than most of what repeats differ by, is a hint at
what hides in the noise, and no more.

Of a large cause first order tells pairs different sizes, and Fisher's F takes their scatter for chance. So what takes
away most of what repeats differ by, and yet may be chance, is fitted in full in the trials in which it acts, and judged
again by its derivatives there.

Legend: T trials, P pairs, K windows that were played twice, S ways to divide trials, C numbers of a cause.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.special import fdtrc

from serpenoid.body import Floats
from serpenoid.diagnose.data.chance import LEFT
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.repeats import Repeat, pairs, repeats
from serpenoid.diagnose.data.windows.windows import columns_of, predictions
from serpenoid.diagnose.inference.doubt.law_error import LAW_ERROR
from serpenoid.diagnose.inference.fits.finding import Divided
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of
from serpenoid.diagnose.residuals.acting import acting
from serpenoid.diagnose.residuals.from_trial_to_trial import MOST
from serpenoid.effects.active import ActiveEffect
from serpenoid.simulation.sensitivity import EPS, Column
from serpenoid.wording import listed

FEW = 3  # pairs: two lie on a line with any third number


@dataclass(frozen=True)
class Differ:
    """What repeats differ by, in units of chance: squares of each pair (P,), of so many numbers (P,)."""

    squares: Floats
    count: Floats

    @property
    def total(self) -> float:
        """Of all pairs."""
        return float(self.squares.sum())


@dataclass(frozen=True)
class Cause:
    """What each pair (P,) says of one: information (P, C, C) and score (P, C), the other trial minus the one; sign: of
    its number, where its bounds allow one alone, else 0. effect: None: the anisotropy ratio."""

    called: str
    sign: int
    information: Floats
    score: Floats
    effect: ActiveEffect | None = None

    def gains(self, signs: Floats) -> Floats:
        """What it takes away of squares (S,), where it acts by signs (S, P)."""
        score = signs @ self.score
        return np.asarray(np.einsum("si,sij,sj->s", score, self._inverse(signs), score))

    def _inverse(self, signs: Floats) -> Floats:
        inverse = np.linalg.pinv(np.tensordot(signs**2, self.information, 1), rcond=1e-9, hermitian=True)
        return np.asarray(inverse, dtype=float)

    def value(self, signs: Floats) -> Floats:
        """Its numbers (C,), where it acts by signs (P,)."""
        return np.asarray(self._inverse(signs[None])[0] @ (signs @ self.score))

    def agreed(self, signs: Floats, differ: Differ) -> Agreed:
        """How well pairs agree on how large it is."""
        value = self.value(signs)
        known = np.einsum("i,pij,j->p", value, self.information, value)
        told = known > 1e-9 * known.max(initial=0.0)
        signs, known, score = signs[told], known[told], (self.score @ value)[told]
        freedom = len(known) - len(value)
        if freedom < 1 or not (signs**2 * known).sum() > 0:
            return Agreed()
        own = score / known  # how large each pair would have it, of what all have
        noise = float((differ.squares[told] - score * own).sum() / np.maximum(differ.count[told] - 1, 1).sum())
        spread = _spread(own - signs, known, noise, freedom)
        weight = 1 / (spread + noise / known)
        mean = float((weight * signs * own).sum() / (weight * signs**2).sum())
        explained = mean**2 * float((weight * signs**2).sum())
        left = float((weight * (own - signs * mean) ** 2).sum())
        left = max(left, 1e-12)
        chance = float(fdtrc(len(value), freedom, explained / len(value) / (left / freedom)))
        return Agreed(chance, left / (explained + left))


class Agreed(NamedTuple):
    """How likely pairs agree so well by chance; what they do not agree about, as a share."""

    chance: float = 1.0
    apart: float = 1.0


def _spread(left: Floats, known: Floats, noise: float, freedom: int) -> float:
    """Variance between pairs of what is left of their numbers (P,), beyond that which windows tell of each."""
    beyond = float((known * left**2).sum()) - freedom * noise
    return max(0.0, beyond / max(float(known.sum() - (known**2).sum() / known.sum()), 1e-300))


@dataclass(frozen=True)
class _Found:
    """The best cause at the best moment of several: squares that it leaves, how likely chance takes away as much at one
    of so many moments, what pairs do not agree about, as a share, and trials (T,) in which it acts for sure, and in
    which it does not."""

    left: float
    cause: Cause
    chance: float
    apart: float
    moments: int
    acts: np.ndarray
    rests: np.ndarray

    @property
    def called(self) -> str:
        """The cause's name."""
        return self.cause.called

    def far_less_than(self, other: _Found) -> bool:
        """Whether it leaves far less than another: of all squares, or of what pairs do not agree about, where chance
        makes that no more likely."""
        agree = self.apart < LAW_ERROR**2 * other.apart and self.chance < other.chance and self.left < other.left
        return agree or self.left < LAW_ERROR**2 * other.left


def one_cause_in_some(motion: Motion, found: Fit, since: Collection[str] = ()) -> Divided | None:
    """By what repeats differ by, if it is one cause with its moment; None where it is not, or nothing tells.

    since: trials that do not move as in an earlier campaign, if that is known.
    """
    played = pairs(motion.tracks)
    if len(played) < FEW or any(t.noise is not None for t in motion.tracks):
        return None
    differ, causes = _causes(motion, found)
    names = [t.recording.name for t in motion.tracks]
    return divided(differ, causes, played, names, since, lambda best: _in_full(motion, found, played, best))


def divided(
    differ: Differ,
    causes: Sequence[Cause],
    played: Sequence[tuple[int, int]],
    names: Sequence[str],
    since: Collection[str] = (),
    in_full: Callable[[_Found], _Found] = lambda best: best,
) -> Divided | None:
    """Trials, by name, of which pairs differ so, as causes tell, or a hint at what hides in the noise: no chance, and
    less than most of what repeats differ by. None where no cause has its moment. in_full: the same, fitted in full."""
    squares = differ.total
    if squares <= 0:
        return None
    count = len(names)
    later = np.zeros(count)
    for one, again in played:  # in order: one more than the repeat before it
        later[again] = later[one] + 1
    runs = ([np.arange(count)], list(_begun(count)), list(_gone(count)), [later])
    strays = np.array([name in since for name in names])
    grew, began, went, each = (_best(causes, differ, played, of, strays) for of in runs)
    rounds = bool((np.diff(later) >= 0).all())
    if not rounds and grew.left > LAW_ERROR**2 * each.left:  # every repeat differs by as much from the one before it,
        grew = replace(grew, chance=1.0)  # whenever it was played
    began, went = (in_full(f) if _mostly(f, squares) and f.chance > LEFT else f for f in (began, went))
    mostly = [f for f in (began, grew, went) if _told(f, squares)]
    best = _first(mostly or [f for f in (began, grew, went) if f.chance * len(causes) <= LEFT])
    if best is None:
        return None
    share = f"{1 - best.left / squares:.0%} of what repeats differ by is one cause (to first order {best.called})"
    if best is grew:
        apart = "that grows from trial to trial"
        apart += ", or began with the second round" if rounds and later[-1] == 1 else ""
        said = f"something changes all through the campaign: {share} {apart}"
        no = np.zeros(count, dtype=bool)
        changed, others = (_named(names, of) for of in ((later == later[-1], later == 0) if rounds else (no, no)))
        found = Divided(said, changed, others, perhaps=True, grows=_within(changed, others, names))
    else:
        changed, others = (_named(names, of) for of in (best.acts, best.rests))
        perhaps = _told(grew, squares) and grew.left < best.left / LAW_ERROR**2
        few = min(changed, others, key=len)
        apart = f"by which {listed([f'`{n}`' for n in few])} differ{'' if few[1:] else 's'} from the other trials"
        apart += ", or which grows from trial to trial" if perhaps else ""
        said = f"something changed amid the campaign: {share} {apart}"
        found = Divided(said, changed, others, perhaps, _within(changed, others, names) if perhaps else 0.0)
    return replace(found, cause=best.called) if mostly else Divided(f"{share} {apart}", hint=True)


def _named(names: Sequence[str], some: np.ndarray) -> tuple[str, ...]:
    """Some (T,) of the trials."""
    return tuple(n for n, x in zip(names, some, strict=True) if x)


def _first(found: Sequence[_Found]) -> _Found | None:
    """What leaves far less than those before it."""
    best = None
    for other in found:
        if best is None or other.far_less_than(best):
            best = other
    return best


def _within(changed: Sequence[str], others: Sequence[str], names: Sequence[str]) -> float:
    """What grows evenly from trial to trial: how far it is, in one of the changed trials, from what it is in their
    mean, over how far that is from the others' mean."""
    if not changed or not others:
        return 0.0
    acts, rests = (np.array([names.index(n) for n in side], dtype=float) for side in (changed, others))
    return float(np.abs(acts - acts.mean()).max() / abs(acts.mean() - rests.mean()))


def _told(found: _Found, squares: float) -> bool:
    """Whether it is what repeats differ by, and no chance."""
    return found.chance <= LEFT and _mostly(found, squares)


def _mostly(found: _Found, squares: float) -> bool:
    """Whether it is what repeats differ by."""
    return found.left < (1 - MOST) * squares


def _in_full(motion: Motion, found: Fit, played: Sequence[tuple[int, int]], best: _Found) -> _Found:
    """The same with its cause fitted in full in the trials in which it acts; as it was if that leaves no less."""
    signs = np.array([float(best.acts[b]) - float(best.acts[a]) for a, b in played])
    fitted = acting(motion, found, best.cause.effect, best.acts)
    remains, left, told = residuals(motion.tracks, fitted.predicted), 0.0, []
    for repeat, s in zip(repeats(motion.tracks), signs, strict=True):
        one, other = repeat.both(remains)
        here, there = repeat.both(fitted.by)
        d, slopes = other - one, (here + there) / 2 if not s else there if s > 0 else here
        rows, flat = _white(motion, repeat, d, slopes)
        left += float(rows @ rows)
        told.append((rows + s * flat @ fitted.change, flat))  # without the cause, to first order
    if not left < best.left:
        return best
    differ, information, score = _summed(told)
    cause = replace(best.cause, information=information, score=score)
    agreed = cause.agreed(signs, differ)
    return replace(best, left=left, cause=cause, chance=agreed.chance * best.moments, apart=agreed.apart)


def _white(motion: Motion, repeat: Repeat, d: Floats, slopes: Floats) -> tuple[Floats, Floats]:
    """What a pair differs by (R,), and its derivatives (R, C), in units of chance, while playing."""
    d, slopes = d / motion.noise.playing, slopes / motion.noise.playing[:, None]
    known = np.isfinite(d).all(axis=1) & np.isfinite(slopes).all(axis=(1, 2))
    known &= motion.tracks[repeat.one].playing[repeat.here]
    return d[known].ravel(), slopes[known].reshape(-1, slopes.shape[2])


def _summed(told: Sequence[tuple[Floats, Floats]]) -> tuple[Differ, Floats, Floats]:
    """Squares of what pairs differ by (R,), information (P, C, C) and score (P, C) by their derivatives (R, C)."""
    squares, count = (np.array([float(x) for x in of]) for of in zip(*((d @ d, len(d)) for d, _ in told), strict=True))
    information, score = (np.array(of) for of in zip(*((by.T @ by, by.T @ d) for d, by in told), strict=True))
    return Differ(squares, count), information, score


def _causes(motion: Motion, found: Fit) -> tuple[Differ, list[Cause]]:
    """What repeats differ by, and what they say of every cause that the motion shows."""
    candidates = candidates_of(found)
    tried = [(e, 0) for e in found.effects] + [(e, _sign(e)) for e in candidates]
    named = ["the anisotropy ratio", *(f"`{e.called}`" for e, _ in tried)]
    signs = [0, *(sign for _, sign in tried)]
    columns: list[tuple[Column, ...]] = [(EPS,), *(columns_of([e]) for e, _ in tried)]
    every = [c for of in columns for c in of]
    predicted = predictions(found.model, motion.tracks, candidates, found.predictions)
    left, by = residuals(motion.tracks, predicted), [p.by(every) for p in predicted]
    told = []
    for repeat in repeats(motion.tracks):
        (one, other), (here, there) = repeat.both(left), repeat.both(by)
        told.append(_white(motion, repeat, other - one, (here + there) / 2))
    differ, whole, scores = _summed(told)
    ends = np.cumsum([0, *(len(of) for of in columns)]).tolist()
    parts = [slice(a, b) for a, b in zip(ends, ends[1:], strict=False)]
    return differ, [
        Cause(name, sign, whole[:, p, p], scores[:, p], effect)
        for name, sign, p, effect in zip(named, signs, parts, [None, *(e for e, _ in tried)], strict=True)
    ]


def _sign(candidate: ActiveEffect) -> int:
    """Of what its one number does from where it changes nothing, if bounds allow one alone."""
    if len(candidate.effect.parameters) != 1 or not candidate.is_neutral:
        return 0
    p = candidate.effect.parameters[0]
    low, high = sorted((p.coordinate(p.lower), p.coordinate(p.upper)))
    return int(p.resting <= low) - int(p.resting >= high)


def runs_of(count: int) -> list[np.ndarray]:
    """Trials (T,) in which a cause may act that began with one of them, and of one that went again before the last."""
    return [*_begun(count), *_gone(count)]


def _begun(count: int) -> Iterator[np.ndarray]:
    """Trials (T,) in which a cause acts that began with one of them."""
    for first in range(1, count):
        yield np.arange(count) >= first


def _gone(count: int) -> Iterator[np.ndarray]:
    """The same of one that went again before the last."""
    for first in range(1, count - 1):
        for last in range(first + 1, count):
            yield (np.arange(count) >= first) & (np.arange(count) < last)


def _best(
    causes: Sequence[Cause],
    differ: Differ,
    pairs: Sequence[tuple[int, int]],
    runs: Sequence[np.ndarray],
    strays: np.ndarray,
) -> _Found:
    """Of all causes at all moments. Moments that divide no pair otherwise are one; trials in which these do not agree
    belong to neither side. strays: trials (T,) that do not move as they did in an earlier campaign."""
    alike: dict[tuple[int, ...], list[np.ndarray]] = {}
    for run in runs:
        alike.setdefault(tuple(int(run[b]) - int(run[a]) for a, b in pairs), []).append(run)
    signs = np.array(list(alike), dtype=float)
    gains = np.array([c.gains(signs) for c in causes])
    at, moment = (int(i) for i in np.unravel_index(int(gains.argmax()), gains.shape))
    cause, best = causes[at], signs[moment]
    agreed = cause.agreed(best, differ)
    size = float((best @ cause.score)[0])
    ways = [(size, alike[key]) for key in alike if key == tuple(best)]
    ways += [(-size, alike[key]) for key in alike if key == tuple(-best)]  # the same, undone
    acts, rests = _sides(cause.sign, ways, strays)
    left = max(differ.total - float(gains[at, moment]), 0.0)
    return _Found(left, cause, agreed.chance * len(alike), agreed.apart, len(alike), acts, rests)


def _sides(
    sign: int, ways: Sequence[tuple[float, Sequence[np.ndarray]]], strays: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Trials (T,) in which a cause acts, and does not, of several ways to say so, by its size in each: what agrees best
    with an earlier campaign, or the latest that its sign allows; if none is, it was there and is no more."""
    every = [(size, np.all(runs, axis=0), ~np.any(runs, axis=0)) for size, runs in ways]
    undone = [(-size, rests, acts) for size, acts, rests in every]
    here, there = ([(acts, rests) for size, acts, rests in some if sign * size >= 0] for some in (every, undone))
    if strays.any():
        return max([*here, *there], key=lambda of: int((of[0] & strays).sum()) + int((of[1] & ~strays).sum()))
    return max(here or there, key=lambda of: float(np.flatnonzero(of[0]).mean()) if of[0].any() else -1.0)
