"""What a calibration can ask for: named numbers, and how each changes the model's parameter vector.

The vector is edges (N - 1), weights (N, sum 1), anisotropy ratio; a fitted number moves along one direction of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid.body import Floats
from serpenoid.errors import InputError
from serpenoid.model import Model


@dataclass(frozen=True)
class Fittable:
    """A number one can fit: unit, bounds, value that changes nothing (None: the model's own), and what it means."""

    name: str
    meaning: str
    low: float
    high: float
    neutral: float | None


FITTABLE = {
    entry.name: entry
    for entry in (
        Fittable("anisotropy_ratio", "eps, tangential over normal dissipation", 1e-4, 1.0, None),
        Fittable("end_weight", "factor on the weights of head and tail (batteries)", 0.05, 20.0, 1.0),
        Fittable("front_weight", "how weights grow linearly from tail (1 - b) to head (1 + b)", -0.95, 0.95, 0.0),
    )
}


def start_values(names: tuple[str, ...], model: Model) -> Floats:
    """Where a fit begins: the model's eps, and neutral values."""
    unknown = [name for name in names if name not in FITTABLE]
    if unknown:
        raise InputError(f"cannot fit `{unknown[0]}`; one can fit {', '.join(FITTABLE)}.")
    if not names or len(set(names)) != len(names):
        raise InputError("name each number to fit once.")
    neutral = [FITTABLE[name].neutral for name in names]
    return np.array([model.medium.anisotropy_ratio if value is None else value for value in neutral])


def bounds(names: tuple[str, ...], model: Model) -> tuple[Floats, Floats]:
    """Lower and upper bounds (P,); those of eps are the medium's, where it states them."""
    pairs = [(FITTABLE[n].low, FITTABLE[n].high) for n in names]
    pairs = [model.medium.limits(*p) if n == "anisotropy_ratio" else p for n, p in zip(names, pairs, strict=True)]
    return np.array([low for low, _ in pairs]), np.array([high for _, high in pairs])


def changed(model: Model, names: tuple[str, ...], values: Floats) -> Model:
    """The model with these numbers in place."""
    body, medium = model.body, model.medium
    weights = body.vertex_weights.copy()
    for name, value in zip(names, values, strict=True):
        if name == "anisotropy_ratio":
            medium = medium.with_ratio(value)
        elif name == "end_weight":
            weights[[0, -1]] *= value
        else:
            weights *= 1 + value * np.linspace(-1, 1, len(weights))
    if any(name != "anisotropy_ratio" for name in names):
        body = type(body).model_validate({**body.model_dump(), "weights": tuple(weights.tolist())})
    return Model(body, medium)


def direction(model: Model, names: tuple[str, ...], values: Floats) -> Floats:
    """Derivative of the parameter vector by the fitted numbers, shape (2 N, P); exact for eps, central for weights."""
    columns = []
    for i, name in enumerate(names):
        if name == "anisotropy_ratio":
            columns.append(np.eye(2 * model.body.vertices)[-1])
            continue
        step = np.zeros(len(values))
        step[i] = 1e-6
        up, down = changed(model, names, values + step), changed(model, names, values - step)
        columns.append((up.parameters - down.parameters) / 2e-6)
    return np.stack(columns, axis=1)
