"""Dissipation laws: the formulas by hand, and where one law becomes another."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from pydantic import ValidationError

from oracle import power_laws
from oracle.chain import place
from serpenoid.effects.active import ActiveEffect
from serpenoid.errors import InputError
from serpenoid.mechanics import functions
from serpenoid.media import LAWS, Law
from serpenoid.medium import Medium
from serpenoid.model import Model
from serpenoid.simulation.steps import elements_of_vertices
from specimens import problem, reference, uneven

SHAPES = np.random.default_rng(5).normal(size=(2, 12, 2)) * 0.02 + np.linspace(-0.5, 0.5, 12)[:, None] * [1, 0]


def friction(eps: float = 0.3, softening: float = 1e-6) -> Model:
    return Model(reference().body, Medium(anisotropy_ratio=eps, law="coulomb", softening=softening))


def step_energy(model: Model, pose: np.ndarray, shapes: np.ndarray = SHAPES) -> float:
    before, after = (elements_of_vertices(model, shape[None]) for shape in shapes)
    return float(functions.step_energy(model.structure)(before, after, pose, model.parameters))


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_the_multiplier_is_the_slope_of_the_potential_and_the_degree_is_what_it_says(law: Law) -> None:
    q, s = ca.SX.sym("q"), ca.SX.sym("s")
    slope = ca.Function("slope", [q, s], [2 * ca.gradient(law.potential(q, s), q) - law.multiplier(q, s)])
    assert float(slope(0.37, 0.1)) == pytest.approx(0, abs=1e-15)
    potential = ca.Function("potential", [q, s], [law.potential(q, s)])
    # twice the slip, with a softening too small to matter
    assert float(potential(4 * 0.37, 1e-12) / potential(0.37, 1e-12)) == pytest.approx(2**law.degree)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_what_a_law_says_of_itself_is_so(law: Law) -> None:
    """Softened, linear, and what it becomes beyond any slip: sqrt(q + s^2) - s is q / (2 s), and so on."""
    q = np.array([0.2, 0.37])
    one, other = (law.potential(q, s) for s in (0.0, 0.1))
    assert law.softened == bool(np.any(one != other))
    assert law.linear == bool(np.allclose(one, q / 2))
    if law.softer is not None:
        assert law.softer.linear
        far = law.potential(q, 1e4) * law.multiplier(0 * q, 1.0) / law.multiplier(0 * q, 1e4)
        np.testing.assert_allclose(far, law.softer.potential(q, 0.0), rtol=1e-6)
    assert law.rival is None or law.rival.of in LAWS.values()


@pytest.mark.parametrize("name", LAWS)
def test_eps_is_the_force_on_a_straight_body_lengthwise_over_that_sideways(name: str) -> None:
    line = np.stack([np.linspace(-0.5, 0.5, 12), np.zeros(12)], axis=1)[None].repeat(2, axis=0)
    model = Model(reference().body, Medium(anisotropy_ratio=0.3, law=name))
    lengthwise, sideways = (step_energy(model, np.array(way), line) for way in ([0.1, 0, 0], [0, 0.1, 0]))
    assert lengthwise == pytest.approx(0.3 * sideways, rel=1e-6)  # of Coulomb's law a softening of 1e-9


def test_the_friction_energy_and_its_gradient_are_those_written_by_hand() -> None:
    model, pose = friction(), np.array([0.03, -0.05, 0.2])
    w = model.body.vertex_weights
    energy, gradient = power_laws.step_energy(pose, SHAPES[0], SHAPES[1], w, 0.3, degree=1)
    assert step_energy(model, pose) == pytest.approx(energy, abs=1e-6)  # the softening, subtracted
    before, after = (elements_of_vertices(model, shape[None]) for shape in SHAPES)
    turn, *force = functions.step_momentum(model.structure)(before, after, pose, model.parameters).full()[:, 0]
    moment = gradient[2] + pose[0] * gradient[1] - pose[1] * gradient[0]  # about the origin
    np.testing.assert_allclose([*force, turn], [gradient[0], gradient[1], moment], atol=1e-9)
    assert np.ptp([place(pose, SHAPES[1])[0], place(pose, SHAPES[1])[1]]) > 0


def test_a_straight_body_slides_most_easily_along_itself_and_its_friction_lies_on_the_ellipse() -> None:
    line = np.stack([np.linspace(-0.5, 0.5, 12), np.zeros(12)], axis=1)[None].repeat(2, axis=0)
    angles = np.linspace(0, np.pi / 2, 7)
    work = [step_energy(friction(0.3), 0.1 * np.array([np.cos(b), np.sin(b), 0]), line) for b in angles]
    # the support function of an ellipse with half axes 0.3 and 1, times the way
    np.testing.assert_allclose(work, 0.1 * np.hypot(0.3 * np.cos(angles), np.sin(angles)), atol=1e-8)
    assert np.argmin(work) == 0


def test_friction_of_slips_far_below_the_softening_is_linear_drag_with_the_square_of_the_ratio() -> None:
    softer = Medium(anisotropy_ratio=0.3, law="coulomb").model_copy(update={"softening": 1e4})  # no file may say so
    soft, pose = Model(reference().body, softer), np.array([0.01, 0.02, 0.05])
    drag = Model(reference().body, Medium(anisotropy_ratio=0.09))
    shapes = np.stack([SHAPES[0], SHAPES[0] + [0.03, 0.04]])  # all elements go 0.05 in the frame of the shapes
    # next term of sqrt(q + s^2) - s: relative size q / (4 s^2), 1e-8, of a difference that loses half the digits
    assert step_energy(soft, pose, shapes) * 0.05e4 == pytest.approx(step_energy(drag, pose, shapes), rel=1e-5)


def test_dry_friction_on_top_of_dry_friction_is_refused() -> None:
    effect = ActiveEffect.typical("dry_friction")
    with pytest.raises(
        InputError, match='does not act in a medium of law = "coulomb"; leave it out, or state law = "viscous"'
    ):
        Model(reference().body, Medium(anisotropy_ratio=0.3, law="coulomb"), (effect,), cycle_duration_s=2.0)


def test_a_problem_file_names_its_law_and_the_default_keeps_its_hash() -> None:
    plain = problem("reference")
    assert plain.hash == problem("reference", 'medium.law="viscous"').hash
    assert plain.hash == problem("reference", "medium.softening=0.5").hash
    assert plain.hash != problem("reference", 'medium.law="coulomb"').hash
    with pytest.raises(InputError, match="law"):
        problem("reference", 'medium.law="columb"')


@pytest.mark.parametrize(
    ("name", "changes", "known"),
    [
        ("reference", (), "200cab5f"),
        ("reference", ('medium.law="coulomb"',), "042785a9"),
        ("reference", ('medium.law="coulomb"', "medium.softening=0.1"), "9682bc11"),
        ("snake10", (), "5139cae4"),
        ("snake10", ('medium.law="coulomb"',), "1bbc4a4e"),
        ("broken-joint", ('medium.law="coulomb"',), "455d6e0b"),
    ],
)
def test_hashes_are_those_of_results_that_are_there(name: str, changes: tuple[str, ...], known: str) -> None:
    """Recorded before laws were listed: a folder of results is found again by them."""
    assert problem(name, *changes).hash == known


def test_uneven_bodies_have_the_law_of_their_medium() -> None:
    assert uneven().law is LAWS["viscous"]
    assert friction().law is LAWS["coulomb"]


def test_a_softening_so_large_that_the_law_is_linear_drag_is_refused() -> None:
    with pytest.raises(ValidationError, match="softening"):
        friction(softening=1.5)


def test_a_softening_below_what_a_motion_shows_is_refused() -> None:
    """A search comes to it through softer friction, each three times as soft: four hundred searches for 1e-200."""
    with pytest.raises(ValidationError, match="softening"):
        friction(softening=1e-200)


@pytest.mark.parametrize("law", LAWS.values(), ids=lambda law: law.name)
def test_the_cost_of_a_slip_is_the_work_over_the_degree(law: Law) -> None:
    """As docs/theory.md tells what share of the work `dissipation` is: half, all of it, a third."""
    across, along, eps = 0.7, 0.3, 0.2
    ratio = law.form_ratio(eps)
    m_n, m_a = law.multipliers(across, along, ratio, 0.0)
    work = m_n * across + ratio * m_a * along  # force times slip: both parts of it
    assert law.degree * law.cost(across, along, ratio, 0.0) == pytest.approx(work, rel=1e-14)
