"""Cases that a gait must serve together: anisotropy ratios of an interval, model files, what a diagnosis left open.

[task.robust]
over = "worst"                      # or "mean"
anisotropy_ratio = [0.1, 0.3]       # or: models = ["a.toml", "b.toml"], or: diagnosis = "results/foam"
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.effects.base import ActuationEffect
from serpenoid.errors import InputError
from serpenoid.files import schema
from serpenoid.files.inputs import read_json
from serpenoid.model_file import ModelFile, read_model_file
from serpenoid.problem import Problem, Robust

NODES = 3  # of a mean over an interval: Gauss-Legendre, exact to the fifth power of the ratio


@dataclass(frozen=True)
class Case:
    """The problem with one of its models; `weight`: its share of a mean."""

    name: str
    problem: Problem
    weight: float


def cases_of(problem: Problem) -> tuple[Case, ...]:
    """What `[task.robust]` names; of an interval its ends (worst case) or nodes (mean). Raises InputError."""
    robust = problem.task.robust
    if robust is None:
        return ()
    if robust.anisotropy_ratio is not None:
        return _ratios(problem, robust)
    found = _models(problem, robust) if robust.models else _alternatives(problem, robust)
    return tuple(Case(name, _with(problem, model, name), 1 / len(found)) for name, model in found)


def told_table(problem: Problem, table: Floats) -> Floats:
    """The joint table (R, m) [rad] that a robot is told: a joint that no case can drive stays where it stands.

    The motion is the same, as no command moves such a joint.
    """
    served = [case.problem for case in cases_of(problem)] or [problem]
    everywhere = set.intersection(*(set(each.effects) for each in served))
    told = table.copy()
    for effect in everywhere:
        angle = effect.effect.held_at(effect.parameters) if isinstance(effect.effect, ActuationEffect) else None
        if angle is not None and effect.place is not None:
            told[:, effect.place - 1] = angle
    return told


def at_ratio(problem: Problem, ratio: float, weight: float = 0.0) -> Case:
    """The problem in a medium with another anisotropy ratio."""
    return Case(f"eps {ratio:.4g}", _of_one(problem, {"medium": problem.medium.with_ratio(ratio)}), weight)


def _ratios(problem: Problem, robust: Robust) -> tuple[Case, ...]:
    low, high = robust.anisotropy_ratio or (0.0, 0.0)
    if robust.over == "worst":
        return at_ratio(problem, low, 0.5), at_ratio(problem, high, 0.5)
    places, weights = np.polynomial.legendre.leggauss(NODES)
    ratios = (low + high) / 2 + (high - low) / 2 * places
    return tuple(at_ratio(problem, float(r), float(w) / 2) for r, w in zip(ratios, weights, strict=True))


def _models(problem: Problem, robust: Robust) -> list[tuple[str, ModelFile]]:
    paths = [problem.folder / path for path in robust.files]
    found = [schema.validate(ModelFile, read_model_file(path), str(path)) for path in paths]
    return [(path.stem, model) for path, model in zip(paths, found, strict=True)]


def _alternatives(problem: Problem, robust: Robust) -> list[tuple[str, ModelFile]]:
    """The extended model of a diagnosis, and it with each alternative in the place of what it could stand for."""
    path, diagnosis = (problem.folder / name for name in robust.files)
    found = schema.validate(ModelFile, read_model_file(path), str(path))
    record = read_json(diagnosis)
    entries = record.get("alternatives") if isinstance(record, dict) else None
    if not isinstance(entries, list):
        raise InputError(f"{diagnosis}: has no list `alternatives`. Is it what `diagnose` wrote?")
    models = [("extended model", found)]
    for entry in entries:
        models.append(_swapped(found, entry, diagnosis))
    return models


def _swapped(model: ModelFile, entry: object, path: Path) -> tuple[str, ModelFile]:
    try:
        name, place, values = entry["name"], entry["place"], entry["parameters"]  # type: ignore[index]
        other = entry["instead_of"]  # type: ignore[index]
        gone = other["name"], other["place"]
    except (TypeError, KeyError) as error:
        raise InputError(f"{path}: `alternatives` has an entry without {error}. Is it what `diagnose` wrote?") from None
    effect = schema.validate(ActiveEffect, {"name": name, "place": place, "parameters": values}, str(path))
    if effect.effect.site == "observation":
        raise InputError(f"{path}: `{effect.name}` changes what cameras see; give the models that move in `models`.")
    kept = tuple(e for e in model.effects if e.key != gone)
    where = "" if effect.place is None else f" at {effect.place}"
    return f"{effect.name}{where}", model.model_copy(update={"effects": (*kept, effect)})


def _with(problem: Problem, model: ModelFile, name: str) -> Problem:
    body = problem.body
    if model.body is not None:
        limits = {key: getattr(body, key) for key in ("joint_limit_deg", "joint_speed_limit_rpm")}
        stated = {key: value for key, value in limits.items() if getattr(model.body, key) is None}
        body = model.body.model_copy(update=stated)
    if body.joint_count != problem.body.joint_count:
        raise InputError(
            f"[task.robust] {name}: has {body.joint_count} joints, the problem {problem.body.joint_count}; one table "
            "must fit all."
        )
    return _of_one(problem, {"medium": model.medium, "effects": model.effects, "body": body})


def _of_one(problem: Problem, update: dict[str, object]) -> Problem:
    """One case alone: the same task, without the others."""
    task = problem.task.model_copy(update={"robust": None})
    found = problem.model_copy(update={**update, "task": task})
    found.model.step_duration(task.steps)  # refuses effects that do not fit the body, or lack the clock
    return found
