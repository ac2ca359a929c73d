"""Forward substitution through chains of steps: a block-banded system whose blocks stand on and below the diagonal.

    slopes[0, i] x_i + slopes[1, i] x_{i-1} + .. = right_i        (terms before a chain's first step are left out)

In C where a compiler exists, else by SciPy's banded solver.

Legend: n steps of G chains, K ages, d unknowns of a step, P right sides.
"""

from __future__ import annotations

import ctypes
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.linalg import LinAlgError, solve_banded

from serpenoid.body import Floats
from serpenoid.mechanics.compile import loaded

LONG = np.dtype("l")
SOURCE = """#include <math.h>
#include <string.h>
static void swapped(const long k, double *a, double *b) {
  for (long i = 0; i < k; ++i) { const double y = a[i]; a[i] = b[i]; b[i] = y; }
}
static int solved(const long d, const long p, double *a, double *x) {
  for (long c = 0; c < d; ++c) {
    long best = c;
    for (long r = c + 1; r < d; ++r)
      if (fabs(a[r * d + c]) > fabs(a[best * d + c])) best = r;
    if (!(fabs(a[best * d + c]) > 0.0)) return 0;
    if (best != c) {
      swapped(d, a + c * d, a + best * d);
      swapped(p, x + c * p, x + best * p);
    }
    for (long r = c + 1; r < d; ++r) {
      const double by = a[r * d + c] / a[c * d + c];
      for (long j = c + 1; j < d; ++j) a[r * d + j] -= by * a[c * d + j];
      for (long j = 0; j < p; ++j) x[r * p + j] -= by * x[c * p + j];
    }
  }
  for (long r = d - 1; r >= 0; --r)
    for (long j = 0; j < p; ++j) {
      for (long c = r + 1; c < d; ++c) x[r * p + j] -= a[r * d + c] * x[c * p + j];
      x[r * p + j] /= a[r * d + r];
      if (!isfinite(x[r * p + j])) return 0;
    }
  return 1;
}
void substitute(const long chains, const long *lengths, const long ages, const long d, const long p, const long steps,
                const double *slopes, const double *right, double *found, double *own) {
  memcpy(found, right, sizeof(double) * steps * d * p);
  for (long g = 0, first = 0; g < chains; first += lengths[g++])
    for (long i = 0; i < lengths[g]; ++i) {
      double *x = found + (first + i) * d * p;
      for (long k = 1; k < ages && k <= i; ++k) {
        const double *by = slopes + (k * steps + first + i) * d * d, *behind = x - k * d * p;
        for (long r = 0; r < d; ++r)
          for (long c = 0; c < d; ++c)
            for (long j = 0; j < p; ++j) x[r * p + j] -= by[r * d + c] * behind[c * p + j];
      }
      memcpy(own, slopes + (first + i) * d * d, sizeof(double) * d * d);
      if (!solved(d, p, own, x)) {
        memset(found + first * d * p, 0, sizeof(double) * lengths[g] * d * p);
        break;
      }
    }
}
"""


def substituted(slopes: Floats, right: Floats, chains: np.ndarray) -> Floats:
    """Solutions (n, d, P) from slopes (K, n, d, d) and right sides (n, d, P) of chains of so many steps (G,).

    Zero throughout a chain whose system is singular.
    """
    run = _substitute()
    if run is None:
        ends = np.cumsum(chains)[:-1]
        parts = zip(np.split(slopes, ends, axis=1), np.split(right, ends), strict=True)
        return np.concatenate([banded(*part) for part in parts])
    ages, steps, d, _ = slopes.shape
    lengths = np.ascontiguousarray(chains, LONG)
    given, found, own = (
        [np.ascontiguousarray(a, float) for a in (slopes, right)],
        np.empty(right.shape),
        np.empty((d, d)),
    )
    arrays = [ctypes.c_void_p(a.ctypes.data) for a in (*given, found, own)]
    numbers = [ctypes.c_long(n) for n in (ages, d, right.shape[2], steps)]
    run(ctypes.c_long(len(lengths)), ctypes.c_void_p(lengths.ctypes.data), *numbers, *arrays)
    return found


def banded(slopes: Floats, right: Floats) -> Floats:
    """The same of one chain, by SciPy."""
    k, count, d, _ = slopes.shape
    lower, upper = d * k - 1, d - 1
    bands = np.zeros((lower + upper + 1, d * count))
    row, column = np.meshgrid(np.arange(d), np.arange(d), indexing="ij")
    for below in range(k):
        steps = np.arange(below, count)
        i, j = d * steps[:, None, None] + row, d * (steps[:, None, None] - below) + column
        bands[upper + i - j, j] = slopes[below, below:]
    if not np.isfinite(bands).all():
        return np.zeros_like(right)
    try:
        found = solve_banded((lower, upper), bands, right.reshape(d * count, right.shape[2]))
    except LinAlgError:
        return np.zeros_like(right)
    return np.asarray(found).reshape(right.shape)


@lru_cache(maxsize=1)
def _substitute() -> Any:
    return loaded("substitute", SOURCE, lambda library: ctypes.CDLL(library).substitute)
