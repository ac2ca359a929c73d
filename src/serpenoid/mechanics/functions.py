"""The model's public, named casadi.Functions, for one Structure; every other number is an input.

Legend: N vertices, m joints, M elements. `parameters` = edges (N - 1), weights (N), anisotropy ratio: (2 N, 1).
Lengths in body lengths, weights summing to one. Poses are relative: body frame of t + 1 in that of t, (x, y, heading).

    gait_joint_angles (gait (k), row data (d), parameters) -> joint_angles (m), for one family of gaits
    lifted_row     (coordinates (5), parameters) -> points (3, N), shares (N), elements (7, M): of a body that is lifted
    relative_pose  (from (3), to (3)) -> pose (3): the second in the frame of the first
    shape          (joint_angles (m), parameters) -> vertices (2, N), elements (4, M) in the body frame
    shape_elements (vertices (2, N)) -> elements (4, M): positions above unit tangents, in the vertices' frame
    step_energy    (before (4, M), after (4, M), pose (3), parameters) -> energy
    step_momentum  (before, after, pose, parameters) -> momentum (3): rotation, translation
    step_moments   (before, after, parameters) -> moments (18)
    step           (before, after, guess, parameters) -> pose (3), residual, curvature, energy
"""

from __future__ import annotations

from functools import lru_cache

import casadi as ca

from serpenoid.gaits import GaitFamily
from serpenoid.gaits.lifted import Lift
from serpenoid.mechanics import energy, kinematics, lifted, planar
from serpenoid.mechanics.momentum import momentum
from serpenoid.media import LAWS, Law
from serpenoid.model import Structure

CSE = {"cse": True}


def split_parameters(parameters: ca.SX | ca.MX, structure: Structure) -> tuple:
    """(edges (N - 1), vertex weights (N), anisotropy ratio)."""
    n = structure.vertices
    return parameters[: n - 1], parameters[n - 1 : 2 * n - 1], parameters[2 * n - 1]


@lru_cache(maxsize=64)
def gait_joint_angles(structure: Structure, family: GaitFamily) -> ca.Function:
    """A row of a family's table: the parameters it depends on and its data to joint angles."""
    p, data = ca.SX.sym("gait", family.indices.shape[1]), ca.SX.sym("data", family.data.shape[1])
    parameters = _parameters(structure)
    edges, weights, _ = split_parameters(parameters, structure)
    angles = lifted.commanded_angles(family, p, data, edges, weights, structure)
    names = (["gait", "data", "parameters"], ["joint_angles"])
    return ca.Function("gait_joint_angles", [p, data, parameters], [angles], *names, CSE)


@lru_cache(maxsize=16)
def lifted_row(structure: Structure, lift: Lift) -> ca.Function:
    """A row of a lifted body: points and elements in the body frame, shares of the weight."""
    coordinates, parameters = ca.SX.sym("coordinates", 5), _parameters(structure)
    edges, weights, _ = split_parameters(parameters, structure)
    body = lifted.lifted_body(coordinates, edges, weights, structure, lift)
    outputs = [ca.densify(x) for x in (body.points, body.shares, lifted.elements(body, edges, structure))]
    names = (["coordinates", "parameters"], ["points", "shares", "elements"])
    return ca.Function("lifted_row", [coordinates, parameters], outputs, *names, CSE)


@lru_cache(maxsize=1)
def relative_pose() -> ca.Function:
    """Pose of the second argument in the frame of the first."""
    a, b = ca.SX.sym("a", 3), ca.SX.sym("b", 3)
    value = ca.vertcat(energy.planar_rotation(a[2]).T @ (b[:2] - a[:2]), b[2] - a[2])
    return ca.Function("relative_pose", [a, b], [value], ["from", "to"], ["pose"])


@lru_cache(maxsize=64)
def shape(structure: Structure) -> ca.Function:
    """Joint angles to vertices and dissipation elements in the body frame."""
    angles, parameters = ca.SX.sym("joint_angles", len(structure.joints)), _parameters(structure)
    edges, weights, _ = split_parameters(parameters, structure)
    points, unit = kinematics.vertices(angles, edges, weights, structure)
    names = (["joint_angles", "parameters"], ["vertices", "elements"])
    outputs = [points, kinematics.elements(points, unit, structure)]
    return ca.Function("shape", [angles, parameters], outputs, *names, CSE)


@lru_cache(maxsize=64)
def shape_elements(structure: Structure, dimension: int = 2) -> ca.Function:
    """Vertices to dissipation elements, in the plane or in space."""
    points = ca.SX.sym("vertices", dimension, structure.vertices)
    found = kinematics.elements(points, kinematics.unit_edges(points), structure)
    return ca.Function("shape_elements", [points], [found], ["vertices"], ["elements"], CSE)


@lru_cache(maxsize=64)
def step_energy(structure: Structure, dimension: int = 2) -> ca.Function:
    """Energy of one step at a given relative pose."""
    before, after, pose, parameters = _step_symbols(structure, dimension)
    moved = energy.move(pose, after)
    value = energy.step_energy(before, moved, *_medium(parameters, structure), *_law(before, after, structure))
    return ca.Function("step_energy", [before, after, pose, parameters], [value], STEP_INPUTS, ["energy"], CSE)


@lru_cache(maxsize=64)
def step_momentum(structure: Structure, dimension: int = 2) -> ca.Function:
    """Geometric momentum of one step at a given relative pose: (rotation, translation)."""
    before, after, pose, parameters = _step_symbols(structure, dimension)
    medium = _medium(parameters, structure)
    value = momentum(before, after, pose, *medium, *_law(before, after, structure))
    return ca.Function("step_momentum", [before, after, pose, parameters], [value], STEP_INPUTS, ["momentum"], CSE)


@lru_cache(maxsize=64)
def step_moments(structure: Structure) -> ca.Function:
    """The planar step's eighteen moments."""
    size = (4, structure.elements)
    before, after = ca.MX.sym("before", *size), ca.MX.sym("after", *size)
    parameters = ca.MX.sym("parameters", 2 * structure.vertices)
    value = planar.moments(before, after, *element_parameters(structure)(parameters))
    names = (["before", "after", "parameters"], ["moments"])
    return ca.Function("step_moments", [before, after, parameters], [value], *names)


@lru_cache(maxsize=64)
def element_parameters(structure: Structure) -> ca.Function:
    """parameters -> element weights (M), anisotropy ratio."""
    parameters = _parameters(structure)
    outputs = list(_medium(parameters, structure))
    return ca.Function("element_parameters", [parameters], outputs, ["parameters"], ["weights", "anisotropy_ratio"])


@lru_cache(maxsize=64)
def step(structure: Structure) -> ca.Function:
    """The planar step: the relative pose that makes the energy stationary, by Newton's method."""
    size = (4, structure.elements)
    before, after = ca.MX.sym("before", *size), ca.MX.sym("after", *size)
    guess, parameters = ca.MX.sym("guess"), ca.MX.sym("parameters", 2 * structure.vertices)
    m = step_moments(structure)(before, after, parameters)
    outputs = planar.root().call([guess, m])
    names = (["before", "after", "guess", "parameters"], ["pose", "residual", "curvature", "energy"])
    return ca.Function("step", [before, after, guess, parameters], outputs, *names)


STEP_INPUTS = ["before", "after", "pose", "parameters"]


def _parameters(structure: Structure) -> ca.SX:
    return ca.SX.sym("parameters", 2 * structure.vertices)


def _step_symbols(structure: Structure, dimension: int) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX]:
    size = (2 * dimension, structure.elements)
    pose = ca.SX.sym("pose", 3 if dimension == 2 else 6)
    return ca.SX.sym("before", *size), ca.SX.sym("after", *size), pose, _parameters(structure)


def _law(before: ca.SX, after: ca.SX, structure: Structure) -> tuple[Law, ca.SX]:
    """The medium's law and its softening lengths in this step."""
    return LAWS[structure.law], energy.softening_length(before, after, structure.softening)


def _medium(parameters: ca.SX, structure: Structure) -> tuple[ca.SX, ca.SX]:
    edges, weights, anisotropy_ratio = split_parameters(parameters, structure)
    return kinematics.element_weights(weights, edges, structure), anisotropy_ratio
