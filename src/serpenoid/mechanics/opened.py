"""The step's Functions of a model, to put into an optimiser of one's own."""

from __future__ import annotations

import casadi as ca

from serpenoid.errors import InputError, of_kind
from serpenoid.mechanics import functions
from serpenoid.model import Model

STEP = (functions.shape, functions.step_energy, functions.step_momentum, functions.step)


def step_functions(model: Model) -> dict[str, ca.Function]:
    """`shape`, `step_energy`, `step_momentum`, `step` (see `mechanics.functions`); their inputs: `model.parameters`.

    InputError where the model has effects: these Functions are the baseline's, and silence would mislead.
    """
    if of_kind("model", model, Model, "Of a problem: problem.model.").effects:
        names = ", ".join(dict.fromkeys(effect.name for effect in model.effects))
        raise InputError(
            f"step functions are the baseline's, and this model has effects ({names}). Simulate, solve or open "
            "`gait_nlp` with them; or drop them for the baseline: dataclasses.replace(model, effects=())."
        )
    return {make.__name__: make(model.structure) for make in STEP}
