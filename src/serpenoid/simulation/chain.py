"""Steps with effects that know place or history: each one needs those before it.

Newton's method for a window of steps at once: the residual of step i contains the poses i - 2 .. i + 1. Motions are
solved side by side, each in windows of its own; a window that does not converge is halved, down to single steps.

Legend: S steps of a motion, G windows side by side, n steps of all of them, M elements.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.model import Model
from serpenoid.simulation.balance import about, by_step
from serpenoid.simulation.inertia import coefficients
from serpenoid.simulation.law import MediumNumbers, evaluate
from serpenoid.simulation.newton import State, newton
from serpenoid.simulation.steps import Steps

WINDOW = 256
AGES = 4  # poses that a residual contains: its own second one, and three before it


def solve_chain(model: Model, before: Floats, after: Floats, times: Floats, start: Floats, guess: Floats) -> Steps:
    """Relative poses of S steps between `times` (S + 1,) [s] from pose `start` on the floor, at rest before.

    before, after: elements (4, M S); guess: relative poses (S, 3) to begin with. `start` (K + 1, 3): the body is
    moving; its first K steps are these, and what momentum they leave it with is carried on.
    """
    spans = np.column_stack([times[:-1], times[1:]])
    chain = Chain.of(MediumNumbers.of(model), before, after, spans, coefficients(times))
    return solve_chains(model, [chain], [start], [guess])[0]


@dataclass(frozen=True)
class Chain:
    """What does not change about steps: elements before and after each (S, 4 M), settings (6, S), inertia (S, 3)."""

    before: Floats
    after: Floats
    settings: Floats
    inertia: Floats

    @classmethod
    def of(cls, law: MediumNumbers, before: Floats, after: Floats, spans: Floats, inertia: Floats) -> Chain:
        """From elements (4, M S), `spans` (S, 2) [s] and coefficients of momenta."""
        count = len(spans)
        return cls(by_step(before, count), by_step(after, count), law.settings(spans), inertia)

    def some(self, steps: slice | np.ndarray) -> Chain:
        """Those with some numbers."""
        return Chain(self.before[steps], self.after[steps], self.settings[:, steps], self.inertia[steps])

    @classmethod
    def joined(cls, parts: Sequence[Chain], origins: Floats) -> Chain:
        """Several, one after the other, each step about an origin (n, 2)."""
        before, after, inertia = (
            np.concatenate([getattr(p, x) for p in parts]) for x in ("before", "after", "inertia")
        )
        settings = np.concatenate([p.settings for p in parts], axis=1)
        settings[3:5] = origins.T
        return cls(before, after, settings, inertia)


def solve_chains(
    model: Model, chains: Sequence[Chain], starts: Sequence[Floats], guesses: Sequence[Floats]
) -> list[Steps]:
    """The same of several motions, which do not know each other, side by side."""
    law = MediumNumbers.of(model)
    motions = [_Motion.begun(law, c, np.atleast_2d(s), g) for c, s, g in zip(chains, starts, guesses, strict=True)]
    while todo := [m for m in motions if m.going]:
        for motion, found in zip(todo, _windows(law, todo), strict=True):
            motion.take(found)
    return [m.steps for m in motions]


@dataclass(frozen=True)
class _Found:
    poses: Floats
    momenta: Floats
    energy: Floats
    residual: Floats
    rooted: np.ndarray
    resisting: np.ndarray

    @property
    def converged(self) -> bool:
        return bool(self.rooted.all())


@dataclass
class _Motion:
    """How far one motion is: poses (S + 1, 3), momenta (S + 2, 3): two at rest, then its steps'; what else is known."""

    chain: Chain
    guess: Floats
    poses: Floats
    momenta: Floats
    energy: Floats
    residual: Floats
    sound: np.ndarray
    done: int
    window: int
    lost: bool = False

    @classmethod
    def begun(cls, law: MediumNumbers, chain: Chain, known: Floats, guess: Floats) -> _Motion:
        count, done = len(guess), len(known) - 1
        poses, momenta = np.full((count + 1, 3), np.nan), np.zeros((count + 2, 3))
        energy, residual, sound = np.full(count, np.nan), np.full(count, np.inf), np.zeros(count, bool)
        poses[: done + 1] = known
        if done:
            part = Chain.joined([chain.some(slice(0, done))], np.zeros((done, 2)))
            given = coupled(law, part, np.array([done]), known[:1], np.zeros((1, 2, 3)), known[1:])
            energy[:done], momenta[2 : done + 2] = given.more
            residual[:done], sound[:done] = 0.0, True
        return cls(chain, guess, poses, momenta, energy, residual, sound, done, min(WINDOW, count))

    @property
    def part(self) -> slice:
        """The window that is next."""
        return slice(self.done, min(self.done + self.window, len(self.guess)))

    @property
    def going(self) -> bool:
        return self.done < len(self.guess) and not self.lost

    def take(self, found: _Found) -> None:
        """Go on after a window, or halve it."""
        part, length = self.part, len(found.energy)
        if not found.converged and length > 1:
            self.window = max(length // 2, 1)
            return
        self.energy[part], self.residual[part] = found.energy, found.residual
        self.sound[part] = found.converged & found.resisting
        if not found.converged:
            self.lost = True
            return
        self.poses[part.start + 1 : part.stop + 1], self.momenta[part.start + 2 : part.stop + 2] = (
            found.poses,
            found.momenta,
        )
        self.done, self.window = part.stop, min(2 * self.window, WINDOW)

    @property
    def steps(self) -> Steps:
        return Steps(group.relative(self.poses[:-1], self.poses[1:]), self.energy, self.residual, self.sound)


def _windows(law: MediumNumbers, motions: Sequence[_Motion]) -> Iterator[_Found]:
    """The next window of each: its steps solved for their second poses."""
    parts = [m.part for m in motions]
    lengths = np.array([p.stop - p.start for p in parts])
    first = np.array([m.poses[m.done] for m in motions])
    home = first * [1, 1, 0]
    at_home = np.repeat(home, lengths, axis=0)
    chain = Chain.joined([m.chain.some(p) for m, p in zip(motions, parts, strict=True)], at_home[:, :2])
    before = np.array([about(m.momenta[m.done : m.done + 2], h) for m, h in zip(motions, home, strict=True)])
    guesses = [group.accumulate(m.guess[p], m.poses[m.done])[1:] for m, p in zip(motions, parts, strict=True)]
    owner = np.repeat(np.arange(len(lengths)), lengths)

    def equations(trial: Floats, steps: np.ndarray) -> State:
        with np.errstate(invalid="ignore"):  # of a trial that leads nowhere, which is refused
            if len(steps) == len(owner):
                return coupled(law, chain, lengths, first - home, before, trial)
            some = np.unique(owner[steps])
            return coupled(law, chain.some(steps), lengths[some], (first - home)[some], before[some], trial)

    x, state = newton(equations, np.concatenate(guesses) - at_home, lengths)
    energy, own = state.more
    every = x + at_home, about(own, -at_home), energy, state.size, state.found, state.resisting
    ends = np.cumsum(lengths)[:-1]
    for found in zip(*(np.split(value, ends) for value in every), strict=True):
        yield _Found(*found)


def coupled(
    law: MediumNumbers, chain: Chain, lengths: np.ndarray, first: Floats, before: Floats, poses: Floats
) -> State:
    """Equations of n steps in G runs of so many: second poses (n, 3), each run's first pose (G, 3) and the two momenta
    before it (G, 2, 3), all about the origin of the chain's settings.

    Slopes by the poses i + 1 .. i - 2, those before a run's first step included; more: energy (n,), momenta (n, 3).
    """
    begins = np.cumsum(lengths) - lengths

    def behind(values: Floats, age: int, known: Floats) -> Floats:
        """What stands so many steps before each; before a run's first step what is known."""
        found = np.empty_like(values)
        found[age:] = values[:-age]
        for j in range(age):
            found[begins[lengths > j] + j] = known[lengths > j, j - age]
        return found

    pairs = np.hstack([behind(poses, 1, first[:, None]), poses]).T
    value, energy, slope = evaluate(
        "coupled", law, chain.before.reshape(-1, 4).T, chain.after.reshape(-1, 4).T, pairs, chain.settings
    )
    c0, c1, c2 = chain.inertia.T[..., None]
    momenta = value[:, 3:]
    residual = value[:, :3] + c0 * momenta + c1 * behind(momenta, 1, before) + c2 * behind(momenta, 2, before)
    place = (np.arange(len(poses)) - np.repeat(begins, lengths))[:, None]
    c0, c1, c2 = (c[..., None] for c in (c0, np.where(place > 0, c1, 0.0), np.where(place > 1, c2, 0.0)))
    start, end = slope[:, 3:, :3], slope[:, 3:, 3:]
    slopes = np.zeros((AGES, *start.shape))
    slopes[0] = slope[:, :3, 3:] + c0 * end
    slopes[1] = slope[:, :3, :3] + c0 * start
    slopes[1, 1:] += c1[1:] * end[:-1]
    slopes[2, 1:] = c1[1:] * start[:-1]
    slopes[2, 2:] += c2[2:] * end[:-2]
    slopes[3, 2:] = c2[2:] * start[:-2]
    return State(residual, slopes, (energy, momenta))
