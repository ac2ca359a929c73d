"""Gaits in space: bodies along the way in three dimensions, where they rest on the floor, and a film of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from serpenoid.body import Floats
from serpenoid.objectives.position import Position
from serpenoid.objectives.reach import Reach
from serpenoid.plot.animate import write_gif
from serpenoid.plot.style import BLUE, FAINT, GREY, INK, LARGE, PHASE_MAP, RED, colour_bar, dress, figure
from serpenoid.plot.world import cycles_asked, targets
from serpenoid.problem import Problem
from serpenoid.trajectory import RESTING, LiftedTrajectory

BODIES = 7
FRAMES = 40
CYCLES = 2
SECONDS = 2.5  # a cycle of the film


def lifted_figure(motion: LiftedTrajectory, problem: Problem) -> Figure:
    """Bodies along the way over their shadows; dots where they rest. Heights are drawn three times as large."""
    fig = figure(7.4, 5.6)
    ax: Any = fig.add_subplot(projection="3d")
    every, places = repeated(motion, cycles_asked(problem))
    for row in np.linspace(0, len(every) - 1, BODIES).round().astype(int):
        colour = PHASE_MAP(row / (len(every) - 1))
        points = every[row]
        ax.plot(*points[:, :2].T, zs=0, color=FAINT, linewidth=2.0)
        ax.plot(*points.T, color=colour, linewidth=2.6)
        ax.scatter(*points[_rests(motion, row)].T, color=colour, s=14, depthshade=False)
        ax.scatter(*points[-1:].T, color=colour, s=40, depthshade=False)
    ax.plot(*places.T, color=INK, linewidth=1.2)
    for target in _targets(problem):
        ax.plot(*target, "x", zs=0, color=RED, markersize=9)
    _room(ax, every)
    x, y, turn = (motion.poses[motion.steps_per_cycle] - motion.poses[0])[:3]
    way = f"moves {np.hypot(x, y):.3f} body lengths, {motion.sideways_deg:.0f}° off the axis"
    words = f"A cycle {way}, turns {np.rad2deg(turn):.1f}°".replace("-", "−")
    fig.suptitle(
        f"{words}\nDots rest on the floor; large dot: head; heights threefold", fontsize=LARGE, x=0.02, ha="left"
    )
    colour_bar(
        ax, PHASE_MAP, 0, (len(every) - 1) / motion.steps_per_cycle, "phase [cycles]", pad=0.02, aspect=25, shrink=0.8
    )
    return fig


def prints_figure(motion: LiftedTrajectory, problem: Problem) -> Figure:
    """Where along the body and when it rests on the floor, and what marks it leaves there."""
    fig = figure(8.6, 3.6)
    when, where = fig.subplots(1, 2)
    share = motion.contact / motion.contact.max()
    extent = (0, _cycles(motion), -0.5, share.shape[1] - 0.5)
    when.imshow(share.T, origin="lower", aspect="auto", extent=extent, cmap="Greys", vmin=0, vmax=1)
    dress(when, "On the floor: dark", "phase [cycles]", "vertex, tail to head", grid=False)
    resting = share > RESTING
    where.scatter(*motion.vertices[resting][:, :2].T, s=3, color=BLUE)
    where.plot(*motion.poses[:, :2].T, color=GREY, linewidth=1.0)
    targets(problem, where)
    where.set_aspect("equal", adjustable="datalim")
    dress(where, "Tracks of what rests", "x [body lengths]", "y [body lengths]")
    return fig


def repeated(motion: LiftedTrajectory, cycles: int) -> tuple[Floats, Floats]:
    """Vertices (R, N, 3) and places of the frame (R, 3) of so many cycles: what the motion lacks repeats all of it."""
    last, turn = _places(motion)[-1], motion.rotations[-1]
    chains, places = [motion.vertices], [_places(motion)]
    for _ in range(-(-cycles * motion.steps_per_cycle // len(motion.step_energy)) - 1):
        for parts in (chains, places):
            parts.append(parts[-1][-len(motion.step_energy) :] @ turn.T + last)
    return np.concatenate(chains), np.concatenate(places)


def film(path: Path, motion: LiftedTrajectory) -> None:
    """Cycles one after the other, as a GIF."""
    every, _ = repeated(motion, CYCLES)
    rows = np.linspace(0, len(every) - 1, FRAMES, endpoint=False).round().astype(int)
    fig = figure(5.2, 4.2)
    fig.set_dpi(80)
    canvas = FigureCanvasAgg(fig)
    ax: Any = fig.add_subplot(projection="3d")
    images = []
    for row in rows:
        ax.clear()
        points = every[row]
        ax.plot(*points[:, :2].T, zs=0, color=FAINT, linewidth=2.0)
        ax.plot(*points.T, color=BLUE, linewidth=3.0)
        ax.scatter(*points[_rests(motion, row)].T, color=INK, s=16, depthshade=False)
        _room(ax, every, zoom=0.9)
        canvas.draw()
        images.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    write_gif(path, images, CYCLES * SECONDS / FRAMES)


def _cycles(motion: LiftedTrajectory) -> float:
    return len(motion.step_energy) / motion.steps_per_cycle


def _places(motion: LiftedTrajectory) -> Floats:
    """Of the body frames, (T + 1, 3)."""
    return motion.poses[:, [0, 1, 3]]


def _targets(problem: Problem) -> list[tuple[float, float]]:
    """Places on the floor that are asked for."""
    asked = [*problem.task.objectives, *problem.task.demands]
    return [goal.target for goal in asked if isinstance(goal, Position | Reach)]


def _rests(motion: LiftedTrajectory, row: int) -> np.ndarray:
    share = motion.contact[(row - 1) % len(motion.step_energy) + 1 if row else 0]
    return np.asarray(share > RESTING * share.max())


def _room(ax: Any, vertices: np.ndarray, zoom: float = 1.15) -> None:
    low, high = vertices.reshape(-1, 3).min(0), vertices.reshape(-1, 3).max(0)
    ax.set_xlim(low[0], high[0])
    ax.set_ylim(low[1], high[1])
    ax.set_zlim(0, max(high[2], 0.01))
    ax.set_box_aspect((high[0] - low[0], high[1] - low[1], 3 * max(high[2], 0.01)), zoom=zoom)
    ax.xaxis.set_major_locator(MaxNLocator(4))
    ax.yaxis.set_major_locator(MaxNLocator(5))
    ax.set_xlabel("x [body lengths]")
    ax.set_ylabel("y [body lengths]", labelpad=10)
    ax.set_zticks([0, round(float(high[2]), 2)])
    ax.view_init(elev=38, azim=-70)
