"""What the tests of effects share: the snake, a gait, and one active effect of each kind."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

import serpenoid as sp
from serpenoid.effects import ActiveEffect, find
from serpenoid.media import LAWS
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.problem import Problem

PROBLEM = Path(__file__).parents[2] / "problems" / "snake10.toml"


def place_of(name: str) -> int | None:
    """Some place in the middle of the body."""
    return {None: None, "vertex": 4, "joint": 3}[find(name).place]


def typical(name: str) -> ActiveEffect:
    """The effect at a moderate strength."""
    return ActiveEffect.typical(name, place_of(name))


@pytest.fixture(scope="session")
def problem() -> Problem:
    """The robot with a gait that turns, so that left and right differ."""
    return sp.load(PROBLEM, ["gait.x_c=0.8", "gait.sigma=0.8", "gait.a=5.0", "gait.theta=0.4", "gait.xi=1.1"])


@pytest.fixture(scope="session")
def table(problem: Problem) -> np.ndarray:
    """Its joint table (50, 10)."""
    return sp.simulate(problem).table


def medium_for(medium: Medium, *effects: ActiveEffect) -> Medium:
    """A medium, by the first law in which all these effects act."""
    law = next(law for law in LAWS if all(e.effect.acts_in(law) for e in effects))
    return medium.model_copy(update={"law": law})


def extended(
    problem: Problem, *effects: ActiveEffect, duration: float | None = 5.0, asked: Sequence[ActiveEffect] = ()
) -> Model:
    """The robot with effects, in a medium in which they and those that are asked about act."""
    return Model(problem.body, medium_for(problem.medium, *effects, *asked), effects, duration)
