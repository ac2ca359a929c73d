"""One element's Lagrangian in the plain medium with exact derivatives, written out: half of what differentiation makes.

    L = w (d . v + k (s0 p0 + s1 p1 + r s1 n1)) + f w / 2 (d . d + k (s0^2 + s1^2)),      k = (eps - 1) / 2

of the displacement d, the velocity v = (m0, m1) + r J arm that the residual's multipliers (m0, m1, r) give the element
after the step (arm: its place beside the body frame), and the directions of both tangents t0, t1;
s_i = d . t_i, n_i = d . J t_i, p_i = v . t_i, q_i = v . J t_i. So L is m . dE/d(pose after) + f E with the step energy
E = w / 2 (d . d + k (s0^2 + s1^2)) of `energy.element_energy`.
"""

from __future__ import annotations

import casadi as ca

from serpenoid.effects.element import left


def motion(pose: ca.SX, before: ca.SX, after: ca.SX, multipliers: ca.SX) -> ca.SX:
    """(d, v, both directions) of an element: places (x, y, direction), the second one in the body frame `pose`."""
    c, s = ca.cos(pose[2]), ca.sin(pose[2])
    arm = ca.vertcat(c * after[0] - s * after[1], s * after[0] + c * after[1])
    velocity = multipliers[:2] + multipliers[2] * left(arm)
    return ca.vertcat(pose[:2] + arm - before[:2], velocity, before[2], pose[2] + after[2])


def lagrangian(u: ca.SX, weight: ca.SX, eps: ca.SX, turning: ca.SX, factor: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Gradient (6) and Hessian (6, 6) of L by u = (d, v, both directions); turning: r, factor: f."""
    d, v, wk = u[:2], u[2:4], weight * (eps - 1) / 2
    t = [ca.vertcat(ca.cos(u[i]), ca.sin(u[i])) for i in (4, 5)]
    a = [left(x) for x in t]
    s, n, p, q = ([ca.dot(x, y) for y in ys] for x, ys in ((d, t), (d, a), (v, t), (v, a)))
    metric, turn = weight * ca.SX.eye(2) + wk * (t[0] @ t[0].T + t[1] @ t[1].T), turning * wk
    by_d = metric @ (v + factor * d) + turn * (n[1] * t[1] + s[1] * a[1])
    by_angle = [wk * (n[i] * p[i] + s[i] * (q[i] + factor * n[i])) for i in (0, 1)]
    by_angle[1] += turn * (n[1] ** 2 - s[1] ** 2)
    d_angle = [wk * ((p[i] + factor * s[i]) * a[i] + (q[i] + factor * n[i]) * t[i]) for i in (0, 1)]
    d_angle[1] += 2 * turn * (n[1] * a[1] - s[1] * t[1])
    v_angle = [wk * (s[i] * a[i] + n[i] * t[i]) for i in (0, 1)]
    angle = [wk * (2 * (n[i] * q[i] - s[i] * p[i]) + factor * (n[i] ** 2 - s[i] ** 2)) for i in (0, 1)]
    angle[1] -= 4 * turn * n[1] * s[1]
    own = factor * metric + turn * (t[1] @ a[1].T + a[1] @ t[1].T)
    rows = [
        ca.horzcat(own, metric, *d_angle),
        ca.horzcat(metric, ca.SX(2, 2), *v_angle),
        *(
            ca.horzcat(d_angle[i].T, v_angle[i].T, *(angle[j] if i == j else ca.SX(1, 1) for j in (0, 1)))
            for i in (0, 1)
        ),
    ]
    return ca.vertcat(by_d, metric @ d, *by_angle), ca.vertcat(*rows)


def chained(outer: ca.SX, inner: ca.SX, gradient: ca.SX, hessian: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Gradient and Hessian by `outer` of a function whose gradient and Hessian by `inner` (of `outer`) are known."""
    slope, force = ca.jacobian(inner, outer), ca.SX.sym("force", gradient.numel())
    bend = ca.substitute(ca.hessian(ca.dot(force, inner), outer)[0], force, ca.densify(gradient))
    return slope.T @ gradient, slope.T @ hessian @ slope + bend
