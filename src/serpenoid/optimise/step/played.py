"""Servos with memory in the gait NLP: what every such effect lets through, at every row, is a variable.

    z_t = respond(z_{t-1}, in_{t-1}, in_t)     per joint, effect with memory, and row: equations for all it remembers

`in` is the command, or what the effect before lets through; realised angles follow from z_t and the command of row t.
A closed gait's first row follows its last, so that the solution is the periodic motion on which servos settle; a
transient begins at rest. Kinks (a gap of play that is just crossed) are those of the simulation.

Legend: R rows, m joints, S states of a row, n gait parameters, k that a row depends on, d data of a row.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import ActuationEffect, Symbols
from serpenoid.effects.catalogue import actuation_effects
from serpenoid.gaits import GaitFamily
from serpenoid.mechanics import kinematics
from serpenoid.mechanics.functions import split_parameters
from serpenoid.model import Model
from serpenoid.optimise.step.layer import Layer, RowFunctions, row_functions
from serpenoid.simulation.servos import coordinates


@dataclass(frozen=True)
class Played:
    """States beside the parameters of a family: NLP parameters are (states row by row, gait parameters)."""

    model: Model
    family: GaitFamily
    portable: bool = False

    @property
    def per_row(self) -> int:
        """S."""
        return sum(kind.memory for joint in range(self.family.joints) for kind in self._remembering(joint))

    @property
    def states(self) -> int:
        """S R."""
        return self.per_row * self.family.rows

    def behind(self, layer: Layer) -> Layer:
        """A layer of the gait's parameters as one of all parameters."""
        return Layer(layer.functions, layer.indices + self.states, layer.size + self.states)

    def realised(self) -> Layer:
        """Parameters to the joint angles that the body has."""
        family, s = self.family, self.per_row
        p, data, parameters = self._symbols(1)
        angles = self._row(p[:s], self._command(p[s:], data, parameters))
        functions = self._functions("realised", ca.Function("realised", [p, data, parameters], [angles]))
        return Layer(functions, np.hstack([self._own, family.indices + self.states]), self.states + family.size)

    def equations(self) -> tuple[Layer, Floats]:
        """Layer of the servos' equations, (S) per row, and its data (R, 2 d + 1)."""
        family, s, d = self.family, self.per_row, self.family.data.shape[1]
        sparse, k = family.sparse, family.indices.shape[1]
        p, data, parameters = self._symbols(2)
        first = data[2 * d]
        before, after = p[:s], p[s : 2 * s]
        gait = p[2 * s :]
        then = self._command(gait[:k], data[:d], parameters)
        now = self._command(gait[k:] if sparse else gait, data[d : 2 * d], parameters)
        left = self._left(before, after, then, now, first)
        functions = self._functions("servos", ca.Function("servos", [p, data, parameters], [left]))
        previous = np.arange(family.rows) - 1
        begins = np.zeros(family.rows)
        if not family.closed:
            previous[0], begins[0] = 0, 1.0
        previous %= family.rows
        commands = [family.indices[previous], family.indices] if sparse else [family.indices]
        behind = [indices + self.states for indices in commands]
        indices = np.hstack([self._own[previous], self._own, *behind])
        numbers = np.hstack([family.data[previous], family.data, begins[:, None]])
        return Layer(functions, indices, self.states + family.size), numbers

    def start(self, table: Floats) -> Floats:
        """States (S R) of a joint table (R, m), played again and again or from rest."""
        if not self.per_row:
            return np.zeros(0)
        command, then = ca.SX.sym("command", self.family.joints), ca.SX.sym("then", self.family.joints)
        before, first = ca.SX.sym("before", self.per_row), ca.SX.sym("first")
        step = ca.Function("play", [before, then, command, first], [self._following(before, then, command, first)])
        state = np.zeros(self.per_row)
        found = np.zeros((self.family.rows, self.per_row))
        for cycle in range(CYCLES if self.family.closed else 1):
            last = state
            for t in range(self.family.rows):
                begins = 1.0 if t == cycle == 0 else 0.0
                state = found[t] = step(state, table[t if begins else t - 1], table[t], begins).full()[:, 0]
            if cycle and np.abs(state - last).max() <= FADED:
                break
        return found.ravel()

    @property
    def _own(self) -> np.ndarray:
        """States of every row, (R, S)."""
        return np.arange(self.states).reshape(self.family.rows, -1)

    def _remembering(self, joint: int) -> list[ActuationEffect]:
        return [kind for kind, _ in self._chain(joint) if remembers(kind)]

    def _chain(self, joint: int) -> Iterator[tuple[ActuationEffect, Symbols]]:
        """Effects at work in a joint, in order, with their numbers."""
        theta, start = ca.SX(ca.DM(coordinates(self.model)[:, joint])), 0
        for kind in actuation_effects():
            count = len(kind.parameters) + 1
            if any(e.name == kind.name and e.place in (None, joint + 1) for e in self.model.actuation_effects):
                yield kind, kind.symbols(theta[start : start + count])
            start += count

    def _row(self, states: ca.SX, command: ca.SX) -> ca.SX:
        """Realised angles (m) of a row."""
        remembered, angles = iter(ca.vertsplit(states)), []
        for joint in range(self.family.joints):
            angle = command[joint]
            for kind, p in self._chain(joint):
                if not remembers(kind):
                    angle = _at_once(kind, angle, p)
                    continue
                angle, *_ = (next(remembered) for _ in range(kind.memory))
            angles.append(angle)
        return ca.vertcat(*angles)

    def _left(self, before: ca.SX, after: ca.SX, then: ca.SX, now: ca.SX, first: ca.SX) -> ca.SX:
        """What the equations leave, (S)."""
        return after - self._following(before, then, now, first, after)

    def _following(self, before: ca.SX, then: ca.SX, now: ca.SX, first: ca.SX, after: ca.SX | None = None) -> ca.SX:
        """States (S) after a step; `first`: it begins at rest. after: states that later effects take as given."""
        duration = ca.SX(self.model.step_duration(self.family.rows - (not self.family.closed)))
        olds, news = ca.vertsplit(before), None if after is None else ca.vertsplit(after)
        found: list[ca.SX] = []
        for joint in range(self.family.joints):
            was, now_in = then[joint], now[joint]
            for kind, p in self._chain(joint):
                if not remembers(kind):
                    was, now_in = _at_once(kind, was, p), _at_once(kind, now_in, p)
                    continue
                number = len(found)
                last = ca.vertcat(*olds[number : number + kind.memory])
                old = first * then[joint] + (1 - first) * last
                found.extend(ca.vertsplit(kind.respond(old, was, now_in, duration, p)))
                was, now_in = old[0], (found if news is None else news)[number]
        return ca.vertcat(*found)

    def _command(self, p: ca.SX, data: ca.SX, parameters: ca.SX) -> ca.SX:
        edges, _, _ = split_parameters(parameters, self.model.structure)
        return kinematics.family_joint_angles(self.family, p, data, edges, self.model.structure)

    def _symbols(self, rows: int) -> tuple[ca.SX, ca.SX, ca.SX]:
        k, d = self.family.indices.shape[1], self.family.data.shape[1]
        commands = k * (rows if self.family.sparse else 1)
        p = ca.SX.sym("p", self.per_row * rows + commands)
        return p, ca.SX.sym("data", d * rows + (rows > 1)), ca.SX.sym("parameters", 2 * self.model.structure.vertices)

    def _functions(self, name: str, function: ca.Function) -> RowFunctions:
        return row_functions(name, function, portable=True)  # every selection of effects would be another library


CYCLES = 2000  # a memory that has not faded by then never will
FADED = 1e-14


def remembers(effect: object) -> bool:
    """Whether an effect has a state in the NLP; a gait that never saturates has none of saturation."""
    return isinstance(effect, ActuationEffect) and effect.memory > 0 and not effect.limits


def _at_once(kind: ActuationEffect, angle: ca.SX, p: Symbols) -> ca.SX:
    return angle if kind.memory else kind.respond(angle, angle, angle, ca.SX(1), p)
