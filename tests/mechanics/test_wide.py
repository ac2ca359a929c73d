"""Functions over as many columns as a register holds: CasADi's numbers, for any count of columns."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from serpenoid.mechanics import wide
from serpenoid.mechanics.compile import find_compiler
from serpenoid.mechanics.wide import Columns, over_columns

needs_compiler = pytest.mark.skipif(not find_compiler(), reason="no C compiler here")
ROUNDING = 1e-15  # a few units in the last place of sums of numbers near one


def chain() -> list[ca.Function]:
    """A sum over the columns of x of what C may hold: loops, products, constants, sines; and its sparse slope."""
    x, y, p = ca.SX.sym("x", 2), ca.SX.sym("y"), ca.SX.sym("p", 3)
    wave = ca.sin(p[0] * x[0]) + 2 * ca.cos(x[1]) ** 2 - ca.sqrt(p[1] + y**2) / 3 + ca.fmax(x[0], y) * ca.atan2(y, p[2])
    one = ca.Function("wave", [x, y, p], [wave, ca.vertcat(x[0] * y, 0.25)])
    columns, shared = ca.MX.sym("columns", 2, 3), ca.MX.sym("shared", 3)
    total, rows = one.map("waves", "serial", 3, [1, 2], [0])(columns, 1.5, shared)
    weights = ca.MX(ca.DM([[1.0, -2.0], [0.5, 3.0]]))
    value = ca.Function("chain_value", [columns, shared], [total, weights @ rows])
    slope = ca.Function("chain_slope", [columns, shared], [ca.sparsify(ca.DM([[1, 0], [0, 2]])) * total])
    return [value, slope]


def numbers(functions: list[Columns], count: int) -> list[list[np.ndarray]]:
    """Outputs of each function over `count` random columns, one list per function, and column by column."""
    rng = np.random.default_rng(count)
    x, p = rng.normal(size=(2, 3 * count)), rng.uniform(1, 2, 3)
    columns, shared = ca.MX.sym("columns", 2, 3 * count), ca.MX.sym("shared", 3)
    found = []
    for one in functions:
        outputs = one(count, columns, shared)
        outputs = outputs if isinstance(outputs, tuple) else (outputs,)
        every = ca.Function("every", [columns, shared], list(outputs)).call([x, p])
        each = [one.function.call([x[:, 3 * i : 3 * i + 3], p]) for i in range(count)]
        found += [[a.full(), ca.horzcat(*b).full()] for a, b in zip(every, zip(*each, strict=True), strict=True)]
    return found


@needs_compiler
@pytest.mark.parametrize("count", [1, 2, 7, 8, 9, 17])
def test_every_number_of_columns_gives_each_column_its_own(count: int) -> None:
    made = over_columns(chain())
    assert all(one.block is not None and one.width == wide.register() for one in made)
    for together, alone in numbers(made, count):
        np.testing.assert_allclose(together, alone, rtol=0, atol=8 * ROUNDING)


@needs_compiler
@pytest.mark.parametrize("flag", ["-mavx2", "-fno-math-errno"])
def test_narrow_registers_give_the_numbers_of_wide_ones(flag: str, monkeypatch: pytest.MonkeyPatch) -> None:
    widest = numbers(over_columns(chain()), 9)
    if wide.register() < 4 and flag == "-mavx2":
        pytest.skip("this machine has no such registers")
    monkeypatch.setattr(wide, "flags", lambda: ("-fno-math-errno", flag))
    for (narrow, _), (widely, _) in zip(numbers(over_columns(chain()), 9), widest, strict=True):
        np.testing.assert_array_equal(narrow, widely)


@needs_compiler
def test_comparisons_are_compiled_column_by_column() -> None:
    x, p = ca.SX.sym("x"), ca.SX.sym("p")
    (made,) = over_columns([ca.Function("choice", [x, p], [ca.if_else(x < p, x, 2 * p)])])
    assert made.block is None
    columns = ca.MX.sym("columns", 1, 3)
    every = ca.Function("every", [columns], [made(3, columns, 1.0)])
    found = every(ca.DM([[-1.0, 0.5, 3.0]]))
    np.testing.assert_array_equal(found.full(), [[-1.0, 0.5, 2.0]])


def test_without_a_compiler_the_virtual_machine_maps_the_columns(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SERPENOID_COMPILE", "0")
    made = over_columns(chain())
    assert all(one.block is None for one in made)
    for together, alone in numbers(made, 5):
        np.testing.assert_array_equal(together, alone)
