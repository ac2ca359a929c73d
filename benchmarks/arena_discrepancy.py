"""What the drag model gets wrong about the healthy arena robot: its contact law restored term by term.

serpenoid arena run problems/protocols/six-gaits.toml --out results/healthy
python benchmarks/arena_discrepancy.py results/healthy > results/benchmarks/arena_discrepancy.md

Force balance at every step of the measured shapes, with the arena's own numbers; only the baseline's eps is fitted.
Wheel pair: grip g u / |u| of the slip u = (b omega, v_n) with half-track b; rolling resistance r v_t / |v_t| + d v_t.
Legend: S steps, N vertices.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace

import numpy as np

from serpenoid.diagnose.data.cameras.observation import Observation
from serpenoid.diagnose.data.noise.motion import Motion
from serpenoid.diagnose.data.noise.noise import residuals
from serpenoid.diagnose.data.noise.paths import path_error
from serpenoid.diagnose.data.recordings.reading import read_recordings
from serpenoid.diagnose.data.shapes.geometry import turn
from serpenoid.diagnose.data.windows.tracks import make_tracks
from serpenoid.diagnose.data.windows.windows import Prediction, Track
from serpenoid.diagnose.diagnose import choose_observation
from serpenoid.diagnose.inference.fits.medium import fit_eps
from serpenoid.diagnose.inference.search.select import calibrated
from serpenoid.diagnose.stages.motion.choose_motion import GUESS
from serpenoid.diagnose.start import baseline
from serpenoid.group import accumulate, relative

Floats = np.ndarray
CREEP = 2e-3  # m/s: over which the arena's soft contacts reach their full friction


@dataclass(frozen=True)
class Law:
    """mount: wheels roll along the link behind the joint (else the mean of both links); offset [m] behind the axis."""

    grip: float = 0.6
    rolling: float = 0.05
    damping: float = 1.0
    half_track: float = 0.025
    mount: bool = True
    offset: float = 0.01823
    loads: Floats | None = None


def forces(law: Law, turning: Floats, along: Floats, across: Floats) -> tuple[Floats, Floats, Floats]:
    """Per load: along the wheel, across it, moment (S, N)."""
    scrub = law.half_track * turning
    slip = np.sqrt(across**2 + scrub**2 + CREEP**2)
    roll = law.rolling * along / np.sqrt(along**2 + CREEP**2 / 4) + law.damping * along
    return roll, law.grip * across / slip, law.grip * law.half_track * scrub / slip


def contacts(law: Law, track: Track) -> tuple[Floats, Floats, Floats, Floats, Floats]:
    """Contact points, their velocities, rolling directions, turning rates in the body frame, durations."""
    dt = np.diff(track.time)
    points = (track.vertices[1:] + track.vertices[:-1]) / 2
    speeds = np.diff(track.vertices, axis=0) / dt[:, None, None]
    edge, rate = np.diff(points, axis=1), np.diff(speeds, axis=1)
    length = np.linalg.norm(edge, axis=2, keepdims=True)
    edge, turning = edge / length, (edge[..., 0] * rate[..., 1] - edge[..., 1] * rate[..., 0]) / length[..., 0] ** 2
    behind, ahead = (np.concatenate(x, axis=1) for x in ((edge[:, :1], edge), (edge, edge[:, -1:])))
    tail, head = (np.concatenate(x, axis=1) for x in ((turning[:, :1], turning), (turning, turning[:, -1:])))
    wheel, omega = (behind, tail) if law.mount else (behind + ahead, (tail + head) / 2)
    wheel = wheel / np.linalg.norm(wheel, axis=2, keepdims=True)
    inner = np.full((points.shape[1], 1), law.offset)
    inner[[0, -1]] = 0
    return points - inner * wheel, speeds - inner * omega[..., None] * left(wheel), wheel, omega, dt


def left(v: Floats) -> Floats:
    return np.stack([-v[..., 1], v[..., 0]], axis=-1)


def body_velocities(law: Law, track: Track) -> Floats:
    """(S, 3) that balance all forces, by damped Newton steps."""
    c, moving, wheel, omega, dt = contacts(law, track)
    loads = track.recording.body.vertex_weights if law.loads is None else law.loads

    def wrench(x: Floats) -> Floats:
        v = moving + x[:, None, :2] + x[:, None, 2:] * left(c)
        f_t, f_n, m = forces(law, omega + x[:, 2:], (v * wheel).sum(axis=-1), (v * left(wheel)).sum(axis=-1))
        f = loads[:, None] * (f_t[..., None] * wheel + f_n[..., None] * left(wheel))
        moment = c[..., 0] * f[..., 1] - c[..., 1] * f[..., 0] + loads * m
        return np.concatenate([f.sum(axis=1), moment.sum(axis=1)[:, None]], axis=1)

    x, damping = np.zeros((len(dt), 3)), np.zeros(len(dt))
    now = wrench(x)
    for _ in range(60):
        slope = np.stack([(wrench(x + h) - now) / h.sum() for h in np.diag([1e-6, 1e-6, 1e-5])], axis=2)
        regular = slope + damping[:, None, None] * slope * np.eye(3) + 1e-12 * np.eye(3)
        trial = x - np.linalg.solve(regular, now[..., None])[..., 0]
        new = wrench(trial)
        better = (new**2).sum(axis=1) < (now**2).sum(axis=1)
        x, now = np.where(better[:, None], trial, x), np.where(better[:, None], new, now)
        damping = np.where(better, damping / 5, np.maximum(4 * damping, 1e-3))
    return np.column_stack([turn(x[:, 2] * dt / 2, x[:, :2]) * dt[:, None], x[:, 2] * dt])


def predicted(law: Law, track: Track) -> Prediction:
    path = accumulate(body_velocities(law, track), track.poses[0])[track.boundaries]
    return Prediction(relative(path[:-1], path[1:]), np.zeros(0), ())


def row(name: str, motion: Motion, predictions: list[Prediction]) -> None:
    left_over = residuals(motion.tracks, predictions)
    white = np.concatenate([r / motion.noise.of(t) for r, t in zip(left_over, motion.tracks, strict=True)])
    path = 1e3 * path_error(motion, predictions)
    sys.stdout.write(f"| {name} | {np.sqrt(np.nanmean(white**2)):.1f} | {path:.0f} |\n")


def main() -> None:
    file, recordings = read_recordings(sys.argv[1])
    _, seen = choose_observation(recordings, Observation.neutral(file.body))
    gaits = list(dict.fromkeys(r.gait for r in recordings))
    model = baseline(None, file, file.body)
    for _ in range(2):
        tracks = make_tracks(recordings, seen, model)
        motion = Motion(tracks, GUESS, tuple(gaits.index(r.gait) for r in recordings))
        model = fit_eps(motion, model).model
    motion, null = calibrated(motion, fit_eps(motion, model))
    sys.stdout.write("`python benchmarks/arena_discrepancy.py`: RMS of what windows leave over chance; path RMS\n\n")
    sys.stdout.write("| law | windows [SD] | paths [mm] |\n| --- | --- | --- |\n")
    row(f"baseline, eps {null.model.medium.anisotropy_ratio:.3f} fitted", motion, list(null.predictions))
    arena = Law()
    laws = {
        "the arena's contact law": arena,
        "... rolling along the mean of both links": replace(arena, mount=False),
        "... wheels under the axes": replace(arena, offset=0.0),
        "... no dry rolling resistance": replace(arena, rolling=0.0),
        "... wheel pairs without width": replace(arena, half_track=0.0),
        "... equal loads": replace(arena, loads=np.full(file.body.vertices, 1 / file.body.vertices)),
    }
    for name, law in laws.items():
        row(name, motion, [predicted(law, t) for t in motion.tracks])


if __name__ == "__main__":
    main()
