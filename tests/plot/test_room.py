"""A grid that is settled: nothing covers anything, and nothing is cut off."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from serpenoid.plot.room import settle
from serpenoid.plot.style import dress, figure, fill_equal


def overlaps(fig):
    """Panels that reach into others, or out of the figure."""
    canvas = FigureCanvasAgg(fig)
    canvas.draw()
    boxes = [ax.get_tightbbox(canvas.get_renderer()) for ax in fig.axes]
    out = [i for i, b in enumerate(boxes) if b.x0 < 0 or b.y0 < 0 or b.x1 > fig.bbox.x1 or b.y1 > fig.bbox.y1]
    return out, [pair for pair in combinations(range(len(boxes)), 2) if boxes[pair[0]].overlaps(boxes[pair[1]])]


@pytest.mark.parametrize(
    "size", [1e-4, pytest.param(0.03, marks=pytest.mark.slow), pytest.param(7.0, marks=pytest.mark.slow), 4e4]
)
@pytest.mark.parametrize("equal", [False, True])
def test_numbers_of_any_length_have_room(size, equal):
    fig = figure(9.6, 4.6)
    axes = fig.subplots(2, 3)
    for i, ax in enumerate(axes.flat):
        ax.plot(size * np.array([-1.0, 0.2, 1.3]), size * np.array([0.1 * i, -1, 1]))
        dress(ax, "A title", "x [mm]", "y [mm]")
        if equal:
            fill_equal(ax)
    settle(fig, axes, above=0.3, title=0.27)
    assert overlaps(fig) == ([], [])


@pytest.mark.parametrize("name", ["gait01, 4.26 s", "SIDEWINDING, 12.5 s", "mmmmwwww", "i"])
def test_names_have_room_and_take_no_more_than_they_need(name):
    fig = figure(9.6, 2.0)
    axes = fig.subplots(1, 3, sharey=True)
    for ax in axes:
        dress(ax, "", "time [s]", "baseline" if ax is axes[0] else "")
    axes[0].set_yticks([0.5], [name])
    settle(fig, axes, right=0.2)
    assert overlaps(fig) == ([], [])
    box = axes[0].get_tightbbox(fig.canvas.get_renderer())
    assert box.x0 / fig.dpi < 0.75  # inches


def test_a_grid_fills_its_figure_and_its_panels_are_alike():
    fig = figure(8.0, 4.0)
    axes = fig.subplots(2, 2)
    settle(fig, axes, above=0.5)
    places = [ax.get_position() for ax in axes.flat]
    assert {round(p.width, 6) for p in places} == {round(places[0].width, 6)}
    assert {round(p.height, 6) for p in places} == {round(places[0].height, 6)}
    assert 4.0 * (1 - places[0].y1) == pytest.approx(0.5)
    assert 8.0 * (1 - places[-1].x1) == pytest.approx(0.1)
