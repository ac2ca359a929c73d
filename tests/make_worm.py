"""The recording of the worm in problems/recordings: a smooth curve in a medium, none of the package's equations.

python tests/make_worm.py        # writes it anew
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from swimmers_by_curves import Curve

FILE = Path(__file__).parents[1] / "problems" / "recordings" / "worm.csv"
RATIO = 5.0  # K, sideways over lengthwise drag: what `fit` is to find
POINTS, FRAMES, BEATS = 15, 161, 4
BEAT_S, LENGTH_MM, NOISE_MM = 2.0, 1.0, 0.001


def rows() -> np.ndarray:
    """Time [s] and x, y of every point [mm], shape (F, 1 + 2 N)."""
    beats, points, _ = Curve(ratio=RATIO, waves=1.3, amplitude=0.9).film(POINTS, FRAMES, BEATS)
    seen = LENGTH_MM * points + np.random.default_rng(5).normal(0, NOISE_MM, points.shape)
    return np.hstack([BEAT_S * beats[:, None], seen.reshape(FRAMES, -1)])


def main() -> None:
    """Write it."""
    header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(POINTS))
    np.savetxt(FILE, rows(), "%.4f", ",", header=header, comments="")


if __name__ == "__main__":
    main()
