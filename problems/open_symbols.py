"""The symbols behind the simulation and the optimiser: named casadi.Functions to call, differentiate, save and compile.

Lists the step's functions and the whole-cycle NLP's, with their inputs and outputs, saves each one, loads it back, and
writes C source for all of them.

    python problems/open_symbols.py [folder]
"""

from __future__ import annotations

import sys
from pathlib import Path

import casadi as ca
import numpy as np

import serpenoid as sp
from serpenoid.files.writing import write_text
from serpenoid.mechanics import functions
from serpenoid.mechanics.compile import generate_c

PROBLEM = Path(__file__).with_name("reference.toml")


def open_functions(problem: sp.Problem) -> list[ca.Function]:
    """The step's functions in the plane and in space, then the NLP's."""
    structure = problem.model.structure
    step = [
        functions.gait_joint_angles(structure, problem.family_of()),
        functions.shape(structure),
        functions.step_energy(structure),
        functions.step_momentum(structure),
        functions.step(structure),
        functions.step_momentum(structure, dimension=3),
    ]
    nlp = sp.gait_nlp(problem, portable=True)
    return [*step, *nlp.functions().values()]


def describe(function: ca.Function) -> str:
    """`name: input (shape), ... -> output (shape), ...`."""

    def side(names: list[str], shape: ca.Function) -> str:
        return ", ".join(f"{name} {shape(i)}" for i, name in enumerate(names))

    inputs, outputs = side(function.name_in(), function.size_in), side(function.name_out(), function.size_out)
    return f"{function.name()}: {inputs} -> {outputs}"


def largest_momentum(problem: sp.Problem) -> float:
    """The momentum function asked at the simulated poses: it must vanish there."""
    model, simulation = problem.model, sp.simulate(problem)
    shape, momentum = functions.shape(model.structure), functions.step_momentum(model.structure)
    elements = [shape(row, model.parameters)[1] for row in simulation.table]
    poses, relative = simulation.trajectory.poses, functions.relative_pose()
    steps = zip(elements, elements[1:], poses, poses[1:], strict=False)
    found = [momentum(a, b, relative(g, h), model.parameters).full() for a, b, g, h in steps]
    return float(np.max(np.abs(found)))


def main(folder: Path) -> None:
    """List, save, load, generate."""
    problem = sp.load(PROBLEM)
    opened = open_functions(problem)
    folder.mkdir(parents=True, exist_ok=True)
    for number, function in enumerate(opened):
        stem = f"{number:02d}-{function.name()}"
        function.save(str(folder / f"{stem}.casadi"))
        write_text(folder / f"{stem}.c", generate_c([function]))
        again = ca.Function.load(str(folder / f"{stem}.casadi"))
        sys.stdout.write(f"{describe(again)}\n")
    sys.stdout.write(f"largest momentum along the simulated motion: {largest_momentum(problem):.1e}\n")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "results/open-symbols"))
