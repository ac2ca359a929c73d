"""Whole figures: written, not blank, labelled with units, nothing cut off."""

import itertools
import re
from dataclasses import replace
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

from serpenoid.gaits import EllipseGait, TableGait
from serpenoid.media import LAWS
from serpenoid.plot import figures, optima, sweep, transport
from serpenoid.plot.animate import animation
from serpenoid.plot.beside import apart
from serpenoid.plot.both import save
from serpenoid.plot.calibration import displacement_for_eps
from serpenoid.plot.comparison import heat_maps
from serpenoid.plot.hero import hero
from serpenoid.plot.motion import over_cycles
from serpenoid.plot.space import repeated
from serpenoid.plot.style import figure
from serpenoid.plot.world import targets
from serpenoid.problem import Problem
from serpenoid.simulation.problem import simulate
from serpenoid.status import Status
from serpenoid.trajectory import LiftedTrajectory
from specimens import problem

GAIT = EllipseGait(sigma=0.6, theta=0.5, a=6, xi=1)


def check(folder, names):
    """Every PNG has ink and a white rim (nothing is cut off), every SVG is one."""
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    for name in names:
        if name.endswith("png"):
            pixels = np.asarray(Image.open(folder / name).convert("L"))
            assert (pixels < 200).mean() > 0.002
            assert min(pixels[0].min(), pixels[-1].min(), pixels[:, 0].min(), pixels[:, -1].min()) == 255
        if name.endswith("svg"):
            assert ElementTree.parse(folder / name).getroot().tag.endswith("svg")


def check_labels(fig):
    for ax in fig.axes:
        words = [ax.get_xlabel(), ax.get_ylabel()]
        assert any(words), "an axis without a name"
        for word in words:
            assert not word or "[" in word or word.startswith(("dissipation coefficient", "flatness", "waves", "joint"))


def test_simulation_figures_are_written(tmp_path, problem, trajectory, table):
    names = figures.simulation_figures(tmp_path, problem, trajectory, table, GAIT)
    assert "animation.gif" in names
    check(tmp_path, names)


def test_the_title_of_a_narrow_picture_is_broken_and_not_cut_off(tmp_path, problem):
    """Played upright, and turning by more than a hundred degrees: the longest title in the narrowest picture."""
    motion = simulate(problem).trajectory
    turned = motion.poses[:, [1, 0, 2]] - np.linspace(0, 2.1, len(motion.poses))[:, None] * [0, 0, 1]
    picture = figures.motion_figure(replace(motion, vertices=motion.vertices[..., ::-1], poses=turned), problem)
    check(tmp_path, save(picture, tmp_path, "motion"))


def test_a_joint_table_has_no_gait_curve_and_a_failed_motion_has_joints_only(tmp_path, problem, trajectory, table):
    names = figures.simulation_figures(tmp_path / "table", problem, trajectory, table, TableGait())
    assert not any(name.startswith("gait") for name in names)
    unknown = replace(trajectory, vertices=np.full_like(trajectory.vertices, np.nan))
    assert figures.simulation_figures(tmp_path, problem, unknown, table, GAIT) == ["joints.png", "joints.svg"]


def test_sweep_figures_are_written(tmp_path, family):
    check(tmp_path, figures.sweep_figures(tmp_path, family))


def test_one_gait_is_no_sweep(tmp_path, family):
    assert figures.sweep_figures(tmp_path, replace(family, c=np.full(26, np.nan))) == []


def test_multistart_figures_show_failures_too(tmp_path):
    def end(cost, status=Status.SOLVED):
        return SimpleNamespace(cost=cost, status=status)

    failed = end(np.nan, Status.INFEASIBLE)
    distinct = tuple(SimpleNamespace(solution=end(cost)) for cost in (-0.4, -0.3))
    result = SimpleNamespace(solutions=(end(-0.4), end(-0.3), end(-0.4), failed), optima=distinct)
    costs, optimum = optima.start_costs(result)
    assert optimum.tolist() == [0, 1, 0, -1]
    (ax,) = optima.optima_figure(result).axes
    assert [t.get_text() for t in ax.texts] == ["−0.400000: 2 of 4", "−0.300000: 1 of 4"]
    assert ax.get_title(loc="left") == "Cost reached from each start: 2 distinct optima"
    assert ax.get_legend_handles_labels()[1] == ["failed (1)"]
    check(tmp_path, figures.multistart_figures(tmp_path, result))


@pytest.mark.parametrize("pairs", [1, 3])
def test_quotients_of_ratios_fill_their_picture(tmp_path, pairs):
    one = SimpleNamespace(
        quotients=np.full((3, 3), 1.1), pair="Exp / Sim", mean=1.1, std=0.0, bias=1.1, bias_interval=(1.0, 1.2),
        s=0.1, s_interval=(0.0, 0.2), rank_text="1", wrong_pairs=[], pair_count=3,
    )  # fmt: skip
    check(tmp_path, save(heat_maps([one] * pairs, ["a", "b", "c"]), tmp_path, "ratios"))
    pixels = np.asarray(Image.open(tmp_path / "ratios.png").convert("L"))
    inked = np.flatnonzero((pixels < 250).any(axis=1))
    assert max(inked[0], len(pixels) - 1 - inked[-1]) < 0.05 * len(pixels)


def test_names_of_curves_that_end_together_do_not_overlap():
    time, eps = np.linspace(0, 5, 20), np.geomspace(0.002, 0.032, 25)
    curves = np.outer(0.7 - eps, time / 5)  # ends within 0.03, as of a body for which eps hardly matters
    rms = np.abs(curves - curves[12]).mean(1)
    fig = figure(7.4, 4.4)
    ax = displacement_for_eps(time, curves[12], eps, curves, rms, (eps[12], curves[12]), fig.add_subplot())
    FigureCanvasAgg(fig).draw()
    boxes = sorted((box.y0, box.y1) for box in map(Text.get_window_extent, ax.texts))  # without the lines
    assert len(boxes) == 9
    assert all(low >= below for (_, below), (low, _) in itertools.pairwise(boxes))


def test_names_of_idle_levels_whose_costs_end_together_do_not_overlap(family):
    fig = figure(9.6, 4.0)
    left = fig.subplots(1, 2)[0]
    transport.cost_of_transport(family, left, [0.0, 0.001, 0.002, 0.004, 1.0])
    FigureCanvasAgg(fig).draw()
    boxes = sorted((box.y0, box.y1) for box in map(Text.get_window_extent, left.texts))
    assert len(boxes) == 5
    assert all(low >= below for (_, below), (low, _) in itertools.pairwise(boxes))


def test_names_of_optima_stand_apart_in_their_order_and_within_the_axes():
    for places in ([0.5], [0.0, 0.01, 0.02, 0.9], [0.97, 0.98, 0.99], []):
        moved = apart(np.array(places), 0.1)
        assert (np.diff(moved) >= 0.1 - 1e-12).all()
        assert moved.size == 0 or (moved.min() >= 0 and moved.max() <= 1)
    np.testing.assert_array_equal(apart(np.array([0.1, 0.5]), 0.1), [0.1, 0.5])


@pytest.mark.parametrize(("cost", "label"), [(-0.4, "−0.4"), (0.000737, "0.000737")])
def test_one_optimum_has_its_cost_on_the_axis(cost, label):
    ax = optima.strip(np.full(3, cost), np.zeros(3, dtype=int), Figure().add_subplot())
    assert [text.get_text() for text in ax.get_yticklabels()] == [label]


def test_beyond_a_dozen_optima_are_counted_together():
    levels, words = optima.names(np.arange(15) / 100, np.arange(15))
    assert len(levels) == len(words) == optima.SHOWN + 1
    assert words[-1] == "3 more: 3 of 15"


def test_all_axes_are_labelled_with_units(problem, trajectory, table, family):
    made = [
        figures.gait_figure(GAIT, trajectory), figures.motion_figure(trajectory, problem, 3),
        figures.joints_figure(table, problem), sweep.family_figure(family), sweep.front_figure(family),
        sweep.costs_figure(family),
    ]  # fmt: skip
    for fig in made:
        check_labels(fig)


def test_a_motion_that_is_played_once_has_no_cycles_and_its_many_legend_entries_clear_the_title(
    tmp_path, problem, trajectory, table
):
    line = {"kind": "path", "line": ((0.0, 0.0), (0.5, 0.1))}
    asked = {"transient": True, "objectives": (line, {"kind": "position", "target": (0.4, 0.1)})}
    once = Problem.model_validate(problem.model_dump(exclude_unset=True) | {"task": asked})
    moved = figures.motion_figure(trajectory, once)
    for fig in (moved, figures.joints_figure(table, once)):
        assert not any("cycle" in word for ax in fig.axes for word in (ax.get_xlabel(), ax.get_ylabel()))
    canvas = FigureCanvasAgg(moved)
    canvas.draw()
    title, legend = moved.axes[0]._left_title, moved.axes[0].get_legend()
    assert len(legend.get_texts()) == 6
    assert not title.get_window_extent().overlaps(legend.get_window_extent())
    seen = []
    animation(tmp_path / "a.gif", trajectory, None, world=lambda ax: seen.append(targets(once, ax)))
    assert seen


def test_a_motion_is_drawn_until_what_is_asked_for_has_been_reached(problem, trajectory):
    task = {"steps": 20, "objectives": ({"kind": "position", "target": (1.4, 0.5), "cycles": 3},)}
    asked = Problem.model_validate(problem.model_dump(exclude_unset=True) | {"task": task})
    ax = figures.motion_figure(trajectory, asked).axes[0]
    path = next(line for line in ax.lines if line.get_label() == "weighted centroid")
    poses, _ = over_cycles(trajectory, 3)
    np.testing.assert_array_equal(path.get_xydata(), poses[:, :2])
    assert ax.get_title(loc="left").endswith("; 3 cycles")


@pytest.mark.parametrize("walls", [(), ({"kind": "half_plane", "point": (0, -0.3), "normal": (0, 1)},)])
def test_the_scale_bar_stands_on_no_wall(walls, problem, trajectory):
    task = {"steps": 20, "demands": walls}
    asked = Problem.model_validate(problem.model_dump(exclude_unset=True) | {"task": task})
    fig = figures.motion_figure(trajectory, asked)
    FigureCanvasAgg(fig).draw()
    ax = fig.axes[0]
    (words,) = (text for text in ax.texts if "body length" in text.get_text())
    place = words.get_window_extent()
    assert ax.bbox.contains(*place.p0) == (not walls)
    assert fig.bbox.contains(*place.p0)
    assert not place.overlaps(ax.xaxis.get_tightbbox())


def test_no_minus_stands_before_a_zero_and_it_is_as_long_as_a_plus():
    assert [figures.rounded(v, 1) for v in (-0.01, 2.0, -3.14)] == ["0.0", "2.0", "−3.1"]


def test_what_rests_and_repeats_in_space_goes_on_from_where_it_came():
    c, s = np.cos(0.3), np.sin(0.3)
    way, heading = np.array([[0, 0], [0.3, 0.1], [0.6, 0.2]]), np.array([0, 0.15, 0.3])
    poses = np.column_stack([way, heading, np.zeros((3, 3))])
    chains = np.concatenate([way, np.zeros((3, 1))], 1)[:, None] + np.zeros((3, 2, 1))
    moved = LiftedTrajectory(Status.SOLVED, poses, chains, np.ones(2), 0.0, 2, contact=np.ones((3, 2)))
    vertices, places = repeated(moved, 3)
    assert len(vertices) == len(places) == 7
    turned = way[-1] + way[-1] @ np.array([[c, s], [-s, c]])
    np.testing.assert_allclose(places[4], [*turned, 0], atol=1e-12)  # rounding of O(1) numbers
    np.testing.assert_allclose(vertices[:, 0], places, atol=1e-12)


def test_hero_is_written(tmp_path, problem, trajectory, table):
    solution = SimpleNamespace(problem=problem, trajectory=trajectory, gait=GAIT, table=table)
    fig = hero(solution)
    check_labels(fig)
    check(tmp_path, figures.save(fig, tmp_path, "hero"))


@pytest.mark.parametrize("cycles", [1, 2])
def test_animation_has_a_frame_per_row_in_real_time(tmp_path, trajectory, cycles):
    animation(tmp_path / "a.gif", trajectory, cycles, cycle_duration_s=2.0)
    with Image.open(tmp_path / "a.gif") as film:
        assert film.n_frames == cycles * 20
        assert film.info["duration"] == 100
        assert film.info["loop"] == 0
        first = np.asarray(film.convert("RGB"))
        film.seek(10)
        later = np.asarray(film.convert("RGB"))
    assert tuple(first[2, 2]) == (255, 255, 255)
    assert (first != later).any(-1).sum() > 500


def test_a_failed_save_leaves_nothing_behind(tmp_path, problem, table, monkeypatch):
    fig = figures.joints_figure(table, problem)
    monkeypatch.setattr(fig, "draw", lambda *a, **k: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises(OSError, match="disk full"):
        figures.save(fig, tmp_path, "joints")
    assert not list(tmp_path.iterdir())


def test_a_figure_is_drawn_once_for_both_files(tmp_path, problem, table, monkeypatch):
    fig = figures.joints_figure(table, problem)
    drawn, draw = [], fig.draw
    monkeypatch.setattr(fig, "draw", lambda renderer: (drawn.append(1), draw(renderer)))
    figures.save(fig, tmp_path, "joints")
    assert len(drawn) == 1
    with Image.open(tmp_path / "joints.png") as picture:
        pixels = np.asarray(picture.convert("RGB"), dtype=float)
    assert pixels.shape[:2] == tuple(int(150 * side) for side in fig.get_size_inches()[::-1])
    svg = (tmp_path / "joints.svg").read_text()
    assert svg.count("<image") == 1  # the colour bar: hundreds of patches otherwise
    width, height, x, y = (float(re.search(rf' {k}="(-?[\d.]+)"', svg[svg.index("<image") :])[1]) for k in SIDES)
    middle = 150 / 72 * np.array([x + width / 2, -y - height / 2])  # SVG turns the image: y counts from its foot
    column, row = middle.round().astype(int)
    assert np.ptp(pixels[row, column]) > 20  # the bar is coloured, in the same place of both
    assert (pixels[row, round(150 / 72 * x) - 3] == 255).all()  # and begins there


SIDES = ("width", "height", "x", "y")


@pytest.mark.parametrize("law", LAWS)
def test_a_motions_title_has_the_dissipation_of_its_own_law(law: str) -> None:
    found = simulate(problem("reference", "task.steps=30", "task.cycles=2", f"medium.law={law}"))
    spent = found.trajectory.dissipation / 2  # of one cycle of two
    assert figures.trajectory_words(found.trajectory).endswith(f"dissipates {spent:.3f}")
