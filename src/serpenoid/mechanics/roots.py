"""Newton's method for steps with effects, in C: lanes that are done take the next step, so none waits for another.

The method is that of `simulation.newton` for steps that do not know each other, number for number; what is evaluated
are the vertices of `vertices`. Legend: S steps, M elements, P coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np

from serpenoid.body import Floats
from serpenoid.effects.catalogue import medium_effects
from serpenoid.mechanics.columns import call
from serpenoid.mechanics.extended import SETTING, Vertex, coordinate_count, vertex_functions
from serpenoid.mechanics.lanes import LANES, PRELUDE, kernel
from serpenoid.mechanics.vertices import QUICKLY, SOLVED, edge, in_c, links

Roots = Callable[..., tuple[Floats, Floats, Floats, Floats]]

GATHER = f"""
static void gather(long eights, const long *step, const long k, const long apart, const double *a, double *x) {{
  for (long i = 0; i < 8 * eights; ++i)
    for (long r = 0; r < k; ++r) x[r * {LANES} + i] = a[step[i] * apart + r];
}}
"""


@lru_cache(maxsize=64)
def roots(law: str, held: frozenset[str]) -> Roots | None:
    """Second poses of steps by Newton's method, with the medium effects `held`; None where it cannot be compiled.

    Takes before, after (S, M, 4), first poses (S, 3), settings (S, 6), rate (S,) and carried (S, 3) of momenta, a guess
    (S, 3), medium (M, 2), theta (M, P), and limits (3,): the residual that is small enough, the least damping, how many
    iterations. Gives second poses (S, 3), slopes (S, 3, 3) of the residuals, energies (S,) and largest residuals (S,):
    infinite where the guess has none.
    """
    vertex = vertex_functions(law, held)["balance"]
    run = in_c("roots", "roots", vertex, _source)
    if run is None:
        return None

    def found(*given: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        steps, elements, _ = given[0].shape
        answers = np.empty((steps, 3)), np.empty((steps, 3, 3)), np.empty(steps), np.empty(steps)
        call(run, steps, list(given), list(answers), elements)
        return answers

    return found


def _source(vertex: Vertex) -> str:
    """C of `roots`: lanes hold the steps that are not done; a lane that is done takes the next."""
    function, coordinates = vertex.function, coordinate_count(medium_effects())
    sizes = [function.numel_out(i) for i in range(function.n_out())]
    numbers = sum(sizes)
    results = ", ".join(f"y + {sum(sizes[:i]) * LANES}" for i in range(len(sizes)))
    evaluated = f"""
static void evaluated(long eights, const long *step, const double *before, const double *after, const double *starts,
                      const double *settings, const double *medium, const double *theta, const double *ends,
                      long elements, double *y) {{
  static _Thread_local double work[{(12 + 4 + 6 + SETTING) * LANES}];
  double *x = work, *z = x + {6 * LANES}, *tail = z + {6 * LANES};
  double *poses = tail + {4 * LANES}, *setting = poses + {6 * LANES};
  gather(eights, step, 3, 3, starts, poses);
  memcpy(poses + {3 * LANES}, ends, {3 * LANES} * sizeof(double));
  gather(eights, step, {SETTING}, {SETTING}, settings, setting);
  for (long i = 0; i < {numbers * LANES}; ++i) y[i] = 0.0;
  for (long k = 0; k < elements; ++k) {{
{links("gather(eights, step, 4, 4 * elements, {} + 4 * {}, {});")}
    {function.name()}(eights, x, z, poses, medium + 2 * k, setting, theta + {coordinates} * k, {results});
  }}
}}
"""
    run = f"""
typedef struct {{ double size, damping, direction[3]; long tries; }} Lane;

void roots(long count, const double *before, const double *after, const double *starts, const double *settings,
           const double *rate, const double *carried, const double *guess, const double *medium, const double *theta,
           const double *limits, double *ends, double *slopes, double *energy, double *size, long elements) {{
  static _Thread_local double y[{numbers * LANES}], trial[{3 * LANES}];
  static _Thread_local Lane lanes[{LANES}];
  long step[{LANES}], active = 0, next = 0;
  memset(trial, 0, sizeof trial);
  for (;;) {{
    while (active < {LANES} && next < count) {{
      step[active] = next;
      lanes[active].tries = 0;
      for (int j = 0; j < 3; ++j) trial[j * {LANES} + active] = guess[3 * next + j];
      ++active, ++next;
    }}
    if (!active) return;
    const long eights = (active + 7) / 8;
    for (long i = active; i < 8 * eights; ++i) {{
      step[i] = step[active - 1];
      for (int j = 0; j < 3; ++j) trial[j * {LANES} + i] = trial[j * {LANES} + active - 1];
    }}
    evaluated(eights, step, before, after, starts, settings, medium, theta, trial, elements, y);
    long kept = 0;
    for (long i = 0; i < active; ++i) {{
      Lane *lane = lanes + i;
      const long s = step[i];
      double residual[3], now = 0.0;
      for (int j = 0; j < 3; ++j) {{
        residual[j] = y[j * {LANES} + i] + rate[s] * y[(3 + j) * {LANES} + i] + carried[3 * s + j];
        if (!(fabs(residual[j]) <= now)) now = fabs(residual[j]);
      }}
      if (!isfinite(residual[0] + residual[1] + residual[2])) now = INFINITY;
      const int first = lane->tries == 0;
      if (first || now < lane->size) {{
        for (int j = 0; j < 3; ++j) {{
          ends[3 * s + j] = trial[j * {LANES} + i];
          for (int c = 0; c < 3; ++c) {{
            const double *by = y + (7 + 6 * c + j) * {LANES} + i;
            slopes[9 * s + 3 * j + c] = now < INFINITY ? by[0] + rate[s] * by[{3 * LANES}] : 0.0;
          }}
        }}
        energy[s] = y[6 * {LANES} + i], size[s] = lane->size = now;
        memcpy(lane->direction, residual, sizeof residual);
        solved(slopes + 9 * s, 1, lane->direction);
        lane->damping = first ? 1.0 : fmin(1.0, 2.0 * lane->damping);
      }} else {{
        lane->damping /= 3.0;
      }}
      ++lane->tries;
      const int goes = lane->size > limits[0] && lane->size < INFINITY && lane->damping > limits[1];
      if (goes && lane->tries <= limits[2]) {{
        lanes[kept] = *lane, step[kept] = s;
        for (int j = 0; j < 3; ++j)
          trial[j * {LANES} + kept] = ends[3 * s + j] + lanes[kept].damping * lanes[kept].direction[j];
        ++kept;
      }}
    }}
    active = kept;
  }}
}}
"""
    kernels = [kernel(edge()), kernel(function, [3, 5], add=True)]
    return "\n".join([QUICKLY, PRELUDE, *kernels, GATHER, SOLVED, evaluated, run])
