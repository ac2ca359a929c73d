"""The model: a body in a medium, with what effects there are, as the numbers that the symbolic mechanics takes.

Legend: N vertices, m joints, M dissipation elements (M = N at vertices, N - 1 at edges).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from serpenoid.body import Body, Floats
from serpenoid.effects.active import ActiveEffect, check
from serpenoid.effects.base import ActuationEffect, MediumEffect, ObservationEffect
from serpenoid.errors import InputError
from serpenoid.media import DEFAULT, LAWS, Law
from serpenoid.medium import Medium
from serpenoid.wording import listed

UNEVEN = 1.2  # times as heavy per length: more than the spread of a well-made robot's modules
HOLDS = 0.01  # of what others move about it: an element that is dragged along by less is no part of a body that goes


@dataclass(frozen=True)
class Structure:
    """What fixes the shape of the equations; everything else is a number given to the compiled functions."""

    vertices: int
    joints: tuple[int, ...]
    dissipation: str
    law: str = DEFAULT
    softening: float = 0.0

    @property
    def elements(self) -> int:
        """M."""
        return self.vertices if self.dissipation == "vertex" else self.vertices - 1

    @property
    def links(self) -> tuple[tuple[int, ...], ...]:
        """Edges of each rigid link, tail to head: m + 1 groups."""
        cuts = (0, *self.joints, self.vertices - 1)
        return tuple(tuple(range(a, b)) for a, b in zip(cuts[:-1], cuts[1:], strict=True))


@dataclass(frozen=True)
class Model:
    """A body in a medium; dimensionless inside (body length = 1, total weight = 1).

    effects: those at work. Neutral ones are left out when the model is made, so that a model with neutral effects *is*
    the baseline. cycle_duration_s: clock of joint tables, for effects that know speed; recordings bring their own.
    """

    body: Body
    medium: Medium
    effects: tuple[ActiveEffect, ...] = ()
    cycle_duration_s: float | None = None

    def __post_init__(self) -> None:
        present = tuple(effect for effect in self.effects if not effect.is_neutral)
        object.__setattr__(self, "effects", present)
        if self.medium.dissipation == "edge" and self.body.weights is None:
            object.__setattr__(self, "body", self.body.uniform())
        check(present, self.body)
        at_vertices = self.medium.dissipation == "vertex"
        kinds = [e.effect for e in present if isinstance(e.effect, MediumEffect)]
        strangers = [kind for kind in kinds if not kind.acts_in(self.medium.law)]
        if strangers:
            acting = " or ".join(f'"{law}"' for law in LAWS if strangers[0].acts_in(law))
            raise InputError(
                f'[medium] law: `{strangers[0].name}` does not act in a medium of law = "{self.medium.law}"; leave '
                f"it out, or state law = {acting}."
            )
        if not at_vertices and kinds:
            raise InputError('[medium] dissipation: effects of the medium sit at vertices; set it to "vertex".')

    @property
    def remarks(self) -> tuple[str, ...]:
        """What its author may not expect, as sentences."""
        seen = [f"`{e.name}` changes what cameras record, not how the body moves" for e in self.observation_effects]
        return (*([self.sparse_drag] if self.sparse_drag else []), *self._odd_weights, *seen)

    @property
    def where_drag_acts(self) -> str:
        """In words: of an animal all along the curve through its points, whatever [medium] says."""
        return "drag all along the body" if self.body.is_animal else f"dissipation at each {self.medium.dissipation}"

    @property
    def sparse_drag(self) -> str | None:
        """See `Body.sparse_edges`; nothing where drag sits at vertices."""
        return self.body.sparse_edges if self.medium.dissipation == "edge" else None

    @property
    def odd_weight(self) -> str | None:
        """A sentence where one element holds the body: drag of all others together cannot drag it along.

        Balance of forces: it moves by at most rest / (eps heaviest) of what the others do about it.
        """
        at_edges = self.medium.dissipation == "edge"
        weights = self.body.edge_weights if at_edges else self.body.vertex_weights
        heaviest = int(weights.argmax())
        rest = float(np.delete(weights, heaviest).sum())
        eps = min(self.medium.anisotropy_ratio, 1.0)
        if self.body.weights is None or rest > HOLDS * eps * weights[heaviest]:
            return None
        times = weights[heaviest] / rest
        return (
            f"by `weights` {self.medium.dissipation} {heaviest} has {times:.2g} times the drag of all "
            "others together, and holds the body where it is. Is one of the numbers too large?"
        )

    @property
    def _odd_weights(self) -> tuple[str, ...]:
        """A body that is not uniform where its author may think it is."""
        body, at_edges = self.body, self.medium.dissipation == "edge"
        per_length = body.edge_weights / body.edges if at_edges else body.edges
        if (not at_edges and body.weights is not None) or per_length.max() <= UNEVEN * per_length.min():
            return ()
        ratio = per_length.max() / per_length.min()
        if at_edges:
            return (
                f"`weights` put {ratio:.2g} times as much drag on a unit of one edge as of another; leave them out?",
            )
        return (f"the longest edge has {ratio:.2g} times the shortest's length, but every vertex the same `weights`",)

    @cached_property
    def medium_effects(self) -> tuple[ActiveEffect, ...]:
        """Effects from shape to motion; where there are none, the baseline's own fast functions are used."""
        return tuple(e for e in self.effects if isinstance(e.effect, MediumEffect))

    @cached_property
    def actuation_effects(self) -> tuple[ActiveEffect, ...]:
        """Effects from command to shape."""
        return tuple(e for e in self.effects if isinstance(e.effect, ActuationEffect))

    @cached_property
    def observation_effects(self) -> tuple[ActiveEffect, ...]:
        """Effects from motion to data."""
        return tuple(e for e in self.effects if isinstance(e.effect, ObservationEffect))

    @property
    def law(self) -> Law:
        """The medium's dissipation law."""
        return LAWS[self.medium.law]

    @property
    def only_in_the_plane(self) -> str | None:
        """Why the body cannot be lifted, as a sentence; None: it can."""
        if not self.effects and self.law.linear:
            return None
        given = ["effects"] * bool(self.effects) + [self.law.title] * (not self.law.linear)
        linear = next(name for name, law in LAWS.items() if law.linear)
        return (
            f'bodies are lifted with linear drag alone (law = "{linear}") and without effects; leave out '
            f"{listed(given)}, or [lift]."
        )

    @property
    def is_plain(self) -> bool:
        """Whether the planar step is that of linear drag without effects, which has a function of its own."""
        return self.law.linear and not self.medium_effects

    def knows(self, what: str) -> bool:
        """Whether an effect of the medium depends on `speed`, `clock`, `place` or `history`."""
        return any(isinstance(e.effect, MediumEffect) and what in e.effect.knows for e in self.effects)

    def step_duration(self, steps: int) -> float:
        """Seconds per step of a table with `steps` rows; one second a cycle where nobody knows and no effect asks.

        Raises InputError where an effect asks.
        """
        kinds = (e.effect for e in self.effects)
        needy = [k for k in kinds if isinstance(k, MediumEffect | ActuationEffect) and k.needs_seconds]
        if self.cycle_duration_s is None and needy:
            raise InputError(f"[task] cycle_duration_s: `{needy[0].name}` knows speed; give the seconds per cycle.")
        return (1.0 if self.cycle_duration_s is None else self.cycle_duration_s) / steps

    @cached_property
    def structure(self) -> Structure:
        """The part of the model that compiled functions depend on."""
        medium = self.medium
        softening = medium.softening if self.law.softened else 0.0
        return Structure(self.body.vertices, self.body.joint_vertices, medium.dissipation, medium.law, softening)

    @cached_property
    def parameters(self) -> Floats:
        """Edge lengths (N - 1), vertex weights (N) and anisotropy ratio, in this order: shape (2 N,)."""
        return np.concatenate([self.body.edges, self.body.vertex_weights, [self.medium.anisotropy_ratio]])
