"""The baseline's shapes and steps for many columns at once: in SIMD where a C compiler exists, else CasADi's maps.

Arrays are those of CasADi's maps: column after column in memory. Legend: S steps, M elements, k numbers of a column.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.mechanics import functions, planar
from serpenoid.mechanics.compile import compiled, loaded
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.mechanics.lanes import LANES, PRELUDE, flags, has_c, kernel
from serpenoid.model import Structure

LONG = 2000  # instructions (70 vertices): compilers take more than 5 s for the loop of a longer Function
OverColumns = Callable[..., list[Floats]]

GATHER = f"""
static void gather(long n, long eights, const long k, const long apart, const double *a, double *x) {{
  for (long i = 0; i < 8 * eights; ++i)
    for (long r = 0; r < k; ++r) x[r * {LANES} + i] = a[(i < n ? i : n - 1) * apart + r];
}}
static void scatter(long n, const long k, const long apart, const double *y, double *b) {{
  for (long i = 0; i < n; ++i)
    for (long r = 0; r < k; ++r) b[i * apart + r] = y[r * {LANES} + i];
}}
"""
BLOCKS = f"""  for (long first = 0; first < count; first += {LANES}) {{
    const long n = count - first < {LANES} ? count - first : {LANES}, eights = (n + 7) / 8;
"""
STEPS = f"""
void steps_columns(long count, const double *before, const double *after, const double *weights, const double *eps,
                   double *pose, double *slope, double *curvature, double *energy, long elements) {{
  static _Thread_local double work[{(14 + planar.MOMENTS) * LANES}];
  double *x = work, *y = x + 4 * {LANES}, *moments = y + 4 * {LANES}, *found = moments + {planar.MOMENTS * LANES};
  const double guess[1] = {{0.0}};
{BLOCKS}
    for (long i = 0; i < {planar.MOMENTS * LANES}; ++i) moments[i] = 0.0;
    for (long k = 0; k < elements; ++k) {{
      gather(n, eights, 4, 4 * elements, before + 4 * (first * elements + k), x);
      gather(n, eights, 4, 4 * elements, after + 4 * (first * elements + k), y);
      element_moments(eights, x, y, weights + k, eps, moments);
    }}
    root(eights, guess, moments, found, found + 3 * {LANES}, found + 4 * {LANES}, found + 5 * {LANES});
    scatter(n, 3, 3, found, pose + 3 * first);
    scatter(n, 1, 1, found + 3 * {LANES}, slope + first);
    scatter(n, 1, 1, found + 4 * {LANES}, curvature + first);
    scatter(n, 1, 1, found + 5 * {LANES}, energy + first);
  }}
}}
"""


def over_columns(function: ca.Function) -> OverColumns:
    """A dense SX Function of (column, shared numbers), over C columns: (columns (k, C), shared) -> outputs."""
    outputs = [function.size_out(i) for i in range(function.n_out())]
    sizes = [rows * columns for rows, columns in outputs]
    if function.n_instructions() > LONG or not has_c(function):
        run, plain = None, compiled([function])[0]
    else:
        source, plain = _columns_source(function, sizes), function
        run = loaded(f"{function.name()}_columns", source, _entry(function.name()), flags())
    if run is None:
        return lambda columns, shared: evaluate(_mapped(plain, len(columns)), columns, shared)

    def over(columns: Floats, shared: Floats) -> list[Floats]:
        count = len(columns)
        found = [np.empty((rows, wide * count), order="F") for rows, wide in outputs]
        call(run, count, [columns, shared], found)
        return found

    return over


@lru_cache(maxsize=32)
def steps(structure: Structure) -> OverColumns:
    """(before, after (S M, 4), parameters) -> pose (3, S), residual, curvature, energy (1, S) of S planar steps."""
    source = PRELUDE + kernel(planar.element_moments(), [2, 3], add=True) + kernel(planar.root(), [0]) + GATHER + STEPS
    run, m = loaded("steps_columns", source, _entry("steps"), flags()), structure.elements
    if run is None:
        step = functions.step(structure)
        return lambda before, after, parameters: evaluate(
            _mapped(step, len(before) // m), before, after, np.zeros(1), parameters
        )

    def over(before: Floats, after: Floats, parameters: Floats) -> list[Floats]:
        count = len(before) // m
        found = [np.empty((rows, count), order="F") for rows in (3, 1, 1, 1)]
        medium = _medium(structure, parameters.tobytes())
        call(run, count, [before, after, *medium], found, m)
        return found

    return over


@lru_cache(maxsize=64)
def _medium(structure: Structure, parameters: bytes) -> list[Floats]:
    """Weights of the elements and anisotropy ratio; kept, for a call into CasADi takes as long as ten steps."""
    return [part.full() for part in functions.element_parameters(structure)(np.frombuffer(parameters))]


@lru_cache(maxsize=32)
def shapes(structure: Structure) -> OverColumns:
    """(joint angles (R, m), parameters) -> vertices (2, N R), elements (4, M R) of R rows, in the body frame."""
    return over_columns(functions.shape(structure))


def _columns_source(function: ca.Function, sizes: list[int]) -> str:
    name, width = function.name(), function.size1_in(0)
    results = "".join(f", double *b{i}" for i in range(len(sizes)))
    places = [f"work + {(width + sum(sizes[:i])) * LANES}" for i in range(len(sizes))]
    lines = [f"    gather(n, eights, {width}, {width}, columns + first * {width}, work);"]
    lines += [f"    {name}(eights, work, shared, {', '.join(places)});"]
    lines += [f"    scatter(n, {k}, {k}, {places[i]}, b{i} + first * {k});" for i, k in enumerate(sizes)]
    head = f"void {name}_columns(long count, const double *columns, const double *shared{results}) {{\n"
    head += f"  static _Thread_local double work[{(width + sum(sizes)) * LANES}];"
    return "\n".join([PRELUDE, kernel(function, [1]), GATHER, head, BLOCKS, *lines, "  }\n}\n"])


def _entry(name: str) -> Callable[[str], Any]:
    return lambda library: getattr(ctypes.CDLL(library), f"{name}_columns")


def call(run: Any, count: int, given: list[Floats], found: list[Floats], *more: int) -> None:
    """Run C on (count, arrays given, arrays found, more numbers)."""
    arrays = [*(np.ascontiguousarray(a, float) for a in given), *found]
    run(ctypes.c_long(count), *(ctypes.c_void_p(a.ctypes.data) for a in arrays), *(ctypes.c_long(n) for n in more))


@lru_cache(maxsize=128)
def _mapped(function: ca.Function, count: int) -> ca.Function:
    """`function` over `count` columns; the last input (parameters), and the guess before it, are shared."""
    shared = [function.n_in() - 1] if function.n_in() == 2 else [function.n_in() - 2, function.n_in() - 1]
    return function.map(f"map{count}_{function.name()}", "serial", count, shared, [])
