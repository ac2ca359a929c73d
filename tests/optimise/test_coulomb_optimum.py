"""Optimal gaits on dry ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oracle import power_laws
from serpenoid.optimise.multistart import MultiStart
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
    run = power_laws.simulate(s.table, body.edges, body.vertex_weights, s.problem.medium.anisotropy_ratio, degree=1)
    # the oracle's friction is not softened: tests/simulation/test_coulomb.py measures 1e-4 for it
    assert s.trajectory.displacement == pytest.approx(run.displacement, abs=5e-4)
    assert s.trajectory.dissipation == pytest.approx(run.energies.sum(), rel=2e-3)


UNEQUAL = (
    *DRY, "body.vertices=7", "body.edge_lengths=[1,2,1,3,1,1]", "body.joint_limit_deg=60", "task.c=0.3",
    "medium.anisotropy_ratio=0.3",
)  # fmt: skip


@pytest.fixture(scope="module")
def unequal() -> MultiStart:
    return solve(problem(*UNEQUAL), starts=2, seed=0)


@pytest.mark.slow
def test_unequal_links_on_dry_ground_are_optimised_from_every_start(unequal: MultiStart) -> None:
    """A plain search over forward simulations (SLSQP) reaches -0.5922 and -0.5926 from three starts."""
    assert [s.status for s in unequal.solutions] == [Status.SOLVED] * 2
    assert unequal.best.cost < -0.588


@pytest.mark.slow
def test_of_failed_starts_the_gait_that_goes_is_shown_and_not_the_one_that_stands(unequal: MultiStart) -> None:
    """IPOPT's last points differ by how far they are off the equations of motion; gaits are simulated without."""
    going = unequal.best
    failed = replace(going, status=Status.NOT_CONVERGED)
    loose = replace(failed, residuals=replace(going.residuals, feasibility=1e-2))
    standing = replace(failed, cost=0.0, residuals=replace(going.residuals, feasibility=1e-4))
    assert MultiStart((standing, loose), ()).best is loose


@pytest.mark.slow
def test_a_sweep_over_the_price_of_friction_is_certified_throughout() -> None:
    """Where dissipation is free the gait goes farthest, and steps are longest: 40 are 6.3 % off, 60 are 3.5 %."""
    result = sweep(problem(*DRY, "task.steps=60"), np.linspace(0, 2, 3), starts=2, seed=1)
    assert all(point.solution is not None for point in result.points)
    assert (np.diff(result.dissipation) < 1e-9).all()


def test_a_sweep_refuses_the_point_that_its_mesh_is_too_coarse_for_and_keeps_the_others() -> None:
    result = sweep(problem("reference-optimum", "task.steps=16"), [0.0, 2.0], starts=2, seed=1)
    assert [point.solution is not None for point in result.points] == [False, True]
    assert "depends on the number of steps" in result.points[0].message
