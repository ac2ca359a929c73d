"""One drawing, two files: what a figure draws goes into a picture of pixels and a picture of lines at once.

A figure's own work (layout, ticks, text) takes longer than either renderer's, and two files would pay for it twice.
Coordinates are the SVG's, 72 to the inch; the pixels' renderer gets them multiplied, and makes lines and letters of
points itself.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, cast

import numpy as np
from matplotlib.backend_bases import GraphicsContextBase, RendererBase
from matplotlib.backends.backend_agg import FigureCanvasAgg, RendererAgg
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.figure import Figure
from matplotlib.transforms import Affine2D, TransformedBbox, TransformedPath
from PIL import Image

from serpenoid.files.writing import atomic

POINTS_PER_INCH = 72
PIXELS_PER_INCH = 150
COMPRESSION = 3  # of the PNG: 6 takes three times as long for a tenth less


def save(fig: Figure, folder: str | Path, name: str) -> list[str]:
    """Write `name`.png and `name`.svg into `folder`, each whole or not at all; returns the file names."""
    png, svg = (Path(folder) / f"{name}.{kind}" for kind in ("png", "svg"))
    with atomic(png) as pixels, atomic(svg) as lines:
        draw(fig, PIXELS_PER_INCH, pixels, lines)
    return [png.name, svg.name]


def draw(fig: Figure, pixels_per_inch: int, png: Path, svg: Path) -> None:
    """Write a figure as PNG and SVG, drawn once."""
    fig.dpi = POINTS_PER_INCH
    width, height = fig.get_size_inches()
    _without_needless_places(fig)
    with svg.open("w", encoding="utf-8") as stream:
        size = width * POINTS_PER_INCH, height * POINTS_PER_INCH
        lines = RendererSVG(*size, stream, image_dpi=pixels_per_inch, metadata={"Date": None})
        both = Both(lines, RendererAgg(width * pixels_per_inch, height * pixels_per_inch, pixels_per_inch))
        _Canvas(fig, both)
        fig.draw(both)
        lines.finalize()
    opaque = np.ascontiguousarray(np.asarray(both.pixels.buffer_rgba())[..., :3])
    resolution = (pixels_per_inch, pixels_per_inch)
    Image.fromarray(opaque).save(png, format="png", dpi=resolution, compress_level=COMPRESSION)


def rehearse() -> None:
    """Draw a figure that nobody sees: the first reads fonts and builds the parser of formulas, a fifth of a second."""
    fig = Figure(figsize=(1.0, 1.0))
    ax = fig.add_subplot(xscale="log", title="a")
    ax.plot([1.0, 1e3], [0.0, 1.0], "-o", label="b")
    ax.legend()
    nowhere = Path(os.devnull)
    draw(fig, PIXELS_PER_INCH, nowhere, nowhere)


def _without_needless_places(fig: Figure) -> None:
    """What has no label needs no place for it, and a frame none beside its axes': to look for one measures every number
    along the axis again."""
    for ax in fig.get_axes():
        for axis in (ax.xaxis, ax.yaxis):
            if not axis.get_label_text():
                axis.set_label_coords(0.0, 0.0)
        for spine in ax.spines.values():
            spine.set_in_layout(False)


class Both(RendererBase):
    """Hands every stroke to an SVG renderer and to a renderer of pixels."""

    def __init__(self, lines: RendererSVG, pixels: RendererAgg) -> None:
        super().__init__()
        self.lines, self.pixels = lines, pixels
        self._times = pixels.dpi / POINTS_PER_INCH
        self._larger = Affine2D().scale(self._times)
        self._inset: RendererAgg | None = None  # what is drawn as pixels in the SVG, too

    def draw_path(self, gc: Any, path: Any, transform: Any, rgbFace: Any = None) -> None:  # noqa: N803
        for to, own in self._pixels(gc):
            to.draw_path(own, path, transform + self._larger, rgbFace)
        if self._inset is None:
            self.lines.draw_path(gc, path, transform, rgbFace)

    def draw_markers(
        self,
        gc: Any,
        marker_path: Any,
        marker_trans: Any,
        path: Any,
        trans: Any,
        rgbFace: Any = None,  # noqa: N803
    ) -> None:
        for to, own in self._pixels(gc):
            to.draw_markers(own, marker_path, marker_trans + self._larger, path, trans + self._larger, rgbFace)
        if self._inset is None:
            self.lines.draw_markers(gc, marker_path, marker_trans, path, trans, rgbFace)

    def draw_path_collection(
        self, gc: Any, master_transform: Any, paths: Any, all_transforms: Any, offsets: Any, offset_trans: Any,
        *rest: Any, **options: Any,
    ) -> None:  # fmt: skip
        for to, own in self._pixels(gc):
            to.draw_path_collection(
                own, master_transform + self._larger, paths, all_transforms, offsets, offset_trans + self._larger,
                *rest, **options,
            )  # fmt: skip
        if self._inset is None:
            self.lines.draw_path_collection(
                gc, master_transform, paths, all_transforms, offsets, offset_trans, *rest, **options
            )

    def draw_quad_mesh(
        self, gc: Any, master_transform: Any, width: int, height: int, coordinates: Any, offsets: Any,
        offset_trans: Any, *rest: Any,
    ) -> None:  # fmt: skip
        mesh = width, height, coordinates, offsets
        for to, own in self._pixels(gc):
            to.draw_quad_mesh(own, master_transform + self._larger, *mesh, offset_trans + self._larger, *rest)
        if self._inset is None:
            self.lines.draw_quad_mesh(gc, master_transform, *mesh, offset_trans, *rest)

    def draw_image(self, gc: Any, x: float, y: float, im: Any, transform: Any = None) -> None:
        for to, own in self._pixels(gc):
            to.draw_image(own, x * self._times, y * self._times, im)
        if self._inset is None:
            self.lines.draw_image(gc, x, y, im, transform)

    def draw_text(
        self, gc: Any, x: float, y: float, s: str, prop: Any, angle: float, ismath: Any = False, mtext: Any = None
    ) -> None:
        for to, own in self._pixels(gc):
            to.draw_text(own, x * self._times, y * self._times, s, prop, angle, ismath, mtext)
        if self._inset is None:
            self.lines.draw_text(gc, x, y, s, prop, angle, ismath, mtext)

    def _pixels(self, gc: GraphicsContextBase) -> list[tuple[RendererAgg, GraphicsContextBase]]:
        """The renderers of pixels, and what is set for a stroke with its clip enlarged."""
        own = self.new_gc()
        own.copy_properties(gc)
        if (box := gc.get_clip_rectangle()) is not None:
            own.set_clip_rectangle(cast(Any, TransformedBbox(box, self._larger)))
        path, transform = cast(tuple[Any, Any], gc.get_clip_path())
        if path is not None:
            own.set_clip_path(TransformedPath(path, transform + self._larger))
        return [(to, own) for to in (self.pixels, self._inset) if to is not None]

    def start_rasterizing(self) -> None:
        """What follows is an image in the SVG: a colour bar's hundreds of patches."""
        self._inset = RendererAgg(self.pixels.width, self.pixels.height, self.pixels.dpi)

    def stop_rasterizing(self) -> None:
        """The image, cut to what was drawn."""
        inset, self._inset = self._inset, None
        image = np.asarray(inset.buffer_rgba()) if inset is not None else np.empty((0, 0, 4))
        rows, columns = (np.flatnonzero(image[..., 3].any(axis=axis)) for axis in (1, 0))
        if len(rows):
            cut = image[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
            x, y = columns[0] / self._times, (len(image) - 1 - rows[-1]) / self._times
            self.lines.draw_image(self.new_gc(), x, y, cut[::-1])

    def open_group(self, s: str, gid: str | None = None) -> None:
        self.lines.open_group(s, gid)

    def close_group(self, s: str) -> None:
        self.lines.close_group(s)

    def get_image_magnification(self) -> float:
        return self._times

    def flipy(self) -> bool:
        return True

    def get_canvas_width_height(self) -> tuple[float, float]:
        return self.lines.width, self.lines.height

    def get_text_width_height_descent(self, s: str, prop: Any, ismath: Any) -> tuple[float, float, float]:
        return self.lines.get_text_width_height_descent(s, prop, ismath)


class _Canvas(FigureCanvasAgg):
    """Where a figure finds its renderer, to lay itself out."""

    def __init__(self, figure: Figure, renderer: Both) -> None:
        super().__init__(figure)
        self._both = renderer

    def get_renderer(self) -> Both:
        return self._both
