"""How a model moves, as the gait NLP needs it: step blocks, and the layers that lead from gait parameters to shapes.

    family --shapes--> coordinates of the realised rows --blocks--> values per step --combine--> residuals

Without effects the rows are the commanded ones. Actuation effects change the layer, effects of the medium the blocks;
inertia couples steps, which `combine` (constant) does. Legend: T steps, R rows, n parameters, v values per step.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca
import numpy as np

from serpenoid.effects.base import ActuationEffect
from serpenoid.errors import InputError
from serpenoid.gaits import GaitFamily
from serpenoid.gaits.lifted import LiftedFamily
from serpenoid.mechanics import functions, lifted
from serpenoid.mechanics.functions import CSE, split_parameters
from serpenoid.model import Model, Structure
from serpenoid.optimise.step.blocks import StepBlocks
from serpenoid.optimise.step.extended import combination, extended_blocks, realised_angles, settings
from serpenoid.optimise.step.joint_blocks import baseline_blocks
from serpenoid.optimise.step.layer import Layer, RowFunctions, over_rows, row_functions
from serpenoid.optimise.step.lifted_blocks import COORDINATES, LiftedBlocks
from serpenoid.optimise.step.played import Played, remembers
from serpenoid.optimise.step.rows import joint_functions
from serpenoid.optimise.step.serpenoid_blocks import SerpenoidBlocks


@dataclass(frozen=True)
class MotionLaw:
    """shapes: None where the parameters are the shapes. combine (3 T, v T): None where values are residuals. played:
    servos with memory, where the gait's family has no formula for what they settle on.
    """

    structure: Structure
    family: GaitFamily
    steps: int
    coordinates: int
    blocks: StepBlocks
    shapes: Layer | None
    combine: ca.DM | None = None
    settings: ca.MX | None = None
    played: Played | None = None

    @property
    def states(self) -> int:
        """Numbers of the servos' memories: NLP variables before the gait's parameters."""
        return 0 if self.played is None else self.played.states

    def behind(self, layer: Layer) -> Layer:
        """A layer of the gait's parameters as one of these variables."""
        return layer if self.played is None else self.played.behind(layer)


def motion_law(model: Model, family: GaitFamily, portable: bool = False) -> MotionLaw:
    """The law of a model for gaits of a family."""
    steps, structure = family.rows - (not family.closed), model.structure
    if isinstance(family, LiftedFamily):
        return _in_space(model, family, portable)
    plain = model.is_plain and not model.actuation_effects
    if plain and family.coordinates == "serpenoid" and family.modes == 1:
        blocks: StepBlocks = SerpenoidBlocks(structure, portable)
        return MotionLaw(structure, family, steps, 3, blocks, _coordinates(family, structure, portable))
    _refuse_delay(model, family)
    played = Played(model, family) if needs_states(model, family) else None
    shapes = _angles(model, family, steps, portable) if played is None else played.realised()
    m = len(structure.joints)
    if model.is_plain:
        return MotionLaw(structure, family, steps, m, baseline_blocks(structure, portable), shapes, played=played)
    blocks, combine = extended_blocks(model, steps, portable), combination(model, steps)
    return MotionLaw(structure, family, steps, m, blocks, shapes, combine, settings(model, steps), played)


def _in_space(model: Model, family: LiftedFamily, portable: bool) -> MotionLaw:
    if model.only_in_the_plane is not None:
        raise InputError(f"[lift]: {model.only_in_the_plane}")
    steps, blocks = family.rows - (not family.closed), LiftedBlocks(model.structure, family.lift, portable)
    coordinates = _coordinates(family, model.structure, portable)
    return MotionLaw(model.structure, family, steps, COORDINATES, blocks, coordinates)


def _refuse_delay(model: Model, family: GaitFamily) -> None:
    """Rows that are told between two earlier ones are written for gaits whose rows follow from the phase alone."""
    late = [e.name for e in model.actuation_effects if isinstance(e.effect, ActuationEffect) and e.effect.dead_time]
    if late and not (family.harmonic and family.closed):
        kind = family.like.family if family.closed else "transient"
        raise InputError(
            f"[[effects]] `{late[0]}` is not optimised with a gait of family `{kind}`: take an ellipse, or leave the "
            "effect out. Servos that are late play the same gait, only later; `simulate` knows it with any gait."
        )


def needs_states(model: Model, family: GaitFamily) -> bool:
    """Whether servos remember, and the family has no formula for what they settle on."""
    remembering = any(remembers(active.effect) for active in model.actuation_effects)
    return remembering and not (family.harmonic and family.closed)


def _coordinates(family: GaitFamily, structure: Structure, portable: bool) -> Layer:
    """Parameters to shape coordinates."""
    p, data = ca.SX.sym("p", family.indices.shape[1]), ca.SX.sym("data", family.data.shape[1])
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    function = ca.Function("coordinates", [p, data, parameters], [family.at(p, data)], CSE)
    return _layer("coordinates", function, family, portable)


def _angles(model: Model, family: GaitFamily, steps: int, portable: bool) -> Layer | None:
    """Parameters to the joint angles that the body really has."""
    if not model.actuation_effects:
        return None if family.free else table_layer(family, model.structure, portable)
    p, data = ca.SX.sym("p", family.indices.shape[1]), ca.SX.sym("data", family.data.shape[1])
    parameters = ca.SX.sym("parameters", 2 * model.structure.vertices)
    edges, _, _ = split_parameters(parameters, model.structure)
    angles = realised_angles(model, family, p, data, edges, steps)
    return _layer("realised", ca.Function("realised", [p, data, parameters], [angles], CSE), family, True)


def table_layer(family: GaitFamily, structure: Structure, portable: bool) -> Layer:
    """Parameters to the joint table."""
    if family.coordinates == "serpenoid":
        made = over_rows(joint_functions(family, structure, changes=False), portable)
        return Layer(made, family.indices, family.size)
    made = functions.gait_joint_angles(structure, family)
    return _layer("table", made, family, portable or _long(family))


def path_layer(family: GaitFamily, structure: Structure, rows: int, portable: bool) -> Layer:
    """Parameters to a row's joint angles and their change to the next row (2 m), for rows whose data are parameters.

    Of a sparse family all rows are taken, in order.
    """
    indices = np.tile(np.arange(family.size), (rows, 1))
    if family.sparse:
        indices = np.hstack([family.indices, np.roll(family.indices, -1, axis=0)])[:rows]
    return Layer(_path_functions(family, structure, portable), indices, family.size)


@lru_cache(maxsize=16)
def _path_functions(family: GaitFamily, structure: Structure, portable: bool) -> RowFunctions:
    """Of one row, kept for NLPs of other numbers of rows."""
    if family.coordinates == "serpenoid":
        return over_rows(joint_functions(family, structure, changes=True), portable)
    k, d = family.indices.shape[1], family.data.shape[1]
    p, data = ca.SX.sym("p", k * (1 + family.sparse)), ca.SX.sym("data", 2 * d)
    parameters = ca.SX.sym("parameters", 2 * structure.vertices)
    edges, weights, _ = split_parameters(parameters, structure)

    def angles(q: ca.SX, row: ca.SX) -> ca.SX:
        return lifted.commanded_angles(family, q, row, edges, weights, structure)

    here, there = angles(p[:k], data[:d]), angles(p[p.numel() - k :], data[d:])
    function = ca.Function("path", [p, data, parameters], [ca.vertcat(here, there - here)])
    return row_functions("path", function, portable or _long(family))


def _long(family: GaitFamily) -> bool:
    """Whether rows are those of a lifted body: long C, and another library for every body and every lift."""
    return isinstance(family, LiftedFamily)


def _layer(name: str, function: ca.Function, family: GaitFamily, portable: bool) -> Layer:
    return Layer(row_functions(name, function, portable), family.indices, family.size)
