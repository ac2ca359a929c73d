"""The NLP's assembled derivatives are CasADi's own of a transcription in one piece, and finite differences.

Legend: T steps, K path rows, x variables (3 T poses, 6 gait parameters), p parameters (c, K phases, model).
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np
import pytest

from serpenoid.body import Body, Floats
from serpenoid.gaits import EllipseGait
from serpenoid.mechanics import functions
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.objectives import Criteria
from serpenoid.optimise.step.blocks import Cycle
from serpenoid.optimise.step.extended import extended_blocks, settings
from serpenoid.optimise.step.joint_blocks import baseline_blocks
from specimens import nlp_of, phases_of_rows, reference, uneven

pytestmark = pytest.mark.usefixtures("virtual_machine")
STEPS, ROWS = 5, 3
GAIT = np.array([0.6, 0.5, -0.8, 0.3, 4.0, 1.1])
ROUNDING = 1e-11  # second derivatives reach 1e3 here (T^2, amplitudes of 4); 1e-14 of that, and sums of a hundred terms

MODELS = {
    "five vertices": Model(Body(vertices=5), Medium(anisotropy_ratio=0.2)),
    "uneven, vertices": uneven("vertex"),
    "uneven, edges": uneven("edge"),
    "three links": Model(Body(vertices=7, joints=(2, 4)), Medium(anisotropy_ratio=0.5, dissipation="edge")),
}
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)


@dataclass
class Direct:
    """f, g and their derivatives from one SX graph: nothing of the NLP's blocks, layers and assembly is used."""

    values: ca.Function
    derivatives: ca.Function


def direct(model: Model, c: float, phases: Floats) -> Direct:
    structure, m = model.structure, model.structure.elements
    x, parameters = ca.SX.sym("x", 3 * STEPS + 6), ca.DM(model.parameters)
    q, poses = x[3 * STEPS :], ca.horzcat(ca.SX.zeros(3, 1), ca.reshape(x[: 3 * STEPS], 3, STEPS))
    angles = functions.gait_joint_angles(structure, EllipseGait().of(len(structure.joints), STEPS))
    rows = [functions.shape(structure)(angles(q, t / STEPS, parameters), parameters)[1] for t in range(STEPS + 1)]
    before, after, pose = ca.SX.sym("before", 4, m), ca.SX.sym("after", 4, m), ca.SX.sym("pose", 3)
    value = functions.step_energy(structure)(before, after, pose, parameters)
    step = ca.Function("step", [before, after, pose], [value, ca.gradient(value, pose)])
    total, residuals = ca.SX(0), []
    for t in range(STEPS):
        relative = functions.relative_pose()(poses[:, t], poses[:, t + 1])
        value, slope = step(rows[t], rows[t + 1], relative)
        total += value
        residuals.append(STEPS * slope)
    path = []
    for phase in phases:
        here, there = angles(q, phase, parameters), angles(q, phase + 1 / STEPS, parameters)
        path += [here, there - here]
    f = -ca.norm_2(poses[:2, -1]) + c * STEPS * total
    g = ca.vertcat(*residuals, *path)
    factor, multipliers = ca.SX.sym("factor"), ca.SX.sym("multipliers", g.numel())
    hessian = ca.triu(ca.hessian(factor * f + ca.dot(multipliers, g), x)[0])
    return Direct(
        ca.Function("values", [x], [f, g]),
        ca.Function("derivatives", [x, factor, multipliers], [ca.gradient(f, x), ca.jacobian(g, x), hessian]),
    )


def point(seed: int) -> Floats:
    """Poses near no root, and a gait."""
    rng = np.random.default_rng(seed)
    return np.concatenate([0.2 * rng.normal(size=3 * STEPS), GAIT + 0.1 * rng.normal(size=6)])


@every_model
def test_values_jacobian_and_hessian_are_casadis_own_of_the_same_equations(model: Model) -> None:
    c, phases = 0.7, np.array([0.0, 0.4, 0.8])
    nlp = nlp_of(model, STEPS, ROWS)
    made, expected = nlp.functions(), direct(model, c, phases)
    p = np.concatenate([[c], phases_of_rows(phases, STEPS), model.parameters])
    for seed in range(3):
        x, rng = point(seed), np.random.default_rng(seed)
        factor, multipliers = 1.7, rng.normal(size=sum(nlp.constraint_counts))
        f, g = expected.values(x)
        gradient, jacobian, hessian = expected.derivatives(x, factor, multipliers)
        pairs = [
            (made["f"](x, p), f),
            (made["g"](x, p), g),
            (made["grad_f"](x, p)[0], f),
            (made["grad_f"](x, p)[1], gradient),
            (made["jac_g"](x, p)[0], g),
            (made["jac_g"](x, p)[1], jacobian),
            (made["hess_lag"](x, p, factor, multipliers), hessian),
        ]
        for found, wanted in pairs:
            np.testing.assert_allclose(ca.densify(found).full(), ca.densify(wanted).full(), atol=ROUNDING, rtol=1e-11)


@every_model
def test_derivatives_are_finite_differences_of_the_functions(model: Model) -> None:
    nlp = nlp_of(model, STEPS, ROWS)
    made, x, h = nlp.functions(), point(7), 1e-6
    p = np.concatenate([[0.7], phases_of_rows([0.0, 0.4, 0.8], STEPS), model.parameters])
    rng = np.random.default_rng(8)
    multipliers, direction = rng.normal(size=sum(nlp.constraint_counts)), rng.normal(size=x.size)

    def difference(name: str, index: int) -> Floats:
        ahead, behind = (made[name](x + s * h * direction, p)[index].full()[:, 0] for s in (1, -1))
        return (ahead - behind) / (2 * h)

    jacobian, upper = made["jac_g"](x, p)[1].full(), made["hess_lag"](x, p, 1.0, multipliers).full()
    # truncation h^2 times third derivatives (1e4), cancellation 1e-15 / h: both 1e-8
    np.testing.assert_allclose(jacobian @ direction, difference("jac_g", 0), atol=1e-7)
    np.testing.assert_allclose(made["grad_f"](x, p)[1].full()[:, 0] @ direction, difference("grad_f", 0)[0], atol=1e-7)

    def lagrangian_slope(y: Floats) -> Floats:
        return (made["grad_f"](y, p)[1] + made["jac_g"](y, p)[1].T @ multipliers).full()[:, 0]

    hessian = upper + np.triu(upper, 1).T
    slope = (lagrangian_slope(x + h * direction) - lagrangian_slope(x - h * direction)) / (2 * h)
    np.testing.assert_allclose(hessian @ direction, slope, atol=2e-6)


def test_the_hessian_has_no_entry_between_steps_that_do_not_touch() -> None:
    nlp = nlp_of(MODELS["five vertices"], 20)
    pattern = nlp.functions()["hess_lag"].sparsity_out(0)
    rows, column = (np.array(indices) for indices in pattern.get_triplet())
    poses = (rows < 60) & (column < 60)
    assert np.abs(rows[poses] // 3 - column[poses] // 3).max() <= 1
    assert (rows <= column).all()


def test_terms_of_the_users_own_get_exact_derivatives_too() -> None:
    model = MODELS["uneven, vertices"]

    def own(of: Criteria) -> None:
        of.also_minimise(0.3 * of.dissipation + ca.sumsqr(of.joint_angles))
        of.subject_to(of.heading_change**2 + of.displacement, 0.0, 1.0)
        of.subject_to(of.gait[4] * of.gait[0], -1.0, 9.0)

    nlp = nlp_of(model, STEPS, customise=own)
    made, x = nlp.functions(), point(9)
    p = np.concatenate([[0.7], model.parameters])
    plain = nlp_of(model, STEPS).functions()
    # c = 0.7 + 0.3 is the same objective
    shifted = np.concatenate([[1.0], model.parameters])
    q = ca.SX.sym("x", x.size)
    table = functions.gait_joint_angles(model.structure, EllipseGait().of(model.body.joint_count, STEPS))
    rows = [table(q[3 * STEPS :], t / STEPS, ca.DM(model.parameters)) for t in range(STEPS)]
    squares = ca.sumsqr(ca.vertcat(*rows))
    value, slope = ca.Function("extra", [q], [squares, ca.gradient(squares, q)])(x)
    assert float(made["f"](x, p)) == pytest.approx(float(plain["f"](x, shifted) + value), rel=1e-12)
    expected = (plain["grad_f"](x, shifted)[1] + slope).full()
    np.testing.assert_allclose(made["grad_f"](x, p)[1].full(), expected, atol=ROUNDING)
    added = made["g"](x, p).full()[-2:, 0]
    heading, last = x[3 * STEPS - 1], x[3 * STEPS - 3 : 3 * STEPS - 1]
    gait = x[3 * STEPS :]
    np.testing.assert_allclose(added, [heading**2 + np.hypot(*last), gait[4] * gait[0]], rtol=1e-12)


def test_the_momentum_constraints_vanish_exactly_on_simulated_motions() -> None:
    from serpenoid.mechanics.tables import joint_table
    from serpenoid.simulation import simulate_joint_angles

    for model in MODELS.values():
        nlp = nlp_of(model, 20)
        motion = simulate_joint_angles(model, joint_table(model, GAIT, 20))
        x = np.concatenate([motion.poses[1:].ravel(), GAIT])
        g = nlp.functions()["g"](x, np.concatenate([[0.5], model.parameters])).full()
        assert np.abs(g).max() < 20 * 1e-12  # T times the root finder's tolerance
        f = float(nlp.functions()["f"](x, np.concatenate([[0.5], model.parameters])))
        assert f == pytest.approx(-motion.displacement + 0.5 * motion.dissipation, abs=1e-12)


@pytest.mark.parametrize("body", [reference().body, uneven().body], ids=["reference", "uneven"])
def test_the_law_of_effects_without_any_is_the_slope_of_the_energy_written_out(body: Body) -> None:
    """Forces of every element (`extended.wrench`) beside derivatives of the step energy (`plain_element`)."""
    model, steps, rng = Model(body, reference().medium, (), 5.0), 4, np.random.default_rng(8)
    poses = np.hstack([np.zeros((3, 1)), rng.normal(size=(3, steps))])
    shapes = 0.4 * rng.normal(size=(len(model.structure.joints), steps))
    found = []
    for blocks, more in (
        (baseline_blocks(model.structure), None),
        (extended_blocks(model, steps), settings(model, steps)),
    ):
        values, energies = blocks.value(Cycle(ca.MX(poses), ca.MX(shapes), True, ca.MX(model.parameters), more))
        found.append([ca.evalf(x).full() for x in (values, energies)])
    (slopes, energies), (wrenches, same) = found
    x, y = poses[:2, 1:]
    about_origin = slopes[2] + x * slopes[1] - y * slopes[0]
    np.testing.assert_allclose(wrenches[:3], [slopes[0], slopes[1], about_origin], atol=1e-13)
    np.testing.assert_allclose(same, energies, atol=1e-13)
