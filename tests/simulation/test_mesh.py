"""The mesh certificate: what coarse steps move is not called an optimum, and a finer mesh confirms what is."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from serpenoid.body import Floats
from serpenoid.gaits import TableGait
from serpenoid.mechanics.tables import joint_table
from serpenoid.optimise.refine import refine, refine_best
from serpenoid.optimise.solve import solve
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.mesh import FACTORS, MeshStudy, study_mesh
from serpenoid.simulation.problem import mesh_of, on_meshes, simulate
from serpenoid.status import Status
from specimens import oracle_run, problem, random_table, reference

ONE_JOINT = ("reference-optimum", "body.vertices=3", "body.joint_limit_deg=170", "task.bounds.a=[0.0, 12.0]")

UNEVEN = (
    "reference-optimum", "task.steps=60", "task.c=0.5", "medium.anisotropy_ratio=0.01", "body.vertices=27",
    "body.edge_lengths=[1,2,3,0.1,5,1,1,1,1,1,1,10,1,1,1,0.05,1,1,1,1,1,1,2,2,2,0.5]",
    f"body.weights={[1e-9, *[1.0] * 11, 1e-6, *[1.0] * 13, 50.0]}", "task.constraints.joint_limits=false",
)  # fmt: skip


def reference_study(steps: int) -> MeshStudy:
    model, gait = reference(), problem("reference").gait.parameters

    return study_mesh([simulate_joint_angles(model, joint_table(model, gait, f * steps)) for f in FACTORS], steps)


@pytest.mark.parametrize("steps", [3, 50])
def test_a_gait_that_is_simulated_has_the_mesh_error_of_one_that_is_solved(steps: int) -> None:
    asked = problem("reference", f"task.steps={steps}")
    own, study = simulate(asked), reference_study(steps)
    found = mesh_of(asked, own.table, on_meshes(asked, own.table))
    assert found.displacements[0] == pytest.approx(own.trajectory.displacement, abs=1e-12)
    np.testing.assert_allclose(found.displacements, study.displacements, atol=1e-12)
    assert found.converged == (steps == 50)
    assert own.mesh == found
    said = "3 steps are too coarse for this gait: what it does is off by more than 5 %: ask for task.steps=12"
    assert (said in repr(own)) == (steps == 3)


def test_a_table_of_other_rows_than_the_file_says_is_refined_as_it_is_played() -> None:
    angles = random_table(reference(), np.random.default_rng(0), 7)
    path = TableGait.from_angles(angles)
    asked = problem("reference", "task.steps=50").model_copy(update={"gait": path})
    found = mesh_of(asked, angles, on_meshes(asked, angles))
    once, twice = (played(angles, factor) for factor in (1, 2))
    assert found.steps == 7
    np.testing.assert_allclose(found.displacements[:2], [once, twice], atol=1e-12)


def played(angles: Floats, factor: int) -> float:
    """Displacement of a closed table, along straight lines between its rows."""
    rows = np.arange(factor * len(angles)) / factor
    closed = np.concatenate([angles, angles[:1]])
    finer = np.stack([np.interp(rows, np.arange(len(closed)), joint) for joint in closed.T], -1)
    return simulate_joint_angles(reference(), finer).displacement


@pytest.mark.parametrize(
    "steps",
    [
        pytest.param(3, marks=pytest.mark.slow),
        pytest.param(4, marks=pytest.mark.slow),
        5,
        pytest.param(50, marks=pytest.mark.slow),
    ],
)
def test_one_joint_goes_nowhere_whatever_coarse_steps_say(steps: int) -> None:
    result = solve(problem(*ONE_JOINT, f"task.steps={steps}"), starts=2, seed=1)
    assert not result.optima
    if steps < 5:
        assert result.best.status is Status.MESH_TOO_COARSE
        assert result.best.trajectory.displacement > 0.1  # the discrete problem is solved, and it does move
        assert result.best.mesh.error > 0.1


def test_the_papers_mesh_passes_with_its_half_per_cent_stated() -> None:
    mesh = reference_study(50)
    assert mesh.converged
    assert mesh.error / mesh.displacement == pytest.approx(0.005, abs=0.0005)  # 0.4523 of 0.4546, docs/theory.md


def test_the_extrapolated_displacement_is_that_of_many_steps_and_the_error_bounds_the_truth() -> None:
    model, gait = reference(), problem("reference").gait.parameters
    fine = oracle_run(model, joint_table(model, gait, 1600))  # its own error: 0.5 % / 32^2
    limit, spent = fine.displacement, fine.dissipation
    for steps in (25, 50, 100):
        mesh = reference_study(steps)
        assert mesh.displacement == pytest.approx(limit, abs=1e-5)
        assert abs(mesh.displacements[0] - limit) <= mesh.error + 3e-6
        assert mesh.dissipation == pytest.approx(spent, abs=3e-6)
        assert abs(mesh.dissipations[0] - spent) == pytest.approx(mesh.dissipation_error, rel=0.1)
        assert f"dissipation {mesh.dissipation:.6f}, error" in mesh.words
    errors = [reference_study(steps).error for steps in (25, 50, 100)]
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(4, rel=0.1)  # second order


def test_refining_solves_the_same_problem_on_meshes_until_one_is_fine() -> None:
    coarse = solve(problem("reference-optimum", "task.steps=20"), starts=3, seed=1).best
    fine = refine(coarse).solution
    assert coarse.status is Status.MESH_TOO_COARSE
    assert fine.status is Status.SOLVED
    assert fine.problem.task.steps in (160, 320)  # 8 % at 20 steps, a quarter of it with each doubling
    assert fine.mesh.error <= 1e-3 * fine.mesh.displacement
    assert fine.trajectory.displacement == pytest.approx(fine.mesh.displacement, rel=1e-3)


@pytest.mark.slow  # 27 vertices and meshes of hundreds of steps
def test_refining_begins_with_the_best_optimum_though_its_mesh_is_too_coarse() -> None:
    """Starts that end in a worse optimum do not hide those that reach a better one."""
    found = solve(problem(*UNEVEN), starts=4, seed=0)
    assert found.optima
    assert found.better_but_coarse
    fine = refine_best(found).solution
    assert fine.status is Status.SOLVED
    assert fine.cost < refine(found.optima[0].solution).solution.cost - 0.1


def test_a_turn_has_its_mesh_error_in_words_too() -> None:
    """Of a gait that turns in place the displacement says nothing."""
    still = (0.0, 0.0, 0.0)
    study = MeshStudy(50, still, still, (1.04, 1.01, 1.0025))
    assert study.turn_error == pytest.approx(0.04, rel=1e-6)  # second order, the limit is 1
    assert "turn 1.000000 rad, error 4.0e-02 (4 %)" in study.words
    assert "turn 0.010000 rad, error 1.4e-02 (143 %)" in MeshStudy(50, still, still, (0.0207, 0.01, 0.01)).words
    assert study.record["turn_error_rad"] == pytest.approx(0.04)
    assert "turn" not in MeshStudy(50, (0.5, 0.5, 0.5), still).words


@pytest.mark.parametrize(("forward", "turn", "shares"), [(0.6, 0.0012, 1), (1e-4, 1.0, 1), (0.6, 0.3, 2)])
def test_an_error_is_a_share_only_of_what_moves_the_body(forward: float, turn: float, shares: int) -> None:
    """Of a turn that is zero with these steps, as asked for, the error is all there is."""
    goes, turns = (0.99 * forward, forward, forward), (0.0, turn, turn)
    assert MeshStudy(50, goes, (0.0, 0.0, 0.0), turns).words.count(" %)") == shares


def test_a_table_is_refined_by_straight_lines_that_keep_its_rows() -> None:
    table = random_table(reference(), np.random.default_rng(3), 12)
    family = TableGait().of(10, 12)
    fine = family.on_finer_rows(table.ravel(), 4).reshape(-1, 10)
    np.testing.assert_array_equal(fine[::4], table)
    np.testing.assert_allclose(fine[2::4], (table + np.roll(table, -1, axis=0)) / 2, atol=1e-15)
    assert np.abs(np.diff(fine, axis=0)).max() == pytest.approx(np.abs(np.diff(table, axis=0)).max() / 4)


def test_a_finer_mesh_that_cannot_be_simulated_certifies_nothing() -> None:
    study = MeshStudy(10, (0.1, np.nan, 0.1), (0.1, np.nan, 0.1))
    assert not study.converged
    assert study.record["displacement_error"] is None
    assert "could not" in study.words
