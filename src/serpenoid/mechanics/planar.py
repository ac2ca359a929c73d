"""The planar step reduced to one scalar equation for the turn phi.

With R = cos(phi) I + sin(phi) J every dp_k is linear in z = (cos phi, sin phi, b, 1), so

    E = 1/4 (z^t G z + y^t G' y),   y = (cos phi, sin phi, R^t b, 1),

with two symmetric 5 x 5 moment matrices G, G' that hold all vertices: N enters once per step, not once per iteration.
E is quadratic in the translation b; b(phi) is eliminated exactly and dE/dphi = 0 is left. `root` wants a minimum.
Source: derived from Even et al., Eqs. 3-7; docs/theory.md.
"""

from __future__ import annotations

import casadi as ca

UPPER = [(i, j) for i in range(5) for j in range(i, 5)]
MOMENTS = 2 * len(UPPER)
QUARTER_TURN = ca.DM([[0, -1], [1, 0]])


def element_moments() -> ca.Function:
    """(before (4), after (4), weight, anisotropy ratio) -> one element's share of the 30 moments."""
    before, after = ca.SX.sym("before", 4), ca.SX.sym("after", 4)
    weight, eps = ca.SX.sym("weight"), ca.SX.sym("eps")
    p, q = before[:2], after[:2]
    first = _moment_matrix(q, QUARTER_TURN @ q, -p, before[2:], weight, eps)
    second = _moment_matrix(-p, QUARTER_TURN @ p, q, after[2:], weight, eps)
    share = ca.vertcat(*(matrix[i, j] for matrix in (first, second) for i, j in UPPER))
    return ca.Function("element_moments", [before, after, weight, eps], [share], {"cse": True})


def moments(before: ca.MX, after: ca.MX, weights: ca.MX, anisotropy_ratio: ca.MX) -> ca.MX:
    """The 30 numbers that determine the step energy, from two sets of elements (4, M): a loop over the elements."""
    count = before.size2()
    total = element_moments().map("all_moments", "serial", count, [3], [0])
    return total(before, after, weights.T, anisotropy_ratio)


def energy_from_moments(phi: ca.SX, b: ca.SX, m: ca.SX) -> ca.SX:
    """Step energy at the relative pose (b, phi)."""
    c, s = ca.cos(phi), ca.sin(phi)
    back = ca.vertcat(c * b[0] + s * b[1], c * b[1] - s * b[0])
    z, y = ca.vertcat(c, s, b, 1), ca.vertcat(c, s, back, 1)
    first, second = _symmetric(m[: len(UPPER)]), _symmetric(m[len(UPPER) :])
    return (ca.dot(z, first @ z) + ca.dot(y, second @ y)) / 4


def translation_at(phi: ca.SX, m: ca.SX) -> ca.SX:
    """The translation (2,) that minimises the energy at a given turn."""
    b = ca.SX.sym("b", 2)
    hessian, gradient = ca.hessian(energy_from_moments(phi, b, m), b)
    gx, gy = ca.vertsplit(ca.substitute(gradient, b, ca.SX.zeros(2)))
    hxx, hxy, hyy = hessian[0, 0], hessian[0, 1], hessian[1, 1]
    return ca.vertcat(hxy * gy - hyy * gx, hxy * gx - hxx * gy) / (hxx * hyy - hxy**2)


def turning_moment(phi: ca.SX, m: ca.SX) -> ca.SX:
    """dE/dphi with the translation eliminated: its roots with positive slope are the minima of the energy."""
    b = ca.SX.sym("b", 2)
    slope = ca.gradient(energy_from_moments(phi, b, m), phi)
    return ca.substitute(slope, b, translation_at(phi, m))


def root_finder(tolerance: float = 1e-15) -> ca.Function:
    """CasADi Newton root finder (guess, moments) -> phi; a failure shows in the residual, which is always checked."""
    phi, m = ca.SX.sym("phi"), ca.SX.sym("m", MOMENTS)
    equation = {"x": phi, "p": m, "g": ca.cse(turning_moment(phi, m))}
    options = {"abstol": tolerance, "max_iter": 30, "error_on_fail": False}
    return ca.rootfinder("turn", "fast_newton", equation, options)


def _moment_matrix(x: ca.SX, y: ca.SX, c: ca.SX, tangent: ca.SX, weight: ca.SX, eps: ca.SX) -> ca.SX:
    """M^t D M of one element with M = [x, y, I, c]; only the upper triangle is filled."""
    d = weight * (ca.SX.eye(2) + (eps - 1) * (tangent @ tangent.T))
    columns = [x, y, ca.SX([1, 0]), ca.SX([0, 1]), c]
    images = [d @ x, d @ y, d[:, 0], d[:, 1]]
    images.append(ca.vertcat(ca.dot(images[2], c), ca.dot(images[3], c)))
    matrix = ca.SX.zeros(5, 5)
    for i, j in UPPER:
        matrix[i, j] = ca.dot(images[i], columns[j])
    return matrix


def _symmetric(entries: ca.SX) -> ca.SX:
    matrix = ca.SX.zeros(5, 5)
    for (i, j), value in zip(UPPER, ca.vertsplit(entries), strict=True):
        matrix[i, j] = matrix[j, i] = value
    return matrix
