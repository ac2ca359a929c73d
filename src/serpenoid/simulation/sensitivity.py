"""What each step of a recording would have been, and how that depends on every parameter: for fits.

Given measured shapes and poses, step i is predicted from its own measured start. With r(h, theta) = 0 at the root,
dh/dtheta = -(dr/dh)^{-1} dr/dtheta (implicit function theorem). Legend: R rows, S = R - 1 steps, N vertices, P columns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect, MediumEffect
from serpenoid.effects.catalogue import find, medium_effects
from serpenoid.mechanics.extended import held_for, parameter_rows
from serpenoid.mechanics.root_columns import root_columns
from serpenoid.mechanics.servo import parameter_rows as parameter_rows_of_servos
from serpenoid.model import Model
from serpenoid.simulation import balance, servos
from serpenoid.simulation.balance import Balance
from serpenoid.simulation.inertia import carried, coefficients
from serpenoid.simulation.law import MediumNumbers, evaluate, sensitivities
from serpenoid.simulation.newton import implicit_derivative
from serpenoid.simulation.poses import body_frame, body_poses
from serpenoid.simulation.steps import elements_of_vertices, solve_steps


@dataclass(frozen=True)
class Column:
    """One parameter of a fit: the coordinate of an effect's parameter, or eps (effect None).

    A column may have a place though its effect has none: the law of the whole body, at that vertex alone.
    """

    effect: str | None
    place: int | None
    parameter: str

    @property
    def alone(self) -> bool:
        """Whether it is of a law of the whole body at one vertex."""
        return self.effect is not None and self.place is not None and find(self.effect).place is None


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

    def part(self, some: slice) -> StepSensitivities:
        """Of some of the steps."""
        return StepSensitivities(self.relative[some], self.jacobian[some], self.columns, self.sound[some])


EPS = Column(None, None, "anisotropy_ratio")
DIFFERENCE = 1e-6  # of a typical value: derivatives good to about as much


@dataclass(frozen=True)
class MeasuredSteps:
    """Measured shapes and poses as steps, of one recording or of several, one after the other.

    before, after: elements (4, M S); spans (S, 2) [s]: when each step begins and ends; starts, ends (S, 3): measured
    poses on the floor [body lengths, rad]; inertia (S, 3): coefficients of momenta.
    """

    before: Floats
    after: Floats
    spans: Floats
    starts: Floats
    ends: Floats
    inertia: Floats

    @classmethod
    def of(cls, model: Model, vertices: Floats, times: Floats, floor: Floats) -> MeasuredSteps:
        """Of vertices (R, N, 2) [body lengths] at `times` (R,) with poses (R, 3)."""
        m = model.structure.elements
        elements = np.ascontiguousarray(elements_of_vertices(model, body_frame(model, vertices)).T).T  # step by step
        spans = np.column_stack([times[:-1], times[1:]])
        return cls(elements[:, :-m], elements[:, m:], spans, floor[:-1], floor[1:], coefficients(times))

    @classmethod
    def joined(cls, parts: Sequence[MeasuredSteps]) -> MeasuredSteps:
        """Several recordings."""
        elements = (np.concatenate([getattr(p, name).T for p in parts]).T for name in ("before", "after"))
        others = (np.concatenate([getattr(p, name) for p in parts]) for name in ("spans", "starts", "ends", "inertia"))
        return cls(*elements, *others)

    def some(self, keep: np.ndarray) -> MeasuredSteps:
        """Those with the numbers `keep`."""
        elements = (balance.some_steps(x, len(self), keep) for x in (self.before, self.after))
        return MeasuredSteps(*elements, *(x[keep] for x in (self.spans, self.starts, self.ends, self.inertia)))

    def placed(self, coast: balance.Coast | None) -> balance.Placed:
        """As steps to be solved, with what earlier momenta add."""
        return balance.Placed(self.before, self.after, self.spans, self.starts, coast)

    def __len__(self) -> int:
        return len(self.spans)


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
    are not in the model: `ActiveEffect.neutral(name, place)`, with values for parameters that have no neutral one. A
    law of the whole body that the model has not may have a vertex as its place: what it would do there alone.
    """
    floor = body_poses(model, vertices) if poses is None else np.asarray(poses, float)
    return sensitivities_of(model, MeasuredSteps.of(model, vertices, np.asarray(times, float), floor), candidates)


def sensitivities_of(
    model: Model, steps: MeasuredSteps, candidates: Sequence[ActiveEffect] = (), near: Floats | None = None
) -> StepSensitivities:
    """The same of measured steps, of any number of recordings at once; each step's answer is its own.

    near (S, 3): relative poses of a model much like this one, NaN where there are none: the search begins there.
    """
    problem, columns = recorded(model, steps, candidates)
    root = problem.predict(near)
    jacobian = problem.differentiate(root, columns)
    jacobian[~root.sound] = np.nan
    return StepSensitivities(root.relative, jacobian, columns, root.sound)


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
    model: Model, steps: MeasuredSteps, candidates: Sequence[ActiveEffect]
) -> tuple[Recorded, tuple[Column, ...]]:
    """Recorded steps as a problem, and the columns of its derivatives: eps, the model's medium effects, candidates."""
    wanted = [e for e in (*model.medium_effects, *candidates) if isinstance(e.effect, MediumEffect)]
    wanted = list({e.key: e for e in reversed(wanted)}.values())[::-1]
    columns = (EPS, *(Column(e.name, e.place, p.name) for e in wanted for p in e.effect.parameters))
    whole = [e for e in wanted if e not in model.effects and (e.place is None) == (e.effect.place is None)]
    law = MediumNumbers.of(model, candidates=whole)
    history = any("history" in e.effect.knows for e in wanted if isinstance(e.effect, MediumEffect))
    return Recorded(model, law, steps, history), columns


def _has_edge(active: ActiveEffect) -> bool:
    return isinstance(active.effect, ActuationEffect) and active.effect.memory > 0 and active.effect.place is not None


@dataclass(frozen=True)
class Recorded:
    """Recorded steps, with the law of the model plus resting candidates; history: whether momenta matter to any."""

    model: Model
    law: MediumNumbers
    steps: MeasuredSteps
    history: bool

    @property
    def settings(self) -> Floats:
        """Settings of the steps."""
        return self.law.settings(self.steps.spans)

    @property
    def measured(self) -> Floats:
        """Measured poses before and after each step, (6, S)."""
        return np.hstack([self.steps.starts, self.steps.ends]).T

    def predict(self, near: Floats | None = None) -> Balance:
        """Relative poses (S, 3), whether they are sound, and slopes; `near`: where to begin."""
        if self.model.is_plain:
            plain = solve_steps(self.model, self.steps.before, self.steps.after)
            slopes = self._slopes(plain.relative)
            return Balance(plain.relative, plain.energy, plain.residual, plain.sound, slopes)
        coast = self._coast()
        if near is None:
            return self._balanced(np.arange(len(self.steps)), coast)
        found = balance.solve_near(self.model, self.steps.placed(coast), near)
        lost = np.flatnonzero(~found.sound)
        if lost.size:
            again = self._balanced(lost, coast)
            for mine, theirs in zip(_fields(found), _fields(again), strict=True):
                mine[lost] = theirs
        return found

    def _balanced(self, some: np.ndarray, coast: balance.Coast | None) -> Balance:
        """Some of the steps, from the baseline's roots."""
        s = self.steps.some(some)
        plain = solve_steps(self.model, s.before, s.after)
        guess = np.where(np.isfinite(plain.relative), plain.relative, 0.0)
        mine = None if coast is None else coast.part(some)
        return balance.solve_balance(self.model, s.placed(mine), guess)

    def _coast(self) -> balance.Coast | None:
        """What the momenta of the measured motion carry into each step."""
        if not self.model.knows("history"):
            return None
        now = evaluate("balance", self.law, self.steps.before, self.steps.after, self.measured, self.settings)[0]
        return balance.Coast(self.steps.inertia[:, 0], carried(self.steps.inertia, now[:, 3:]))

    def _slopes(self, relative: Floats) -> Floats:
        s = self.steps
        poses = np.hstack([s.starts, group.compose(s.starts, np.nan_to_num(relative))]).T
        slope = evaluate("balance", self.law, s.before, s.after, poses, self.settings)[2]
        return slope[:, :3] + s.inertia[:, :1, None] * slope[:, 3:]

    def differentiate(self, root: Balance, columns: Sequence[Column]) -> Floats:
        """Derivatives (S, 3, P) of the relative poses."""
        starts = self.steps.starts
        ends = group.compose(starts, np.nan_to_num(root.relative))
        slopes = np.where(root.sound[:, None, None], root.slopes, np.eye(3))
        law = self.law.asked(c.effect for c in columns)
        run = None if self.history else root_columns(law.kind, held_for(law.acting))
        alone = np.array([c.alone for c in columns], dtype=bool)
        if run is not None and alone.any() and not alone.all():  # the others are compiled
            found = np.empty((len(ends), 3, len(columns)))
            for own in (alone, ~alone):
                found[:, :, own] = self.differentiate(root, [c for c, mine in zip(columns, own, strict=True) if mine])
            return found
        if run is not None and not alone.any():
            placed, own, row = _rows(columns)
            which = np.column_stack([np.where(placed, own, -1), row])
            chains = (np.asarray(x.T, float).reshape(len(ends), -1, 4) for x in (self.steps.before, self.steps.after))
            return run(*chains, np.hstack([starts, ends]), self.settings.T, slopes, law.medium.T, law.theta.T, which)
        by = self.residual_derivatives(columns, np.hstack([starts, ends]).T)
        ends_by = implicit_derivative(slopes[None], by)
        c, s = np.cos(starts[:, 2])[:, None], np.sin(starts[:, 2])[:, None]
        x, y = ends_by[:, 0], ends_by[:, 1]
        return np.stack([c * x + s * y, c * y - s * x, ends_by[:, 2]], axis=1)

    def residual_derivatives(self, columns: Sequence[Column], poses: Floats | None = None) -> Floats:
        """Derivatives of the residual by the columns (S, 3, P), momenta of earlier steps included; poses (6, S), by
        default the measured ones."""
        now = self._by_columns(self.measured if poses is None else poses, columns)
        total = now[:, :3]
        if self.history:
            earlier = (now if poses is None else self._by_columns(self.measured, columns))[:, 3:]
            c = self.steps.inertia
            total = total + c[:, 0, None, None] * now[:, 3:] + carried(c, earlier)
        return total

    def _by_columns(self, poses: Floats, columns: Sequence[Column]) -> Floats:
        alone = np.array([c.alone for c in columns], dtype=bool)
        found = np.empty((len(self.steps), 6, len(columns)))
        if not alone.all():
            everywhere, somewhere = sensitivities(self.law, self.steps.before, self.steps.after, poses, self.settings)
            placed, own, row = _rows([c for c in columns if not c.alone])
            by = everywhere[:, :, row]
            by[:, :, placed] = somewhere[:, :, own[placed], row[placed]]
            found[:, :, ~alone] = by
        if alone.any():
            found[:, :, alone] = self._by_vertices(poses, [c for c in columns if c.alone])
        return found

    def _by_vertices(self, poses: Floats, columns: Sequence[Column]) -> Floats:
        """By coordinates of laws of the whole body at one vertex each, from differences: (S, 6, P)."""
        rows = {(e, p): row for e, p, row in parameter_rows(medium_effects(), placed=False)}

        def momenta(law: MediumNumbers) -> Floats:
            return evaluate("balance", law, self.steps.before, self.steps.after, poses, self.settings)[0]

        now, found = momenta(self.law), []
        for c in columns:
            (p,) = (p for p in find(c.effect or "").parameters if p.name == c.parameter)
            step, theta = DIFFERENCE * abs(p.coordinate(p.typical)), self.law.theta.copy()
            theta[rows[c.effect or "", c.parameter], c.place] += step
            found.append((momenta(replace(self.law, theta=theta)) - now) / step)
        return np.stack(found, axis=2)


def _rows(columns: Sequence[Column]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of each column (P,): whether it has a place, that place, and its number among those with one or without."""
    kinds = medium_effects()
    first = {(e, p): 1 + i for i, (e, p, _) in enumerate(parameter_rows(kinds, placed=False))}
    second = {(e, p): i for i, (e, p, _) in enumerate(parameter_rows(kinds, placed=True))}
    placed = np.array([c.place is not None for c in columns], dtype=bool)
    own = np.array([c.place or 0 for c in columns])
    rows = [(first if c.place is None else second)[c.effect, c.parameter] if c.effect else 0 for c in columns]
    return placed, own, np.array(rows)


def _fields(found: Balance) -> tuple[Floats, ...]:
    return found.relative, found.energy, found.residual, found.sound, found.slopes
