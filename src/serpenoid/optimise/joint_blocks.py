"""The step over joint angles: any shape, with or without effects of the medium.

    angles --row--> places w = (x, y, direction of its tangent[, of its link]) of the elements, and dw/d angles
    poses, w_t, w_{t+1} --element--> one summand of values and energy with first and second derivatives, in a C loop
    sums over the elements --step--> derivatives by both poses and all angles

Directions are linear in the angles, positions are B (cos psi, sin psi) with B constant in the angles, so the second
derivatives of the kinematics are diagonal in the edge directions psi: a step costs matrix products of its elements and
joints, and its code does not grow with them. Legend: N vertices, n = N - 1 edges, M elements, m joints, l numbers per
place (3 or 4), v values per step, o = 6 + 2 m.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics import energy
from serpenoid.mechanics.compile import compiled
from serpenoid.mechanics.functions import CSE, element_parameters, split_parameters
from serpenoid.model import Structure
from serpenoid.optimise.blocks import Cycle, over

FRAME = 6  # both poses


@dataclass(frozen=True)
class ElementShare:
    """One element's symbolic share: inputs frame (6), w (l), w after (l), *more (numbers of the element and the step).

    more: symbols; shared: which of them are the same for all elements. value: SX (v); energy: SX.
    """

    frame: ca.SX
    before: ca.SX
    after: ca.SX
    more: tuple[ca.SX, ...]
    shared: tuple[bool, ...]
    value: ca.SX
    energy: ca.SX


class JointBlocks:
    """Functions of one step over joint angles. `numbers`: what the law takes per element, constant over the steps."""

    def __init__(self, structure: Structure, functions: list[ca.Function], values: int) -> None:
        self.joints, self.values = len(structure.joints), values
        self._places, self._row, self._value, self._gradient, self._jacobian, self._hessian = functions
        self._widths = (structure.elements, self.joints, structure.vertices - 1)

    def value(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Values (v, T) and energies (1, T)."""
        value, energies = self._over(self._value, cycle, of=self._places)
        return value, energies

    def jacobian(self, cycle: Cycle) -> ca.MX:
        """d values, shape (v, o T)."""
        return self._over(self._jacobian, cycle)

    def gradient(self, cycle: Cycle) -> ca.MX:
        """d energy, shape (1, o T)."""
        return self._over(self._gradient, cycle)

    def hessian(self, cycle: Cycle, multipliers: ca.MX, factors: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Gradient (o, T) and Hessian (o, o T) of the steps' Lagrangians."""
        slope, curvature = self._over(self._hessian, cycle, multipliers, factors)
        return slope, curvature

    def _over(self, function: ca.Function, cycle: Cycle, *more: ca.MX, of: ca.Function | None = None) -> ca.MX:
        """`function` of every step; of: what it needs of the rows, default places with slopes."""
        rows = over(of or self._row, int(cycle.shapes.size2()), [1], cycle.shapes, cycle.parameters)
        parts = [rows] if isinstance(rows, ca.MX) else rows
        ends = [end for part, width in zip(parts, self._widths, strict=False) for end in cycle.ends(part, width)]
        settings = [] if cycle.settings is None else [cycle.settings]
        inputs = [ca.vertcat(cycle.poses[:, :-1], cycle.poses[:, 1:]), *ends, *settings, *more, cycle.parameters]
        return over(function, cycle.steps, [function.n_in() - 1], *inputs)


@lru_cache(maxsize=16)
def baseline_blocks(structure: Structure, portable: bool = False) -> JointBlocks:
    """The blocks of a body in the plain medium."""
    functions = step_functions(structure, _baseline(), element_parameters(structure), ca.DM(0, structure.elements))
    return JointBlocks(structure, functions if portable else compiled(functions), 3)


def _baseline() -> ElementShare:
    """Half the squared displacement in the element's own metric; the residual is dE/d (second pose)."""
    frame, before, after = ca.SX.sym("frame", FRAME), ca.SX.sym("before", 3), ca.SX.sym("after", 3)
    weight, eps = ca.SX.sym("weight"), ca.SX.sym("eps")
    begin, end = energy.move(frame[:3], with_directions(before)), energy.move(frame[3:], with_directions(after))
    value = energy.element_energy(begin, end, weight, eps)
    return ElementShare(frame, before, after, (weight, eps), (False, True), ca.gradient(value, frame[3:]), value)


def with_directions(w: ca.SX) -> ca.SX:
    """(x, y) above unit vectors of the directions."""
    return ca.vertcat(w[:2], *(part for i in range(2, w.numel()) for part in (ca.cos(w[i]), ca.sin(w[i]))))


def directions(structure: Structure, links: bool) -> tuple[Floats, list[Floats]]:
    """Constant matrices: edge directions psi (n, m) by joint angles; tangent (and link) directions (M, n) by psi."""
    n, group = structure.vertices - 1, np.zeros(structure.vertices - 1)
    for i, edges in enumerate(structure.links):
        group[list(edges)] = i
    psi = (group[:, None] > np.arange(len(structure.joints))[None]).astype(float)
    psi -= psi.mean(0)
    if structure.dissipation == "edge":
        return psi, [np.eye(n)] * (1 + links)
    ahead, behind = np.vstack([np.eye(n), np.eye(n)[-1:]]), np.vstack([np.eye(n)[:1], np.eye(n)])
    return psi, [(ahead + behind) / 2, *([behind] if links else [])]


def placement(structure: Structure, parameters: ca.MX) -> ca.MX:
    """B (M, n): element positions in the body frame are B times the unit edges."""
    edges, weights, _ = split_parameters(parameters, structure)
    n = structure.vertices - 1
    reach = ca.DM(np.tril(np.ones((n + 1, n)), -1))  # vertex k lies behind edges 0 .. k - 1
    vertices = (reach - ca.repmat(weights.T @ reach, n + 1, 1)) * ca.repmat(edges.T, n + 1, 1)
    return (vertices[1:, :] + vertices[:-1, :]) / 2 if structure.dissipation == "edge" else vertices


def step_functions(structure: Structure, law: ElementShare, medium: ca.Function, numbers: ca.DM) -> list[ca.Function]:
    """places, row, value, gradient, jacobian, hessian; see the module's head.

    medium: parameters -> the element's own numbers (M) and shared ones; numbers (q, M): constants of each element.
    """
    place = law.before.numel()
    return [*_rows(structure, place), *_Step(structure, law, medium, numbers).functions()]


def _rows(structure: Structure, place: int) -> list[ca.Function]:
    """(angles (m), parameters) -> w (l, M); and with it dw/d angles (l M, m), (cos psi, sin psi) (2, n)."""
    angles = ca.MX.sym("angles", len(structure.joints))
    parameters = ca.MX.sym("parameters", 2 * structure.vertices)
    to_psi, others = directions(structure, links=place == 4)
    psi, b = ca.DM(to_psi) @ angles, placement(structure, parameters)
    c, s, m = ca.cos(psi), ca.sin(psi), len(structure.joints)
    w = ca.horzcat(b @ c, b @ s, *(ca.DM(matrix) @ psi for matrix in others)).T
    slopes = [b @ (ca.repmat(-s, 1, m) * ca.DM(to_psi)), b @ (ca.repmat(c, 1, m) * ca.DM(to_psi))]
    slopes += [ca.MX(ca.DM(matrix @ to_psi)) for matrix in others]
    order = [i * structure.elements + k for k in range(structure.elements) for i in range(place)]
    outputs = [w, ca.densify(ca.vertcat(*slopes))[order, :], ca.horzcat(c, s).T]
    inputs = [angles, parameters]
    return [ca.Function("joint_places", inputs, [w]), ca.Function("joint_row", inputs, outputs)]


class _Step:
    """Symbols of one step, and its functions."""

    def __init__(self, structure: Structure, law: ElementShare, medium: ca.Function, numbers: ca.DM) -> None:
        self.structure, self.law = structure, law
        m, joints, n, size = structure.elements, len(structure.joints), structure.vertices - 1, law.before.numel()
        self.frame = ca.MX.sym("frame", FRAME)
        self.w = [ca.MX.sym(f"w{i}", size, m) for i in (0, 1)]
        self.slopes = [ca.MX.sym(f"d{i}", size * m, joints) for i in (0, 1)]
        self.units = [ca.MX.sym(f"u{i}", 2, n) for i in (0, 1)]
        self.parameters = ca.MX.sym("parameters", 2 * structure.vertices)
        own, *shared = medium(self.parameters) if medium.n_out() > 1 else (medium(self.parameters),)
        constants = [ca.MX(numbers)] if numbers.size1() else []
        self.settings = [ca.MX.sym("setting", s.numel()) for s in law.more[1 + len(shared) + len(constants) :]]
        self.more = [own.T, *shared, *constants, *self.settings]
        ends = [x for pair in (self.w, self.slopes, self.units) for x in pair]
        self.inputs = [self.frame, *ends, *self.settings]
        self.plain = [self.frame, *self.w, *self.settings]  # what values need

    def functions(self) -> list[ca.Function]:
        """value, gradient, jacobian, hessian."""
        parameters, law = self.parameters, self.law
        z = [law.frame, law.before, law.after]
        multipliers, factor = ca.SX.sym("multipliers", law.value.numel()), ca.SX.sym("factor")
        slopes = [ca.densify(ca.jacobian(law.value, part)) for part in z]
        falls = [ca.densify(ca.jacobian(law.energy, part)) for part in z]
        value, energies = self._sum("value", [], [law.value, law.energy], [0, 1])
        jacobian = self._chain(*self._sum("jacobian", [], slopes, [0]))
        gradient = self._chain(*self._sum("gradient", [], falls, [0]))
        lagrangian = ca.dot(multipliers, law.value) + factor * law.energy
        by = [multipliers, factor]
        symbols = [ca.MX.sym("multipliers", law.value.numel()), ca.MX.sym("factor")]
        first = [ca.densify(ca.gradient(lagrangian, part)) for part in z]
        pairs = [(i, j) for i in range(3) for j in range(i, 3)]
        second = [ca.densify(ca.jacobian(first[i], z[j])) for i, j in pairs]
        found = self._sum("hessian", by, [*first, *second], [0, 3], symbols)
        slope, curvature = self._second(found[:3], dict(zip(pairs, found[3:], strict=True)))
        return [
            ca.Function("joint_value", [*self.plain, parameters], [value, energies]),
            ca.Function("joint_gradient", [*self.inputs, parameters], [gradient]),
            ca.Function("joint_jacobian", [*self.inputs, parameters], [jacobian]),
            ca.Function("joint_hessian", [*self.inputs, *symbols, parameters], [slope, curvature]),
        ]

    def _sum(
        self, name: str, by: list[ca.SX], outputs: list[ca.SX], summed: list[int], values: list[ca.MX] | None = None
    ) -> tuple[ca.MX, ...]:
        """The element's outputs over all elements: `summed` ones added up, the others side by side."""
        law, m = self.law, self.structure.elements
        inputs = [law.frame, law.before, law.after, *by, *law.more]
        function = ca.Function(f"joint_element_{name}", inputs, outputs, CSE)
        first = 3 + len(by)
        shared = [0, *range(3, first), *(first + i for i, same in enumerate(law.shared) if same)]
        mapped = function.map(f"all_{name}", "serial", m, shared, summed)
        return tuple(mapped(self.frame, *self.w, *(values or []), *self.more))

    def _chain(self, by_frame: ca.MX, by_before: ca.MX, by_after: ca.MX) -> ca.MX:
        return ca.horzcat(by_frame, by_before @ self.slopes[0], by_after @ self.slopes[1])

    def _second(self, first: tuple[ca.MX, ...], second: dict[tuple[int, int], ca.MX]) -> tuple[ca.MX, ca.MX]:
        """Gradient and Hessian by (frame, angles before, angles after) from those by (frame, w, w after)."""
        size = self.law.before.numel()
        blocks = ca.diagcat(*[ca.DM.ones(size, size)] * self.structure.elements).sparsity()

        def inside(i: int, j: int) -> ca.MX:
            """Block-diagonal (l M, l M) times the slopes of row j, from side by side blocks (l, l M)."""
            return self.slopes[i].T @ (ca.MX(blocks, ca.vec(second[i + 1, j + 1])) @ self.slopes[j])

        cross = [second[0, 1] @ self.slopes[0], second[0, 2] @ self.slopes[1]]
        corner = inside(0, 1)
        own = [inside(i, i) + self._bend(i, first[i + 1]) for i in (0, 1)]
        rows = [
            ca.horzcat(second[0, 0], *cross),
            ca.horzcat(cross[0].T, own[0], corner),
            ca.horzcat(cross[1].T, corner.T, own[1]),
        ]
        slope = ca.vertcat(first[0], *(self.slopes[i].T @ ca.vec(first[i + 1]) for i in (0, 1)))
        return ca.densify(slope), ca.densify(ca.vertcat(*rows))

    def _bend(self, i: int, force: ca.MX) -> ca.MX:
        """What the positions' second derivatives by the angles add: diagonal in the edge directions."""
        b, unit = placement(self.structure, self.parameters), self.units[i]
        along = -(ca.sum1((force[:2, :] @ b) * unit)).T
        to_psi, joints = ca.DM(directions(self.structure, False)[0]), len(self.structure.joints)
        return to_psi.T @ (ca.repmat(along, 1, joints) * to_psi)
