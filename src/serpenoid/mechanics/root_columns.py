"""How roots of steps with effects move with some of the parameters, in C: no derivative is kept that nobody asked for.

By the implicit function theorem, as `simulation.newton.implicit_derivative`; what is evaluated are the vertices of
`vertices`. Legend: S steps, M elements, P coordinates, K columns.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.catalogue import medium_effects
from serpenoid.mechanics.columns import BLOCKS, GATHER, call
from serpenoid.mechanics.extended import SETTING, Vertex, coordinate_count, vertex_functions
from serpenoid.mechanics.lanes import LANES, PRELUDE, kernel
from serpenoid.mechanics.vertices import QUICKLY, SOLVED, edge, in_c, links

RootColumns = Callable[..., Floats]


@lru_cache(maxsize=64)
def root_columns(law: str, held: frozenset[str]) -> RootColumns | None:
    """Derivatives of relative poses, with the medium effects `held`; None where it cannot be compiled.

    Takes before, after (S, M, 4), first and second poses (S, 6), settings (S, 6), slopes of the residuals (S, 3, 3),
    medium (M, 2), theta (M, P), and columns (K, 2): place (below zero: none) and number among the derivatives of
    `extended.vertex_functions`' "sensitivity" with a place, or without one. Gives (S, 3, K).
    """
    vertex = vertex_functions(law, held)["sensitivity"]
    run = in_c("root_columns", "root_columns", vertex, _source)
    if run is None:
        return None

    def found(*given: Floats) -> Floats:
        steps, elements, _ = given[0].shape
        moved = np.empty((steps, 3, len(given[-1])))
        call(run, steps, list(given), [moved], elements, len(given[-1]))
        return moved

    return found


def _source(vertex: Vertex) -> str:
    """C of `root_columns`: block after block of steps; the columns asked for are picked, then solved and turned."""
    function, coordinates = vertex.function, coordinate_count(medium_effects())
    every, some = (function.numel_out(i) for i in range(2))
    put = "for (long i = 0; i < n; ++i) for (long j = 0; j < 3; ++j)\n        b[((first + i) * 3 + j) * width + w] ="
    body = f"""
void root_columns(long count, const double *before, const double *after, const double *poses, const double *settings,
                  const double *slopes, const double *medium, const double *theta, const double *columns, double *b,
                  long elements, long width) {{
  static _Thread_local double work[{(12 + 4 + 6 + SETTING + every + some) * LANES}];
  double *x = work, *z = x + {6 * LANES}, *tail = z + {6 * LANES};
  double *poses_ = tail + {4 * LANES}, *settings_ = poses_ + {6 * LANES}, *y = settings_ + {SETTING * LANES};
  double *own = y + {every * LANES};
{BLOCKS}
    gather(n, eights, 6, 6, poses + 6 * first, poses_);
    gather(n, eights, {SETTING}, {SETTING}, settings + {SETTING} * first, settings_);
    for (long i = 0; i < {every * LANES}; ++i) y[i] = 0.0;
    for (long k = 0; k < elements; ++k) {{
{links("gather(n, eights, 4, 4 * elements, {} + 4 * (first * elements + {}), {});")}
      for (long i = 0; i < {some * LANES}; ++i) own[i] = 0.0;
      {function.name()}(eights, x, z, poses_, medium + 2 * k, settings_, theta + {coordinates} * k, y, own);
      for (long w = 0; w < width; ++w) if ((long)columns[2 * w] == k)
        {put} own[(6 * (long)columns[2 * w + 1] + j) * {LANES} + i];
    }}
    for (long w = 0; w < width; ++w) if (columns[2 * w] < 0.0)
      {put} y[(6 * (long)columns[2 * w + 1] + j) * {LANES} + i];
    for (long i = 0; i < n; ++i) {{
      double *to = b + (first + i) * 3 * width;
      const double turned = poses[6 * (first + i) + 2], c = cos(turned), s = sin(turned);
      solved(slopes + 9 * (first + i), width, to);
      for (long w = 0; w < width; ++w) {{
        const double x = to[w], y_ = to[width + w];
        to[w] = c * x + s * y_, to[width + w] = c * y_ - s * x;
      }}
    }}
  }}
}}
"""
    return "\n".join([QUICKLY, PRELUDE, kernel(edge()), kernel(function, [3, 5], add=True), GATHER, SOLVED, body])
