"""Step values times the step's energy: what a bounded force needs in an optimiser.

Friction is bounded however far a step goes, and so would the violation of its balance be: an optimiser that gains
distance by leaping away from the motion would be right. Multiplied by k = T^2 E + least > 0 the residual has the same
roots and grows with the step. Derivatives follow by the product rule: with a = dE and b = lambda . dr, the Hessian of
lambda . (k r) + f E is that of (k lambda) . r + (f + T^2 lambda . r) E, plus T^2 (a b^t + b a^t).
Legend: T steps, v values per step, o local variables.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.optimise.step.blocks import Cycle, StepBlocks

LEAST = 0.01  # keeps the balance in pauses; a cycle of one body length works about ten times as much


class GrowingBlocks:
    """StepBlocks of a law of degree one: values are all multiplied, energies divided by T (the NLP takes T E)."""

    def __init__(self, blocks: StepBlocks, steps: int) -> None:
        self.blocks, self.values, self._scale, self._share = blocks, blocks.values, float(steps**2), 1 / steps

    def value(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Values (v, T) and energies (1, T)."""
        value, energies = self._plain(cycle)
        return self._rows(self._factor(energies)) * value, energies

    def _plain(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        value, energies = self.blocks.value(cycle)
        return value, self._share * energies

    def gradient(self, cycle: Cycle) -> ca.MX:
        """d energy, shape (1, o T)."""
        return self._share * self.blocks.gradient(cycle)

    def jacobian(self, cycle: Cycle) -> ca.MX:
        """d values, shape (v, o T)."""
        value, energies = self._plain(cycle)
        slopes, falls = self.blocks.jacobian(cycle), self.gradient(cycle)
        spread = _spread(slopes.size2(), cycle.steps)
        grown = self._rows(self._factor(energies) @ spread) * slopes
        return grown + self._scale * (value @ spread) * self._rows(falls)

    def hessian(self, cycle: Cycle, multipliers: ca.MX, factors: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Gradient (o, T) and Hessian (o, o T) of the steps' Lagrangians."""
        value, energies = self._plain(cycle)
        scaled = self._rows(self._factor(energies)) * multipliers
        on_energy = self._share * (factors + self._scale * ca.sum1(multipliers * value))
        slope, curvature = self.blocks.hessian(cycle, scaled, on_energy)
        slopes, o = self.blocks.jacobian(cycle), slope.size1()
        forces = ca.sum1(slopes * (multipliers @ _spread(slopes.size2(), cycle.steps)))
        sides = (ca.reshape(row, o, cycle.steps) for row in (self.gradient(cycle), forces))
        return slope, curvature + self._scale * _products(o).map(cycle.steps)(*sides)

    def _factor(self, energies: ca.MX) -> ca.MX:
        return self._scale * energies + LEAST

    def _rows(self, row: ca.MX) -> ca.MX:
        return ca.repmat(row, self.values, 1)


def _spread(columns: int, steps: int) -> ca.DM:
    """(T, o T): a number per step to its o columns."""
    return ca.kron(ca.DM.eye(steps), ca.DM.ones(1, columns // steps))


def _products(o: int) -> ca.Function:
    a, b = ca.SX.sym("a", o), ca.SX.sym("b", o)
    return ca.Function("products", [a, b], [a @ b.T + b @ a.T])
