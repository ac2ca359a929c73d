"""A body that is bent and lifted in two waves: its points, what each part carries, and the joints that make it so.

    height = lift.height (1 - contact);  edges keep their lengths: they rise by pitching
    share  = w (air + (1 - air) contact), which all parts together carry

Contacts are those of the wave at the ends of rigid links, and in proportion between them. Legend: N vertices, m joints,
M elements; coordinates (w1, w2, xi, t - phase, bias), see `gaits.lifted`.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from serpenoid.gaits import GaitFamily
from serpenoid.gaits.lifted import Lift, LiftedFamily
from serpenoid.mechanics import kinematics
from serpenoid.model import Structure

ELEMENT = 7  # position, tangent, share of the weight


@dataclass(frozen=True)
class Lifted:
    """points (3, N) in the body frame, over the floor; unit edges (3, N - 1); shares (N); yaw (m), pitch (m) [rad]."""

    points: ca.SX
    unit: ca.SX
    shares: ca.SX
    yaw: ca.SX
    pitch: ca.SX


def lifted_body(coordinates: ca.SX, edges: ca.SX, weights: ca.SX, structure: Structure, lift: Lift) -> Lifted:
    """The body at a row."""
    contact, rise = _contact(coordinates[2:], edges, structure, lift)
    along = ca.sqrt(1 - rise**2)
    yaw = kinematics.serpenoid_joint_angles(coordinates[:3], edges, structure)
    _, flat = kinematics.vertices(yaw, edges, weights, structure)
    of_edge = [i for i, group in enumerate(structure.links) for _ in group]
    unit = ca.vertcat(ca.repmat(along[of_edge].T, 2, 1) * flat, rise[of_edge].T)
    points = [ca.SX.zeros(2, 1)]
    for j in range(structure.vertices - 1):
        points.append(points[-1] + edges[j] * unit[:2, j])
    chain = ca.horzcat(*points)
    resting = weights * (lift.air + (1 - lift.air) * contact)
    pitch = ca.asin(rise)
    above = ca.vertcat(chain - chain @ weights, lift.height * (1 - contact).T)
    return Lifted(above, unit, resting / ca.sum1(resting), yaw, pitch[1:] - pitch[:-1])


def _contact(wave: ca.SX, edges: ca.SX, structure: Structure, lift: Lift) -> tuple[ca.SX, ca.SX]:
    """Contacts of the vertices (N) and how much each link rises along its length (m + 1)."""
    xi, time, bias = ca.vertsplit(wave)
    s = ca.vertcat(0, ca.cumsum(edges))
    ends = [0, *structure.joints, structure.vertices - 1]
    crest = ca.cos(2 * ca.pi * (xi * s[ends] + time)) + bias
    at_ends = 1 / (1 + ca.exp(-lift.sharpness * crest))
    found, rises = [at_ends[0]], []
    for i, (begin, end) in enumerate(zip(ends[:-1], ends[1:], strict=True)):
        slope = (at_ends[i + 1] - at_ends[i]) / (s[end] - s[begin])
        found += [at_ends[i] + slope * (s[k] - s[begin]) for k in range(begin + 1, end)] + [at_ends[i + 1]]
        rises.append(-lift.height * slope)
    return ca.vertcat(*found), ca.vertcat(*rises)


def elements(body: Lifted, edges: ca.SX, structure: Structure) -> ca.SX:
    """Elements (7, M): position, unit tangent, share of the weight."""
    shares = kinematics.element_weights(body.shares, edges, structure)
    return ca.vertcat(kinematics.elements(body.points, body.unit, structure), shares.T)


def commanded_angles(
    family: GaitFamily, p: ca.SX, data: ca.SX, edges: ca.SX, weights: ca.SX, structure: Structure
) -> ca.SX:
    """Joint angles of a row of any family's table: (m), of a lifted body (2 m), yaw and then pitch."""
    if isinstance(family, LiftedFamily):
        body = lifted_body(family.at(p, data), edges, weights, structure, family.lift)
        return ca.vertcat(body.yaw, body.pitch)
    return kinematics.family_joint_angles(family, p, data, edges, structure)
