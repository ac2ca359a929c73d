"""From derivatives by the places of elements to derivatives by joint angles: what turns with a joint, summed up.

    twist (t, omega) moves the element at x by t + omega J x and turns it by omega;  J x = (-y, x)
    angle j moves the elements beyond its joint p_j by  xi_j = (-J p_j, 1),  and all of them, back to the centre, by
    -eta_j = -(J tau_j, mu_j): tau_j how far the centroid came, mu_j the share of the edges beyond the joint

A derivative by places is carried to twists once per element (3 numbers a covector, 9 a matrix) and summed from the
head to each joint, whose twists read the sums (composite rigid bodies, Featherstone 2008, ch. 6). With S_j, the sum
over all elements beyond joint j, for i <= j

    H_ij = xi_i^t S_j xi_j - eta_i^t S_j xi_j - xi_i^t S_i eta_j + eta_i^t S_0 eta_j

so that a step costs M + m^2 and not M m^2. The second derivatives of the places, by two turns of one row, are a number
that is added to S_j where both twists turn. An element at a joint (a vertex) turns by half of it and stays.
Legend: M elements, m joints, l numbers per place (3 or 4), v rows of covectors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np

from serpenoid.mechanics.functions import CSE
from serpenoid.model import Structure

Symbols = Mapping[str, ca.SX]
DIRECTION = 2  # of the tangent, among the numbers of a place
ENDS = ((0, 0), (0, 1), (1, 1))  # of a step: rows before and after


def carry(w: ca.SX) -> ca.SX:
    """How the place w (l) moves by a twist, (l, 3)."""
    turning = ca.vertcat(-w[1], w[0], *[1.0] * (w.numel() - 2))
    return ca.horzcat(ca.SX.eye(w.numel())[:, :2], turning)


@dataclass(frozen=True)
class Joints:
    """Where the joints of a structure are among its elements."""

    structure: Structure

    @property
    def at_vertices(self) -> bool:
        """Whether elements lie on joints."""
        return self.structure.dissipation == "vertex"

    def beyond(self, values: ca.MX) -> tuple[ca.MX, ca.MX]:
        """Sums over the elements beyond each joint (k, m), and over all (k,), of values (k, M)."""
        columns = ca.horzsplit(values)
        sums = [columns[-1]]
        for column in reversed(columns[:-1]):
            sums.append(sums[-1] + column)
        first = [joint + self.at_vertices for joint in self.structure.joints]
        return ca.horzcat(*(sums[len(columns) - 1 - k] for k in first)), sums[-1]

    def at(self, values: ca.MX) -> ca.MX:
        """Values (k, M) of the elements at the joints, (k, m); (0, m) where none are."""
        return values[:, list(self.structure.joints)] if self.at_vertices else ca.MX(0, len(self.structure.joints))

    @property
    def shares(self) -> ca.DM:
        """mu (1, m)."""
        edges = self.structure.vertices - 1
        return ca.DM([(edges - joint) / edges for joint in self.structure.joints]).T


def packed(parts: Symbols) -> ca.SX:
    """All parts in one column."""
    return ca.densify(ca.vertcat(*(ca.vec(part) for part in parts.values())))


def unpacked(column: ca.SX, parts: Symbols) -> dict[str, ca.SX]:
    """Parts of these shapes from one column; zeros from an empty one."""
    if not column.numel():
        return {name: ca.SX.zeros(*part.shape) for name, part in parts.items()}
    ends = np.cumsum([0, *(part.numel() for part in parts.values())]).tolist()
    return {
        name: ca.reshape(piece, *part.shape)
        for (name, part), piece in zip(parts.items(), ca.vertsplit(column, ends), strict=True)
    }


def first_parts(by_place: ca.SX, w: ca.SX) -> tuple[dict[str, ca.SX], dict[str, ca.SX]]:
    """What an element with covectors (v, l) adds to sums beyond joints, and what is asked of it at a joint."""
    return {"twist": by_place @ carry(w)}, {"turn": by_place[:, DIRECTION]}


def reads_first(sums: Symbols, at: Symbols, structure: Structure) -> ca.Function:
    """(sums, at the joint, twists (4), mu, sums over all) of one joint -> covectors (v) by its angle."""
    joint = _JointSymbols.of(sums, at, structure, 1)
    xi, eta = joint.twists[0]
    value = joint.sums["twist"] @ xi + joint.at["turn"] / 2 - joint.total["twist"] @ eta
    return ca.Function("joint_reads_first", joint.inputs, [ca.densify(value)], CSE)


def second_parts(
    w: Sequence[ca.SX], forces: Sequence[ca.SX], by_frame: Sequence[ca.SX], blocks: Mapping[tuple[int, int], ca.SX]
) -> tuple[dict[str, ca.SX], dict[str, ca.SX]]:
    """As `first_parts`, for second derivatives of a step with two rows.

    forces: gradients (l) by both places; by_frame: (6, l) by frame and place; blocks: (l, l) by places of two rows.
    """
    x = [carry(place) for place in w]
    sums, at = {}, {}
    for i in (0, 1):
        sums[f"force {i}"] = x[i].T @ forces[i]
        sums[f"along {i}"] = ca.dot(forces[i][:2], w[i][:2])
        sums[f"frame {i}"] = by_frame[i] @ x[i]
        at[f"force {i}"], at[f"frame {i}"] = forces[i][DIRECTION], by_frame[i][:, DIRECTION]
    for i, j in ENDS:
        block = blocks[i, j]
        sums[f"block {i}{j}"] = x[i].T @ block @ x[j]
        at[f"left {i}{j}"], at[f"right {i}{j}"] = x[i].T @ block[:, DIRECTION], x[j].T @ block[DIRECTION, :].T
        at[f"both {i}{j}"] = block[DIRECTION, DIRECTION]
    return sums, at


def reads_second(sums: Symbols, at: Symbols, structure: Structure) -> ca.Function:
    """(sums, at the joint, twists (8), mu, sums over all) of one joint -> what `second` puts together.

    Slopes (2); by the frame (6) twice; for each pair of rows the diagonal's entry, and factors (6) of the entries above
    it (left, right); those below it (left, right) for the pair of different rows.
    """
    joint = _JointSymbols.of(sums, at, structure, 2)
    slopes, cross = [], []
    for i, (xi, eta) in enumerate(joint.twists):
        force, whole = joint.sums[f"force {i}"], joint.total[f"force {i}"]
        slopes.append(ca.dot(force, xi) + joint.at[f"force {i}"] / 2 - ca.dot(whole, eta))
        read = joint.sums[f"frame {i}"] @ xi - joint.total[f"frame {i}"] @ eta
        cross.append(read + joint.at[f"frame {i}"] / 2)
    diagonal, factors = [], []
    for i, j in ENDS:
        entry, above, below = _pair(joint, i, j)
        diagonal.append(entry)
        factors += [*above, *(below if i != j else [])]
    outputs = [ca.vertcat(*slopes), ca.vertcat(*cross), ca.vertcat(*diagonal), *factors]
    return ca.Function("joint_reads_second", joint.inputs, [ca.densify(x) for x in outputs], CSE)


def second(parts: Sequence[ca.MX], by_frame: ca.MX, joints: int) -> tuple[ca.MX, ca.MX]:
    """Slopes (2 m) and Hessian (o, o) by (frame, angles before, angles after); by_frame (6, 6) by the frame alone."""
    slopes, cross, diagonal, *factors = parts
    products = [ca.vec(a.T @ b) for a, b in zip(factors[::2], factors[1::2], strict=True)]
    values = ca.vertcat(ca.vec(by_frame), *(ca.vec(x.T) for x in (cross, diagonal)), *products)
    size = 6 + 2 * joints
    return ca.vec(slopes.T), ca.reshape(values[_places(joints).ravel(order="F").tolist()], size, size)


@dataclass(frozen=True)
class _JointSymbols:
    """A joint's inputs: sums beyond it, elements at it, sums over all, and (xi, eta) of each row."""

    inputs: list[ca.SX]
    sums: dict[str, ca.SX]
    at: dict[str, ca.SX]
    total: dict[str, ca.SX]
    twists: list[tuple[ca.SX, ca.SX]]

    @staticmethod
    def of(sums: Symbols, at: Symbols, structure: Structure, rows: int) -> _JointSymbols:
        size, here = packed(sums).numel(), packed(at).numel() if Joints(structure).at_vertices else 0
        inputs = [ca.SX.sym(*x) for x in (("sums", size), ("at", here), ("twists", 4 * rows), ("mu", 1), ("all", size))]
        mu = inputs[3]
        twists = [(ca.vertcat(p[:2], 1), ca.vertcat(p[2:], mu)) for p in ca.vertsplit(inputs[2], 4)]
        found = unpacked(inputs[0], sums), unpacked(inputs[1], at), unpacked(inputs[4], sums)
        return _JointSymbols(inputs, *found, twists)


def _pair(joint: _JointSymbols, i: int, j: int) -> tuple[ca.SX, tuple[ca.SX, ca.SX], tuple[ca.SX, ca.SX]]:
    """The entry on the diagonal, and factors (6) of the entries above and below it, by angles of rows i and j."""
    (xi, eta), (xj, ej) = joint.twists[i], joint.twists[j]
    block, whole = joint.sums[f"block {i}{j}"], joint.total[f"block {i}{j}"]
    if i == j:
        bend, bend_all = _bends(joint, i)
        block[2, 2] += bend
        whole[2, 2] += bend_all
    u = block @ xj + joint.at[f"left {i}{j}"] / 2
    v = block.T @ xi + joint.at[f"right {i}{j}"] / 2
    above = ca.vertcat(xi - eta, whole.T @ eta - v), ca.vertcat(u, ej)
    below = ca.vertcat(v, eta), ca.vertcat(xj - ej, whole @ ej - u)
    own = joint.at[f"both {i}{j}"] / 4 - ca.dot(xi, joint.at[f"left {i}{j}"]) / 2
    return ca.dot(*above) + own, above, below


def _bends(joint: _JointSymbols, i: int) -> tuple[ca.SX, ca.SX]:
    """What second derivatives of the places add beyond the joint, and over all: -sum force . (x - p_j - tau_j)."""
    (xi, eta), force, whole = joint.twists[i], joint.sums[f"force {i}"], joint.total[f"force {i}"]
    at, shift = ca.vertcat(-xi[1], xi[0]), ca.vertcat(eta[1], -eta[0])
    bend = ca.dot(force[:2], at) - joint.sums[f"along {i}"] + ca.dot(whole[:2], shift)
    return bend, -joint.total[f"along {i}"]


def _places(m: int) -> np.ndarray:
    """Where the entries (o, o) of a step's Hessian stand in the values that `second` puts in a column."""
    size, square = 6 + 2 * m, np.arange(m * m).reshape(m, m, order="F")
    cross = 36 + np.arange(12 * m).reshape(m, 12, order="F").T
    diagonal = 36 + 12 * m + np.arange(3 * m).reshape(3, m)
    first = 36 + 15 * m
    above00, above01, below01, above11 = (first + k * m * m + square for k in range(4))
    upper = np.triu(np.ones((m, m), bool), 1)
    found = np.zeros((size, size), int)
    found[:6, :6] = np.arange(36).reshape(6, 6, order="F")
    found[:6, 6:] = np.hstack([cross[:6], cross[6:]])
    blocks = {(0, 0): (above00, above00.T), (0, 1): (above01, below01), (1, 1): (above11, above11.T)}
    for k, (i, j) in enumerate(ENDS):
        above, below = blocks[i, j]
        entry = np.where(upper, above, below)
        np.fill_diagonal(entry, diagonal[k])
        found[6 + i * m : 6 + (i + 1) * m, 6 + j * m : 6 + (j + 1) * m] = entry
    lower = np.tril_indices(size, -1)
    found[lower] = found.T[lower]
    return found
