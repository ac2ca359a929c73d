"""SX Functions over many columns at once, in C that fills a processor's wide registers (SIMD).

CasADi's own C calls a Function once per column, and the scalar sine of the C library with it. Here every number of a
Function is an array over a block of columns (its lanes), in loops that compilers turn into SIMD, and the sine is a
polynomial that they can. The formulas are the Functions' own, instruction by instruction; nothing is derived twice.

Legend: L lanes of a block; k numbers of a column.
"""

from __future__ import annotations

import math
import platform
from collections import Counter
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import casadi as ca

LANES = 64  # of a block: its numbers stay in the first cache, its loops are long enough
WIDEST = ("avx512f", "avx2")
LN2 = (0.6931471803691238, 1.9082149292705877e-10)  # in two parts, the first of 32 bits: exact times any exponent

_BINARY = {ca.OP_ADD: "+", ca.OP_SUB: "-", ca.OP_MUL: "*", ca.OP_DIV: "/"}
_UNARY = {
    ca.OP_NEG: "-{0}",
    ca.OP_SQ: "{0} * {0}",
    ca.OP_TWICE: "2.0 * {0}",
    ca.OP_INV: "1.0 / {0}",
    ca.OP_SQRT: "sqrt({0})",
    ca.OP_SIN: "lane_sin({0})",
    ca.OP_COS: "lane_cos({0})",
    ca.OP_EXP: "lane_exp({0})",
    ca.OP_LOG: "lane_log({0})",
    ca.OP_FABS: "fabs({0})",
    ca.OP_SIGN: "({0} > 0.0 ? 1.0 : {0} < 0.0 ? -1.0 : 0.0)",
    ca.OP_NOT: "({0} == 0.0 ? 1.0 : 0.0)",
}
_OF_TWO = {
    ca.OP_POW: "lane_exp({1} * lane_log({0}))",
    ca.OP_CONSTPOW: "lane_exp({1} * lane_log({0}))",
    ca.OP_ATAN2: "lane_atan2({0}, {1})",
    ca.OP_LT: "({0} < {1} ? 1.0 : 0.0)",
    ca.OP_LE: "({0} <= {1} ? 1.0 : 0.0)",
    ca.OP_FMIN: "({0} < {1} ? {0} : {1})",
    ca.OP_FMAX: "({0} > {1} ? {0} : {1})",
    ca.OP_IF_ELSE_ZERO: "({0} != 0.0 ? {1} : 0.0)",
}  # powers: of what is positive


def _horner(coefficients: Sequence[float], of: str = "r2") -> str:
    """A polynomial of a variable."""
    *lower, highest = [repr(c) for c in coefficients]
    return "".join(f"{c} + {of} * (" for c in lower) + highest + ")" * len(lower)


def _series(first: int) -> str:
    """Taylor's polynomial of the sine over r (first 1) or of the cosine (0) in r2 = r^2."""
    return _horner([(-1) ** i / math.factorial(2 * i + first) for i in range(11)])


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


_EXP = _horner([1 / math.factorial(i) for i in range(15)], "r")
_LOG = _horner([2 / (2 * i + 1) for i in range(12)])  # 2 artanh(r) / r
_ATAN = _horner([(-1) ** i / (2 * i + 1) for i in range(22)])


# Exponentials: powers of two by the bits of the exponent, the rest within ln(2) / 2; logarithms: of a number within
# sqrt(2) of 1, (r - 1) / (r + 1) below 0.172; arc tangents: turned by pi / 4 to below 0.415. Each leaves out less than
# 1e-17. Normal numbers only: what is below 2e-308 or above 8e307 is zero or infinite here.
PRELUDE = f"""#include <math.h>
#include <string.h>
#ifdef __clang__
#define INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#else
#define INDEPENDENT _Pragma("GCC ivdep")
#endif
#define KERNEL static __attribute__((noinline)) void
{polynomial_sine("double")}INLINE lane_exp(double x) {{
  const double k = rounded(x * {1 / math.log(2)!r}), r = (x - k * {LN2[0]!r}) - k * {LN2[1]!r};
  const double whole = k + 6755399441055744.0;
  long long bits;
  memcpy(&bits, &whole, 8);
  bits = (long long)((unsigned long long)(bits + 1023) << 52);
  double power;
  memcpy(&power, &bits, 8);
  const double found = power * ({_EXP});
  return x > 709.0 ? INFINITY : x < -708.0 ? 0.0 : found;
}}
INLINE lane_log(double x) {{
  long long bits, exponent;
  memcpy(&bits, &x, 8);
  exponent = (long long)((unsigned long long)bits >> 52) | 0x4330000000000000LL;
  bits = (bits & 0x000FFFFFFFFFFFFFLL) | 0x3FF0000000000000LL;
  double e, m;
  memcpy(&e, &exponent, 8);
  memcpy(&m, &bits, 8);
  const double large = m > {math.sqrt(2)!r} ? 1.0 : 0.0, k = e - 4503599627371519.0 + large;
  m = m - large * 0.5 * m;
  const double r = (m - 1.0) / (m + 1.0), r2 = r * r;
  const double found = k * {LN2[0]!r} + (k * {LN2[1]!r} + r * ({_LOG}));
  return x > 0.0 ? found : x == 0.0 ? -INFINITY : NAN;
}}
INLINE lane_atan2(double y, double x) {{
  const double a = fabs(x), b = fabs(y), high = a > b ? a : b, low = a > b ? b : a;
  const double steep = low > {math.tan(math.pi / 8)!r} * high ? 1.0 : 0.0;
  const double top = low - steep * high, bottom = high + steep * low;
  const double r = top / (bottom > 0.0 ? bottom : 1.0), r2 = r * r;
  const double half = steep * {math.pi / 4!r} + r * ({_ATAN});
  const double right = b > a ? {math.pi / 2!r} - half : half;
  return copysign(x < 0.0 ? {math.pi!r} - right : right, y);
}}
"""


@cache
def flags() -> tuple[str, ...]:
    """What this machine's widest registers ask of the compiler; part of a library's key: machines share a cache."""
    try:
        known = Path("/proc/cpuinfo").read_text(encoding="ascii", errors="replace").split()
    except OSError:
        known = []
    intel = platform.machine() in ("x86_64", "AMD64")
    return ("-fno-math-errno", *[f"-m{name}" for name in WIDEST if intel and name in known][:1])


def has_c(function: ca.Function) -> bool:
    """Whether all operations of an SX Function have C here."""
    known = {ca.OP_CONST, ca.OP_INPUT, ca.OP_OUTPUT, *_BINARY, *_UNARY, *_OF_TWO}
    return all(function.instruction_id(i) in known for i in range(function.n_instructions()))


def kernel(function: ca.Function, shared: Sequence[int] = (), add: bool = False) -> str:
    """C of `NAME(eights, x_0, .., y_0, ..)` for the first 8 `eights` of L lanes: arrays (k, L), shared inputs (k).

    add: to what the outputs hold.
    """
    if not function.is_a("SXFunction"):
        raise ValueError(f"`{function.name()}` must be an SX Function, got a {function.class_name()}.")
    put = "+=" if add else "="
    lines = _statements(function, set(shared), put)
    inputs = [f"const double *restrict x{i}" for i in range(function.n_in())]
    outputs = [f"double *restrict y{i}" for i in range(function.n_out())]
    names = ", ".join(f"w{i}" for i in range(function.sz_w()))
    arguments = ", ".join(["const long eights", *inputs, *outputs])
    body = "\n    ".join([f"double {names};", *lines])
    loop = f"  INDEPENDENT\n  for (long i = 0; i < 8 * eights; ++i) {{\n    {body}\n  }}"
    return f"KERNEL {function.name()}({arguments}) {{\n{loop}\n}}\n"


def _statements(function: ca.Function, shared: set[int], put: str) -> list[str]:
    """Every instruction. Where several divide by the same number, they multiply by its inverse: a division takes as
    long as eight products.
    """
    written = [0] * function.sz_w()  # how often each place was
    divisors = []
    for i in range(function.n_instructions()):
        if function.instruction_id(i) == ca.OP_DIV:
            place = function.instruction_input(i)[1]
            divisors.append((place, written[place]))
        if function.instruction_id(i) != ca.OP_OUTPUT:
            written[function.instruction_output(i)[0]] += 1
    shares = {divisor for divisor, times in Counter(divisors).items() if times > 1}
    lines: list[str] = []
    known: set[tuple[int, int]] = set()
    following, zeros = iter(divisors), set[int]()
    for i in range(function.n_instructions()):
        if put == "+=" and _adds_nothing(function, i, zeros):
            continue
        if function.instruction_id(i) == ca.OP_DIV and (divisor := next(following)) in shares:
            inverse = f"inverse_{divisor[0]}_{divisor[1]}"
            if divisor not in known:
                lines.append(f"const double {inverse} = 1.0 / w{divisor[0]};")
                known.add(divisor)
            result, over = function.instruction_output(i)[0], function.instruction_input(i)[0]
            lines.append(f"w{result} = w{over} * {inverse};")
        else:
            lines.append(_statement(function, i, shared, put))
    return lines


def _adds_nothing(function: ca.Function, i: int, zeros: set[int]) -> bool:
    """Whether an instruction puts out what is always zero; zeros: places that hold it, kept up to date."""
    operation, outputs = function.instruction_id(i), function.instruction_output(i)
    if operation == ca.OP_OUTPUT:
        return function.instruction_input(i)[0] in zeros
    zeros.discard(outputs[0])
    if operation == ca.OP_CONST and function.instruction_constant(i) == 0:
        zeros.add(outputs[0])
    return False


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
    if operation in _OF_TWO:
        return f"w{outputs[0]} = {_OF_TWO[operation].format(*(f'w{i}' for i in inputs))};"
    if operation in _UNARY:
        return f"w{outputs[0]} = {_UNARY[operation].format(f'w{inputs[0]}')};"
    raise ValueError(f"`{function.name()}` holds operation {operation}, which has no C here.")
