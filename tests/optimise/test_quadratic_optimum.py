"""Optimal gaits of a swimmer with quadratic drag."""

from __future__ import annotations

import pytest

from oracle import power_laws
from serpenoid.optimise.solve import solve
from serpenoid.status import Status
from specimens import problem

FAST = ("reference-optimum", 'medium.law="quadratic"', "medium.anisotropy_ratio=0.4", "task.steps=40", "task.c=0.5")


def test_every_start_is_certified_and_finds_what_plain_minimisation_confirms() -> None:
    found = solve(problem(*FAST), starts=3, seed=1)
    assert [s.status for s in found.solutions] == [Status.SOLVED] * 3
    s = found.best
    assert s.residuals.largest <= 1e-8
    assert s.polishing_gain is not None
    assert s.polishing_gain < 1e-6
    run = power_laws.simulate(s.table, s.problem.body.edges, s.problem.body.vertex_weights, 0.4, degree=3)
    # what softening leaves is 1e-5, see tests/simulation/test_quadratic.py
    assert s.trajectory.displacement == pytest.approx(run.displacement, abs=1e-4)
    assert s.trajectory.energy_raw == pytest.approx(run.energies.sum(), rel=1e-3)


@pytest.mark.parametrize("effect", ["{name='slope',pull_x=0.02,pull_y=0.01}", "{name='inertia',relaxation_time=0.1}"])
def test_effects_are_optimised_and_certified_by_simulation(effect: str) -> None:
    asked = problem(*FAST, "task.cycle_duration_s=1.0", f"effects=[{effect}]")
    s = solve(asked, starts=1, seed=1).best
    assert s.status is Status.SOLVED
    assert s.residuals.largest <= 1e-8
