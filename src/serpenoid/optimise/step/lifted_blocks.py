"""The step of a lifted body in space, over the coordinates of both waves, in layers like those of `serpenoid_blocks`.

    (w1, w2, xi, t - phase, bias)  --row-->  elements with first and second derivatives (once per row)
    elements, relative pose  --element-->  one summand of energy and residual (`mechanics.spatial`), over the elements
    relative pose of (g_t, g_{t+1})  --compose-->  2 x 6 numbers of absolute poses

The residual is d(E + S)/dh by the relative pose, scaled; its roots are those of the simulation (`simulation.lifted`).
Legend: M elements, s = 5 coordinates, z = (h (6), row t (s), row t + 1 (s)).
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from serpenoid.gaits.lifted import Lift
from serpenoid.mechanics import functions, spatial
from serpenoid.mechanics.chain_rule import composed, upper
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.functions import CSE, element_parameters
from serpenoid.mechanics.wide import Columns, over_columns
from serpenoid.model import Structure
from serpenoid.objectives import frames
from serpenoid.optimise.step.blocks import Cycle

COORDINATES = 5
# of the residuals: the floor's support is stiffer than the drag by so much, and would stop every step of a search
SCALE = ca.DM([1.0] * 3 + [1 / spatial.SUPPORT] * 3)


class LiftedBlocks:
    """Functions of one step in space; those of an element and of the composition are compiled, once for all bodies."""

    values = spatial.POSE

    def __init__(self, structure: Structure, lift: Lift, portable: bool = False) -> None:
        self.elements = structure.elements
        self._rows = [_row(structure, lift, order) for order in (0, 1, 2)]
        self._value, self._gradient, self._jacobian, self._hessian = _steps(structure, portable)

    def value(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Residuals (6, T) and energies (1, T)."""
        residual, energies = self._over(self._value, 0, cycle)
        return residual, energies

    def jacobian(self, cycle: Cycle) -> ca.MX:
        """d residual, shape (6, 22 T)."""
        return self._over(self._jacobian, 1, cycle)

    def gradient(self, cycle: Cycle) -> ca.MX:
        """d energy, shape (1, 22 T)."""
        return self._over(self._gradient, 1, cycle)

    def hessian(self, cycle: Cycle, multipliers: ca.MX, factors: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Gradient (22, T) and Hessian (22, 22 T) of the steps' Lagrangians."""
        slope, curvature = self._over(self._hessian, 2, cycle, multipliers, factors)
        return slope, curvature

    def _over(self, function: ca.Function, order: int, cycle: Cycle, *more: ca.MX) -> ca.MX:
        """Rows once for the steps on both sides of them, then `function` of every step."""
        rows, m = _mapped(self._rows[order], int(cycle.shapes.size2()))(cycle.shapes, cycle.parameters), self.elements
        following = ca.horzcat(rows[:, m:], rows[:, :m]) if cycle.closed else rows[:, m:]
        ends = [*cycle.ends, rows[:, : m * cycle.steps], following]
        inputs = [cycle.poses[:, :-1], cycle.poses[:, 1:], *ends, *more, cycle.parameters]
        return _mapped(function, cycle.steps)(*inputs)


def _mapped(function: ca.Function, count: int) -> ca.Function:
    """Over columns, but for the last input, which is the same for all."""
    return function.map(f"over_{function.name()}", "serial", count, [function.n_in() - 1], [])


@lru_cache(maxsize=2)
def element_functions(portable: bool = False) -> list[Columns]:
    """`spatial.element_functions` over elements, but for the single step."""
    return over_columns(spatial.element_functions(COORDINATES)[1:], portable=portable)


@lru_cache(maxsize=2)
def composition(portable: bool) -> list[ca.Function]:
    """`_composition`, compiled unless portable."""
    return _composition() if portable else compiled(_composition())


@lru_cache(maxsize=48)
def _row(structure: Structure, lift: Lift, order: int) -> ca.Function:
    """(coordinates, parameters) -> elements (7 C, M): each above its first and second derivatives, up to `order`."""
    v, parameters = ca.SX.sym("coordinates", COORDINATES), ca.SX.sym("parameters", 2 * structure.vertices)
    _, _, found = functions.lifted_row(structure, lift)(v, parameters)
    parts = [ca.vec(found)]
    if order:
        parts += ca.horzsplit(ca.jacobian(parts[0], v))
    if order == 2:
        parts += [ca.jacobian(parts[1 + j], v[i]) for i, j in upper(COORDINATES)]
    stacked = ca.vertcat(*(ca.reshape(part, found.shape) for part in parts))
    return ca.Function(f"lifted_row_{order}", [v, parameters], [ca.densify(stacked)], CSE)


def _steps(structure: Structure, portable: bool) -> list[ca.Function]:
    """value, gradient, jacobian, hessian of one step: sums over the elements, then the chain rule to the poses."""
    (value, gradient, jacobian, hessian), (local, sensitivity, compose) = (
        element_functions(portable),
        composition(portable),
    )
    m, n = structure.elements, spatial.POSE
    outer = [ca.MX.sym("g0", n), ca.MX.sym("g1", n), ca.MX.sym("a0", COORDINATES), ca.MX.sym("a1", COORDINATES)]
    parameters, multipliers = ca.MX.sym("parameters", 2 * structure.vertices), ca.MX.sym("multipliers", n)
    factor, (weights, eps) = ca.MX.sym("factor"), element_parameters(structure)(parameters)
    h, by_outer = local(*outer), sensitivity(*outer)

    def total(element: Columns, *more: ca.MX) -> tuple[list[ca.MX], list[ca.MX]]:
        function = element.function
        rows = [ca.MX.sym(f"r{i}", function.size1_in(1), m) for i in (0, 1)]
        same = [ca.repmat(x, 1, m) for x in (h, *more)]
        found = element(m, same[0], *rows, *same[1:], weights.T, eps)
        each = zip([found] if isinstance(found, ca.MX) else found, range(function.n_out()), strict=True)
        return [*outer, *rows], [ca.reshape(ca.sum2(ca.reshape(x, -1, m)), function.size_out(i)) for x, i in each]

    def made(name: str, inputs: list[ca.MX], outputs: list[ca.MX]) -> ca.Function:
        return ca.Function(f"lifted_{name}", [*inputs, parameters], outputs)

    (plain, values), (first, slopes), (also, rates) = total(value), total(gradient), total(jacobian)
    second, (slope, curvature) = total(hessian, SCALE * multipliers, factor)
    return [
        made("value", plain, [SCALE * values[0], values[1]]),
        made("gradient", first, [slopes[0] @ by_outer]),
        made("jacobian", also, [ca.diag(SCALE) @ rates[0] @ by_outer]),
        made("hessian", [*second, multipliers, factor], list(compose(*outer, slope, curvature))),
    ]


def _composition() -> list[ca.Function]:
    """h from the outer variables; the derivative of z by them; gradient and Hessian by the chain rule."""
    n, s = spatial.POSE, COORDINATES
    inputs = [ca.SX.sym("g0", n), ca.SX.sym("g1", n), ca.SX.sym("a0", s), ca.SX.sym("a1", s)]
    h, outer = frames.relative(inputs[0], inputs[1]), ca.vertcat(*inputs)
    z = ca.vertcat(h, *inputs[2:])
    sensitivity = ca.jacobian(z, outer)
    return [
        ca.Function("spatial_local", inputs, [ca.densify(h)], CSE),
        ca.Function("spatial_local_jacobian", inputs, [ca.densify(sensitivity)], CSE),
        composed("spatial_compose", inputs, z),
    ]
