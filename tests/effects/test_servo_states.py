"""Servos with memory and any family of gaits: their states are variables of the NLP."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from serpenoid.effects import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.gaits import EllipseGait, Gait, TableGait
from serpenoid.gaits.fourier import FourierGait
from serpenoid.gaits.spline import SplineGait
from serpenoid.mechanics.tables import family_tables
from serpenoid.model import Model
from serpenoid.optimise.solution import Solution
from serpenoid.optimise.solve import solve_from
from serpenoid.optimise.step.motion_law import motion_law, needs_states
from serpenoid.optimise.step.played import Played
from serpenoid.problem import Problem
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.servos import realise, realise_gait
from serpenoid.status import Status
from specimens import nlp_of, oracle_run, problem

CHAIN = (
    ActiveEffect.of("servo_lag", lag=0.3),
    ActiveEffect.of("servo_inertia", lag=0.2, damping=0.4),
    ActiveEffect.of("backlash", 3, width=0.1),
    ActiveEffect.of("gain_loss", 2, loss=0.2),
    ActiveEffect.of("loose_joint", 3, width=0.05),
)
LAG = 'effects=[{name="servo_lag",lag=0.3}]'
ELLIPSE = EllipseGait(sigma=0.6, a=5.0, xi=1.0)


def small(*changes: str) -> Problem:
    fixed = "body.vertices=6", "task.steps=24", "task.c=0.5", "task.cycle_duration_s=5.0"
    return problem("reference-optimum", *fixed, *changes)


def model_of(*effects: ActiveEffect) -> Model:
    return small().model_copy(update={"effects": effects}).model


def gaits() -> list[Gait]:
    table = family_tables(model_of(), ELLIPSE.of(4, 24), ELLIPSE.of(4, 24).start()[None])[0]
    return [FourierGait.from_ellipse(ELLIPSE), SplineGait.from_table(table, 8), TableGait.from_angles(table)]


@pytest.mark.parametrize("gait", gaits(), ids=lambda gait: gait.family)
@pytest.mark.parametrize("closed", [True, False])
def test_states_are_what_the_servos_let_through(gait: Gait, closed: bool) -> None:
    model = model_of(*CHAIN)
    if isinstance(gait, TableGait) and not closed:
        gait = TableGait.from_angles(np.array([*gait.angles, gait.angles[0]]))  # type: ignore[misc]
    family = gait.of(4, 24 + (not closed), closed=closed)
    q = family.start()
    table = family_tables(model, family, q[None])[0]
    played = Played(model, family)
    times = np.arange(len(table)) * model.step_duration(24)
    expected = realise_gait(model, table) if closed else realise(model, table, times).angles
    x = np.concatenate([played.start(table), q])
    layer, data = played.equations()
    free, parameters = ca.MX.sym("free", x.size), ca.DM(model.parameters)
    left = layer.value(free, ca.MX(ca.DM(data.T)), ca.MX(parameters))
    angles = played.realised().value(free, ca.MX(ca.DM(family.data.T)), ca.MX(parameters))
    both = [value.full() for value in ca.Function("both", [free], [left, angles])(x)]
    assert np.abs(both[0]).max() < 1e-12
    np.testing.assert_allclose(both[1].T, expected, atol=1e-12)


def test_servos_that_are_late_are_refused_where_no_formula_says_what_they_are_told() -> None:
    late = model_of(ActiveEffect.of("servo_delay", delay=0.1))
    motion_law(late, ELLIPSE.of(4, 24))
    for family in (TableGait().of(4, 24), ELLIPSE.of(4, 25, closed=False)):
        with pytest.raises(InputError, match="`servo_delay` is not optimised .* leave the effect out"):
            motion_law(late, family)


def test_what_a_family_has_a_formula_for_needs_no_states() -> None:
    model = model_of(*CHAIN)
    assert not needs_states(model, ELLIPSE.of(4, 24))
    assert needs_states(model, ELLIPSE.of(4, 25, closed=False))  # a transient begins at rest
    assert not needs_states(model_of(ActiveEffect.of("stuck_joint", 2, angle=0.3)), TableGait().of(4, 24))
    assert motion_law(model, TableGait().of(4, 24)).states == 24 * (4 + 4 * 2 + 2)


@pytest.mark.parametrize("gait", gaits(), ids=lambda gait: gait.family)
def test_derivatives_with_states_are_those_of_differences(gait: Gait) -> None:
    model = model_of(*CHAIN)
    nlp = nlp_of(model, 24, gait=gait, path_rows=24)
    functions, family = nlp.functions(), gait.of(4, 24)
    table = family_tables(model, family, family.start()[None])[0]
    motion = simulate_joint_angles(model, table)
    states = Played(model, family).start(table)
    x = np.concatenate([(motion.poses[1:] - motion.poses[0]).ravel(), states, family.start()])
    data = np.hstack([family.data, np.roll(family.data, -1, axis=0)])
    p = np.concatenate([[0.7], data.ravel(), model.parameters])
    assert np.abs(functions["g"](x, p).full()[: nlp.constraint_counts[0]]).max() < 1e-9
    rng = np.random.default_rng(0)
    x = x + 1e-3 * rng.normal(size=x.size)  # off the kinks of play, which the motion itself stands on
    way, lam, h = rng.normal(size=x.size), rng.normal(size=sum(nlp.constraint_counts)), 1e-6
    up, down = x + h * way, x - h * way
    change = (functions["g"](up, p) - functions["g"](down, p)).full()[:, 0] / (2 * h)
    np.testing.assert_allclose((functions["jac_g"](x, p)[1] @ way).full()[:, 0], change, atol=1e-6)

    def slope(at: np.ndarray) -> np.ndarray:
        return (1.3 * functions["grad_f"](at, p)[1] + functions["jac_g"](at, p)[1].T @ lam).full()[:, 0]

    upper = functions["hess_lag"](x, p, 1.3, lam).full()
    hessian = upper + np.triu(upper, 1).T
    np.testing.assert_allclose(hessian @ way, (slope(up) - slope(down)) / (2 * h), atol=5e-5)


@pytest.fixture(scope="module")
def lagged() -> Solution:
    return solve_from(small(LAG), ELLIPSE)


@pytest.mark.parametrize("kind", ["fourier", "spline"])
def test_larger_families_do_better_than_the_ellipse_with_servos_that_lag(kind: str, lagged: Solution) -> None:
    begin = FourierGait.from_ellipse(lagged.gait) if kind == "fourier" else SplineGait.from_table(lagged.table, 10)  # type: ignore[arg-type]
    found = solve_from(small(LAG), begin)
    assert found.status is Status.SOLVED
    assert found.polishing_gain is not None
    assert found.cost < lagged.cost
    run = oracle_run(found.problem.model, realise_gait(found.problem.model, found.table))
    assert found.cost == pytest.approx(-run.displacement + 0.5 * run.dissipation, abs=1e-9)


def test_a_free_transient_begins_at_rest_with_servos_that_lag() -> None:
    fixed = "body.vertices=5", "task.steps=24", "task.c=0.3", "task.transient=true", "task.cycle_duration_s=5.0"
    wanted = problem("reach", *fixed, LAG, 'task.objectives=[{kind="position",target=[0.5,0.0],weight=5.0}]')
    found = solve_from(wanted, TableGait.from_angles(TableGait().of(3, 25, closed=False).sample(
        np.random.default_rng(1)).reshape(25, 3)))  # fmt: skip
    assert found.residuals.largest <= 1e-8
    assert found.resimulation_error <= 1e-8
    assert np.hypot(*(found.trajectory.poses[-1, :2] - [0.5, 0.0])) < 0.1


def test_play_with_splines_is_certified() -> None:
    play = small('effects=[{name="backlash",place=2,width=0.1}]')
    first = solve_from(play, ELLIPSE)
    found = solve_from(play, SplineGait.from_table(first.table, 10))
    assert found.status is Status.SOLVED
    assert found.cost < first.cost
