"""The numbers that the step functions with effects take: settings, weights and every effect's coordinates.

Legend: S steps, M vertices, P coordinates.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import MediumEffect
from serpenoid.effects.catalogue import medium_effects
from serpenoid.mechanics.vertices import over_steps
from serpenoid.model import Model

SOFTER = 3  # power of the strength: at a tenth, friction gives way at a thousand times the slip (at most at all of it)


@dataclass(frozen=True)
class MediumNumbers:
    """medium (2, M): weights above anisotropy ratios; theta (P, M): coordinates, element by element; length [m].

    kind: the medium's law; softening: share of the change of shape (0: the law has none); acting: names of effects
    that are not neutral, or by whose coordinates it is differentiated.
    """

    medium: Floats
    theta: Floats
    length_m: float
    kind: str
    softening: float
    acting: frozenset[str]

    @classmethod
    def of(cls, model: Model, strength: float = 1.0, candidates: Sequence[ActiveEffect] = ()) -> MediumNumbers:
        """A model's numbers; `strength` between 0 and 1 scales the effects' coordinates (1 = as they are), and makes
        friction softer.

        Candidates are effects at neutral values that lend their other values (where a patch lies).
        """
        at_edges = model.medium.dissipation == "edge"
        weights = model.body.edge_weights if at_edges else model.body.vertex_weights
        medium = np.vstack([weights, np.full(weights.size, model.medium.anisotropy_ratio)])
        theta = coordinates(model, strength, candidates=candidates)[:, : weights.size]
        softening = min(model.structure.softening / strength**SOFTER, max(1.0, model.structure.softening))
        acting = frozenset(e.name for e in (*model.medium_effects, *candidates))
        return cls(medium, theta, model.body.total_length_m, model.medium.law, softening, acting)

    def asked(self, effects: Iterable[str | None]) -> MediumNumbers:
        """The same, to be differentiated by coordinates of these effects, too (None: eps)."""
        return replace(self, acting=self.acting.union(name for name in effects if name is not None))

    def settings(self, times: Floats) -> Floats:
        """Settings (6, S) of steps between `times` (S, 2) [s]: length, duration, middle, origin 0, softening."""
        length, zero, soft = (np.full(len(times), x) for x in (self.length_m, 0.0, self.softening))
        return np.vstack([length, times[:, 1] - times[:, 0], times.mean(1), zero, zero, soft])


def coordinates(
    model: Model,
    strength: float = 1.0,
    kinds: Sequence[MediumEffect] | None = None,
    candidates: Sequence[ActiveEffect] = (),
) -> Floats:
    """theta (P, M) of `kinds` (default all): an effect's coordinates where it sits, its resting ones elsewhere."""
    chosen = tuple(medium_effects() if kinds is None else kinds)
    first, resting = _resting(chosen, model.body.vertices)
    theta = resting.copy()
    for active in (*model.medium_effects, *candidates):
        if active.name in first:
            begin = first[active.name]
            _enter(theta[begin : begin + len(active.effect.parameters) + 1], active, strength)
    return theta


@lru_cache(maxsize=32)
def _resting(kinds: tuple[MediumEffect, ...], vertices: int) -> tuple[dict[str, int], Floats]:
    """The first row of each effect by name, and theta (P, M) where nothing acts."""
    first: dict[str, int] = {}
    blocks = [np.zeros((0, vertices))]
    for kind in kinds:
        first[kind.name] = sum(map(len, blocks))
        block = np.repeat(np.array([*(p.resting for p in kind.parameters), 0.0])[:, None], vertices, axis=1)
        if kind.place is None:
            block[-1] = [kind.is_present(vertex, vertices) for vertex in range(vertices)]
        blocks.append(block)
    return first, np.vstack(blocks)


def _enter(block: Floats, active: ActiveEffect, strength: float) -> None:
    values, resting = np.array(active.coordinates), np.array([*(p.resting for p in active.effect.parameters), 0.0])
    scaled = [p.neutral is not None for p in active.effect.parameters] + [False]
    values = np.where(scaled, resting + strength * (values - resting), values)
    if active.place is None:
        block[:-1] = values[:-1, None]
    else:
        block[:, active.place] = values


def evaluate(
    which: str, law: MediumNumbers, before: Floats, after: Floats, poses: Floats, settings: Floats
) -> tuple[Floats, Floats, Floats]:
    """`balance` or `coupled` of S steps: drag and momentum (S, 6), energy (S,), derivatives (S, 6, 3 or 6)."""
    count = poses.shape[1]
    value, energy, slope = _over_steps(which, law, before, after, poses, settings)
    return value, energy[:, 0], slope.reshape(count, -1, 6).transpose(0, 2, 1)


def sensitivities(
    law: MediumNumbers, before: Floats, after: Floats, poses: Floats, settings: Floats
) -> tuple[Floats, Floats]:
    """Derivatives of drag and momentum by (eps, unplaced parameters): (S, 6, 1 + G); by placed ones: (S, 6, M, L)."""
    count, m = poses.shape[1], law.medium.shape[1]
    everywhere, somewhere = _over_steps("sensitivity", law, before, after, poses, settings)
    first = everywhere.reshape(count, -1, 6).transpose(0, 2, 1)
    return first, somewhere.reshape(count, m, -1, 6).transpose(0, 3, 1, 2)


def _over_steps(
    which: str, law: MediumNumbers, before: Floats, after: Floats, poses: Floats, settings: Floats
) -> list[Floats]:
    """Outputs (S, ...) of a step function."""
    count, m = poses.shape[1], law.medium.shape[1]
    chains = [np.asarray(x.T, float).reshape(count, m, 4) for x in (before, after)]
    return over_steps(which, law.kind)(*chains, poses.T, settings.T, law.medium.T, law.theta.T)
