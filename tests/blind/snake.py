"""Robots, and the kinematics of their shapes, by angles. The ten-servo snake is the usual one.

r_k: vertex k about the weighted centroid, in the frame of the mean edge angle; alpha_j: angle of edge j in that frame;
tau_k: angle of the vertex tangent = mean of the adjacent edge angles; bend_k: from the edge behind to the edge ahead,
zero at head and tail. S: any leading dimensions, N vertices, m = N - 2 joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SPACING = 0.92 / 11
EDGES = np.array([SPACING / 2, *[SPACING] * 9, SPACING / 2])  # tail to head [m]
MASSES = np.array([0.181, *[0.0988] * 10, 0.211])  # kg carried at each vertex, as problems/snake10.toml has it
JOINT_LIMIT = np.deg2rad(60)
SPEED_LIMIT = 57 * 2 * np.pi / 60  # rad/s
TICK = 2 * np.pi / 4096


@dataclass(frozen=True, eq=False)
class Robot:
    """edges (N - 1,) [m], masses (N,) carried at the vertices [kg], the body's own mass, and limits of its servos."""

    edges: Floats
    masses: Floats
    mass_kg: float
    joint_limit: float = JOINT_LIMIT
    speed_limit: float = SPEED_LIMIT

    @property
    def weights(self) -> Floats:
        return self.masses / self.masses.sum()

    @property
    def vertices(self) -> int:
        return len(self.masses)

    @property
    def joints(self) -> int:
        return len(self.masses) - 2

    @property
    def length(self) -> float:
        """Of the stretched body [m]."""
        return float(self.edges.sum())

    @property
    def size(self) -> float:
        """In lengths of the ten-servo snake: what is drawn in metres is drawn for that one."""
        return self.length / float(EDGES.sum())


SNAKE10 = Robot(EDGES, MASSES, 1.38)
WEIGHTS, VERTICES, JOINTS, MASS_KG = SNAKE10.weights, SNAKE10.vertices, SNAKE10.joints, SNAKE10.mass_kg


@dataclass(frozen=True)
class Shape:
    """r, r_rate (S, N, 2) [m, m/s]; tau, bend and their rates (S, N) [rad, rad/s]."""

    r: Floats
    r_rate: Floats
    tau: Floats
    tau_rate: Floats
    bend: Floats
    bend_rate: Floats


def _vertex_mean(edge: Floats) -> Floats:
    return np.concatenate([edge[..., :1], (edge[..., :-1] + edge[..., 1:]) / 2, edge[..., -1:]], axis=-1)


def _at_joints(phi: Floats) -> Floats:
    """(S, N) of joint values (S, m): zero at head and tail."""
    end = np.zeros((*phi.shape[:-1], 1))
    return np.concatenate([end, phi, end], axis=-1)


def _edge_angles(phi: Floats) -> Floats:
    alpha = np.concatenate([np.zeros((*phi.shape[:-1], 1)), np.cumsum(phi, axis=-1)], axis=-1)
    return alpha - alpha.mean(axis=-1, keepdims=True)


def _chain(edge_vectors: Floats, weights: Floats) -> Floats:
    """Vertices about their weighted centroid from edge vectors (S, N - 1, 2)."""
    r = np.concatenate([np.zeros((*edge_vectors.shape[:-2], 1, 2)), np.cumsum(edge_vectors, axis=-2)], axis=-2)
    return r - (weights @ r)[..., None, :]


def shape(phi: Floats, phi_rate: Floats, robot: Robot = SNAKE10) -> Shape:
    """Joint angles and rates (S, m) -> the shape and its rate of change."""
    alpha, alpha_rate = _edge_angles(phi), _edge_angles(phi_rate)
    unit = np.stack([np.cos(alpha), np.sin(alpha)], axis=-1)
    turned = np.stack([-unit[..., 1], unit[..., 0]], axis=-1)
    r = _chain(robot.edges[:, None] * unit, robot.weights)
    r_rate = _chain((robot.edges * alpha_rate)[..., None] * turned, robot.weights)
    return Shape(r, r_rate, _vertex_mean(alpha), _vertex_mean(alpha_rate), _at_joints(phi), _at_joints(phi_rate))


def vertices(phi: Floats, pose: Floats, robot: Robot = SNAKE10) -> Floats:
    """World positions (S, N, 2) from joint angles (S, m) and poses (S, 3)."""
    return to_world(shape(phi, np.zeros_like(phi), robot).r, pose)


def to_world(r: Floats, pose: Floats) -> Floats:
    """Rotate body-frame points (S, N, 2) by the heading and add the position."""
    c, s = np.cos(pose[..., 2:]), np.sin(pose[..., 2:])
    x = c * r[..., 0] - s * r[..., 1] + pose[..., :1]
    y = s * r[..., 0] + c * r[..., 1] + pose[..., 1:2]
    return np.stack([x, y], axis=-1)
