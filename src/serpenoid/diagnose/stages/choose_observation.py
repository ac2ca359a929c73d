"""Which effects the markers show and the servos do not: zeros, play, displaced markers, length scale, clock rate."""

from __future__ import annotations

from collections.abc import Sequence, Set

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.diagnose.data.observation import Observation, columns_of
from serpenoid.diagnose.data.recording import Recording
from serpenoid.diagnose.inference.finding import Named, Rival, Stage, excludable, interval
from serpenoid.diagnose.stages.marker_evidence import Sample, apart, evidence, misfit, sample, signature
from serpenoid.effects.active import ActiveEffect
from serpenoid.files.store import remembered

AT_MOST = 3
FIRST_ORDER = 0.02  # of what an effect explains: what linear scores fall short by
GAIN = 80.0  # chi squared: thousands of frames; servo creep and smoothing alone reach 30
SHARE, MORE = 0.2, 0.4  # of what is left above chance, the first and each further one: less, and the cause is another
VISIBLE = 1.6  # times the noise level
SETTLED = 1.35  # chi squared per marker coordinate
Key = tuple[str, int | None]


def all_keys(body: Body) -> list[Key]:
    """Every effect that moves markers against the servos' chain."""
    joints, vertices = range(1, body.joint_count + 1), range(body.vertices)
    unread: list[Key] = [(name, j) for name in ("zero_offset", "loose_joint") for j in joints]
    return [*unread, *(("marker_offset", k) for k in vertices), ("length_scale", None)]


@remembered
def choose_observation(
    recordings: Sequence[Recording], now: Observation, without: Set[str] = frozenset()
) -> tuple[Stage, Observation]:
    """What is new beside the observation model `now`, and the model to be taken out of the data (weak effects too).

    without: effects that are no candidates.
    """
    data = sample(recordings)
    chosen: list[Key] = []
    for _ in range(AT_MOST):
        found = _next(data, now, chosen, without)
        if found is None:
            break
        chosen, now = found
    shown: list[Named] = []
    undetected: list[Named] = []
    for key in chosen:
        named = _named(data, now, chosen, key)
        (shown if named.strength >= VISIBLE else undetected).append(named)
    left = misfit(data, now) / data.count
    clock = None if "clock_offset" in without else _clock(recordings, data)
    if clock is not None:
        (shown if clock.strength >= VISIBLE else undetected).append(clock)
    words = (
        () if left < SETTLED else (f"markers stand {np.sqrt(left):.1f} times their noise from where shapes put them",)
    )
    visible = [k for k in chosen if k in {n.effect.key for n in shown}]
    rivals = tuple(r for k in visible for r in rivals_of(data, now, chosen, k, without))
    return Stage("observation", tuple(shown), rivals, tuple(undetected), left, words), now


def _next(data: Sample, now: Observation, chosen: list[Key], without: Set[str]) -> tuple[list[Key], Observation] | None:
    """One more effect, or None: of those that do as well, the one with fewest numbers."""
    body = data.body
    own = [c for k in chosen for c in columns_of(body, *k)]
    sums = evidence(data, now)
    before = sums.held_out(own)
    gains = []
    for key in all_keys(body):
        if key in chosen or key[0] in without:
            continue
        columns = columns_of(body, *key)
        gains.append((before - sums.held_out([*own, *columns]), key))
    gains.sort(key=lambda g: -g[0])
    share = MORE if chosen else SHARE  # what the law of the first gets wrong looks like a second
    if gains[0][0] < max(GAIN, share * (before - SETTLED * data.count)):
        return None
    tries = []
    for gain, key in gains[:6]:
        if gain > 0.3 * gains[0][0]:
            fitted = solved(data, now, [*chosen, key])
            tries.append((misfit(data, fitted), len(columns_of(body, *key)), key, fitted))
    least = min(t[0] for t in tries)
    close = [t for t in tries if not excludable(t[0], least, data.count)]
    _, _, key, fitted = min(close, key=lambda t: (t[1], t[0]))
    return [*chosen, key], fitted


def rivals_of(
    data: Sample, now: Observation, chosen: Sequence[Key], key: Key, without: Set[str] = frozenset()
) -> list[Rival]:
    """What else could stand in the place of one chosen effect, the others kept: scored linearly, then fitted."""
    body = data.body
    kept = [k for k in chosen if k != key]
    base = cleared(body, now, key)
    base = solved(data, base, kept) if kept else base
    sums, least, count = evidence(data, base), misfit(data, now), data.count
    slack = FIRST_ORDER * (float(sums.constant.sum()) - least)
    found = []
    for other in all_keys(body):
        columns = [c for k in (*kept, other) for c in columns_of(body, *k)]
        if other in chosen or other[0] in without or excludable(sums.chi2(columns), least, count, slack):
            continue
        fitted = solved(data, base, [*kept, other])
        effect = ActiveEffect.neutral(*other).with_coordinates(values_of(body, fitted, other))
        mine = ActiveEffect.neutral(*key).with_coordinates(values_of(body, now, key))
        rival = Rival(effect, mine, apart(data, now, fitted))
        if not rival.separable and not excludable(misfit(data, fitted), least, count):
            found.append(rival)
    return found


def solved(data: Sample, now: Observation, keys: Sequence[Key], rounds: int = 4) -> Observation:
    """Gauss-Newton in the numbers of the given effects."""
    columns = [c for k in keys for c in columns_of(data.body, *k)]
    for _ in range(rounds):
        step, _ = evidence(data, now, columns).solve(range(len(columns)))
        for column, amount in zip(columns, step, strict=True):
            now = now.with_column(column, float(amount))
    return now


def cleared(body: Body, now: Observation, key: Key) -> Observation:
    """An observation model without one of its effects."""
    for column, value in zip(columns_of(body, *key), values_of(body, now, key), strict=True):
        now = now.with_column(column, -value)
    return now


def only(body: Body, now: Observation, key: Key) -> Observation:
    """An observation model with this one effect of `now`."""
    alone = Observation.neutral(body)
    for column, value in zip(columns_of(body, *key), values_of(body, now, key), strict=True):
        alone = alone.with_column(column, value)
    return alone


def values_of(body: Body, now: Observation, key: Key) -> list[float]:
    """Parameters of one effect in an observation model."""
    if key[0] == "zero_offset":
        return [float(now.zeros[int(key[1] or 1) - 1])]
    if key[0] == "loose_joint":
        return [float(now.gaps[int(key[1] or 1) - 1])]
    return [float(v) for v in now.markers[int(key[1] or 0)]] if key[0] == "marker_offset" else [now.scale]


def _named(data: Sample, now: Observation, chosen: list[Key], key: Key) -> Named:
    own = [c for k in chosen for c in columns_of(data.body, *k)]
    sums = evidence(data, now, own)
    _, covariance = sums.solve(range(len(own)))
    spread = np.sqrt(sums.constant.sum() / sums.count.sum())
    values = values_of(data.body, now, key)
    effect = ActiveEffect.neutral(key[0], key[1]).with_coordinates(values)
    ends = {}
    for p, value, column in zip(effect.effect.parameters, values, columns_of(data.body, *key), strict=True):
        half = 2.1 * np.sqrt(covariance[own.index(column), own.index(column)]) * spread + SYSTEMATIC[p.name]
        ends[p.name] = interval((value - half, value + half))
    return Named(effect, ends, float(signature(data, only(data.body, now, key)).max()))


QUARTER_TICK = 2 * np.pi / 4096 / 4  # rad: jitter that smoothed readings keep, and that crosses this much of a gap
SYSTEMATIC = {"offset": 5e-5, "width": QUARTER_TICK, "along": 2e-5, "left": 2e-5, "error": 3e-5}  # servo creep


def _clock(recordings: Sequence[Recording], data: Sample) -> Named | None:
    weights = np.array([1 / r.clock.rate_sd**2 for r in recordings])
    rates = np.array([r.clock.rate for r in recordings])
    rate, sd = float((weights * rates).sum() / weights.sum()), float(1 / np.sqrt(weights.sum()))
    if abs(rate) < 5 * sd:
        return None
    squares = [_drifted(r) for r in recordings]
    levels = data.levels[: data.body.joint_count]
    strength = abs(rate) * float((np.sqrt(np.mean(squares, axis=0)) / levels).max())
    effect = ActiveEffect.neutral("clock_offset").with_coordinates([rate])
    half = 2.1 * sd + 1e-5
    return Named(effect, {"rate": interval((rate - half, rate + half))}, strength)


def _drifted(r: Recording) -> Floats:
    inside = (r.time > 0) & (r.time < r.end)
    speed = np.gradient(r.angles, r.time, axis=0)[inside]
    late = r.time[inside] - r.time[inside].mean()
    return np.asarray(((speed * late[:, None]) ** 2).mean(axis=0))
