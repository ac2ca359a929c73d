"""Exp, Sim, Resim of one passage: measured; commanded shapes simulated; measured shapes simulated.

Exp - Sim = (Exp - Resim) + (Resim - Sim): the motion part (the ground did not do what the model says) and the actuation
part (the body did not take the commanded shapes). All three start from the measured pose and share its time grid.

Legend: R rows, N vertices.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from serpenoid import group
from serpenoid.body import Floats
from serpenoid.compare.linearise import about_centroid, mesh_error, relative_poses
from serpenoid.files.store import remember
from serpenoid.measure.shapes.links import chain_vertices
from serpenoid.measure.shapes.principal_bends import bends_smoother
from serpenoid.measure.shapes.smooth import angles_smoother
from serpenoid.measure.trial import Motion, Passage, Trial
from serpenoid.measure.usage import whole_pieces
from serpenoid.model import Model
from serpenoid.simulation import simulate_joint_angles
from serpenoid.simulation.curve import simulate_curve

DRAWS = 12  # shape-noise replicates: the standard deviation is then known to a fifth


@dataclass(frozen=True)
class Path:
    """Poses (R, 3) and vertices (R, N, 2) in the world [body lengths], step energies (R - 1,)."""

    poses: Floats
    vertices: Floats
    step_energy: Floats

    @property
    def displacement(self) -> float:
        return float(np.hypot(*(self.poses[-1] - self.poses[0])[:2]))

    @property
    def turn(self) -> float:
        return float(self.poses[-1, 2] - self.poses[0, 2])


@dataclass(frozen=True)
class Comparison:
    """One passage three ways. `sim` is None where nothing was commanded."""

    trial: str
    gait: str
    cycle: int
    time_s: Floats
    exp: Path
    resim: Path
    sim: Path | None
    resim_sd: float  # of the resimulated displacement, from shape noise [body lengths]
    resim_bias: float  # of the same: what shape noise and the smoothing of it add on average
    exp_sd: float  # of the measured one, from the noise of its first and last poses
    pieces: int  # between holes; their motions are joined end to end, the same for all three

    def error(self, part: str) -> dict[str, float]:
        """Net error in the first measured body frame (forward, left, turn) and path RMS; parts add up to `whole`."""
        pair = {"whole": (self.exp, self.sim), "actuation": (self.resim, self.sim), "motion": (self.exp, self.resim)}[
            part
        ]
        first, second = pair
        if first is None or second is None:
            return {}
        apart = first.poses - second.poses
        heading = self.exp.poses[0, 2]
        c, s = np.cos(heading), np.sin(heading)
        dx, dy, turn = apart[-1]
        rms = float(np.sqrt(np.mean(apart[:, 0] ** 2 + apart[:, 1] ** 2)))
        return {"forward": float(c * dx + s * dy), "left": float(c * dy - s * dx), "turn": float(turn), "path_rms": rms}

    def velocity_residual(self) -> Floats:
        """Measured minus modelled body velocity per step (R - 1, 3): forward, left [body lengths/s], turn [rad/s]."""
        dt = np.diff(self.time_s)[:, None]
        return (relative_poses(self.exp.poses) - relative_poses(self.resim.poses)) / dt

    def residual_along_body(self) -> Floats:
        """RMS speed residual of every vertex, tail to head (N,) [body lengths/s], seen from the measured body frame."""
        dt = np.diff(self.time_s)[:, None, None]
        both = [_vertex_steps(path) / dt for path in (self.exp, self.resim)]
        return np.asarray(np.sqrt(((both[0] - both[1]) ** 2).sum(axis=2).mean(axis=0)))


def compare_passage(trial: Trial, passage: Passage, model: Model, seed: int) -> Comparison | None:
    """Simulate one passage three ways; None where no piece of it is whole. Kept, as it takes long."""
    return remember(lambda: _compare(trial, passage, model, seed), "passage", trial, passage, model, seed)


def _compare(trial: Trial, passage: Passage, model: Model, seed: int) -> Comparison | None:
    motion = trial.motion
    if motion is None:
        return None
    pieces = whole_pieces(motion, passage)
    if not pieces:
        return None
    time = _joined_time([motion.time_s[rows] for rows in pieces])
    poses = [motion.smooth_poses[rows] for rows in pieces]
    angles = [motion.smooth_angles[rows] for rows in pieces]
    measured = [
        Path(p, chain_vertices(trial.body, p, a), np.full(len(p) - 1, np.nan))
        for p, a in zip(poses, angles, strict=True)
    ]
    weights = trial.body.vertex_weights
    resim = [simulate_path(model, a, weights, p[0]) for p, a in zip(poses, angles, strict=True)]
    sim = None
    if trial.schedule is not None and trial.start_source != "none":
        commanded = [trial.schedule.commanded(motion.time_s[rows]) for rows in pieces]
        sim = joined([simulate_path(model, a, weights, p[0]) for p, a in zip(poses, commanded, strict=True)])
    sds, biases = np.transpose([resimulation_error(model, motion, rows, weights, seed) for rows in pieces])
    return Comparison(
        trial.name, trial.gait, passage.cycle, time, joined(measured), joined(resim), sim,
        float(np.sqrt(np.sum(sds**2))), float(np.sum(biases)), _measured_error(motion, pieces), len(pieces),
    )  # fmt: skip


def _measured_error(motion: Motion, pieces: list[slice]) -> float:
    """SD of how far apart the first and last positions of all pieces are seen, frame by frame [body lengths]."""
    variance = np.trace(motion.covariance[:, :2, :2], axis1=1, axis2=2)
    return float(np.sqrt(sum(variance[rows][0] + variance[rows][-1] for rows in pieces)))


def _joined_time(times: list[Floats]) -> Floats:
    """Times (R,) that pass over the holes: the last row of a piece and the first of the next are one."""
    steps = np.concatenate([np.diff(time) for time in times])
    return times[0][0] + np.concatenate([[0.0], np.cumsum(steps)]) if len(times) > 1 else times[0]


def joined(paths: list[Path]) -> Path:
    """Motions end to end: each is carried, as it is, to where the one before it ended. One path stays as it is."""
    first, *rest = paths
    for path in rest:
        turn = first.poses[-1, 2] - path.poses[0, 2]
        c, s = np.cos(turn), np.sin(turn)
        rotation = np.array([[c, -s], [s, c]])
        place = first.poses[-1, :2] - rotation @ path.poses[0, :2]
        moved = np.column_stack([path.poses[:, :2] @ rotation.T + place, path.poses[:, 2] + turn])
        vertices = path.vertices @ rotation.T + place
        first = Path(
            np.concatenate([first.poses, moved[1:]]), np.concatenate([first.vertices, vertices[1:]]),
            np.concatenate([first.step_energy, path.step_energy]),
        )  # fmt: skip
    return first


def simulate_path(model: Model, joint_angles: Floats, weights: Floats, start: Floats) -> Path:
    """Shapes (R, m) played once, without error of the mesh; an animal's as the curves that its points stand for.

    start (3,): the first pose, of the centroid by weights (N,), sum 1, as all poses of the path.
    """
    found = simulate_joint_angles(model, joint_angles, start=start, closed=False)
    if model.body.is_animal:
        found = simulate_curve(model, found.vertices, start)
    poses = about_centroid(found.poses, found.vertices, weights)
    steps, shapes = relative_poses(poses), group.place(group.inverse(poses), found.vertices)
    if not model.body.is_animal:
        steps = steps + mesh_error(model, joint_angles, steps, weights)
    moved = group.accumulate(steps, start)
    return Path(moved, group.place(moved, shapes), found.step_energy)


def resimulation_error(model: Model, motion: Motion, rows: slice, weights: Floats, seed: int) -> tuple[float, float]:
    """SD and bias of the resimulated displacement: the smooth shapes with noise drawn anew, smoothed as the data were.

    The bias is what noise that smoothing leaves, and motion that it takes, add on average: displacement goes with the
    square of the amplitude.
    """
    rng = np.random.default_rng(seed)
    covariance = motion.covariance[rows, 3:, 3:]
    variance = np.diagonal(covariance, axis1=1, axis2=2)
    usable = variance.max(axis=1) < 0.05  # a state that nothing measured is bridged, not drawn
    if usable.sum() < 8:
        return float("nan"), float("nan")
    smoother = bends_smoother if model.body.is_animal else angles_smoother
    smoothed = smoother(motion.time_s[rows], motion.joint_angles[rows], covariance)
    root = np.linalg.cholesky(covariance + 1e-18 * np.eye(covariance.shape[1]))
    base = motion.smooth_angles[rows]
    found = []
    for _ in range(DRAWS):
        noise = np.einsum("rab,rb->ra", root, rng.normal(size=base.shape)) * usable[:, None]
        found.append(simulate_path(model, smoothed(base + noise), weights, np.zeros(3)).displacement)
    true = simulate_path(model, base, weights, np.zeros(3)).displacement
    return float(np.std(found, ddof=1)), float(np.mean(found)) - true


def _vertex_steps(path: Path) -> Floats:
    """Displacement of every vertex in each step, turned into the body frame at its beginning (R - 1, N, 2)."""
    step = np.diff(path.vertices, axis=0)
    c, s = np.cos(path.poses[:-1, 2])[:, None], np.sin(path.poses[:-1, 2])[:, None]
    return np.stack([c * step[..., 0] + s * step[..., 1], c * step[..., 1] - s * step[..., 0]], axis=2)
