"""Model discrepancy: what repeats share and no explanation accounts for; its variance by marginal likelihood.

    r = X theta + d + e        V = cov(d + e) = E + sum_k s_k Z_k Z_k^T        log L = -(log |V| + r^T V^{-1} r) / 2

r: residuals of windows in units of the noise level (E = I). d is alike in repeats, and the sum of what belongs to a
setting as a whole, to a phase of its cycle, to a single window, and, in pauses, of a part as large as the sliding that
the model predicts there. Sizes s_k [body lengths squared; of the sliding: its square] are those most likely given an
explanation. So d shrinks when a true cause enters, and hardly when something stands in for it.

MacKay's fixed point (Neural Computation 4, 415, 1992) for variances: s <- s (a^T D a) / tr(V^{-1} D), a = V^{-1} r.

Legend: B blocks (a setting in one direction), n rows of the longest (shorter ones padded), K parts of d.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from serpenoid.body import Floats
from serpenoid.diagnose.data.windows import Track

GYRATION = 0.29  # of a straight rod, body lengths: turns as motions of its points
PARTS = ("setting", "phase", "window", "sliding")
ROUNDS, ALIKE = 60, 2e-2  # of the fixed point; change of every ln s at which it ends
LEAST, FIRST = 1e-12, 1e-5  # s, as LEAST: none; where it begins (3 mm of a body of a metre)


@dataclass(frozen=True)
class Rows:
    """Where each residual (R,) belongs: setting, direction, window and phase within it; scale (R,): body lengths or
    radians of it in noise levels; playing (R,); slid (R,): predicted displacement in noise levels."""

    setting: NDArray[np.int64]
    direction: NDArray[np.int64]
    window: NDArray[np.int64]
    phase: NDArray[np.int64]
    playing: NDArray[np.bool_]
    scale: Floats
    slid: Floats


def rows_of(
    tracks: Sequence[Track], used: Sequence[np.ndarray], noise: Sequence[Floats], moved: Sequence[Floats]
) -> Rows:
    """Rows of the used windows of all tracks; noise, moved: (B - 1, 3) each."""
    settings: dict[object, int] = {}
    parts: list[tuple[np.ndarray, ...]] = []
    for number, (track, use, level, steps) in enumerate(zip(tracks, used, noise, moved, strict=True)):
        own = track.noise is not None  # such tracks are parts of one recording: no window is repeated
        setting = settings.setdefault(track.recording.setting, len(settings))
        length = track.recording.body.total_length_m
        index = np.flatnonzero(use)
        window = index + (number * 100_000 if own else 0)
        phase = np.round(track.phase[use] * 1000).astype(int)
        count = len(index)
        unit = np.array([length, length, 1 / GYRATION])
        parts.append(
            (
                np.full(3 * count, setting), np.tile([0, 1, 2], count), np.repeat(window, 3), np.repeat(phase, 3),
                np.repeat(track.playing[use], 3), (unit / level[use]).ravel(), (steps / level)[use].ravel(),
            )
        )  # fmt: skip
    return Rows(*(np.concatenate(column) for column in zip(*parts, strict=True)))


@dataclass(frozen=True)
class Blocks:
    """index (B, n): rows of each block, -1 where padded; parts (K, B, n, n): Z Z^T of each part of d."""

    index: NDArray[np.int64]
    parts: Floats

    @classmethod
    def of(cls, rows: Rows) -> Blocks:
        names = rows.setting * 3 + rows.direction
        members = [np.flatnonzero(names == name) for name in np.unique(names)]
        longest = max((len(m) for m in members), default=0)
        index = np.full((len(members), longest), -1)
        parts = np.zeros((len(PARTS), len(members), longest, longest))
        for b, m in enumerate(members):
            index[b, : len(m)] = m
            both = rows.playing[m][:, None] & rows.playing[m]
            same_window = rows.window[m][:, None] == rows.window[m]
            same_phase = rows.phase[m][:, None] == rows.phase[m]
            scaled = np.outer(rows.scale[m], rows.scale[m])
            slid = np.outer(rows.slid[m], rows.slid[m]) * (same_window & ~both)
            own = (scaled * both, scaled * (same_phase & both), scaled * same_window, slid)
            parts[:, b, : len(m), : len(m)] = own
        return cls(index, parts)

    def padded(self, values: Floats) -> Floats:
        """Rows (R, ...) as blocks (B, n, ...)."""
        found = values[self.index]
        found[self.index < 0] = 0.0
        return np.asarray(found)

    def covariance(self, sizes: Floats) -> Floats:
        """V (B, n, n) of sizes (K,)."""
        return np.eye(self.index.shape[1]) + np.einsum("k,kbij->bij", sizes, self.parts)

    def whitened(self, values: Floats, sizes: Floats) -> Floats:
        """L^{-1} of rows (R, P), V = L L^T, in their order."""
        if not sizes.any() or not self.index.size:
            return values
        white = np.linalg.solve(np.linalg.cholesky(self.covariance(sizes)), self.padded(values))
        result = np.empty_like(values)
        result[self.index[self.index >= 0]] = white[self.index >= 0]
        return result

    def log_determinant(self, sizes: Floats) -> float:
        """ln |V|."""
        return float(np.linalg.slogdet(self.covariance(sizes))[1].sum()) if self.index.size else 0.0

    def likeliest(self, residuals: Floats, start: Floats | None = None) -> Floats:
        """Sizes (K,) of the discrepancy that make these residuals (R,) most likely."""
        left = self.padded(residuals)
        sizes = np.full(len(PARTS), FIRST) if start is None else np.maximum(start, FIRST / 100)
        sizes = np.where(self.parts.any(axis=(1, 2, 3)), sizes, 0.0)
        for _ in range(ROUNDS):
            inverse = np.linalg.inv(self.covariance(sizes))
            pull = np.einsum("bij,bj->bi", inverse, left)
            found = np.einsum("bi,kbij,bj->k", pull, self.parts, pull)
            expected = np.einsum("bij,kbij->k", inverse, self.parts)
            share = np.where(sizes > 0, found / np.where(expected > 0, expected, 1.0), 1.0)
            sizes = np.where(sizes * share > LEAST, sizes * share, 0.0)
            if (np.abs(np.log(np.maximum(share, LEAST))) < ALIKE)[sizes > 0].all():
                break
        return sizes
