"""The step over serpenoid coordinates, in three small layers.

    (w1, w2, xi)  --gait_row-->  elements, with first and second derivatives
    elements, relative pose  --element-->  one summand of energy and momentum, mapped over the elements (a C loop)
    relative pose of (g_t, g_{t+1})  --compose-->  12 variables

The layers keep the compiled code small, independent of the number of joints, and the shape kinematics out of the pose
derivatives. The residual is dE/d pose in the relative pose's own coordinates: its roots are those of the geometric
momentum. Legend: M elements, z = (relative pose h (3), row t (3), row t + 1 (3)): 9 local variables.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from serpenoid.mechanics import energy
from serpenoid.mechanics.chain_rule import composed, packed
from serpenoid.mechanics.functions import CSE, element_parameters
from serpenoid.mechanics.wide import Columns, over_columns
from serpenoid.model import Structure
from serpenoid.optimise.step import plain_element
from serpenoid.optimise.step.blocks import Cycle
from serpenoid.optimise.step.rows import COEFFICIENTS, gait_row, polynomial

LOCAL = 9  # h, coordinates of row t, coordinates of row t + 1
VALUES = 4, 4, 3  # of an element, as rows give them with no, first, second derivatives by (w1, w2, xi)
ROW = tuple(size * c for size, c in zip(VALUES, COEFFICIENTS, strict=True))


class SerpenoidBlocks:
    """Functions of one step, over shape coordinates (w1, w2, xi)."""

    values = 3

    def __init__(self, structure: Structure, portable: bool = False) -> None:
        self._value, self._gradient, self._jacobian, self._hessian = _functions(structure, portable)

    def value(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Residuals (3, T) and energies (1, T)."""
        residual, energies = cycle.over(self._value)
        return residual, energies

    def jacobian(self, cycle: Cycle) -> ca.MX:
        """d residual, shape (3, 12 T)."""
        return cycle.over(self._jacobian)

    def gradient(self, cycle: Cycle) -> ca.MX:
        """d energy, shape (1, 12 T)."""
        return cycle.over(self._gradient)

    def hessian(self, cycle: Cycle, multipliers: ca.MX, factors: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Gradient (12, T) and Hessian (12, 12 T) of the steps' Lagrangians."""
        slope, curvature = cycle.over(self._hessian, multipliers, factors)
        return slope, curvature


@lru_cache(maxsize=16)
def _functions(structure: Structure, portable: bool) -> list[Columns]:
    return over_columns(_steps(structure), portable=portable)


def _steps(structure: Structure) -> list[ca.Function]:
    """value, gradient, jacobian, hessian of one step: sums over the elements, then the chain rule to the poses."""
    m = structure.elements
    outer = [ca.MX.sym("g0", 3), ca.MX.sym("g1", 3), ca.MX.sym("a0", 3), ca.MX.sym("a1", 3)]
    parameters = ca.MX.sym("parameters", 2 * structure.vertices)
    shapes = [gait_row(structure, order) for order in range(len(ROW))]
    rows = [[shape(a, parameters) for a in outer[2:]] for shape in shapes]
    multipliers, factor = ca.MX.sym("multipliers", 3), ca.MX.sym("factor")
    weights, eps = element_parameters(structure)(parameters)
    local, local_jacobian, compose = _composition()
    h, sensitivity = local(*outer)[:3], local_jacobian(*outer)

    def total(function: ca.Function, order: int, *more: ca.MX) -> tuple[ca.MX, ...]:
        shared = [2, *range(3, 3 + len(more)), function.n_in() - 1]
        name, outputs = f"all_{function.name()}", list(range(function.n_out()))
        summed = function.map(name, "serial", m, shared, outputs)(*rows[order], h, *more, weights.T, eps)
        return summed if isinstance(summed, tuple) else (summed,)

    value, gradient, jacobian, hessian = _element()
    slope, curvature = total(hessian, 2, multipliers, factor)
    return [
        ca.Function("gait_value", [*outer, parameters], list(total(value, 0))),
        ca.Function("gait_gradient", [*outer, parameters], [total(gradient, 1)[0] @ sensitivity]),
        ca.Function("gait_jacobian", [*outer, parameters], [total(jacobian, 1)[0] @ sensitivity]),
        ca.Function("gait_hessian", [*outer, multipliers, factor, parameters], list(compose(*outer, slope, curvature))),
    ]


def _element() -> list[ca.Function]:
    """Value, gradient, Jacobian and Hessian of one element's share, from the Taylor polynomials of its two rows."""
    h, w, eps = ca.SX.sym("h", 3), ca.SX.sym("w"), ca.SX.sym("eps")
    d0, d1 = ca.SX.sym("d0", 3), ca.SX.sym("d1", 3)
    z, zero = ca.vertcat(h, d0, d1), ca.vertcat(h, ca.SX.zeros(6))

    def share(order: int) -> tuple[list[ca.SX], ca.SX]:
        r0, r1 = ca.SX.sym("r0", ROW[order]), ca.SX.sym("r1", ROW[order])
        after = energy.move(h, polynomial(r1, d1, 4))
        return [r0, r1, h], energy.element_energy(polynomial(r0, d0, 4), after, w, eps)

    def function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> ca.Function:
        at_row = [ca.densify(ca.substitute(expression, z, zero)) for expression in outputs]
        return ca.Function(f"element_{name}", [*inputs, w, eps], at_row, CSE)

    (rows0, plain), (rows1, linear) = share(0), share(1)
    return [
        function("value", rows0, [ca.gradient(plain, h), plain]),
        function("gradient", rows1, [ca.jacobian(linear, z)]),
        function("jacobian", rows1, [ca.jacobian(ca.gradient(linear, h), z)]),
        _element_hessian(),
    ]


def _element_hessian() -> ca.Function:
    """Gradient (9) and packed Hessian of an element's Lagrangian by z, from the Taylor polynomials of its two rows."""
    h, w, eps, factor = ca.SX.sym("h", 3), ca.SX.sym("w"), ca.SX.sym("eps"), ca.SX.sym("factor")
    multipliers, rows = ca.SX.sym("multipliers", 3), [ca.SX.sym(f"r{i}", ROW[2]) for i in (0, 1)]
    offsets = [ca.SX.sym(f"d{i}", 3) for i in (0, 1)]
    z, inner = ca.vertcat(h, *offsets), ca.SX.sym("inner", LOCAL)
    places = [polynomial(row, d, VALUES[2]) for row, d in zip(rows, offsets, strict=True)]
    moved = plain_element.motion(inner[:3], inner[3:6], inner[6:], multipliers)
    by_inner = plain_element.chained(inner, moved, *plain_element.lagrangian(moved, w, eps, multipliers[2], factor))
    found = plain_element.chained(z, ca.vertcat(h, *places), *by_inner)
    here = ca.vertcat(h, *(row[:3] for row in rows))
    slope, curvature = (ca.substitute(ca.substitute(x, z, ca.vertcat(h, ca.SX.zeros(6))), inner, here) for x in found)
    inputs = [*rows, h, multipliers, factor, w, eps]
    return ca.Function("element_hessian", inputs, [ca.densify(slope), ca.densify(packed(curvature))], CSE)


def _composition() -> tuple[ca.Function, ca.Function, ca.Function]:
    """Local variables z from the outer ones, their Jacobian, and gradient and Hessian by the chain rule."""
    inputs = [ca.SX.sym("g0", 3), ca.SX.sym("g1", 3), ca.SX.sym("a0", 3), ca.SX.sym("a1", 3)]
    g0, g1, a0, a1 = inputs
    back = energy.planar_rotation(g0[2]).T @ (g1[:2] - g0[:2])
    z, outer = ca.vertcat(back, g1[2] - g0[2], a0, a1), ca.vertcat(*inputs)
    sensitivity = ca.jacobian(z, outer)
    return (
        ca.Function("local", inputs, [z], CSE),
        ca.Function("local_jacobian", inputs, [ca.densify(sensitivity)], CSE),
        composed("compose", inputs, z),
    )
