"""Values of windows in units of their noise, independent of one another: whatever is fitted or scored is made of these.

    z = L^-1 x,   L L^T = C                 (C: covariance of a trial's windows, by direction)

Where chance does not last C is diagonal, and z is x over the standard deviations. Where it does (memory.py), and where
draws tell how much of it is of the poses that neighbours share, each window is seen beside what those before it tell.
What repeats share is an error of the law, and belongs to its window: with r its variance over that of chance
(`Memory.shared`) residuals have C + r diag C, whose correlations are those of chance over 1 + r; else a law's error
would count for the more, the longer chance lasts. Variances stay those of chance.

Legend: W windows of a track, R those that are known.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.memory import Memory, roots
from serpenoid.diagnose.data.windows.windows import Track


class White:
    """What makes values of a track's windows white; chance (W, 3): SD, and how long it lasts; doubt of the baseline
    stands beside it. times (W, 3): of how many repeats the values are means. repeats: how many trials share the doubt:
    so much more of it in each is as much in their mean as what they share."""

    def __init__(
        self, track: Track, chance: Floats, memory: Memory, times: Floats | float = 1.0, repeats: int = 1
    ) -> None:
        self.track, self.chance, self.memory = track, chance, memory
        self.doubt = np.sqrt(repeats) * np.broadcast_to(track.doubt, chance.shape)
        self.repeated = np.sqrt(np.broadcast_to(times, chance.shape))
        self._found: dict[bytes, list[tuple[slice, Floats]]] = {}

    @cached_property
    def deviations(self) -> Floats:
        """Of each window alone (W, 3)."""
        return np.hypot(self.chance / self.repeated, self.doubt)

    def of(self, values: Floats, known: np.ndarray) -> Floats:
        """Values (W, 3, ...) of the windows known (W,), window by window and direction by direction (3 R, ...)."""
        if not self.memory.correlates:
            sizes = self.deviations.reshape(*self.chance.shape, *[1] * (values.ndim - 2))
            return np.asarray((values / sizes)[known].reshape(-1, *values.shape[2:]))
        flat = values[known].reshape(int(known.sum()), 3, int(np.prod(values.shape[2:]))).transpose(1, 0, 2)
        white = np.concatenate([inverse @ flat[:, span] for span, inverse in self._inverses(known)], axis=1)
        return np.asarray(white.transpose(1, 0, 2).reshape(-1, *values.shape[2:]))

    def spreads(self, known: np.ndarray) -> Floats:
        """What values of windows known are divided by (3 R,): deviations beside what windows before them tell."""
        if not self.memory.correlates:
            return self.deviations[known].ravel()
        own = [1 / np.diagonal(x[:, :, -x.shape[1] :], axis1=1, axis2=2) for _, x in self._inverses(known)]
        return np.concatenate(own, axis=1).T.ravel()

    def _inverses(self, known: np.ndarray) -> list[tuple[slice, Floats]]:
        """Of windows known; the same in every evaluation."""
        name = known.tobytes()
        if name not in self._found:
            self._found[name] = list(roots(self._covariance, np.flatnonzero(known)))
        return self._found[name]

    def _covariance(self, windows: np.ndarray) -> Floats:
        once, doubt, alone = self.repeated[windows].T, self.doubt[windows].T, np.eye(len(windows))
        chance = self.memory.covariance(self.track, self.chance, windows) / (once[:, :, None] * once[:, None])
        share = 1 / np.sqrt(1 + np.array(self.memory.shared)[:, None] * once**2)
        together = alone + (1 - alone) * share[:, :, None] * share[:, None]
        return np.asarray(chance * together + np.einsum("ki,ij->kij", doubt**2, alone))
