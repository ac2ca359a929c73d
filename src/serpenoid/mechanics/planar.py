"""The planar step reduced to one scalar equation for the turn phi.

With R = cos(phi) I + sin(phi) J the distance of an element is d = R q + b - p, and R^t d in its later frame; so, summed
over all elements,

    E = 1/4 (d^t D d + (R^t d)^t D' R^t d) = e + l . b + b^t H b / 2

with e, l, H trigonometric polynomials of degree two in phi. Their eighteen coefficients, the step's moments, hold all
vertices: N enters once per step, not once per iteration. The translation b(phi) = -H^-1 l is eliminated exactly,
dE/dphi = 0 is left, and Newton's method has its slope in closed form:

    dE/dphi = e' + l' . b + b^t H' b / 2        d2E/dphi2 = e'' + l'' . b + b^t H'' b / 2 - k^t H^-1 k,  k = l' + H' b

`root` wants a minimum. Source: derived from Even et al., Eqs. 3-7; docs/theory.md.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

MOMENTS = 18
NEWTON = 4  # iterations from "no turn": all 8600 steps of random gaits of four problems are exact after four


def element_moments() -> ca.Function:
    """(before (4), after (4), weight, anisotropy ratio) -> one element's share of the moments."""
    before, after = ca.SX.sym("before", 4), ca.SX.sym("after", 4)
    weight, eps = ca.SX.sym("weight"), ca.SX.sym("eps")
    p, q, less = before[:2], after[:2], weight * (1 - eps)
    first = _squares(q, 1, -p, before[2:], weight, less)
    second = _squares(-p, -1, q, after[2:], weight, less)
    share = _harmonics(first, second)
    return ca.Function("element_moments", [before, after, weight, eps], [share], {"cse": True})


def moments(before: ca.MX, after: ca.MX, weights: ca.MX, anisotropy_ratio: ca.MX) -> ca.MX:
    """The numbers that determine the step energy, from two sets of elements (4, M): a loop over the elements."""
    count = before.size2()
    total = element_moments().map("all_moments", "serial", count, [3], [0])
    return total(before, after, weights.T, anisotropy_ratio)


def _squares(x: ca.SX, sign: int, c: ca.SX, tangent: ca.SX, weight: ca.SX, less: ca.SX) -> ca.SX:
    """M^t D M (5, 5) of one element with M = [x, y, I, c], y = +-J x, D = w I - less t t^t."""
    y, square = sign * ca.vertcat(-x[1], x[0]), ca.sumsqr(x)
    t = ca.vertcat(ca.dot(x, tangent), ca.dot(y, tangent), tangent, ca.dot(c, tangent))
    plain, scaled = ca.SX.zeros(5, 5), less * t
    plain[0, 0] = plain[1, 1] = square
    plain[2:4, 0], plain[2:4, 1], plain[2:4, 4] = x, y, c
    plain[0, 4], plain[1, 4], plain[4, 4] = ca.dot(x, c), ca.dot(y, c), ca.sumsqr(c)
    plain[2, 2] = plain[3, 3] = 1
    return weight * plain - scaled @ t.T


def _harmonics(a: ca.SX, b: ca.SX) -> ca.SX:
    """e (5), l (constant, cos, sin of both; the second harmonic's two), H (5) from the squares; see `_at`."""
    p, v, w = a[:2, :2] + b[:2, :2], b[2:4, 4], b[2:4, :2]
    e = ca.vertcat(
        (a[4, 4] + b[4, 4]) / 4 + (p[0, 0] + p[1, 1]) / 8,
        (a[0, 4] + b[0, 4]) / 2,
        (a[1, 4] + b[1, 4]) / 2,
        (p[0, 0] - p[1, 1]) / 8,
        p[0, 1] / 4,
    )
    first = ca.vertcat(a[2, 4] + (w[0, 0] - w[1, 1]) / 2, a[2, 0] + v[0], a[2, 1] - v[1]) / 2
    second = ca.vertcat(a[3, 4] + (w[1, 0] + w[0, 1]) / 2, a[3, 0] + v[1], a[3, 1] + v[0]) / 2
    twice = ca.vertcat(w[0, 0] + w[1, 1], w[0, 1] - w[1, 0]) / 4
    mean = (b[2, 2] + b[3, 3]) / 2
    h = ca.vertcat(a[2, 2] + mean, a[3, 3] + mean, a[2, 3], (b[2, 2] - b[3, 3]) / 2, b[2, 3]) / 2
    return ca.vertcat(e, first, second, twice, h)


@dataclass(frozen=True)
class _At:
    """E, its slope and curvature by phi with b eliminated, and b."""

    translation: ca.SX
    energy: ca.SX
    slope: ca.SX
    curvature: ca.SX


def _at(phi: ca.SX, k: ca.SX) -> _At:
    """At turn phi, from the moments k: the polynomials e, l, H, their derivatives, b."""
    c, s = ca.cos(phi), ca.sin(phi)
    c2, s2 = c * c - s * s, 2 * c * s
    e, l0, l1, (kappa, lam), h = k[:5], k[5:8], k[8:11], ca.vertsplit(k[11:13]), k[13:]
    one, two = e[1] * c + e[2] * s, e[3] * c2 + e[4] * s2  # harmonics of e
    g0, g1 = l0[1] * c + l0[2] * s, l1[1] * c + l1[2] * s  # of l: first, then second
    u, v = kappa * c2 + lam * s2, kappa * s2 - lam * c2
    x, y = h[3] * c2 - h[4] * s2, h[3] * s2 + h[4] * c2  # of H = [[h0 + x, h2 + y], [h2 + y, h1 - x]]
    linear = ca.vertcat(l0[0] + g0 + u, l1[0] + g1 + v)
    rise = ca.vertcat(l0[2] * c - l0[1] * s - 2 * v, l1[2] * c - l1[1] * s + 2 * u)
    h00, h11, h01 = h[0] + x, h[1] - x, h[2] + y
    over = 1 / (h00 * h11 - h01 * h01)
    b = ca.vertcat(h01 * linear[1] - h11 * linear[0], h01 * linear[0] - h00 * linear[1]) * over
    across, along = b[0] * b[1], (b[1] * b[1] - b[0] * b[0]) / 2
    slope = e[2] * c - e[1] * s + 2 * (e[4] * c2 - e[3] * s2) + ca.dot(rise, b) + 2 * (y * along + x * across)
    k0, k1 = rise[0] + 2 * (x * b[1] - y * b[0]), rise[1] + 2 * (x * b[0] + y * b[1])
    relaxed = (h11 * k0 * k0 - 2 * h01 * k0 * k1 + h00 * k1 * k1) * over
    bent = -(one + 4 * two) - (g0 + 4 * u) * b[0] - (g1 + 4 * v) * b[1] + 4 * (x * along - y * across)
    return _At(b, e[0] + one + two + ca.dot(linear, b) / 2, slope, bent - relaxed)


@lru_cache(maxsize=1)
def step_at() -> ca.Function:
    """(phi, moments) -> translation (2), dE/dphi, its slope, energy; the translation is eliminated."""
    phi, k = ca.SX.sym("phi"), ca.SX.sym("moments", MOMENTS)
    at = _at(phi, k)
    return ca.Function("step_at", [phi, k], [at.translation, at.slope, at.curvature, at.energy], {"cse": True})


def root() -> ca.Function:
    """(guess, moments) -> pose (3), dE/dphi, its slope, energy: Newton's iterations from a guess.

    A failure shows in dE/dphi, which is always checked.
    """
    guess, k = ca.SX.sym("guess"), ca.SX.sym("moments", MOMENTS)
    phi = guess
    for _ in range(NEWTON):
        at = _at(phi, k)
        phi = phi - at.slope / at.curvature
    at = _at(phi, k)
    outputs = [ca.vertcat(at.translation, phi), at.slope, at.curvature, at.energy]
    return ca.Function("root", [guess, k], outputs, {"cse": True})
