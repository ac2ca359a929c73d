"""Functions over as many columns at once as a register holds numbers (SIMD), in CasADi's own C with another number.

CasADi writes C over `casadi_real`. Here that is a vector of W doubles, one per column, an extension of C that GCC and
Clang share: additions and products act lane by lane, sine and cosine are polynomials (`lanes`), other functions of the
C library are called lane by lane. So W columns cost little more than one, loops, sums and calls inside a Function as
well, and nothing is derived or written twice. What has no such C (comparisons) is compiled column by column.

Legend: W columns of a block; k numbers of a column.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

from serpenoid.mechanics.compile import EFFORT, compiled, find_compiler, generate_c, loaded
from serpenoid.mechanics.lanes import flags, polynomial_sine

NUMBER = r"-?\d[\d.]*(?:e[+-]?\d+)?"
VECTORS = (  # where CasADi's C puts a plain number in a variable: in C a vector needs one made of it
    (rf"\b([aw]\d+) ?= ?({NUMBER});", r"\1 = SPLAT(\2);"),
    (r": 0;", ": SPLAT(0);"),
    (rf"(casadi_fill\([^;]*, )({NUMBER})\);", r"\1SPLAT(\2));"),
    (rf"(\*[xy]\+\+ = )({NUMBER});", r"\1SPLAT(\2);"),
    (r"CASADI_SYMBOL_EXPORT casadi_real \w+_default_in.*?\n}\n", ""),
    (r"CASADI_SYMBOL_EXPORT int \w+_casadi_real_size.*\n", ""),
)
LANEWISE = {"sqrt": 1, "fabs": 1, "exp": 1, "log": 1, "tan": 1, "asin": 1, "acos": 1, "atan": 1, "tanh": 1}
LANEWISE |= {"atan2": 2, "fmin": 2, "fmax": 2, "pow": 2}
COMPARED = re.compile(r"^\s*a\d+=.*(?:[<>!]|==)", re.MULTILINE)


@dataclass(frozen=True)
class Columns:
    """A Function over columns, but for input `shared`, the same for all. block: the same over `width` columns."""

    function: ca.Function
    shared: int
    block: ca.Function | None = None
    width: int = 1

    def __call__(self, count: int, *inputs: ca.MX) -> ca.MX | tuple[ca.MX, ...]:
        """Outputs over `count` columns, side by side."""
        if self.block is None:
            return self._map(self.function, count)(*inputs)
        blocks = -(-count // self.width)
        missing = blocks * self.width - count
        found = self._map(self.block, blocks)(*(self._filled(i, x, missing) for i, x in enumerate(inputs)))
        if not missing:
            return found
        parts = [found] if isinstance(found, ca.MX) else found
        kept = tuple(x[:, : count * self.function.size2_out(i)] for i, x in enumerate(parts))
        return kept[0] if isinstance(found, ca.MX) else kept

    def _map(self, function: ca.Function, count: int) -> ca.Function:
        return function.map(f"over_{function.name()}", "serial", count, [self.shared], [])

    def _filled(self, i: int, x: ca.MX, missing: int) -> ca.MX:
        """An input with its last column repeated."""
        if i == self.shared or not missing:
            return x
        return ca.horzcat(x, ca.repmat(x[:, x.size2() - self.function.size2_in(i) :], 1, missing))


def over_columns(functions: Sequence[ca.Function], shared: int = -1, portable: bool = False) -> list[Columns]:
    """The functions over columns, compiled unless portable. shared: the input that is the same for all, -1 the last."""
    blocks = None if portable else _blocks(functions, shared)
    if blocks is None:
        plain = functions if portable else compiled(functions)
        return [Columns(function, shared % function.n_in()) for function in plain]
    whole = zip(functions, blocks, strict=True)
    return [Columns(function, shared % function.n_in(), block, register()) for function, block in whole]


def _blocks(functions: Sequence[ca.Function], shared: int) -> list[ca.Function] | None:
    """Each function over W columns; None where there is no such C, or no compiler."""
    source = wide_source(functions, shared) if find_compiler() else None
    if source is None:
        return None

    def load(path: str) -> list[ca.Function]:
        return [ca.external(f"{function.name()}_wide", path) for function in functions]

    return loaded(f"{functions[0].name()}_wide", source, load, (*flags(), EFFORT))


def register() -> int:
    """W: numbers in the widest register that the compiler is told of."""
    return {"-mavx512f": 8, "-mavx2": 4}.get(flags()[-1], 2)


def wide_source(functions: Sequence[ca.Function], shared: int) -> str | None:
    """C of `NAME_wide` for each function, in CasADi's form; None where comparisons forbid it."""
    source = generate_c(functions)
    if COMPARED.search(source):
        return None
    for pattern, replacement in VECTORS:
        source = re.sub(pattern, replacement, source, flags=re.DOTALL if "default_in" in pattern else 0)
    source = re.sub(r"(static const casadi_real casadi_c\w+\[\d+\] =\s*)\{([^}]*)\}", _constants, source)
    return "\n".join([_prelude(), source, *(_wrapper(f, shared % f.n_in()) for f in functions)])


def _constants(found: re.Match[str]) -> str:
    numbers = [f"{{{', '.join([number] * register())}}}" for number in re.split(r",\s*", found[2].strip())]
    return f"{found[1]}{{{', '.join(numbers)}}}"


def _prelude() -> str:
    lines = ["#include <math.h>", f"typedef double V __attribute__((vector_size({8 * register()}), aligned(8)));"]
    lines += ["#define SPLAT(x) ((V){0.0} + (double)(x))", polynomial_sine("V")]
    for name, count in LANEWISE.items():
        given, each = (", ".join(f"{a}{b}" for b in "xy"[:count]) for a in ("V ", ""))
        lanes = ", ".join(f"{b}[i]" for b in "xy"[:count])
        loop = f"V r; for (int i = 0; i < {register()}; ++i) r[i] = {name}({lanes}); return r;"
        lines.append(f"static inline V lane_{name}({given}) {{ {loop} }}\n#define {name}({each}) lane_{name}({each})")
    return "\n".join([*lines, "#define sin lane_sin", "#define cos lane_cos", "#define casadi_real V", ""])


def _wrapper(function: ca.Function, shared: int) -> str:
    """NAME_wide: W columns into vectors, the Function, and back."""
    name, w = function.name(), register()
    inputs = [function.nnz_in(i) for i in range(function.n_in())]
    outputs = [function.nnz_out(i) for i in range(function.n_out())]
    lines = [
        f"CASADI_SYMBOL_EXPORT int {name}_wide(const double **arg, double **res, casadi_int *iw, double *w, int m) {{"
    ]
    lines += [f"  const V **a = (const V **)(arg + {len(inputs)});"]
    lines.append(f"  V **r = (V **)(res + {len(outputs)});")
    lines += [f"  V *x = (V *)w, *y = x + {sum(inputs)}, *work = y + {sum(outputs)};"]
    start = 0
    for i, k in enumerate(inputs):
        lines.append(f"  a[{i}] = x + {start};")
        each = f"x[{start} + k] = SPLAT(arg[{i}][k]);"
        if i != shared:
            each = f"for (int c = 0; c < {w}; ++c) x[{start} + k][c] = arg[{i}][c * {k} + k];"
        lines.append(f"  for (int k = 0; k < {k}; ++k) {each}")
        start += k
    start = 0
    for i, k in enumerate(outputs):
        lines.append(f"  r[{i}] = res[{i}] ? y + {start} : 0;")
        start += k
    lines.append(f"  if ({name}(a, r, iw, work, m)) return 1;")
    start = 0
    for i, k in enumerate(outputs):
        each = f"for (int c = 0; c < {w}; ++c) res[{i}][c * {k} + k] = y[{start} + k][c];"
        lines.append(f"  if (res[{i}]) for (int k = 0; k < {k}; ++k) {each}")
        start += k
    lines.append("  return 0;\n}")
    return "\n".join([*lines, *_described(function, shared, sum(inputs) + sum(outputs))])


def _described(function: ca.Function, shared: int, numbers: int) -> list[str]:
    """What CasADi asks of an external function: sizes of its inputs, outputs and work."""
    name, w = f"{function.name()}_wide", register()
    n_in, n_out = function.n_in(), function.n_out()
    inputs = [function.sparsity_in(i) for i in range(n_in)]
    patterns = {
        "in": [s if i == shared else ca.repmat(s, 1, w) for i, s in enumerate(inputs)],
        "out": [ca.repmat(function.sparsity_out(i), 1, w) for i in range(n_out)],
    }
    export, lines = "CASADI_SYMBOL_EXPORT", []
    for side, found in patterns.items():
        lines.append(f"{export} casadi_int {name}_n_{side}(void) {{ return {len(found)}; }}")
        cases = []
        for i, pattern in enumerate(found):
            numbers_of = ", ".join(map(str, [*pattern.shape, *pattern.colind(), *pattern.row()]))
            lines.append(f"static const casadi_int {name}_{side}{i}[] = {{{numbers_of}}};")
            cases.append(f"case {i}: return {name}_{side}{i};")
        head = f"{export} const casadi_int *{name}_sparsity_{side}(casadi_int i)"
        lines.append(f"{head} {{ switch (i) {{ {' '.join(cases)} default: return 0; }} }}")
    lines += [
        f"{export} int {name}_work(casadi_int *a, casadi_int *r, casadi_int *i, casadi_int *w) {{",
        f"  if ({function.name()}_work(a, r, i, w)) return 1;",
        f"  *a += {n_in}; *r += {n_out}; *w = {w} * (*w + {numbers});\n  return 0;\n}}",
    ]
    return lines
