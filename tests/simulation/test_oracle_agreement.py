"""The plain NumPy/SciPy integrator, which shares no code with the package, makes the same motion."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from serpenoid.body import Body
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles
from specimens import BODIES, agree, oracle_run, problem, random_table, serpenoid_table

pytestmark = pytest.mark.usefixtures("virtual_machine")
TOLERANCE = 1e-9  # the oracle stops at a momentum of 1e-12; over the smallest stiffness met (1e-3) that is 1e-9


@st.composite
def models(draw: st.DrawFn) -> Model:
    """Any chain of 3 to 9 vertices, any edges and weights within a factor of ten, any joints, either dissipation."""
    n = draw(st.integers(3, 9))
    lengths = st.floats(0.1, 1.0)
    joints = sorted(draw(st.sets(st.integers(1, n - 2), min_size=1)))
    body = Body(
        vertices=n,
        edge_lengths=tuple(draw(st.lists(lengths, min_size=n - 1, max_size=n - 1))),
        weights=tuple(draw(st.lists(lengths, min_size=n, max_size=n))),
        joints=tuple(joints),
    )
    eps, where = draw(st.floats(0.05, 1.0)), draw(st.sampled_from(["vertex", "edge"]))
    return Model(body, Medium(anisotropy_ratio=eps, dissipation=where))


@settings(max_examples=30, deadline=None, derandomize=True, database=None)
@given(model=models(), seed=st.integers(0, 2**31))
def test_random_bodies_and_random_tables_move_as_in_the_oracle(model: Model, seed: int) -> None:
    table = random_table(model, np.random.default_rng(seed), 12, amplitude=0.25)
    agree(simulate_joint_angles(model, table), oracle_run(model, table), TOLERANCE)


@pytest.mark.parametrize("model", BODIES.values(), ids=BODIES)
@pytest.mark.parametrize("cycles", [1, 2])
def test_elliptical_gaits_move_as_in_the_oracle(model: Model, cycles: int) -> None:
    table = serpenoid_table(model, 40)
    agree(simulate_joint_angles(model, table, cycles=cycles), oracle_run(model, table, cycles=cycles), TOLERANCE)


@pytest.mark.parametrize("name", ["reference", "snake10", "purcell", "gait-a", "gait-b", "gait-c"])
def test_problem_files_move_as_in_the_oracle(name: str) -> None:
    asked = problem(name)
    gait = {key: getattr(asked.gait, key) for key in ("sigma", "a", "xi", "x_c", "y_c", "theta")}
    table = serpenoid_table(asked.model, asked.task.steps, **gait)
    motion, run = simulate_joint_angles(asked.model, table), oracle_run(asked.model, table)
    agree(motion, run, TOLERANCE)
    assert motion.displacement == pytest.approx(run.displacement, abs=TOLERANCE)
    assert motion.forward_displacement == pytest.approx(run.forward_displacement, abs=TOLERANCE)
    assert motion.dissipation == pytest.approx(run.dissipation, abs=TOLERANCE)
