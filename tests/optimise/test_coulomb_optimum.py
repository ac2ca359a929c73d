"""Optimal gaits on dry ground."""

from __future__ import annotations

import numpy as np
import pytest

from oracle import coulomb
from serpenoid.optimise.solve import solve
from serpenoid.status import Status
from serpenoid.studies.sweep import sweep
from specimens import problem

DRY = ("reference-optimum", 'medium.law="coulomb"', "task.steps=40")


def test_an_optimum_with_friction_is_certified_and_plain_minimisation_confirms_it() -> None:
    s = solve(problem(*DRY, "task.c=1.0"), starts=1, seed=1).best
    assert s.status is Status.SOLVED
    assert s.residuals.largest <= 1e-8
    assert s.polishing_gain is not None
    assert s.polishing_gain < 1e-6
    body = s.problem.body
    run = coulomb.simulate(s.table, body.edges, body.vertex_weights, s.problem.medium.anisotropy_ratio)
    # the oracle's friction is not softened: tests/simulation/test_coulomb.py measures 1e-4 for it
    assert s.trajectory.displacement == pytest.approx(run.displacement, abs=5e-4)
    assert s.trajectory.dissipation == pytest.approx(run.energies.sum(), rel=2e-3)


@pytest.mark.slow
def test_a_sweep_over_the_price_of_friction_is_certified_throughout() -> None:
    result = sweep(problem(*DRY), np.linspace(0, 2, 5), starts=2, seed=1)
    assert all(point.solution is not None for point in result.points)
    assert (np.diff(result.dissipation) < 1e-9).all()
