"""The family over c, on an exact family of optima: -Delta + c D is least at x = c / (1 + c)."""

import numpy as np
import pytest
from matplotlib.figure import Figure

from serpenoid.performance import between
from serpenoid.plot import family as panels
from serpenoid.plot import transport
from serpenoid.plot.family import Family
from serpenoid.plot.figures import sweep_figures


@pytest.fixture
def ax():
    return Figure().add_subplot()


def test_the_least_cost_of_transport_is_where_the_first_order_condition_says(family):
    fine = np.linspace(0.5, 2.5, 2001)
    x = fine / (1 + fine)
    dense = Family(fine, 1 - x**2 / 2, (1 - x) ** 2 / 2, np.zeros((fine.size, 6)))
    for c in (0.8, 1.5, 2.2):
        p = np.interp(c, fine, transport.best_idle(dense))
        cost = (p + dense.dissipation) / dense.displacement
        assert fine[cost.argmin()] == pytest.approx(c, abs=2e-3)  # the grid's spacing, twice


def test_idle_levels_fall_as_c_grows_and_bracket_the_interval(family):
    ends = transport.idle_interval(family)
    assert ends == pytest.approx((7 / 18 - 1 / 18, 7 / 8 - 1 / 8))  # Delta / c - D at c = 2 and 1 by hand
    assert (np.diff(transport.best_idle(family)) < 0).all()
    short = Family(*(values[:15] for values in (family.c, family.displacement, family.dissipation, family.gaits)))
    assert transport.idle_interval(short) is None


def test_gaits_on_either_side_of_an_interval_tell_no_idle_level_in_it(family):
    """At c = 5 the best is to stand still: between a gait that moves and none nothing is known; p is never below 0."""
    ends = Family(np.array([0.0, 5.0]), np.array([0.19, 6e-11]), np.array([0.26, 2e-11]), np.zeros((2, 6)))
    assert transport.idle_interval(ends) is None
    stops = Family(
        family.c, *(np.where(family.c < 1.95, v, 0.0) for v in (family.displacement, family.dissipation)), family.gaits
    )
    assert transport.idle_interval(stops) == pytest.approx((0.0, 7 / 8 - 1 / 8))


def test_a_gait_that_stands_still_has_no_cost_of_transport(family, tmp_path):
    stops = np.where(family.c < 1.95, family.displacement, 5e-11)
    moves = Family(family.c, stops, family.dissipation, family.gaits).moving()
    np.testing.assert_array_equal(moves.c, family.c[family.c < 1.95])
    few = Family(*(v[[0, -1]] for v in (family.c, stops, family.dissipation, family.gaits)))
    names = sweep_figures(tmp_path, few)
    assert {name.split(".")[0] for name in names} == {"family", "pareto"}


def test_cost_of_transport_panel_draws_the_costs_and_stars_their_least(family, ax):
    transport.cost_of_transport(family, ax, [0.5])
    cost = (0.5 + family.dissipation) / family.displacement
    np.testing.assert_array_equal(ax.lines[1].get_ydata(), cost)
    fine = np.linspace(family.c[0], family.c[-1], 4001)  # the family's own law: the least may lie between two gaits
    x = fine / (1 + fine)
    true = (0.5 + (1 - x) ** 2 / 2) / (1 - x**2 / 2)
    assert ax.lines[2].get_ydata()[0] == pytest.approx(true.min(), rel=1e-4)
    assert ax.lines[2].get_xdata()[0] == pytest.approx(fine[true.argmin()], abs=0.02)


@pytest.mark.parametrize(("p", "inside"), [(0.0, False), (0.5, True)])
def test_a_least_beyond_the_sweep_is_starred_at_its_end_however_few_gaits_there_are(family, ax, p, inside):
    """Curves through six gaits are too flat to tell; where p = Delta / c - D is not."""
    few = Family(*(values[::5] for values in (family.c, family.displacement, family.dissipation, family.gaits)))
    transport.cost_of_transport(few, ax, [p])
    assert (ax.lines[2].get_xdata()[0] < few.c[-1]) == inside
    assert (str(ax.lines[2].get_markerfacecolor()) != "white") == inside


def test_few_gaits_are_joined_by_a_curve_and_not_by_its_corners(family):
    """The family's own law says what lies between six gaits; the curve goes through all of them."""
    few = Family(*(values[::5] for values in (family.c, family.displacement, family.dissipation, family.gaits)))
    along = few.between()
    x = along.c / (1 + along.c)
    cost = (0.5 + (1 - x) ** 2 / 2) / (1 - x**2 / 2)
    joined = np.interp(along.c, few.c, (0.5 + few.dissipation) / few.displacement)
    for draw in (lambda ax: transport.cost_of_transport(few, ax, [0.5]), lambda ax: transport.idle_levels(few, ax)):
        ax = Figure().add_subplot()
        draw(ax)
        assert len(ax.lines[0].get_xdata()) > 200
        assert set(ax.lines[1].get_xdata()) <= set(ax.lines[0].get_xdata())
    drawn = (0.5 + along.dissipation) / along.displacement
    assert np.abs(drawn - cost).max() < np.abs(joined - cost).max() / 2


def square_root(c):
    """D falls to nothing at c = 0.27, ever faster; Delta = c D - V, V its integral."""
    left = np.sqrt(1 - c / 0.27)
    return c * left + 0.18 * left**3, left


def cubed(c):
    """D = 1 / (1 + c)^3 falls fast at first."""
    return c / (1 + c) ** 3 + 0.5 / (1 + c) ** 2, 1 / (1 + c) ** 3


@pytest.mark.parametrize(("law", "last"), [(square_root, 0.26), (cubed, 2.5)])
@pytest.mark.parametrize("count", [3, 5, 9])
def test_few_gaits_tell_where_the_cost_of_transport_is_least_and_how_large_it_is(law, last, count):
    """Along the curve Delta' = c D', so the drawn least is at p = Delta / c - D: where the family's own law has it."""
    c, fine = np.linspace(0, last, count), np.linspace(0, last, 4001)
    delta, spent = law(c)
    far, work = law(fine)
    for p in (0.1, 0.3):
        ax = Figure().add_subplot()
        transport.cost_of_transport(Family(c, delta, spent, np.zeros((count, 6))), ax, [p])
        (at,), (least,) = ax.lines[2].get_data()
        true = (p + work) / far
        assert least == ax.lines[0].get_ydata().min()
        assert at == pytest.approx(fine[true.argmin()], abs=0.25 * last / (count - 1))  # a quarter of the spacing
        assert least == pytest.approx(true.min(), rel=0.25 / (count - 1) ** 2)  # of second order
        assert least > 0.998 * true.min()  # no dip where no gait is


@pytest.mark.parametrize("law", [square_root, cubed])
def test_between_gaits_the_curve_obeys_what_optima_obey_and_is_exact_at_them(law):
    c = np.array([0.0, 0.03, 0.1, 0.11, 0.26])
    delta, spent = law(c)
    went, work = between(c, delta, spent, c)
    np.testing.assert_allclose([went, work], [delta, spent], rtol=0, atol=1e-14)  # rounding
    fine = np.linspace(0, 0.26, 20001)
    went, work = between(c, delta, spent, fine)
    assert (np.diff(work) < 0).all()
    middle = (fine[1:] + fine[:-1]) / 2
    np.testing.assert_allclose(np.diff(went), middle * np.diff(work), rtol=0, atol=1e-8)  # Delta' = c D', by midpoints


def test_a_family_of_other_goals_stays_between_its_gaits_and_its_star_lies_on_the_curve(ax):
    """Displacement is prescribed: nothing is known of what lies between, and D is drawn within its neighbours."""
    c, spent = np.array([0.5, 1.0, 1.5, 2.0]), np.array([0.3, 0.2, 0.25, 0.2])
    went, work = between(c, np.full(4, 0.1), spent, fine := np.linspace(0.5, 2, 301))
    np.testing.assert_allclose(went, 0.1, rtol=1e-14)
    np.testing.assert_array_equal(between(c, np.full(4, 0.1), spent, c)[1], spent)
    assert work.min() >= 0.2
    assert work[fine > 1].max() <= 0.25
    transport.cost_of_transport(Family(c, np.full(4, 0.1), spent, np.zeros((4, 6))), ax, [0.5])
    assert ax.lines[2].get_ydata()[0] == ax.lines[0].get_ydata().min()


def test_pareto_panel_draws_every_gait_and_joins_the_front(family, ax):
    worse = Family(family.c, family.displacement.copy(), family.dissipation, family.gaits)
    worse.displacement[5] = 0.1
    panels.pareto(worse, ax)
    points = ax.collections[0].get_offsets()
    np.testing.assert_array_equal(points, np.column_stack([worse.dissipation, worse.displacement]))
    assert len(ax.lines[0].get_xdata()) == 25


@pytest.mark.parametrize(("name", "column"), [("sigma", 0), ("a", 4), ("xi", 5)])
def test_gait_parameter_panels(family, ax, name, column):
    panels.gait_parameters(family, ax, name)
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), family.gaits[:, column])


def test_mirror_images_are_drawn_on_one_side(family, ax):
    gaits = family.gaits.copy()
    gaits[:, 1], gaits[:, 2] = 1.0, 0.5
    gaits[1::2, 1:3] *= -1
    panels.gait_curves(Family(family.c, family.displacement, family.dissipation, gaits), ax)
    centres = [np.mean(np.column_stack(line.get_data())[:-1], axis=0) for line in ax.lines[:26]]
    np.testing.assert_allclose(centres, np.tile([1.0, 0.5], (26, 1)), atol=1e-12)  # rounding of a mean of O(10)


def test_failures_are_left_out_and_order_does_not_matter(family):
    displacement = family.displacement.copy()
    displacement[3] = np.nan
    back = Family(family.c[::-1], displacement[::-1], family.dissipation[::-1], family.gaits[::-1]).solved()
    np.testing.assert_array_equal(back.c, np.delete(family.c, 3))
    np.testing.assert_array_equal(back.dissipation, np.delete(family.dissipation, 3))


def test_pareto_panel_does_not_magnify_the_rounding_of_a_prescribed_displacement(family, ax):
    same = 1.2 + 1e-13 * np.arange(family.c.size)
    panels.pareto(Family(family.c, same, family.dissipation, family.gaits), ax)
    low, high = ax.get_ylim()
    assert high - low > 0.1
    assert low < same.min() < same.max() < high
