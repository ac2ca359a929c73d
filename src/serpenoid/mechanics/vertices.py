"""Steps with effects, many at once, summed over the vertices: in SIMD where a C compiler exists, else CasADi's maps.

One library of a law serves bodies of any number of vertices. Legend: S steps, M elements, P coordinates, k numbers.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.catalogue import medium_effects
from serpenoid.mechanics.columns import BLOCKS, GATHER, call
from serpenoid.mechanics.compile import compiled, loaded
from serpenoid.mechanics.evaluate import evaluate
from serpenoid.mechanics.extended import SETTING, Vertex, coordinate_count, vertex_functions, with_links
from serpenoid.mechanics.functions import CSE
from serpenoid.mechanics.kinematics import unit_edges
from serpenoid.mechanics.lanes import LANES, PRELUDE, flags, kernel

LONGEST = 6000  # instructions: compilers take minutes for the loop of a longer Function
# long loops take GCC thrice as long with all optimisations, and are as fast without them
QUICKLY = """#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC optimize ("O2", "tree-loop-vectorize", "vect-cost-model=unlimited")
#endif"""
SOLVED = """
/* b = -m^-1 b, of `width` columns, by elimination with pivots; where m is singular or no number -b */
static void solved(const double *slopes, const long width, double *b) {
  double m[3][3], size = 1.0;
  int top[3], known = 1;
  for (int j = 0; j < 9; ++j) known &= isfinite(m[j / 3][j % 3] = slopes[j]) != 0;
  for (int c = 0; known && c < 3; ++c) {
    top[c] = c;
    for (int j = c + 1; j < 3; ++j) if (fabs(m[j][c]) > fabs(m[top[c]][c])) top[c] = j;
    for (int k = 0; k < 3; ++k) { const double held = m[c][k]; m[c][k] = m[top[c]][k]; m[top[c]][k] = held; }
    size *= m[c][c];
    known = fabs(m[c][c]) > 0.0;
    for (int j = c + 1; known && j < 3; ++j) {
      m[j][c] /= m[c][c];
      for (int k = c + 1; k < 3; ++k) m[j][k] -= m[j][c] * m[c][k];
    }
  }
  known = known && fabs(size) > 1e-300;
  for (long w = 0; w < width; ++w) {
    double d[3] = {b[w], b[width + w], b[2 * width + w]};
    for (int c = 0; known && c < 3; ++c) { const double held = d[c]; d[c] = d[top[c]]; d[top[c]] = held; }
    for (int j = 1; known && j < 3; ++j) for (int k = 0; k < j; ++k) d[j] -= m[j][k] * d[k];
    for (int j = 2; known && j >= 0; --j) {
      for (int k = j + 1; k < 3; ++k) d[j] -= m[j][k] * d[k];
      d[j] /= m[j][j];
    }
    for (int j = 0; j < 3; ++j) b[j * width + w] = -d[j];
  }
}
"""
BLOCK = 256  # steps of one call of CasADi's maps
OverSteps = Callable[..., list[Floats]]


@lru_cache(maxsize=16)
def over_steps(which: str, law: str) -> OverSteps:
    """One of `extended.vertex_functions` over (before, after (S, M, 4), poses (S, 6), settings (S, 6), medium (M, 2),
    theta (M, P)): its outputs (S, ...), column after column of each step's, summed or vertex by vertex.
    """
    vertex = vertex_functions(law)[which]
    run = in_c(f"{which}_steps", "over_steps", vertex, _source)
    if run is None:
        return lambda *given: _mapped(which, law, *given)

    def over(*given: Floats) -> list[Floats]:
        steps, elements, _ = given[0].shape
        repeats = [1 if i in vertex.summed else elements for i in range(vertex.function.n_out())]
        found = [np.empty((steps, vertex.function.numel_out(i) * n)) for i, n in enumerate(repeats)]
        call(run, steps, list(given), found, elements)
        return found

    return over


def in_c(library: str, entry: str, vertex: Vertex, source: Callable[[Vertex], str]) -> Any | None:
    """The function `entry` of the library of what `source` writes about a vertex; None where it cannot be compiled."""
    if vertex.function.n_instructions() > LONGEST:
        return None
    return loaded(library, source(vertex), lambda path: getattr(ctypes.CDLL(path), entry), flags())


def edge() -> ca.Function:
    """Direction (2) of the edge between two elements (4)."""
    points = ca.SX.sym("tail", 4), ca.SX.sym("head", 4)
    return ca.Function("edge", list(points), [unit_edges(ca.horzcat(*(p[:2] for p in points)))], CSE)


def links(gather: str) -> str:
    """C of elements with the direction of the edge on the tail's side, `x` before and `z` after, of vertex k: each is
    gathered once, and stays where the next one's edge begins. gather: one, of an array, at a vertex, into lanes."""
    return "\n".join(
        f"""    if (k) memcpy(tail, {x}, {4 * LANES} * sizeof(double));
    {gather.format(a, "k", x)}
    if (k) {{
      edge(eights, tail, {x}, {x} + {4 * LANES});
    }} else {{
      {gather.format(a, 1, "tail")}
      edge(eights, {x}, tail, {x} + {4 * LANES});
    }}"""
        for a, x in (("before", "x"), ("after", "z"))
    )


def _source(vertex: Vertex) -> str:
    """C of `over_steps`: block after block of steps; for each of them, vertex after vertex."""
    function, coordinates = vertex.function, coordinate_count(medium_effects())
    sizes = [function.numel_out(i) for i in range(function.n_out())]
    ends = np.cumsum([0, *sizes])
    results = [f"y + {end * LANES}" for end in ends[:-1]]
    zero, out, each = [], [], []
    for i, (size, y) in enumerate(zip(sizes, results, strict=True)):
        clear = f"for (long i = 0; i < {size * LANES}; ++i) ({y})[i] = 0.0;"
        if i in vertex.summed:
            zero.append(clear)
            out.append(f"scatter(n, {size}, {size}, {y}, b{i} + {size} * first);")
        else:
            each.append((clear, f"scatter(n, {size}, {size} * elements, {y}, b{i} + {size} * (first * elements + k));"))
    given = ["before", "after", "poses", "settings", "medium", "theta"]
    arguments = ", ".join([*(f"const double *{a}" for a in given), *(f"double *b{i}" for i in range(len(sizes)))])
    taken = f"x, z, poses_, medium + 2 * k, settings_, theta + {coordinates} * k, {', '.join(results)}"
    run = f"{function.name()}(eights, {taken});"
    middle = "\n      ".join([*(clear for clear, _ in each), run, *(scatter for _, scatter in each)])
    body = f"""
void over_steps(long count, {arguments}, long elements) {{
  static _Thread_local double work[{(12 + 4 + 6 + SETTING + int(ends[-1])) * LANES}];
  double *x = work, *z = x + {6 * LANES}, *tail = z + {6 * LANES};
  double *poses_ = tail + {4 * LANES}, *settings_ = poses_ + {6 * LANES}, *y = settings_ + {SETTING * LANES};
{BLOCKS}
    gather(n, eights, 6, 6, poses + 6 * first, poses_);
    gather(n, eights, {SETTING}, {SETTING}, settings + {SETTING} * first, settings_);
    {chr(10).join(zero)}
    for (long k = 0; k < elements; ++k) {{
{links("gather(n, eights, 4, 4 * elements, {} + 4 * (first * elements + {}), {});")}
      {middle}
    }}
    {" ".join(out)}
  }}
}}
"""
    return "\n".join([QUICKLY, PRELUDE, kernel(edge()), kernel(function, [3, 5], add=True), GATHER, body])


def _mapped(
    which: str, law: str, before: Floats, after: Floats, poses: Floats, settings: Floats, medium: Floats, theta: Floats
) -> list[Floats]:
    """The same, BLOCK steps a call, and the last ones filled up: a few maps serve any number of steps."""
    count, elements, _ = before.shape
    rows = [x.reshape(count, -1) for x in (before, after, poses, settings)]
    parts = []
    for first in range(0, count, BLOCK):
        some = [x[first : first + BLOCK] for x in rows]
        size = len(some[0])
        whole = 1 << (size - 1).bit_length()  # the least power of two that holds so many
        some = [np.concatenate([x, np.repeat(x[-1:], whole - size, axis=0)]) for x in some]
        found = evaluate(_map(which, law, elements, whole), *some, medium, theta)
        parts.append([x.reshape(-1, order="A").reshape(whole, -1)[:size] for x in found])
    return [np.concatenate(x) for x in zip(*parts, strict=True)]


@lru_cache(maxsize=128)
def _map(which: str, law: str, elements: int, count: int) -> ca.Function:
    return _step(which, law, elements).map(f"map{count}_{which}", "serial", count, [4, 5], [])


@lru_cache(maxsize=16)
def _step(which: str, law: str, elements: int) -> Any:
    """One step of a body with `elements` vertices."""
    vertex = vertex_functions(law)[which]
    before, after = ca.MX.sym("before", 4, elements), ca.MX.sym("after", 4, elements)
    poses, setting = ca.MX.sym("poses", 6), ca.MX.sym("setting", SETTING)
    medium = ca.MX.sym("medium", 2, elements)
    theta = ca.MX.sym("theta", vertex.function.size1_in(5), elements)
    chain = ca.SX.sym("elements", 4, elements)
    linked = ca.Function("linked", [chain], [with_links(chain)], CSE)
    mapped = vertex.function.map(f"all_{which}", "serial", elements, [2, 4], list(vertex.summed))
    results = mapped(linked(before), linked(after), poses, medium, setting, theta)
    name = f"step_{which}_{law}_{elements}"
    return compiled([ca.Function(name, [before, after, poses, setting, medium, theta], list(results))])[0]
