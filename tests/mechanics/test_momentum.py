"""The momentum is the gradient of the step energy, and it is the paper's formula up to its known factor."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from oracle import integrator
from serpenoid.body import Floats
from serpenoid.mechanics import energy, functions, planar
from serpenoid.model import Model
from specimens import BODIES, reference

# sums of at most 13 terms of order one: rounding stays below 1e-14
ROUNDING = 1e-14


def random_elements(rng: np.random.Generator, dimension: int, count: int) -> Floats:
    """Positions over unit tangents, shape (2 d, M): no chain, because the identity needs none."""
    tangents = rng.normal(size=(dimension, count))
    return np.vstack([rng.normal(size=(dimension, count)), tangents / np.linalg.norm(tangents, axis=0)])


def element_weights(model: Model) -> Floats:
    weights = model.body.vertex_weights
    return weights if model.medium.dissipation == "vertex" else integrator.edge_weights(weights, model.body.edges)


def paper_momentum(before: Floats, after: Floats, weights: Floats, eps: float) -> tuple[Floats, Floats]:
    """(sum mu_rot, sum mu_tran) of Even et al., Eq. 6, without its factor -1/2; cross products by numpy."""
    d = before.shape[0] // 2
    p, q = before[:d].T, after[:d].T

    def metric(tangents: Floats) -> Floats:
        return weights[:, None, None] * (np.eye(d) + (eps - 1) * tangents.T[:, :, None] * tangents.T[:, None, :])

    first, second, dp = metric(before[d:]), metric(after[d:]), q - p
    tran = np.einsum("kij,kj->i", (first + second) / 2, dp)
    arms, forces = np.concatenate([q, p]), np.einsum("kij,kj->ki", np.concatenate([first, second]), np.tile(dp, (2, 1)))
    if d == 2:
        return np.array([(arms[:, 0] * forces[:, 1] - arms[:, 1] * forces[:, 0]).sum()]), tran
    return np.cross(arms, forces).sum(0), tran


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("name", BODIES)
def test_momentum_is_half_the_papers_rotation_block_and_its_translation_block(name: str, dimension: int) -> None:
    model, rng = BODIES[name], np.random.default_rng(1)
    momentum = functions.step_momentum(model.structure, dimension)
    for _ in range(5):
        before, after = (random_elements(rng, dimension, model.structure.elements) for _ in range(2))
        pose = rng.normal(size=3 if dimension == 2 else 6)
        moved = np.asarray(ca.DM(energy.move(ca.DM(pose), ca.DM(after))))
        rotation, translation = paper_momentum(before, moved, element_weights(model), model.medium.anisotropy_ratio)
        expected = np.concatenate([rotation / 2, translation])
        found = momentum(before, after, pose, model.parameters).full()[:, 0]
        np.testing.assert_allclose(found, expected, atol=ROUNDING * 10)


def test_planar_momentum_agrees_with_the_oracle_that_was_written_from_the_paper() -> None:
    model, rng = reference(), np.random.default_rng(2)
    before, after = random_elements(rng, 2, 12), random_elements(rng, 2, 12)
    tensors = [integrator.dissipation_tensors(e[2:].T, model.body.vertex_weights, 0.1865) for e in (before, after)]
    rot, *tran = integrator.momentum(before[:2].T, tensors[0], after[:2].T, tensors[1])
    found = functions.step_momentum(model.structure)(before, after, np.zeros(3), model.parameters).full()[:, 0]
    np.testing.assert_allclose(found, [rot / 2, *tran], atol=ROUNDING * 10)


@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_is_the_slope_of_the_energy_along_rigid_motions(dimension: int) -> None:
    model, rng, h = reference(), np.random.default_rng(3), 1e-5
    size = 3 if dimension == 2 else 6
    before, after = random_elements(rng, dimension, 12), random_elements(rng, dimension, 12)
    pose, value = rng.normal(size=size), functions.step_energy(model.structure, dimension)
    moved = np.asarray(ca.DM(energy.move(ca.DM(pose), ca.DM(after))))

    def at(delta: Floats) -> float:
        return float(value(before, moved, delta, model.parameters))

    slopes = [(at(h * e) - at(-h * e)) / (2 * h) for e in np.eye(size)]
    expected = np.array([*slopes[dimension:], *slopes[:dimension]])
    found = functions.step_momentum(model.structure, dimension)(before, after, pose, model.parameters).full()[:, 0]
    # central differences: truncation h^2 = 1e-10, cancellation 1e-16 / h = 1e-11
    np.testing.assert_allclose(found, expected, atol=1e-9)


def energy_from_moments(phi: ca.SX, b: ca.SX, m: ca.SX) -> ca.SX:
    """Step energy at the relative pose (b, phi)."""
    e, linear, h = _polynomials(phi, m)
    return e + ca.dot(linear, b) + ca.bilin(h, b, b) / 2


def _polynomials(phi: ca.SX, m: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """e, l (2), H (2, 2) at turn phi."""
    c, s, c2, s2 = ca.cos(phi), ca.sin(phi), ca.cos(2 * phi), ca.sin(2 * phi)
    u, v = m[11] * c2 + m[12] * s2, m[11] * s2 - m[12] * c2
    x, y = m[16] * c2 - m[17] * s2, m[16] * s2 + m[17] * c2
    e = m[0] + m[1] * c + m[2] * s + m[3] * c2 + m[4] * s2
    linear = ca.vertcat(m[5] + m[6] * c + m[7] * s + u, m[8] + m[9] * c + m[10] * s + v)
    return e, linear, ca.blockcat([[m[13] + x, m[15] + y], [m[15] + y, m[14] - x]])


@pytest.mark.parametrize("name", BODIES)
def test_energy_from_the_moments_is_the_energy_of_the_elements(name: str) -> None:
    model, rng = BODIES[name], np.random.default_rng(4)
    structure = model.structure
    phi, b, m = ca.SX.sym("phi"), ca.SX.sym("b", 2), ca.SX.sym("m", planar.MOMENTS)
    reduced = ca.Function("reduced", [phi, b, m], [energy_from_moments(phi, b, m)])
    for _ in range(10):
        before, after = (random_elements(rng, 2, structure.elements) for _ in range(2))
        pose = rng.normal(size=3) * [1, 1, 3]
        moments = functions.step_moments(structure)(before, after, model.parameters)
        direct = float(functions.step_energy(structure)(before, after, pose, model.parameters))
        assert float(reduced(pose[2], pose[:2], moments)) == pytest.approx(direct, abs=ROUNDING * 10)


def test_slope_and_curvature_in_closed_form_are_derivatives_of_the_energy_with_the_translation_eliminated() -> None:
    rng, at = np.random.default_rng(6), planar.step_at()
    phi, b, m = ca.SX.sym("phi"), ca.SX.sym("b", 2), ca.SX.sym("m", planar.MOMENTS)
    energy = energy_from_moments(phi, b, m)
    hessian, gradient = ca.hessian(energy, ca.vertcat(phi, b))
    relaxed = hessian[0, 0] - ca.dot(hessian[1:, 0], ca.solve(hessian[1:, 1:], hessian[1:, 0]))
    direct = ca.Function("direct", [phi, b, m], [gradient, relaxed, energy])
    structure, model = reference().structure, reference()
    for turn in (-2.0, 0.1, 1.0):
        elements = (random_elements(rng, 2, structure.elements) for _ in range(2))
        moments = functions.step_moments(structure)(*elements, model.parameters)
        translation, slope, curvature, value = at(turn, moments)
        found = [part.full().ravel() for part in direct(turn, translation, moments)]
        np.testing.assert_allclose(found[0], [float(slope), 0, 0], atol=ROUNDING * 10)
        np.testing.assert_allclose([float(curvature), float(value)], np.concatenate(found[1:]), atol=ROUNDING * 10)


def test_at_the_root_all_three_momenta_vanish_though_only_one_equation_was_solved() -> None:
    model, rng = reference(), np.random.default_rng(5)
    step, momentum = functions.step(model.structure), functions.step_momentum(model.structure)
    table = rng.normal(size=(2, 10)) * 0.2
    elements = [functions.shape(model.structure)(row, model.parameters)[1] for row in table]
    pose, residual, curvature, _ = step(*elements, 0, model.parameters)
    assert abs(float(residual)) < 1e-12
    assert float(curvature) > 0
    assert np.abs(momentum(*elements, pose, model.parameters).full()).max() < 1e-13
