"""C over many columns at once: the same numbers as CasADi's, whatever the columns and the registers."""

from __future__ import annotations

import ctypes

import casadi as ca
import numpy as np
import pytest

from serpenoid.mechanics import columns, lanes
from serpenoid.mechanics.columns import over_columns
from serpenoid.mechanics.compile import find_compiler
from specimens import forget_functions

needs_compiler = pytest.mark.skipif(not find_compiler(), reason="no C compiler here")
ROUNDING = 4e-16  # two units in the last place of a number near one


def waves() -> ca.Function:
    """Sine and cosine of a column times a shared number."""
    x, frequency = ca.SX.sym("x"), ca.SX.sym("frequency")
    return ca.Function("waves", [x, frequency], [ca.sin(frequency * x), ca.cos(frequency * x)])


@needs_compiler
@pytest.mark.parametrize("largest", [1e-3, 4.0, 1e3, 1e6])
def test_the_polynomial_sine_is_the_sine(largest: float) -> None:
    x = np.concatenate([largest * np.linspace(-1, 1, 4001), np.arange(-8, 9) * np.pi / 2, [0.0, -0.0]])
    sine, cosine = over_columns(waves())(x[:, None], np.ones(1))
    assert np.abs(sine[0] - np.sin(x)).max() <= ROUNDING
    assert np.abs(cosine[0] - np.cos(x)).max() <= ROUNDING


@needs_compiler
def test_exponentials_logarithms_powers_and_angles_are_those_of_the_c_library() -> None:
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y")
    a, b = x.elements()
    values = [ca.exp(a), ca.log(b), ca.power(b, a / 400), ca.atan2(a, b), b ** (2 / 3)]
    function = ca.Function("five", [x, y], values)
    rng = np.random.default_rng(4)
    given = np.column_stack([rng.uniform(-700, 700, 5000), np.exp(rng.uniform(-300, 300, 5000))])
    given[:4] = [[0.0, 1.0], [-1.0, 1e-300], [1.0, 0.5], [0.0, 3.0]]
    exponential, logarithm, power, angle, fixed = (f[0] for f in over_columns(function)(given, np.ones(1)))
    a, b = given.T
    np.testing.assert_allclose(exponential, np.exp(a), rtol=4 * ROUNDING)
    np.testing.assert_allclose(logarithm, np.log(b), rtol=4 * ROUNDING, atol=ROUNDING)
    # rounding of y log(x), up to 525, counts
    np.testing.assert_allclose(power, b ** (a / 400), rtol=1000 * ROUNDING)
    np.testing.assert_allclose(fixed, b ** (2 / 3), rtol=400 * ROUNDING)
    np.testing.assert_allclose(angle, np.arctan2(a, b), rtol=4 * ROUNDING)


@needs_compiler
def test_choices_are_those_of_casadi() -> None:
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y")
    a, b = x.elements()
    chosen = [ca.fmin(a, b), ca.fmax(a, b), ca.fabs(a), ca.sign(a), ca.if_else(a < b, a, b), ca.if_else(a <= b, y, b)]
    function = ca.Function("choices", [x, y], [*chosen, ca.logic_not(a)])
    given = np.array([[-1.0, 2.0], [2.0, -1.0], [0.0, 0.0], [0.0, 1.0], [-0.5, -0.5]])
    found = over_columns(function)(given, np.array([7.0]))
    for column, one in enumerate(given):
        np.testing.assert_array_equal([float(f[0, column]) for f in found], [float(f) for f in function(one, 7.0)])


@needs_compiler
def test_angles_are_right_in_all_quarters_and_on_the_axes() -> None:
    x, y = ca.SX.sym("x", 2), ca.SX.sym("y")
    function = ca.Function("angle", [x, y], [ca.atan2(x[0], x[1])])
    turn = np.concatenate([np.linspace(-3.1, 3.1, 999), np.arange(-3, 4) * np.pi / 4])
    given = np.column_stack([np.sin(turn), np.cos(turn)])
    given = np.concatenate([given, [[0.0, 1.0], [0.0, -1.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]]])
    found = over_columns(function)(given, np.ones(1))[0][0]
    np.testing.assert_allclose(found, np.arctan2(*given.T), rtol=4 * ROUNDING, atol=ROUNDING)


@needs_compiler
def test_exponentials_out_of_range_are_zero_and_infinite_and_logarithms_of_what_has_none_are_not_numbers() -> None:
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    function = ca.Function("ends", [x, y], [ca.exp(x), ca.log(x)])
    exponential, logarithm = (
        f[0] for f in over_columns(function)(np.array([[-800.0], [800.0], [0.0], [-1.0]]), np.ones(1))
    )
    np.testing.assert_allclose(exponential, [0.0, np.inf, 1.0, np.exp(-1.0)], rtol=ROUNDING)
    np.testing.assert_array_equal(logarithm[[0, 2, 3]], [np.nan, -np.inf, np.nan])


@needs_compiler
def test_numbers_that_several_divide_by_divide_each_as_they_stand_at_the_time() -> None:
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p")
    d = x[1] + p
    function = ca.Function("shares", [x, p], [x[0] / d, x[2] / d, ca.sin(x[0] / d) / (d * d), 1 / d])
    given = np.random.default_rng(5).uniform(1, 2, size=(70, 3))
    mapped = function.map(70)
    for ours, casadis in zip(over_columns(function)(given, np.ones(1)), mapped(given.T, np.ones((1, 70))), strict=True):
        np.testing.assert_allclose(ours, casadis.full(), rtol=4 * ROUNDING)


@needs_compiler
def test_what_is_not_a_number_stays_so_in_its_own_column() -> None:
    x = np.array([0.5, np.nan, np.inf, -0.5])
    sine, _ = over_columns(waves())(x[:, None], np.ones(1))
    np.testing.assert_array_equal(np.isnan(sine[0]), [False, True, True, False])


@needs_compiler
@pytest.mark.parametrize("count", [1, 7, 8, 9, lanes.LANES, lanes.LANES + 1, 3 * lanes.LANES - 1])
def test_every_number_of_columns_gives_each_column_its_own(count: int) -> None:
    rng = np.random.default_rng(count)
    a, b = ca.SX.sym("a", 3), ca.SX.sym("b", 2)
    outer = ca.Function("outer", [a, b], [a @ b.T, ca.dot(a, a) / ca.sqrt(ca.sumsqr(b))])
    x, y = rng.normal(size=(count, 3)), rng.normal(size=2)
    product, size = over_columns(outer)(x, y)
    np.testing.assert_allclose(product.T.reshape(count, 2, 3), y[None, :, None] * x[:, None, :], rtol=ROUNDING)
    np.testing.assert_allclose(size[0], (x**2).sum(1) / np.linalg.norm(y), rtol=4 * ROUNDING)


@needs_compiler
def test_narrow_registers_give_the_numbers_of_wide_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.linspace(-3, 3, 50)[:, None]
    wide = over_columns(waves())(x, np.array([1.7]))
    monkeypatch.setattr(columns, "flags", lambda: ())
    narrow = over_columns(waves())(x, np.array([1.7]))
    np.testing.assert_array_equal(wide, narrow)


@needs_compiler
def test_functions_too_long_for_one_loop_are_casadis_own(monkeypatch: pytest.MonkeyPatch) -> None:
    x = np.linspace(-3, 3, 9)[:, None]
    short = over_columns(waves())(x, np.array([1.7]))
    monkeypatch.setattr(columns, "LONG", 1)
    np.testing.assert_allclose(over_columns(waves())(x, np.array([1.7])), short, atol=ROUNDING)


def test_a_library_that_cannot_be_loaded_leaves_the_virtual_machine(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(path: str) -> None:
        raise OSError(f"{path}: built for another machine")

    forget_functions()
    monkeypatch.setattr(ctypes, "CDLL", refuse)
    sine, _ = over_columns(waves())(np.array([[0.5]]), np.ones(1))
    assert sine[0, 0] == np.sin(0.5)


def test_operations_without_c_are_refused_by_name() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    with pytest.raises(ValueError, match="`bends` holds operation"):
        lanes.kernel(ca.Function("bends", [x, p], [ca.erf(x) + p]))
    y = ca.MX.sym("y")
    with pytest.raises(ValueError, match="must be an SX Function"):
        lanes.kernel(ca.Function("mixed", [y], [y]))
