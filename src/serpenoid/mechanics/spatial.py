"""One element's share in a step of a lifted body, by relative pose and both elements, with exact derivatives.

    E = 1/2 w <D dp, dp>,   w = (share + share after) / 2       what it dissipates (`energy.element_energy`)
    S = SUPPORT / 2 W (z - height after)^2                      the floor carries it: it neither sinks in nor falls over

A step's relative pose is where E + S of all elements is stationary; W is the element's part of the weight at rest, z
its height over the floor of the row before. S is no loss. Whether gravity would let the body stand like that is
another question (`LiftedTrajectory.standing`).

The relative pose h (6) is written like any pose in space (`objectives.frames`): a flat step has the equations of the
plane. An element (7): position, unit tangent, share of the weight. Nothing here knows the body: one library serves all.
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from serpenoid.mechanics import energy
from serpenoid.mechanics.chain_rule import packed, upper
from serpenoid.mechanics.functions import CSE
from serpenoid.mechanics.lifted import ELEMENT
from serpenoid.objectives import frames

SUPPORT = 100.0  # times the drag of a step of a body length: what stands tilts by thousandths of a radian
POSE = 6


@lru_cache(maxsize=4)
def element_functions(coordinates: int) -> list[ca.Function]:
    """step, value, gradient, jacobian, hessian of one element over s coordinates of each row.

    Inputs of all: h (6), element before, element after, weight W, eps. `step` -> dE+S/dh (6), E, its slope (6, 6).
    The others take elements with their derivatives by the coordinates in a column: (7), (7 + 7 s) and
    (7 + 7 s + 7 s (s + 1) / 2) numbers, column by column; z = (h, coordinates before, after).
    value -> dE+S/dh, E;  gradient -> dE/dz (1, 6 + 2 s);  jacobian -> d (dE+S/dh) / dz;
    hessian, with multipliers (6) and factor before W -> gradient and packed Hessian by z of their Lagrangian.
    """
    h, weight, eps = ca.SX.sym("h", POSE), ca.SX.sym("weight"), ca.SX.sym("eps")
    before, after = ca.SX.sym("before", ELEMENT), ca.SX.sym("after", ELEMENT)
    inner = ca.vertcat(h, before, after)
    value, support = _energies(h, before, after, weight, eps)
    slope, numbers = ca.gradient(value + support, h), [weight, eps]
    multipliers, factor = ca.SX.sym("multipliers", POSE), ca.SX.sym("factor")
    curvature, force = ca.hessian(ca.dot(multipliers, slope) + factor * value, inner)

    def of_rows(order: int) -> tuple[list[ca.SX], ca.SX]:
        """Elements with derivatives, and the derivative of `inner` by z."""
        sizes = ELEMENT * coordinates, ELEMENT * coordinates * (coordinates + 1) // 2
        more = [[ca.SX.sym("d", n) for n in sizes[:order]] for _ in (0, 1)]
        columns = [ca.reshape(d[0], ELEMENT, coordinates) for d in more]
        rows = [ca.vertcat(x, *d) for x, d in zip((before, after), more, strict=True)]
        return [h, *rows], ca.diagcat(ca.SX.eye(POSE), *columns)

    (first, by_z), (second, to_z) = of_rows(1), of_rows(2)
    return [
        ca.Function("spatial_step", [h, before, after, *numbers],
                    [slope, value, ca.densify(ca.jacobian(slope, h))], CSE),
        ca.Function("spatial_value", [h, before, after, *numbers], [slope, value], CSE),
        ca.Function("spatial_gradient", [*first, *numbers], [ca.densify(ca.jacobian(value, inner) @ by_z)], CSE),
        ca.Function("spatial_jacobian", [*first, *numbers], [ca.densify(ca.jacobian(slope, inner) @ by_z)], CSE),
        ca.Function("spatial_hessian", [*second, multipliers, factor, *numbers],
                    _chained(second, to_z, force, curvature, coordinates), CSE),
    ]  # fmt: skip


def _energies(h: ca.SX, before: ca.SX, after: ca.SX, weight: ca.SX, eps: ca.SX) -> tuple[ca.SX, ca.SX]:
    """E and S."""
    moved = ca.vertcat(frames.placed(h, after[:3]), frames.rotation(h) @ after[3:6])
    value = energy.element_energy(before[:6], moved, (before[6] + after[6]) / 2, eps)
    return value, SUPPORT / 2 * weight * (moved[2] - after[2]) ** 2


def _chained(inputs: list[ca.SX], to_z: ca.SX, gradient: ca.SX, hessian: ca.SX, coordinates: int) -> list[ca.SX]:
    """Gradient and packed Hessian by z from those by (h, element before, element after)."""
    total = to_z.T @ hessian @ to_z
    for end, row in enumerate(inputs[1:]):
        bends = ca.reshape(row[ELEMENT * (1 + coordinates) :], ELEMENT, -1)
        force = gradient[POSE + ELEMENT * end : POSE + ELEMENT * (end + 1)]
        begin = POSE + coordinates * end
        for (i, j), value in zip(upper(coordinates), ca.vertsplit(bends.T @ force), strict=True):
            total[begin + i, begin + j] += value
    return [ca.densify(to_z.T @ gradient), ca.densify(packed(total))]
