"""Films in pixels of animals of which only the length is given: is the scale that is found right, and K with it?

    python benchmarks/pixel_scale.py            # 64 films: a line each, then sums
    python benchmarks/pixel_scale.py 8 5        # 8 films, from the 6th on

Each film is of another body: K, waves, bends, points, frames a beat, beats, pixels, noise and hidden points by chance.
It is fitted with `length_m` alone and, as a control, with `metres_per_pixel` beside it. The bodies are smooth curves in
a medium that resists slip across them K times as much as along: sums of three travelling waves under envelopes,
integrals along the body by Simpson's rule, in time by splines over eight moments a frame, without the package.
"""

from __future__ import annotations

import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import cumulative_simpson
from scipy.interpolate import CubicSpline

from serpenoid.compare.calibrate import anisotropy, drag_ratio
from serpenoid.compare.start import neutral_model
from serpenoid.measure.load import load_campaign

FILMS, OFTEN, PIECES, LENGTH_M = 64, 8, 400, 0.2
FEWEST_EDGES = 6.5  # a wave: with fewer the curve between points is guessed, which is another study


@dataclass(frozen=True)
class Case:
    """noise: of a point, over the distance between points; hidden: share of the points."""

    ratio: float  # K
    waves: float
    bend: float  # rad, amplitude of the tangent angle
    points: int
    frames_a_beat: int
    beats: float
    pixels: float  # body length
    noise: float
    hidden: float
    seed: int


def case(index: int) -> Case:
    rng = np.random.default_rng([26, index])
    waves = rng.uniform(0.5, 1.7)
    least = int(np.ceil(FEWEST_EDGES * max(waves, 1.0))) + 1
    return Case(
        float(np.exp(rng.uniform(np.log(1.6), np.log(20)))), float(waves), float(rng.uniform(0.4, 1.0)),
        int(rng.integers(least, 26)), int(rng.integers(14, 45)), float(rng.uniform(3, 8)),
        float(np.exp(rng.uniform(np.log(80), np.log(1500)))), float(np.exp(rng.uniform(np.log(0.004), np.log(0.12)))),
        float(rng.choice([0.0, 0.0, 0.04, 0.12])), index,
    )  # fmt: skip


def film(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) [s] of a beat of 1 s, points (F, N, 2) [body lengths], tail first."""
    rng = np.random.default_rng([27, case.seed])
    every = 2 * max(1, PIECES // 2 // (case.points - 1))
    s = np.linspace(0, 1, every * (case.points - 1) + 1)
    t = np.arange(int(case.beats * case.frames_a_beat) * OFTEN + 1) / OFTEN / case.frames_a_beat
    angle, rate = np.zeros((len(t), len(s))), np.zeros((len(t), len(s)))
    shares, lean = (1.0, *rng.uniform(0, 0.2, 2)), rng.uniform(-0.4, 0.4)
    for beats, waves, share in zip((1, 2, rng.uniform(0.2, 0.5)), (1, 1.6, 0.5), shares, strict=True):
        high = case.bend * share * (1 + lean * (2 * s - 1)) * (1 + 0.3 * rng.uniform(-1, 1) * (2 * s - 1) ** 2)
        phase = 2 * np.pi * (beats * t[:, None] + waves * case.waves * s + rng.uniform())
        angle += high * np.sin(phase)
        rate += high * 2 * np.pi * beats * np.cos(phase)
    return t[::OFTEN], carried(case.ratio, s, t, angle, rate)[::OFTEN, ::every]


def carried(ratio: float, s: np.ndarray, t: np.ndarray, angle: np.ndarray, rate: np.ndarray) -> np.ndarray:
    """Where a body without force and moment goes that bends like that: (moments, places, 2)."""
    weight = np.ones(len(s))
    weight[1:-1:2], weight[2:-1:2] = 4, 2
    weight /= weight.sum()
    way = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    across = np.stack([-way[..., 1], way[..., 0]], axis=2)
    place, bending = (cumulative_simpson(v, x=s, axis=1, initial=0) for v in (way, across * rate[..., None]))
    place, bending = (v - np.einsum("q,tqc->tc", weight, v)[:, None] for v in (place, bending))
    resist, thrust = np.zeros((len(t), 3, 3)), np.zeros((len(t), 3))
    for drag, along in ((1.0, way), (ratio, across)):
        spin = place[..., 0] * along[..., 1] - place[..., 1] * along[..., 0]
        moves = np.concatenate([along, spin[..., None]], axis=2)
        resist += drag * np.einsum("tqa,tqb,q->tab", moves, moves, weight)
        thrust -= drag * np.einsum("tqa,tqc,tqc,q->ta", moves, bending, along, weight)
    velocity = np.linalg.solve(resist, thrust[..., None])[..., 0]
    heading = CubicSpline(t, velocity[:, 2]).antiderivative()(t)
    turn = np.stack([np.cos(heading), -np.sin(heading), np.sin(heading), np.cos(heading)], axis=1).reshape(-1, 2, 2)
    centre = CubicSpline(t, np.einsum("tij,tj->ti", turn, velocity[:, :2])).antiderivative()(t)
    return np.einsum("tij,tqj->tqi", turn, place) + centre[:, None]


def fitted(case: Case, seen: np.ndarray, time_s: np.ndarray, more: str = "") -> tuple[float, np.ndarray]:
    """Scale over the true one, K over the truth with the ends of its interval; more: keys of [motion]."""
    with tempfile.TemporaryDirectory() as name:
        np.savez(Path(name) / "m.npz", t_s=time_s, points=seen)
        (Path(name) / "campaign.toml").write_text(
            f'format = 1\nname = "worm"\n[body]\nkind = "crawler"\nvertices = {case.points}\nlength_m = {LENGTH_M}\n'
            f'[motion]\nformat = "array"\nlength_unit = "px"\n{more}[[trial]]\nname = "a"\nmotion = "m.npz"\n'
        )
        campaign = load_campaign(name)
        model = neutral_model(campaign)
        found = np.array(drag_ratio(anisotropy(campaign, model), model)) / case.ratio
        markers = campaign.trials[0].motion.markers
    one = seen[..., 0] / markers[..., 0] / case.pixels
    return float(np.nanmedian(one)), found


def filmed(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Times, and points (F, N, 2) [px] with noise, NaN hidden."""
    rng = np.random.default_rng([28, case.seed])
    time_s, points = film(case)
    seen = case.pixels * (points + rng.normal(0, case.noise / (case.points - 1), points.shape)) + 900
    seen[rng.random(seen.shape[:2]) < case.hidden] = np.nan
    return time_s, seen


def covers(rows: np.ndarray) -> int:
    return int(((rows[:, 1] <= 1) & (rows[:, 2] >= 1)).sum())


def main() -> None:
    count, first = (*map(int, sys.argv[1:]), *(FILMS, 0)[len(sys.argv) - 1 :])
    scales, alone, control = [], [], []
    for index in range(first, first + count):
        one = case(index)
        time_s, seen = filmed(one)
        scale, found = fitted(one, seen, time_s)
        _, known = fitted(one, seen, time_s, f"metres_per_pixel = {LENGTH_M / one.pixels!r}\n")
        scales.append(scale)
        alone.append(found)
        control.append(known)
        say(
            f"{index:3d} K {one.ratio:5.2f}, {one.points:2d} points, {one.waves:.2f} waves, noise {one.noise:5.1%}, "
            f"{one.hidden:4.0%} hidden: scale {scale - 1:+.4%}, K {found[0]:.4f} ({found[1]:.4f} .. {found[2]:.4f}), "
            f"with the scale given {known[0]:.4f} ({known[1]:.4f} .. {known[2]:.4f})"
        )
    off = np.array(scales) - 1
    say(f"scale off: mean {off.mean():+.4%}, median {np.median(off):+.4%}, RMS {np.sqrt((off**2).mean()):.4%}")
    for words, rows in (("`length_m` alone", np.array(alone)), ("the scale given", np.array(control))):
        half = np.median((rows[:, 2] - rows[:, 1]) / 2)
        say(f"{words}: {covers(rows)} of {len(rows)} intervals hold K, median error {np.median(rows[:, 0]) - 1:+.4%}, "
            f"median |error| {np.median(abs(rows[:, 0] - 1)):.4%}, half an interval {half:.4%}")  # fmt: skip


def say(line: str) -> None:
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
