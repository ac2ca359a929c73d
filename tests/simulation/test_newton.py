"""One Newton's method for all steps: alone, in chains, in space; what is faster beside it finds the same roots."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.effects.active import ActiveEffect
from serpenoid.mechanics.compile import find_compiler
from serpenoid.mechanics.substitution import banded, substituted
from serpenoid.media import LAWS
from serpenoid.model import Model
from serpenoid.simulation import balance, sensitivity
from serpenoid.simulation.balance import Placed, solve_balance, solve_near
from serpenoid.simulation.chain import Chain, solve_chain, solve_chains
from serpenoid.simulation.inertia import carried, coefficients, matrix
from serpenoid.simulation.law import MediumNumbers
from serpenoid.simulation.newton import TOLERANCE, State, at_root, implicit_derivative, newton, solution
from serpenoid.simulation.sensitivity import MeasuredSteps, sensitivities_of
from serpenoid.simulation.steps import shape_rows, solve_steps
from specimens import reference, serpenoid_table, uneven

SAME = 1e-11  # roots of residuals below 1e-12, of steps whose smallest stiffness is a tenth of the largest


@pytest.mark.parametrize("model", [reference(), uneven()], ids=["reference", "uneven"])
def test_the_step_by_moments_is_the_root_of_the_forces_alone_and_in_a_chain(model: Model) -> None:
    """The accelerator (18 moments of the step energy) beside the law of every element: two derivations, one motion."""
    table = serpenoid_table(model, 20)
    _, elements = shape_rows(model, np.concatenate([table, table[:1]]))
    m, times = model.structure.elements, np.linspace(0, 1, 21)
    before, after, rest = elements[:, :-m], elements[:, m:], np.zeros((20, 3))
    by_moments = solve_steps(model, before, after)
    spans = np.column_stack([times[:-1], times[1:]])
    alone = solve_balance(model, Placed(before, after, spans, rest), rest)
    chained = solve_chain(model, before, after, times, np.array([0.3, -0.2, 1.0]), rest)
    for found in (alone, chained):
        assert found.sound.all()
        assert found.residual.max() <= TOLERANCE
        np.testing.assert_allclose(found.relative, by_moments.relative, atol=SAME)
        np.testing.assert_allclose(found.energy, by_moments.energy, rtol=1e-12)


@pytest.mark.skipif(not find_compiler(), reason="no C compiler here")
@pytest.mark.parametrize("law", LAWS)
def test_lanes_that_are_refilled_find_the_roots_of_steps_side_by_side(law: str) -> None:
    """150 steps in C, from a guess that is far off, and some that have no root: the same ones, step for step."""
    begun = reference()
    effects = ActiveEffect.typical("dry_friction"), ActiveEffect.typical("slope")
    model = Model(
        begun.body, begun.medium.model_copy(update={"law": law, "softening": 0.1}), effects[law != "viscous" :]
    )
    table = serpenoid_table(model, 150)
    _, elements = shape_rows(model, np.concatenate([table, table[:1]]))
    m, times = model.structure.elements, np.linspace(0, 3, 151)
    before, after = elements[:, :-m].copy(), elements[:, m:].copy()
    after[0, 70 * m] = np.nan
    rng = np.random.default_rng(1)
    starts, near = rng.normal(size=(150, 3)), 0.1 * rng.normal(size=(150, 3))
    spans = np.column_stack([times[:-1], times[1:]])
    coast = balance.Coast(rng.uniform(size=150), 1e-3 * rng.normal(size=(150, 3)))
    steps = Placed(before, after, spans, starts, coast)
    wide = solve_near(model, steps, near)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(balance, "roots", lambda *_: None)
        plain = solve_near(model, steps, near)
    assert np.array_equal(wide.sound, plain.sound)
    assert 30 < wide.sound.sum() < 150
    assert not wide.sound[70]
    for name in ("relative", "energy", "slopes"):
        one, other = (getattr(found, name)[plain.sound] for found in (wide, plain))
        np.testing.assert_allclose(one, other, rtol=0, atol=SAME * np.abs(other).max())


@pytest.mark.skipif(not find_compiler(), reason="no C compiler here")
def test_columns_asked_for_are_those_of_all_derivatives() -> None:
    """Some with a place and some without, of 100 steps, two of which are no numbers."""
    begun = reference()
    effects = tuple(ActiveEffect.typical(*e) for e in (("dry_friction", None), ("worn_wheel", 2), ("slope", None)))
    model, rng = Model(begun.body, begun.medium, effects), np.random.default_rng(2)
    table = serpenoid_table(model, 100)
    vertices, _ = shape_rows(model, np.concatenate([table, table[:1]]))
    candidates = [ActiveEffect.neutral("worn_wheel", k) for k in (0, 7)]
    steps = MeasuredSteps.of(model, vertices, np.linspace(0, 2, 101), rng.normal(size=(101, 3)))
    steps.after[0, 50 * model.structure.elements] = np.nan
    wide = sensitivities_of(model, steps, candidates)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sensitivity, "root_columns", lambda *_: None)
        plain = sensitivities_of(model, steps, candidates)
    assert wide.columns == plain.columns
    assert wide.sound.sum() == 98
    np.testing.assert_allclose(wide.jacobian, plain.jacobian, rtol=0, atol=SAME * np.nanmax(np.abs(plain.jacobian)))


@pytest.mark.parametrize("effects", [(), (ActiveEffect.typical("slope"),)], ids=["plain", "slope"])
def test_a_body_that_hardly_moves_has_its_roots_on_dry_friction(effects: tuple[ActiveEffect, ...]) -> None:
    """Rounding of places, times a stiffness of a million: residuals above the tolerance at roots that are right."""
    begun, rng = reference(), np.random.default_rng(3)
    model = Model(begun.body, begun.medium.model_copy(update={"law": "coulomb", "softening": 0.01}), effects)
    resting = serpenoid_table(model, 4)[:1] + 1e-5 * rng.normal(size=(400, model.body.joint_count))
    vertices, _ = shape_rows(model, resting)
    found = sensitivities_of(model, MeasuredSteps.of(model, vertices, np.arange(400) / 100, np.zeros((400, 3))))
    assert found.sound.all()
    assert np.isfinite(found.jacobian).all()


def test_what_a_residual_is_worth_as_a_motion_decides() -> None:
    slopes = np.array([np.eye(3), 1e6 * np.eye(3), np.diag([1e6, 1e6, 1.0]), np.full((3, 3), np.nan)])
    assert at_root(np.array([2e-12, 2e-12, 2e-12, 2e-12]), slopes).tolist() == [False, True, False, False]
    assert at_root(np.full(4, 1e-12), slopes).all()


def pulled(loads: Floats, ages: int) -> tuple[Floats, State]:
    """Roots of x_i + |x_i|^2 x_i - x_{i-1} / 2 = load_i (without the neighbour: one age), and the state there."""

    def equations(x: Floats, steps: np.ndarray) -> State:
        n, d = x.shape
        own = (1 + (x**2).sum(1))[:, None, None] * np.eye(d) + 2 * x[:, :, None] * x[:, None]
        slopes = np.zeros((ages, n, d, d))
        slopes[0] = own
        behind = np.vstack([np.zeros((1, d)), x[:-1]]) if ages > 1 else np.zeros_like(x)
        if ages > 1:
            slopes[1, 1:] = -np.eye(d) / 2
        residual = (1 + (x**2).sum(1))[:, None] * x - behind / 2 - loads[steps]
        return State(residual, slopes, (x.sum(1),))

    return newton(equations, np.zeros_like(loads), np.array([len(loads)]) if ages > 1 else None)


@pytest.mark.parametrize("ages", [1, 2])
@pytest.mark.parametrize("unknowns", [3, 6])
def test_roots_and_their_derivatives_by_what_they_depend_on(ages: int, unknowns: int) -> None:
    rng = np.random.default_rng(unknowns)
    loads, way = rng.normal(size=(7, unknowns)), rng.normal(size=(7, unknowns))
    x, state = pulled(10 * loads, ages)
    assert state.size.max() <= TOLERANCE
    np.testing.assert_allclose(state.more[0], x.sum(1))  # what comes along belongs to the root
    assert state.resisting.all()
    by = implicit_derivative(state.slopes, -way[..., None])[..., 0]
    step = 1e-5
    ends = [pulled(10 * loads + sign * step * way, ages)[0] for sign in (1, -1)]
    np.testing.assert_allclose(by, (ends[0] - ends[1]) / (2 * step), atol=1e-8)  # third derivatives times step^2


def test_a_step_that_has_no_root_does_not_spoil_its_neighbours() -> None:
    def equations(x: Floats, steps: np.ndarray) -> State:
        offset = np.where(steps == 1, 1.0, -1.0)[:, None]  # x^2 + 1 has no root
        undefined = np.where(steps == 2, np.nan, 0.0)[:, None]
        return State(x**2 + offset + undefined, (2 * x)[None, :, :, None])

    x, state = newton(equations, np.full((4, 1), 3.0))
    np.testing.assert_allclose(x[[0, 3], 0], 1.0)
    assert state.size[0] <= TOLERANCE
    assert 1.0 <= state.size[1] < 1.1
    assert state.size[2] == np.inf


def test_a_singular_system_is_a_short_step_alone_and_none_in_a_chain() -> None:
    right = np.ones((2, 3, 1))
    np.testing.assert_array_equal(solution(np.zeros((1, 2, 3, 3)), right), right)
    np.testing.assert_array_equal(solution(np.zeros((2, 2, 3, 3)), right), 0.0)


def test_forward_substitution_is_the_banded_solution_chain_by_chain() -> None:
    rng = np.random.default_rng(1)
    slopes, right, chains = rng.normal(size=(4, 9, 3, 3)), rng.normal(size=(9, 3, 2)), np.array([5, 1, 3])
    slopes[0] += 5 * np.eye(3)  # far from singular: rounding is all that differs
    slopes[0, 5] = 0.0  # the chain of one step is singular
    found = substituted(slopes, right, chains)
    for part in (slice(0, 5), slice(5, 6), slice(6, 9)):
        np.testing.assert_allclose(found[part], banded(slopes[:, part], right[part]), rtol=1e-12, atol=1e-13)
    assert not found[5].any()


def test_motions_side_by_side_are_those_alone() -> None:
    """Two bodies with momentum, one of which begins in motion; windows of different lengths."""
    plain = reference()
    model = Model(plain.body, plain.medium, (ActiveEffect.of("inertia", relaxation_time=0.05),))
    table = serpenoid_table(model, 20)
    _, elements = shape_rows(model, np.concatenate([table, table[:1]]))
    m, motions = model.structure.elements, []
    for rows, start in ((21, np.zeros((1, 3))), (13, group.accumulate(np.full((2, 3), 0.01)))):
        times, every = np.linspace(0, 1, rows), elements[:, : m * rows]
        law, spans = MediumNumbers.of(model), np.column_stack([times[:-1], times[1:]])
        chain = Chain.of(law, every[:, :-m], every[:, m:], spans, coefficients(times))
        motions.append((chain, start, np.zeros((rows - 1, 3))))
    together = solve_chains(model, *zip(*motions, strict=True))
    for motion, found in zip(motions, together, strict=True):
        alone = solve_chains(model, *([part] for part in motion))[0]
        assert found.sound.all()
        np.testing.assert_allclose(found.relative, alone.relative, atol=SAME)


def test_impulses_are_the_matrix_of_the_nlp_and_sum_to_the_last_momentum() -> None:
    """A constant momentum, once there, costs no impulse; all impulses add up to it, on uneven steps too."""
    times = np.cumsum([0.0, 0.1, 0.1, 0.25, 0.1, 0.05, 0.2])
    c, momenta = coefficients(times), np.random.default_rng(3).normal(size=(6, 3))
    impulses = c[:, :1] * momenta + carried(c, momenta)
    np.testing.assert_allclose(matrix(c) @ momenta, impulses, atol=1e-14)
    steady = np.ones((6, 1))
    np.testing.assert_allclose((matrix(c) @ steady)[2:], 0.0, atol=1e-14)
    np.testing.assert_allclose((matrix(c) @ steady).sum(), 1.0, atol=1e-14)


def test_poses_in_each_others_frames_compose_back() -> None:
    first, second = np.random.default_rng(4).normal(size=(2, 9, 3))
    np.testing.assert_allclose(group.compose(first, group.relative(first, second)), second, atol=1e-14)
