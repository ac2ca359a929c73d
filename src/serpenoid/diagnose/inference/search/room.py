"""What repeats differ by and is no chance: the room, which a body at another heading feels from another side.

    d = X theta + chance      (d: difference of two repeats' residuals; X: of the columns of effects of the room)

Differences of repeats tell chance. An effect that says it is of the room (a slope, a frame that moves as water does)
is taken out of them first, where that makes them likelier by the price of an effect: ln n for each parameter and 2 ln M
for M candidates. How long chance lasts is told anew each time, so chance that lasts competes with the room for what
differs from trial to trial. Where repeats were laid alike X is next to nothing, and nothing is taken out.

Legend: W windows of a track, P columns of an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.body import Floats
from serpenoid.diagnose.data.noise.motion import Motion, Noise
from serpenoid.diagnose.data.noise.noise import residuals, window_noise
from serpenoid.diagnose.data.noise.repeats import chance_from, repeats
from serpenoid.diagnose.data.windows.windows import columns_of, predictions
from serpenoid.diagnose.inference.fits.medium import Fit, candidates_of
from serpenoid.diagnose.inference.fits.prices import gained_by_chance

CONVERGED = 0.02  # of ln likelihood


@dataclass(frozen=True)
class Told:
    """Noise by the differences of residuals (W, 3) of each track; how many numbers these are, and parameters that were
    fitted to them."""

    noise: Noise
    left: Sequence[Floats]
    numbers: int
    fitted: int = 0

    @property
    def likelihood(self) -> float:
        """ln of it, but for a constant."""
        return self.noise.memory.likelihood

    def unbiased(self, motion: Motion) -> Noise:
        """Noise of as many numbers as are left."""
        if not self.fitted:
            return self.noise
        larger = np.sqrt(self.numbers / max(self.numbers - self.fitted, 1))
        return window_noise(motion.tracks, [larger * x for x in self.left])[0]


def chance(motion: Motion, base: Fit) -> Noise:
    """Noise by what repeats differ by about a fit, beside what effects of the room that it has not explain of that, and
    by what an earlier campaign's differed by."""
    noise = _chance(motion, base)
    return replace(noise, memory=noise.memory.beside(motion.earlier.scattered))


def _chance(motion: Motion, base: Fit) -> Noise:
    left = residuals(motion.tracks, base.predictions)
    found = Told(window_noise(motion.tracks, left)[0], left, 0)
    candidates = [c for c in candidates_of(base) if c.effect.of_the_room and c.name not in motion.untestable]
    absent = [c for c in candidates if c.key not in {e.key for e in base.model.effects}]
    if chance_from(motion.tracks) not in ("trials", "cycles") or not absent:
        return found.noise
    seen = predictions(base.model, motion.tracks, absent, base.predictions)
    columns = [[p.by(columns_of([e])) for p in seen] for e in absent]
    taken: list[int] = []
    while len(taken) < len(absent):
        tries = {
            i: _beside(motion, left, [columns[k] for k in (*taken, i)], found)
            for i in range(len(absent))
            if i not in taken
        }
        best = max(tries, key=lambda i: 2 * tries[i].likelihood - _toll(tries[i]))
        gained = 2 * (tries[best].likelihood - found.likelihood) - _toll(tries[best]) + _toll(found)
        if gained <= gained_by_chance(len(absent)):
            break
        found, taken = tries[best], [*taken, best]
    return found.unbiased(motion)


def _toll(told: Told) -> float:
    """See `Evidence.toll`."""
    return told.fitted * float(np.log(max(told.numbers, 2)))


def _beside(motion: Motion, left: Sequence[Floats], effects: Sequence[Sequence[Floats]], begun: Told) -> Told:
    """Told beside effects, by columns (W, 3, P) of each track, as large as makes differences likeliest: by weighted
    least squares, whose weights are the noise that they leave."""
    columns = [np.concatenate(of, axis=2) for of in zip(*effects, strict=True)]
    while True:
        new = _fitted(motion, left, columns, begun.noise)
        if begun.fitted == new.fitted and new.likelihood < begun.likelihood + CONVERGED:
            return begun
        begun = new


def _fitted(motion: Motion, left: Sequence[Floats], columns: Sequence[Floats], noise: Noise) -> Told:
    """Differences while playing, in units of noise, explained by those of the columns."""
    rows, by = [], []
    for r in repeats(motion.tracks):
        track = motion.tracks[r.one]
        (one, other), (here, there) = r.both(left), r.both(columns)
        d, x = one - other, here - there
        use = track.playing[r.here] & np.isfinite(d).all(axis=1) & np.isfinite(x).all(axis=(1, 2))
        size = noise.chance(track)[r.here][use]
        rows.append((d[use] / size).ravel())
        by.append((x[use] / size[..., None]).reshape(-1, x.shape[2]))
    values = np.linalg.lstsq(np.concatenate(by), np.concatenate(rows), rcond=None)[0]
    rest = [x - c @ values for x, c in zip(left, columns, strict=True)]
    return Told(window_noise(motion.tracks, rest)[0], rest, sum(map(len, rows)), len(values))
