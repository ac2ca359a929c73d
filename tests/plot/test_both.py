"""One drawing for two files: what is left out of its work changes no pixel."""

import numpy as np
from matplotlib.axis import Axis
from matplotlib.mathtext import MathTextParser
from PIL import Image

from serpenoid.plot import both
from serpenoid.plot.style import dress, figure


def panels():
    """Two by two: labels at the left and below only, as in a grid that shares its axes."""
    fig = figure(4.0, 3.0)
    for i, ax in enumerate(fig.subplots(2, 2).flat):
        ax.plot([0, 1, 2], [0, 10.0**i, 1])
        dress(ax, "", "time [s]" if i > 1 else "", "speed [mm/s]" if i % 2 == 0 else "")
    return fig


def drawn(folder, monkeypatch):
    """The picture, and how often the numbers along an axis were made for it."""
    calls, made = [], Axis._update_ticks
    with monkeypatch.context() as patch:
        patch.setattr(Axis, "_update_ticks", lambda axis: calls.append(axis) or made(axis))
        both.save(panels(), folder, "panels")
    with Image.open(folder / "panels.png") as picture:
        picture.load()
    return picture, len(calls)


def test_axes_without_a_label_and_frames_look_for_no_place_and_look_the_same(tmp_path, monkeypatch):
    picture, count = drawn(tmp_path, monkeypatch)
    monkeypatch.setattr(both, "_without_needless_places", lambda fig: None)
    usual, more = drawn(tmp_path, monkeypatch)
    assert count < 0.6 * more
    assert np.array_equal(picture, usual)


def test_pixels_are_written_as_they_are_drawn_without_a_channel_that_is_all_white(tmp_path, monkeypatch):
    picture, _ = drawn(tmp_path, monkeypatch)
    assert picture.mode == "RGB"
    assert np.allclose(picture.info["dpi"], both.PIXELS_PER_INCH, atol=0.1)


def test_a_figure_drawn_for_the_fonts_alone_leaves_no_file_and_what_reads_formulas(tmp_path, monkeypatch):
    monkeypatch.setattr(MathTextParser, "_parser", None)
    both.rehearse()
    assert MathTextParser._parser is not None
    assert not list(tmp_path.iterdir())
