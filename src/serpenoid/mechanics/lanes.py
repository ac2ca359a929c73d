"""SX Functions over many columns at once, in C that fills a processor's wide registers (SIMD).

CasADi's own C calls a Function once per column, and the scalar sine of the C library with it. Here every number of a
Function is an array over a block of columns (its lanes), in loops that compilers turn into SIMD, and the sine is a
polynomial that they can. The formulas are the Functions' own, instruction by instruction; nothing is derived twice.

Legend: L lanes of a block; k numbers of a column.
"""

from __future__ import annotations

import math
import platform
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import casadi as ca

LANES = 64  # of a block: its numbers stay in the first cache, its loops are long enough
WIDEST = ("avx512f", "avx2")

_BINARY = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
_UNARY = {
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_SQRT: "sqrt({0})",
    ca.OP_SIN: "lane_sin({0})",
    ca.OP_COS: "lane_cos({0})",
}


def _series(first: int) -> str:
    """Taylor's polynomial of the sine over r (first 1) or of the cosine (0) in r2 = r^2, by Horner's rule."""
    *lower, highest = [repr((-1) ** i / math.factorial(2 * i + first)) for i in range(11)]
    return "".join(f"{c} + r2 * (" for c in lower) + highest + ")" * len(lower)


def polynomial_sine(number: str) -> str:
    """C of `lane_sin` and `lane_cos` of a type of numbers: double, or a vector of them.

    |r| <= pi / 2: what the polynomials leave out is below 2e-18. pi in three parts, the first two of 33 bits, so that
    k pi is exact for angles up to a million. Adding and taking away 1.5 * 2^52 rounds to an integer.
    """
    return f"""#define INLINE static inline __attribute__((always_inline)) {number}
INLINE rounded({number} x) {{ return (x + 6755399441055744.0) - 6755399441055744.0; }}
INLINE reduced({number} x, {number} *sign) {{
  const {number} k = rounded(x * {1 / math.pi!r}), odd = k - 2.0 * rounded(0.5 * k);
  *sign = 1.0 - 2.0 * odd * odd;
  return ((x - k * 3.1415926534682512) - k * 1.2154201012607932e-10) - k * 4.044532497591901e-21;
}}
INLINE lane_sin({number} x) {{
  {number} sign;
  const {number} r = reduced(x, &sign), r2 = r * r;
  return sign * r * ({_series(1)});
}}
INLINE lane_cos({number} x) {{
  {number} sign;
  const {number} r = reduced(x, &sign), r2 = r * r;
  return sign * ({_series(0)});
}}
"""


PRELUDE = f"""#include <math.h>
#ifdef __clang__
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT _Pragma("GCC ivdep")
#endif
#define KERNEL static __attribute__((noinline)) void
{polynomial_sine("double")}"""


@cache
def flags() -> tuple[str, ...]:
    """What this machine's widest registers ask of the compiler; part of a library's key: machines share a cache."""
    try:
        known = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").split()
    except OSError:
        known = []
    intel = platform.machine() in ("x86_64", "AMD64")
    return ("-fno-math-errno", *[f"-m{name}" for name in WIDEST if intel and name in known][:1])


def kernel(function: ca.Function, shared: Sequence[int] = (), add: bool = False) -> str:
    """C of `NAME(eights, x_0, .., y_0, ..)` for the first 8 `eights` of L lanes: arrays (k, L), shared inputs (k).

    add: to what the outputs hold.
    """
    if not function.is_a("SXFunction"):
        raise ValueError(f"`{function.name()}` must be an SX Function, got a {function.class_name()}.")
    put = "+=" if add else "="
    lines = [_statement(function, i, set(shared), put) for i in range(function.n_instructions())]
    inputs = [f"const double *restrict x{i}" for i in range(function.n_in())]
    outputs = [f"double *restrict y{i}" for i in range(function.n_out())]
    names = ", ".join(f"w{i}" for i in range(function.sz_w()))
    arguments = ", ".join(["const long eights", *inputs, *outputs])
    body = "\n    ".join([f"double {names};", *lines])
    loop = f"  INDEPENDENT\n  for (long i = 0; i < 8 * eights; ++i) {{\n    {body}\n  }}"
    return f"KERNEL {function.name()}({arguments}) {{\n{loop}\n}}\n"


def _statement(function: ca.Function, i: int, shared: set[int], put: str) -> str:
    operation = function.instruction_id(i)
    inputs, outputs = function.instruction_input(i), function.instruction_output(i)
    if operation == ca.OP_CONST:
        return f"w{outputs[0]} = {function.instruction_constant(i)!r};"
    if operation == ca.OP_INPUT:
        which, place = inputs
        return f"w{outputs[0]} = x{which}[{place if which in shared else f'{place * LANES} + i'}];"
    if operation == ca.OP_OUTPUT:
        which, place = outputs
        return f"y{which}[{place * LANES} + i] {put} w{inputs[0]};"
    if operation in _BINARY:
        return f"w{outputs[0]} = w{inputs[0]} {_BINARY[operation]} w{inputs[1]};"
    if operation in _UNARY:
        return f"w{outputs[0]} = {_UNARY[operation].format(f'w{inputs[0]}')};"
    raise ValueError(f"`{function.name()}` holds operation {operation}, which has no C here.")
