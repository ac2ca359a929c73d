"""Does the interval of K cover the truth of continuous worms, seen at few points? Prints a line a recording, then sums.

    python benchmarks/animal_coverage.py            # 5 to 21 points, K 3 to 20, noise 0.2 and 1 mm of 420 mm
    python benchmarks/animal_coverage.py waves      # what fewer and fewer edges a wave do

Worms of resistive force theory (480 straight pieces, no force and no moment on the whole), 8 s at 30 frames a second,
made without the package.
"""

from __future__ import annotations

import sys
import tempfile
from functools import lru_cache
from pathlib import Path

import numpy as np

from serpenoid.compare.calibrate import anisotropy, drag_ratio
from serpenoid.compare.start import neutral_model
from serpenoid.measure.load import load_campaign

PIECES, RATE, SECONDS, BEAT_HZ, LENGTH_M, SUBSTEPS = 480, 30, 8, 0.5, 0.42, 6
WORMS = ((3.0, 0.7, 0.9), (8.0, 0.95, 0.85), (8.0, 0.6, 0.6), (20.0, 1.3, 0.7))  # K, waves, amplitude [rad]
FEWER = ((8, 1.2), (8, 1.4), (12, 2.2), (20, 3.8), (8, 1.6), (8, 1.8), (12, 2.8), (20, 4.9), (8, 2.2))


def shape(waves: float, amplitude: float, t: float) -> tuple[np.ndarray, np.ndarray]:
    """Ends (PIECES + 1, 2) about the mean of the middles, unit tangents."""
    s = (np.arange(PIECES) + 0.5) / PIECES
    angle = amplitude * np.sin(2 * np.pi * (BEAT_HZ * t + waves * s)) + 0.15 * np.sin(0.7 * t) * (2 * s - 1)
    tangent = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ends = np.concatenate([np.zeros((1, 2)), np.cumsum(tangent, axis=0) / PIECES])
    return ends - ((ends[1:] + ends[:-1]) / 2).mean(axis=0), tangent


def velocity(k: float, waves: float, amplitude: float, t: float) -> np.ndarray:
    """Of the body frame, in the body frame (3,)."""
    ends, tangent = shape(waves, amplitude, t)
    middle, normal = (ends[1:] + ends[:-1]) / 2, np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
    later, before = (shape(waves, amplitude, t + h)[0] for h in (1e-4, -1e-4))
    bending = ((later - before)[1:] + (later - before)[:-1]) / 4e-4
    moves = np.zeros((PIECES, 2, 3))
    moves[:, 0, 0] = moves[:, 1, 1] = 1
    moves[:, :, 2] = np.stack([-middle[:, 1], middle[:, 0]], axis=1)
    resist, thrust = np.zeros((3, 3)), np.zeros(3)
    for weight, way in ((1.0, tangent), (k, normal)):
        by = np.einsum("kia,ki->ka", moves, way)
        resist += weight * by.T @ by
        thrust += weight * by.T @ (bending * way).sum(axis=1)
    return -np.linalg.solve(resist, thrust)


def turn(angle: float) -> np.ndarray:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@lru_cache
def film(k: float, waves: float, amplitude: float) -> np.ndarray:
    """Ends of the pieces in every frame (F, PIECES + 1, 2) [body lengths]."""
    pose, frames, step = np.array([0.0, 0.0, 0.3]), [], 1 / RATE / SUBSTEPS
    for i in range(SECONDS * RATE * SUBSTEPS):
        if i % SUBSTEPS == 0:
            frames.append(shape(waves, amplitude, i * step)[0] @ turn(pose[2]).T + pose[:2])
        moved = velocity(k, waves, amplitude, (i + 0.5) * step) * step
        pose = pose + np.concatenate([turn(pose[2] + moved[2] / 2) @ moved[:2], moved[2:]])
    return np.array(frames)


def measured(worm: tuple[float, float, float], points: int, noise_mm: float, seed: int) -> tuple[np.ndarray, bool]:
    """K over the truth, and the ends of its interval; whether the notes ask for more points."""
    at = np.linspace(0, PIECES, points)
    low = np.minimum(at.astype(int), PIECES - 1)
    share = (at - low)[:, None]
    seen = LENGTH_M * (film(*worm)[:, low] * (1 - share) + film(*worm)[:, low + 1] * share)
    seen = seen + np.random.default_rng([seed, points]).normal(0, noise_mm / 1000, seen.shape)
    with tempfile.TemporaryDirectory() as name:
        table = np.column_stack([np.arange(len(seen)) / RATE, seen.reshape(len(seen), -1)])
        header = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(points))
        np.savetxt(Path(name) / "m.csv", table, fmt="%.7f", delimiter=",", header=header, comments="")
        (Path(name) / "campaign.toml").write_text(
            f'format = 1\nname = "worm"\n[body]\nkind = "crawler"\nvertices = {points}\n[motion]\nformat = "tidy"\n'
            'length_unit = "m"\n[[trial]]\nname = "a"\nmotion = "m.csv"\n'
        )
        campaign = load_campaign(name)
        model = neutral_model(campaign)
        found = np.array(drag_ratio(anisotropy(campaign, model), model)) / worm[0]
    return found, any("track more points" in note for note in campaign.trials[0].notes)


def main() -> None:
    if "waves" in sys.argv:
        cases = [((12.0, waves, 0.65), points, 0.13, 0) for points, waves in FEWER]
    else:
        cases = [(w, n, noise, seed) for n in (5, 7, 11, 21) for w in WORMS for noise in (0.2, 1.0) for seed in (0, 1)]
    sums: dict[tuple[int, bool], list[np.ndarray]] = {}
    for worm, points, noise, seed in cases:
        found, few = measured(worm, points, noise, seed)
        sums.setdefault((points, few), []).append(found)
        words = f"{points} points, K {worm[0]:g}, {worm[1]:g} waves, {noise} mm"
        say(f"{words}: K / truth {found[0]:.4f} ({found[1]:.4f} .. {found[2]:.4f}){', too few points' * few}")
    for (points, few), rows in sorted(sums.items()):
        every = np.array(rows)
        covered = int(((every[:, 1] <= 1) & (every[:, 2] >= 1)).sum())
        half = float(np.median(every[:, 2] - every[:, 1]) / 2)
        words = f"{points} points{', said to be too few' * few}: {covered} of {len(every)} intervals cover the truth"
        say(f"{words}; mean of K / truth {every[:, 0].mean():.4f}, half an interval {half:.4f}")


def say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
