"""The body crawling along, as a GIF: one figure, its moving parts redrawn over a stored background."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image

from serpenoid.files.writing import atomic
from serpenoid.plot.body import draw_body, move_body
from serpenoid.plot.motion import over_cycles
from serpenoid.plot.style import BLUE, FAINT, GREY, INK, NORMAL, RED, around, dress, figure
from serpenoid.trajectory import Trajectory

FRAMES_PER_CYCLE, FRAMES = 50, 400  # at most
DEFAULT_CYCLE_S = 2.5
WIDTH = 4.8  # inches at 100 dots


def animation(
    path: str | Path,
    trajectory: Trajectory,
    cycles: int | None = 2,
    cycle_duration_s: float | None = None,
    joints: Sequence[int] = (),
    world: Callable[[Axes], object] | None = None,
) -> None:
    """Write a GIF of `cycles` cycles (None: of a motion played once), in real time where its duration is known.

    world: draws what stands still.
    """
    poses, chains = over_cycles(trajectory, cycles or 1)
    stride = max(-(-trajectory.steps_per_cycle // FRAMES_PER_CYCLE), -(-len(poses) // FRAMES))
    rows = np.arange(0, len(poses) - 1, stride)
    fig = figure(WIDTH, WIDTH)
    fig.set_dpi(100)
    canvas = FigureCanvasAgg(fig)
    ax = fig.add_subplot()
    slope = around(chains.reshape(-1, 2), ax)
    fig.set_size_inches(WIDTH, float(np.clip((WIDTH - 0.7) * slope + 0.85, 2.0, WIDTH)))
    dress(ax, " ", "x [body lengths]", "y [body lengths]")
    ax.plot(*chains[0].T, color=FAINT, linewidth=3.2, solid_capstyle="round", zorder=1)
    if world is not None:
        world(ax)
    (trace,) = ax.plot([], [], color=INK, linewidth=1.4)
    body = draw_body(chains[0], ax, BLUE, width=4.2, joints=joints)
    clock = ax.text(0.0, 1.03, "", transform=ax.transAxes, fontsize=NORMAL, color=INK, va="bottom")
    clock.set_in_layout(False)
    moving = (*body, trace, clock)
    for artist in moving:
        artist.set_animated(True)
    canvas.draw()
    background = canvas.copy_from_bbox(fig.bbox)
    frames = []
    for row in rows:
        canvas.restore_region(background)
        trace.set_data(*poses[: row + 1, :2].T)
        move_body(body, chains[row])
        gone = float(np.hypot(*(poses[row, :2] - poses[0, :2])))
        share = row / trajectory.steps_per_cycle
        when = f"{share:4.2f} cycles" if cycles else f"{share:.0%} of the motion"
        clock.set_text(f"{when}, {gone:4.2f} body lengths")
        for artist in moving:
            fig.draw_artist(artist)
        frames.append(np.asarray(canvas.buffer_rgba())[..., :3].copy())
    write_gif(path, frames, (cycle_duration_s or DEFAULT_CYCLE_S) * stride / trajectory.steps_per_cycle)


def write_gif(path: str | Path, frames: list[NDArray[np.uint8]], seconds: float) -> None:
    """Write frames (height, width, 3), each shown for so many seconds, in a loop."""
    palette = _palette()
    images = [_indexed(frame, palette) for frame in frames]
    delay = max(20, round(100 * seconds) * 10)  # GIF counts hundredths; browsers slow down anything below two
    with atomic(path) as temporary:
        images[0].save(temporary, save_all=True, append_images=images[1:], duration=delay, loop=0)


def _indexed(frame: NDArray[np.uint8], palette: Image.Image) -> Image.Image:
    """A frame in the palette's colours; Pillow's search is coarse, so white is put right."""
    image = Image.fromarray(frame).quantize(palette=palette, dither=Image.Dither.NONE)
    image.paste(0, mask=Image.fromarray((frame == 255).all(-1)))
    return image


def _palette() -> Image.Image:
    """White and the few colours of the picture, blended: fixed, so that white stays white and frames do not flicker."""
    shades = np.linspace(0, 1, 36)[:, None]  # of seven ramps: a GIF has 256 colours
    pairs = [("white", BLUE), ("white", INK), (FAINT, BLUE), (FAINT, INK), (BLUE, INK)]
    pairs += [("white", RED), ("white", GREY)]
    ramps = [(1 - shades) * to_rgb(a) + shades * to_rgb(b) for a, b in pairs]
    image = Image.new("P", (1, 1))
    image.putpalette((np.concatenate(ramps) * 255).round().astype(np.uint8).tobytes())
    return image
