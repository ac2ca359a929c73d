"""What effects change in the gait NLP: the blocks of a step, how steps are combined, and the rows that servos realise.

    T (drag_t + dt (c_0 P_t + c_1 P_{t-1} + c_2 P_{t-2})) = 0 for every step     (on the floor; see mechanics.extended)

The cycle begins at the origin, heading along x, at rest, with the clock at zero: what depends on place, time or history
is optimised as a robot would play it. Rows are the realised ones: a lag makes an ellipse smaller and later, other servo
effects are formulas (`ActuationEffect.in_gait`), and a speed saturation becomes a limit (`limits.py`).
Legend: T steps, M vertices, m joints.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.base import Wave
from serpenoid.effects.catalogue import actuation_effects, medium_effects
from serpenoid.gaits import GaitFamily
from serpenoid.mechanics import kinematics
from serpenoid.mechanics.extended import SETTING, wrench
from serpenoid.mechanics.functions import element_parameters
from serpenoid.mechanics.wide import over_columns
from serpenoid.model import Model
from serpenoid.optimise.step import joint_blocks
from serpenoid.optimise.step.blocks import StepBlocks
from serpenoid.optimise.step.growing_blocks import GrowingBlocks
from serpenoid.optimise.step.joint_blocks import JointBlocks, step_functions, with_directions
from serpenoid.simulation import inertia
from serpenoid.simulation.law import MediumNumbers, coordinates
from serpenoid.simulation.servos import coordinates as servo_coordinates


def extended_blocks(model: Model, steps: int, portable: bool = False) -> StepBlocks:
    """Step blocks with the effects of the medium that are present: drag (3) and momentum (3) of each step.

    Effects are left to CasADi's virtual machine: every selection of them would be another library.
    """
    present = {e.name for e in model.medium_effects}
    kinds = tuple(kind for kind in medium_effects() if kind.name in present)
    frame, before, after = ca.SX.sym("frame", joint_blocks.FRAME), ca.SX.sym("before", 4), ca.SX.sym("after", 4)
    weight, eps, setting = ca.SX.sym("weight"), ca.SX.sym("eps"), ca.SX.sym("setting", SETTING)
    numbers = coordinates(model, kinds=kinds)[:, : model.structure.elements]
    theta = ca.SX.sym("theta", len(numbers))
    ends = with_directions(before), with_directions(after)
    share = wrench(kinds, model.law, *ends, frame, ca.vertcat(weight, eps), setting, theta)
    own, fixed = ((theta,), (False,)) if len(numbers) else ((), ())
    more, shared = (weight, eps, *own, setting), (False, True, *fixed, True)
    bounded = model.law.degree == 1 and not model.knows("history")  # inertia grows with the step
    energy = share[6] if bounded else share[6] * steps ** (model.law.degree - 2)  # the NLP takes T times their sum
    law = joint_blocks.ElementShare(frame, before, after, more, shared, share[:6], energy)
    structure = model.structure
    functions = step_functions(structure, law, element_parameters(structure), ca.DM(numbers))
    blocks = JointBlocks(over_columns(functions, portable=portable or bool(kinds)), 6)
    return GrowingBlocks(blocks, steps) if bounded else blocks


def settings(model: Model, steps: int) -> ca.MX:
    """Settings (6, T) of the steps."""
    times = _times(model, steps)
    return ca.MX(ca.DM(MediumNumbers.of(model).settings(np.column_stack([times[:-1], times[1:]]))))


def combination(model: Model, steps: int) -> ca.DM:
    """Residuals (3 T) from values (6 T): drag, and with inertia the momenta of this step and the two before it."""
    total = np.kron(np.eye(steps), np.eye(3, 6))
    if model.knows("history"):
        total += np.kron(inertia.matrix(inertia.coefficients(_times(model, steps))), np.eye(3, 6, 3))
    return ca.sparsify(ca.DM(total))


def _times(model: Model, steps: int) -> Floats:
    return model.step_duration(steps) * np.arange(steps + 1, dtype=float)


def realised_angles(model: Model, family: GaitFamily, p: ca.SX, data: ca.SX, edges: ca.SX, steps: int) -> ca.SX:
    """Joint angles (m) on which the servos settle when a gait is played again and again, at the row of `data`.

    Effects with memory need a family whose rows are a function of their phase (`data[0]`) alone.
    """
    joints = range(len(model.structure.joints))
    return ca.vertcat(*(_realised(model, family, joint, p, data, edges, steps) for joint in joints))


def _realised(model: Model, family: GaitFamily, joint: int, p: ca.SX, data: ca.SX, edges: ca.SX, steps: int) -> ca.SX:
    def commanded(row: ca.SX) -> ca.SX:
        here = row / steps if family.harmonic else data
        return kinematics.family_joint_angles(family, p, here, edges, model.structure)[joint]

    wave = Wave(commanded, steps, model.step_duration(steps))
    theta, start = ca.SX(ca.DM(servo_coordinates(model)[:, joint])), 0
    for kind in actuation_effects():
        count = len(kind.parameters) + 1
        if any(active.name == kind.name and active.place in (None, joint + 1) for active in model.actuation_effects):
            wave = kind.in_gait(wave, kind.symbols(theta[start : start + count]))
        start += count
    return wave.at(data[0] * steps)
