"""Closed formulas of resistive force theory for long bodies. K = 1 / eps: normal over tangential drag.

U: speed of the body, V: speed of the wave along the body's axis, beta = <cos^2 psi>: mean over arc length, psi: angle
of the body to the axis, c = V / <cos psi>: speed of the wave along the arc. Sources: Gray & Hancock 1955;
Lighthill 1976.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import quad

from oracle.chain import Floats


def wave_speed_ratio(eps: float, beta: float) -> float:
    """U / V of an infinite travelling wave of any form: (K - 1)(1 - beta) / (K - (K - 1) beta)."""
    k = 1.0 / eps
    return (k - 1) * (1 - beta) / (k - (k - 1) * beta)


def serpenoid_mean_cosine(amplitude: float, power: int = 1) -> float:
    """<cos^power psi> for psi(s) = amplitude * sin(2 pi s), over one wave."""
    return float(quad(lambda s: np.cos(amplitude * np.sin(2 * np.pi * s)) ** power, 0, 1, epsabs=1e-13)[0])


def serpenoid_displacement(eps: float, amplitude: float, waves: float) -> float:
    """Body lengths per cycle of a long body with many waves: the wave moves <cos psi> / waves along the axis."""
    ratio = wave_speed_ratio(eps, serpenoid_mean_cosine(amplitude, 2))
    return ratio * serpenoid_mean_cosine(amplitude) / waves


def sawtooth_angle(eps: float) -> float:
    """Lighthill's optimal sawtooth: tan(theta*) = eps^(1/4)."""
    return float(np.arctan(eps**0.25))


def sawtooth_efficiency(eps: float) -> float:
    """Efficiency of that sawtooth: (1 - sqrt(eps))^2."""
    return float((1 - np.sqrt(eps)) ** 2)


def wave_efficiency(eps: float, beta: float, mean_cosine: float) -> float:
    """eps U^2 / mean power, unit weight per length, of an infinite wave with <cos^2 psi> = beta.

    In the body's frame material slides along the wave with speed c = V / <cos psi>; its velocity over ground has
    the tangential part c - (V - U) cos psi and the normal part (V - U) sin psi.
    """
    u = wave_speed_ratio(eps, beta)  # V = 1
    c, w = 1.0 / mean_cosine, 1.0 - u
    power = eps * (c**2 - 2 * c * w * mean_cosine + w**2 * beta) + w**2 * (1 - beta)
    return eps * u**2 / power


def tangent_angles(vertices: Floats) -> tuple[float, float]:
    """Of a motion's vertices (T + 1, N, 2): angle of the edges to the way [rad], median, and its rms over its mean.

    Of the middle half of the body, without its ends. 1 for a sawtooth, pi / sqrt(8) = 1.111 where the angle is a sine.
    """
    way = np.subtract(*vertices[[-1, 0]].mean(axis=1))
    way = way / np.hypot(*way)
    edges, quarter = np.diff(vertices, axis=1), (vertices.shape[1] - 1) // 4
    across = np.abs(edges @ np.array([-way[1], way[0]]))
    angle = np.arctan2(across, np.abs(edges @ way))[:, quarter:-quarter]
    return float(np.median(angle)), float(np.sqrt((angle**2).mean()) / angle.mean())
