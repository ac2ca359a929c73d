"""The step over joint angles: any shape, with or without effects of the medium.

    angles --row--> places w = (x, y, direction of its tangent[, of its link]) of the elements, twists of the joints
    poses, w_t, w_{t+1} --element--> one summand of values and energy with first and second derivatives, in a C loop
    sums of what turns with each joint --twists--> derivatives by both poses and all angles

A step costs its elements and its pairs of joints, no products of the two. Legend: N vertices, n = N - 1 edges,
M elements, m joints, l numbers per place (3 or 4), v values per step, o = 6 + 2 m.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from serpenoid.mechanics import energy
from serpenoid.mechanics.functions import CSE, element_parameters
from serpenoid.mechanics.wide import Columns, over_columns
from serpenoid.model import Structure
from serpenoid.optimise.step import joint_twists, plain_element
from serpenoid.optimise.step.blocks import Cycle
from serpenoid.optimise.step.joint_rows import row_function
from serpenoid.optimise.step.joint_twists import Joints, Symbols, packed

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

    def lagrangian(self, multipliers: ca.SX, factor: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Gradient and Hessian of multipliers . value + factor energy by (frame, w, w after)."""
        z = ca.vertcat(self.frame, self.before, self.after)
        hessian, gradient = ca.hessian(ca.dot(multipliers, self.value) + factor * self.energy, z)
        return gradient, hessian


class PlainShare(ElementShare):
    """The plain medium's, whose second derivatives are written out."""

    def lagrangian(self, multipliers: ca.SX, factor: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Gradient and Hessian of multipliers . value + factor energy by (frame, w, w after)."""
        z, (weight, eps) = ca.vertcat(self.frame, self.before, self.after), self.more
        pose = self.frame[:3]
        before = ca.vertcat(energy.placed(pose, self.before[:2]), pose[2] + self.before[2])
        inner = plain_element.motion(self.frame[3:], before, self.after, multipliers)
        return plain_element.chained(z, inner, *plain_element.lagrangian(inner, weight, eps, multipliers[2], factor))


class JointBlocks:
    """Functions of one step over joint angles."""

    def __init__(self, functions: list[Columns], values: int) -> None:
        self.values = values
        self._value, self._gradient, self._jacobian, self._hessian = functions

    def value(self, cycle: Cycle) -> tuple[ca.MX, ca.MX]:
        """Values (v, T) and energies (1, T)."""
        value, energies = self._over(self._value, cycle)
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

    def _over(self, function: Columns, cycle: Cycle, *more: ca.MX) -> ca.MX:
        settings = [] if cycle.settings is None else [cycle.settings]
        return cycle.over(function, *settings, *more)


@lru_cache(maxsize=16)
def baseline_blocks(structure: Structure, portable: bool = False) -> JointBlocks:
    """The blocks of a body in the plain medium."""
    functions = step_functions(structure, _baseline(), element_parameters(structure), ca.DM(0, structure.elements))
    return JointBlocks(over_columns(functions, portable=portable), 3)


def _baseline() -> ElementShare:
    """Half the squared displacement in the element's own metric; the residual is dE/d (second pose)."""
    frame, before, after = ca.SX.sym("frame", FRAME), ca.SX.sym("before", 3), ca.SX.sym("after", 3)
    weight, eps = ca.SX.sym("weight"), ca.SX.sym("eps")
    begin, end = energy.move(frame[:3], with_directions(before)), energy.move(frame[3:], with_directions(after))
    value = energy.element_energy(begin, end, weight, eps)
    return PlainShare(frame, before, after, (weight, eps), (False, True), ca.gradient(value, frame[3:]), value)


def with_directions(w: ca.SX) -> ca.SX:
    """(x, y) above unit vectors of the directions."""
    return ca.vertcat(w[:2], *(part for i in range(2, w.numel()) for part in (ca.cos(w[i]), ca.sin(w[i]))))


def step_functions(structure: Structure, law: ElementShare, medium: ca.Function, numbers: ca.DM) -> list[ca.Function]:
    """value, gradient, jacobian, hessian from (pose, pose after, angles, angles after, .., parameters).

    medium: parameters -> the element's own numbers (M) and shared ones; numbers (q, M): constants of each element.
    """
    return _Step(structure, law, medium, numbers).functions()


class _Step:
    """Symbols of one step, and its functions."""

    def __init__(self, structure: Structure, law: ElementShare, medium: ca.Function, numbers: ca.DM) -> None:
        self.structure, self.law, self.joints = structure, law, Joints(structure)
        poses = [ca.MX.sym(f"g{i}", 3) for i in (0, 1)]
        angles = [ca.MX.sym(f"a{i}", len(structure.joints)) for i in (0, 1)]
        self.frame, self.parameters = ca.vertcat(*poses), ca.MX.sym("parameters", 2 * structure.vertices)
        row = row_function(structure, law.before.numel())
        self.w, self.twists = zip(*(row(a, self.parameters) for a in angles), strict=True)
        own, *shared = medium(self.parameters) if medium.n_out() > 1 else (medium(self.parameters),)
        constants = [ca.MX(numbers)] if numbers.size1() else []
        self.settings = [ca.MX.sym("setting", s.numel()) for s in law.more[1 + len(shared) + len(constants) :]]
        self.more = [own.T, *shared, *constants, *self.settings]
        self.inputs = [*poses, *angles, *self.settings]

    def functions(self) -> list[ca.Function]:
        """value, gradient, jacobian, hessian."""
        parameters, law = self.parameters, self.law
        value, energies = self._over("value", [], [law.value, law.energy], [0, 1])
        multipliers, factor = ca.MX.sym("multipliers", law.value.numel()), ca.MX.sym("factor")
        return [
            ca.Function("joint_value", [*self.inputs, parameters], [value, energies]),
            ca.Function("joint_gradient", [*self.inputs, parameters], [self._first("gradient", law.energy)]),
            ca.Function("joint_jacobian", [*self.inputs, parameters], [self._first("jacobian", law.value)]),
            ca.Function(
                "joint_hessian",
                [*self.inputs, multipliers, factor, parameters],
                list(self._second(multipliers, factor)),
            ),
        ]

    def _over(
        self, name: str, by: list[ca.SX], outputs: list[ca.SX], summed: list[int], values: list[ca.MX] | None = None
    ) -> tuple[ca.MX, ...]:
        """The element's outputs over all elements: `summed` ones added up, the others side by side."""
        law, m = self.law, self.structure.elements
        inputs = [law.frame, law.before, law.after, *by, *law.more]
        function = ca.Function(f"joint_element_{name}", inputs, [ca.densify(x) for x in outputs], CSE)
        first = 3 + len(by)
        shared = [0, *range(3, first), *(first + i for i, same in enumerate(law.shared) if same)]
        mapped = function.map(f"all_{name}", "serial", m, shared, summed)
        return tuple(mapped(self.frame, *self.w, *(values or []), *self.more))

    def _read(self, by: ca.Function, sums: ca.MX, at: ca.MX, twists: ca.MX) -> tuple[ca.MX, ...]:
        """`by` at every joint: of what turns with it, what lies at it, and its twists."""
        beyond, whole = self.joints.beyond(sums)
        count = len(self.structure.joints)
        mapped = by.map(f"all_{by.name()}", "serial", count, [4], [])
        found = mapped(beyond, self.joints.at(at), twists, self.joints.shares, whole)
        return found if isinstance(found, tuple) else (found,)

    def _first(self, name: str, of: ca.SX) -> ca.MX:
        """Derivatives (v, o) of values (v)."""
        law = self.law
        ends = [joint_twists.first_parts(ca.jacobian(of, w), w) for w in (law.before, law.after)]
        outputs = [ca.jacobian(of, law.frame), *(packed(parts) for end in ends for parts in end)]
        by_frame, *carried = self._over(name, [], outputs, [0])
        reads = joint_twists.reads_first(*ends[0], self.structure)
        pairs = zip(carried[::2], carried[1::2], self.twists, strict=True)
        return ca.horzcat(by_frame, *(self._read(reads, *pair)[0] for pair in pairs))

    def _second(self, multipliers: ca.MX, factor: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Gradient (o) and Hessian (o, o) of multipliers . value + factor energy."""
        law, by = self.law, [ca.SX.sym("multipliers", multipliers.numel()), ca.SX.sym("factor")]
        own, sums, at = self._lagrangian(*law.lagrangian(*by))
        outputs = [*own, packed(sums), packed(at)]
        slope, square, *carried = self._over("hessian", by, outputs, [0, 1], [multipliers, factor])
        reads = joint_twists.reads_second(sums, at, self.structure)
        carried_sums, carried_at = carried
        parts = self._read(reads, carried_sums, carried_at, ca.vertcat(*self.twists))
        slopes, curvature = joint_twists.second(parts, square, len(self.structure.joints))
        return ca.vertcat(slope, slopes), curvature

    def _lagrangian(self, gradient: ca.SX, hessian: ca.SX) -> tuple[list[ca.SX], Symbols, Symbols]:
        """An element's gradient and Hessian by the frame; what it adds beyond joints; what is asked of it at one."""
        w, size = (self.law.before, self.law.after), self.law.before.numel()
        ends = [0, FRAME, FRAME + size, FRAME + 2 * size]
        frame, *forces = ca.vertsplit(gradient, ends)
        by_frame, *rows = (ca.horzsplit(row, ends) for row in ca.vertsplit(hessian, ends))
        blocks = {(i, j): rows[i][1 + j] for i, j in joint_twists.ENDS}
        sums, at = joint_twists.second_parts(w, forces, by_frame[1:], blocks)
        return [frame, by_frame[0]], sums, at
