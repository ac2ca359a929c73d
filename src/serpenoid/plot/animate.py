"""The body crawling along, as a GIF: one figure, its moving parts redrawn over a stored background."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image

from serpenoid.files import atomic
from serpenoid.plot.body import draw_body
from serpenoid.plot.motion import over_cycles
from serpenoid.plot.style import BLUE, FAINT, INK, NORMAL, dress, figure
from serpenoid.trajectory import Trajectory

FRAMES_PER_CYCLE = 50
DEFAULT_CYCLE_S = 2.5


def animation(
    path: str | Path, trajectory: Trajectory, cycles: int = 2, cycle_duration_s: float | None = None
) -> None:
    """Write a GIF of `cycles` cycles, in real time where the cycle's duration is known."""
    poses, chains = over_cycles(trajectory, cycles)
    stride = -(-trajectory.steps_per_cycle // FRAMES_PER_CYCLE)
    rows = np.arange(0, len(poses) - 1, stride)
    fig = figure(4.8, 3.2)
    fig.set_dpi(100)
    canvas = FigureCanvasAgg(fig)
    ax = fig.add_subplot()
    points = chains.reshape(-1, 2)
    low, high = points.min(0), points.max(0)
    pad = 0.06 * float((high - low).max())
    ax.set_xlim(low[0] - pad, high[0] + pad)
    ax.set_ylim(low[1] - pad, high[1] + pad)
    ax.set_aspect("equal")
    dress(ax, "", "x [body lengths]", "y [body lengths]")
    (ghost,) = ax.plot(*chains[0].T, color=FAINT, linewidth=3.2, solid_capstyle="round", zorder=1)
    (trace,) = ax.plot([], [], color=INK, linewidth=1.3, zorder=2)
    chain, head = draw_body(chains[0], ax, BLUE, width=4.0)
    clock = ax.text(0.0, 1.02, "", transform=ax.transAxes, fontsize=NORMAL, color=INK, va="bottom")
    moving = (trace, chain, head, clock)
    for artist in moving:
        artist.set_animated(True)
    clock.set_in_layout(False)
    canvas.draw()
    background = canvas.copy_from_bbox(fig.bbox)
    frames = []
    for row in rows:
        canvas.restore_region(background)
        trace.set_data(*poses[: row + 1, :2].T)
        chain.set_data(*chains[row].T)
        head.set_data(*chains[row, -1:].T)
        gone = float(np.hypot(*(poses[row, :2] - poses[0, :2])))
        clock.set_text(f"{row / trajectory.steps_per_cycle:4.2f} cycles, {gone:4.2f} body lengths")
        for artist in moving:
            fig.draw_artist(artist)
        frames.append(Image.fromarray(np.asarray(canvas.buffer_rgba())[..., :3].copy()))
    _write(path, frames, (cycle_duration_s or DEFAULT_CYCLE_S) * stride / trajectory.steps_per_cycle)


def _write(path: str | Path, frames: list[Image.Image], seconds: float) -> None:
    palette = frames[-1].quantize(64)
    quantized = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    delay = max(20, round(100 * seconds) * 10)  # GIF counts hundredths; browsers slow down anything below two
    with atomic(path) as temporary:
        quantized[0].save(temporary, save_all=True, append_images=quantized[1:], duration=delay, loop=0)
