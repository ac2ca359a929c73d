"""What each step of a recording would have been, and how that depends on every parameter: for fits.

Given measured shapes and poses, step i is predicted from its own measured start. With r(h, theta) = 0 at the root,
dh/dtheta = -(dr/dh)^{-1} dr/dtheta (implicit function theorem). Legend: R rows, S = R - 1 steps, N vertices, P columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect, MediumEffect
from serpenoid.effects.catalogue import find, medium_effects
from serpenoid.mechanics.extended import parameter_rows
from serpenoid.mechanics.servo import parameter_rows as parameter_rows_of_servos
from serpenoid.model import Model
from serpenoid.simulation import balance, servos
from serpenoid.simulation.chain import difference_weights
from serpenoid.simulation.law import MediumNumbers, evaluate, sensitivities
from serpenoid.simulation.poses import body_frame, body_poses
from serpenoid.simulation.steps import elements_of_vertices, solve_steps


@dataclass(frozen=True)
class Column:
    """One parameter of a fit: the coordinate of an effect's parameter, or eps (effect None)."""

    effect: str | None
    place: int | None
    parameter: str


@dataclass(frozen=True)
class StepSensitivities:
    """relative (S, 3): predicted pose of each row in the frame of the one before [body lengths, rad].

    jacobian (S, 3, P): its derivatives by the columns' coordinates (see `Parameter.coordinate`; the anisotropy ratio's
    coordinate is itself). sound (S,): whether each step's root is one; rows of others are NaN.
    """

    relative: Floats
    jacobian: Floats
    columns: tuple[Column, ...]
    sound: np.ndarray


EPS = Column(None, None, "anisotropy_ratio")


def step_sensitivities(
    model: Model,
    vertices: Floats,
    times: Floats,
    poses: Floats | None = None,
    candidates: Sequence[ActiveEffect] = (),
) -> StepSensitivities:
    """Predictions of a model for one recording, with derivatives by eps, by its medium effects and by the candidates'.

    vertices (R, N, 2) [body lengths], in any frame: only their shapes count; times (R,) [s since the start of the
    motion, at rest before]; poses (R, 3) on the floor [body lengths, rad], by default those of the vertices. Candidates
    are not in the model: `ActiveEffect.neutral(name, place)`, with values for parameters that have no neutral one.
    """
    floor = body_poses(model, vertices) if poses is None else np.asarray(poses, float)
    problem, columns = recorded(model, vertices, times, floor, candidates)
    relative, sound = problem.predict()
    jacobian = problem.differentiate(relative, columns)
    jacobian[~sound] = np.nan
    return StepSensitivities(relative, jacobian, columns, sound)


@dataclass(frozen=True)
class ServoSensitivities:
    """angles, readings (R, m) [rad] of a trial, their derivatives (R, m, P) by the columns' coordinates."""

    angles: Floats
    readings: Floats
    angles_by: Floats
    readings_by: Floats
    columns: tuple[Column, ...]


def servo_sensitivities(
    model: Model, setpoints: Floats, times: Floats, candidates: Sequence[ActiveEffect] = ()
) -> ServoSensitivities:
    """What the joints do with set-points (R, m) at `times` (R,) [s], from rest, and derivatives by actuation effects.

    These are the model's and the candidates, at their neutral values; an effect without one must be in the model.
    """
    wanted = [e for e in (*model.actuation_effects, *candidates) if isinstance(e.effect, ActuationEffect)]
    for active in wanted:
        if active not in model.effects and not active.is_neutral:
            raise ValueError(f"`{active.name}` is a candidate and not neutral: put it into the model")
    wanted = list({e.key: e for e in reversed(wanted)}.values())[::-1]
    # play of no width is at its edge wherever the joint rests: it is looked at alone, or other derivatives would stick
    edges = [e for e in wanted if e not in model.effects and _has_edge(e)]
    angles, readings, plain = servos.play_with_derivatives(servos.coordinates(model), setpoints, times)
    alone = plain
    if edges:
        alone = servos.play_with_derivatives(servos.coordinates(model, edges), setpoints, times)[2]
    columns = tuple(Column(e.name, e.place, p.name) for e in wanted for p in e.effect.parameters)
    rows = parameter_rows_of_servos()
    by = np.zeros((*plain.shape[:2], len(columns), 2))
    for i, column in enumerate(columns):
        where = slice(None) if column.place is None else slice(column.place - 1, column.place)
        source = alone if any(e.key == (column.effect, column.place) for e in edges) else plain
        by[:, where, i] = source[:, where, rows[column.effect or "", column.parameter]]
    return ServoSensitivities(angles, readings, by[..., 0], by[..., 1], columns)


def recorded(
    model: Model, vertices: Floats, times: Floats, floor: Floats, candidates: Sequence[ActiveEffect]
) -> tuple[Recorded, tuple[Column, ...]]:
    """A recording as a problem, and the columns of its derivatives: eps, the model's medium effects, the candidates."""
    m = model.structure.elements
    elements = elements_of_vertices(model, body_frame(model, vertices))
    wanted = [e for e in (*model.medium_effects, *candidates) if isinstance(e.effect, MediumEffect)]
    wanted = list({e.key: e for e in reversed(wanted)}.values())[::-1]
    columns = (EPS, *(Column(e.name, e.place, p.name) for e in wanted for p in e.effect.parameters))
    return Recorded.of(model, elements[:, :-m], elements[:, m:], np.asarray(times, float), floor, wanted), columns


def _has_edge(active: ActiveEffect) -> bool:
    return isinstance(active.effect, ActuationEffect) and active.effect.memory and active.effect.place is not None


@dataclass(frozen=True)
class Recorded:
    """A recording's steps, with the law of the model plus resting candidates."""

    model: Model
    law: MediumNumbers
    before: Floats
    after: Floats
    times: Floats
    floor: Floats
    rates: Floats
    history: bool

    @classmethod
    def of(
        cls, model: Model, before: Floats, after: Floats, times: Floats, floor: Floats, wanted: list[ActiveEffect]
    ) -> Recorded:
        law = MediumNumbers.of(model, candidates=[e for e in wanted if e not in model.effects])
        rates = difference_weights(times) * np.diff(times)[:, None]
        history = any("history" in e.effect.knows for e in wanted if isinstance(e.effect, MediumEffect))
        return cls(model, law, before, after, times, floor, rates, history)

    @property
    def settings(self) -> Floats:
        """Settings of the steps."""
        return self.law.settings(np.column_stack([self.times[:-1], self.times[1:]]))

    @property
    def elements_by_step(self) -> tuple[Floats, Floats]:
        """Elements before and after, (4, S, M)."""
        m = self.model.structure.elements
        return self.before.reshape(4, -1, m), self.after.reshape(4, -1, m)

    @property
    def measured(self) -> Floats:
        """Measured poses before and after each step, (6, S)."""
        return np.hstack([self.floor[:-1], self.floor[1:]]).T

    def predict(self) -> tuple[Floats, np.ndarray]:
        """Relative poses (S, 3) and whether they are sound."""
        plain = solve_steps(self.model, self.before, self.after)
        if self.model.is_plain:
            return plain.relative, plain.sound
        guess = np.where(np.isfinite(plain.relative), plain.relative, 0.0)
        spans = np.column_stack([self.times[:-1], self.times[1:]])
        coast = None
        if self.model.knows("history"):
            momenta = evaluate("balance", self.law, self.before, self.after, self.measured, self.settings)[0][:, 3:]
            coast = balance.Coast(self.rates[:, 0], self._carried(momenta))
        steps = balance.solve_balance(self.model, self.before, self.after, spans, self.floor[:-1], guess, coast)
        return steps.relative, steps.sound

    def differentiate(self, relative: Floats, columns: Sequence[Column]) -> Floats:
        """Derivatives (S, 3, P) of the relative poses."""
        starts = self.floor[:-1]
        ends = balance.compose(starts, np.nan_to_num(relative))
        poses = np.hstack([starts, ends]).T
        _, _, slope = evaluate("balance", self.law, self.before, self.after, poses, self.settings)
        by = self.residual_derivatives(poses, columns)
        matrix = slope[:, :3] + self.rates[:, :1, None] * slope[:, 3:]
        ends_by = -np.linalg.solve(matrix, by)
        c, s = np.cos(starts[:, 2])[:, None], np.sin(starts[:, 2])[:, None]
        x, y = ends_by[:, 0], ends_by[:, 1]
        return np.stack([c * x + s * y, c * y - s * x, ends_by[:, 2]], axis=1)

    def residual_derivatives(self, poses: Floats, columns: Sequence[Column]) -> Floats:
        """Derivatives of the residual by the columns (S, 3, P), momenta of earlier steps included."""
        now = self._by_columns(poses, columns)
        total = now[:, :3]
        if self.history:
            earlier = self._by_columns(self.measured, columns)[:, 3:]
            total = total + self.rates[:, 0, None, None] * now[:, 3:] + self._carried(earlier)
        return total

    def _by_columns(self, poses: Floats, columns: Sequence[Column]) -> Floats:
        everywhere, somewhere = sensitivities(self.law, self.before, self.after, poses, self.settings)
        kinds = medium_effects()
        first = {(e, p): 1 + i for i, (e, p, _) in enumerate(parameter_rows(kinds, placed=False))}
        second = {(e, p): i for i, (e, p, _) in enumerate(parameter_rows(kinds, placed=True))}
        found = []
        for column in columns:
            if column.effect is None:
                found.append(everywhere[:, :, 0])
            elif find(column.effect).place is None:
                found.append(everywhere[:, :, first[column.effect, column.parameter]])
            else:
                found.append(somewhere[:, :, column.place, second[column.effect, column.parameter]])
        return np.stack(found, axis=2)

    def _carried(self, momenta: Floats) -> Floats:
        """What earlier momenta (S, 3, ...) add to each step's residual."""
        zero = np.zeros((2, *momenta.shape[1:]))
        earlier = np.concatenate([zero, momenta])
        shape = (-1, *[1] * (momenta.ndim - 1))
        return self.rates[:, 1].reshape(shape) * earlier[1:-1] + self.rates[:, 2].reshape(shape) * earlier[:-2]
