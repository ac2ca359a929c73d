"""The report: one file that needs no other, the verdict first; its figures, labelled."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.quiver import Quiver, QuiverKey

from serpenoid.diagnose.diagnose import Diagnosis
from serpenoid.diagnose.report.animate import animated
from serpenoid.diagnose.report.cards import cards, worse
from serpenoid.diagnose.report.pages import write_pages
from serpenoid.diagnose.residuals import maps
from serpenoid.diagnose.residuals.maps import ACROSS, Windows, cell_side, windows
from serpenoid.plot import diagnosis, diagnosis_ladder, diagnosis_maps, diagnosis_ranking, diagnosis_trials
from serpenoid.plot.style import figure
from serpenoid.report.animated import ALL_FRAMES, animation_data
from serpenoid.report.glossary import glossed

ORDER = [
    "Before and after", "Alternatives", "What is left", "Next experiment",
    "Evidence", "Candidates", "Residuals of the shape", "Residuals of the motion", "Not tested",
]  # fmt: skip
LAYERS = ("baseline", "extended")


@pytest.fixture(scope="module")
def report(diagnosed: tuple[Diagnosis, dict[str, Any], Path]) -> tuple[str, list[str]]:
    """The page and the names of its figures, with some joint table as the next experiment."""
    d, record, out = diagnosed
    names = diagnosis.draw_shapes(out, d.ladder[:2]) + diagnosis.draw_motion(out, d.motion.selection)
    names += diagnosis.draw_rest(out, d)
    names += diagnosis.draw_experiment(out, np.zeros((20, 10)))
    write_pages(out, record, animated(d))
    return (out / "report.html").read_text(encoding="utf-8"), names


def test_a_floor_of_which_no_square_was_visited_often_is_not_drawn(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(maps, "LEAST_VISITS", 10**6)
    assert "on-floor" not in diagnosis.draw_motion(tmp_path, diagnosed[0].motion.selection)


def test_a_ranking_that_nothing_stands_in_is_not_drawn(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found, jobs = diagnosed[0].motion.selection, []
    monkeypatch.setattr(diagnosis, "_draw", lambda folder, asked: jobs.append(set(asked)))
    diagnosis.draw_motion(tmp_path, found)
    monkeypatch.setattr(diagnosis_ranking, "ranked", lambda found: {})
    diagnosis.draw_motion(tmp_path, found)
    assert jobs[0] - jobs[1] == {"ranking"}


def test_the_report_needs_no_other_file(report: tuple[str, list[str]]) -> None:
    page, names = report
    sources = re.findall(r'(?:src|href)\s*=\s*"([^"]*)"', page)
    assert len(sources) == len(names)
    assert all(s.startswith("data:image/svg+xml;base64,") for s in sources)
    assert not re.search(r"url\(|@import|<link", page)


def test_the_verdict_comes_first_and_everything_else_in_order(report: tuple[str, list[str]]) -> None:
    page = report[0]
    text = re.sub(r"<[^>]+>", " ", page)
    assert text.index("snake10, two: explained") < text.index("load at vertex 2") < text.index("Before and after")
    assert "gain_loss at joint 3" in text
    headings = re.findall(r"<h2>([^<]*)</h2>", page)
    places = [next(i for i, h in enumerate(headings) if h.startswith(name)) for name in ORDER]
    assert places == sorted(places)


def test_a_report_without_figures_still_reads(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path], tmp_path: Path
) -> None:
    write_pages(tmp_path, diagnosed[1])
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "<img" not in page
    assert "load at vertex 2" in page


def test_all_axes_are_labelled_with_units(diagnosed: tuple[Diagnosis, dict[str, Any], Path]) -> None:
    d = diagnosed[0]
    found = d.motion.selection
    w = windows(found.motion, found.null.predictions, found.best.predictions)
    parts = [s for s in d.ladder if s.error.name in diagnosis.PARTS]
    figures = [
        diagnosis.paths_figure(d),
        diagnosis_ladder.ladder_figure(d.ladder),
        *(diagnosis_ladder.parts_figure(s) for s in parts),
        diagnosis_maps.body_figure(w, True, found.scores),
        diagnosis_maps.floor_figure(w, True),
    ]
    unlike = {"joint", "vertex", "vertex (0 = tail)", "chi squared gained, thousands", "RMS over noise", ""}
    for fig in figures:
        shown = [ax for ax in fig.axes if ax.axison]
        labels = {text for ax in shown for text in (ax.get_xlabel(), ax.get_ylabel())}
        assert all(ax.get_ylabel() for ax in shown)
        assert all(re.search(r"\[.+\]$", text) for text in labels - unlike), labels
    grid = diagnosis_maps.residuals_figure(w, True).axes
    assert [ax.get_ylabel() for ax in grid[::2]] == ["forward [mm/s]", "to the left [mm/s]", "turning left [°/s]"]
    assert [ax.get_xlabel() for ax in grid[4:]] == ["phase [cycles], 1 = pause", "RMS speed of the vertices [mm/s]"]


def test_repeats_have_colours_of_their_own_and_measured_ones_those_of_their_predictions(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path],
) -> None:
    d = diagnosed[0]
    setting = d.motion.selection.motion.tracks[0].recording.setting
    count = sum(t.recording.setting == setting for t in d.motion.selection.motion.tracks)
    ax = diagnosis.paths(d, setting, figure(4, 3).add_subplot())
    colours = [line.get_color() for line in ax.get_lines()]
    assert count > 1
    assert len(set(colours)) == len(colours) == 3 * count
    by_repeat = np.reshape(colours, (count, 3, 3)).min(axis=2)  # later ones first: the first lies on top
    assert (np.diff(by_repeat, axis=0) < 0).all()
    legend = [text.get_text() for text in diagnosis.paths_figure(d).legends[0].get_texts()]
    assert {"later repeats (paler)", "dots: where windows end"} <= set(legend)


def test_a_predicted_path_has_dots_where_windows_end_and_the_measured_one_at_the_same_moments(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path],
) -> None:
    d = diagnosed[0]
    track = d.motion.selection.motion.tracks[0]
    measured, *predicted = reversed(diagnosis.paths(d, track.recording.setting, figure(4, 3).add_subplot()).get_lines())
    assert [line.get_markevery() for line in predicted[:2]] == [
        list(range(len(line.get_xdata()))) for line in predicted[:2]
    ]
    assert len(measured.get_markevery()) == len(predicted[0].get_xdata()) < len(measured.get_xdata())


def test_every_trial_has_a_line_of_its_own_in_time_and_settings_are_not_mixed(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path],
) -> None:
    found = diagnosed[0].motion.selection
    tracks = found.motion.tracks
    backwards = replace(found.motion, tracks=tracks[::-1])  # the order of files says nothing about settings
    kinds = [("baseline", found.null.predictions[::-1]), ("extended", found.best.predictions[::-1])]
    grid = diagnosis_trials.trials_figure(backwards, kinds).axes[:6]
    assert [t.get_text() for t in grid[0].get_yticklabels()] == sorted(
        {f"{gait}, {seconds:.3g} s" for gait, seconds in (t.recording.setting for t in tracks)}
    )
    settings = len(grid[0].get_yticks())
    for ax in grid:  # names beside the first column, strokes between settings in all
        assert list(ax.get_yticks()) == list(grid[0].get_yticks())
        (strokes,) = (c for c in ax.collections if isinstance(c, LineCollection))
        assert len(strokes.get_segments()) == settings - 1
    for ax, predictions in zip(grid[::3], (found.null.predictions, found.best.predictions), strict=True):
        over = diagnosis_trials.in_chance(found.motion, tracks, predictions)
        (boxes,) = (c for c in ax.collections if isinstance(c, PolyCollection))
        assert len(boxes.get_paths()) == sum(np.isfinite(r[:, 0]).sum() for r in over)
        lines = {round(path.vertices[:4, 1].mean()) for path in boxes.get_paths()}
        assert lines == set(range(len(tracks)))
    large = [
        np.nanmax(np.abs(np.concatenate(diagnosis_trials.in_chance(found.motion, tracks, p))))
        for p in (found.null.predictions, found.best.predictions)
    ]
    assert large[0] > 10 > 5 > large[1]


def test_the_colours_of_few_trials_have_room_for_their_name(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path],
) -> None:
    found = diagnosed[0].motion.selection
    few = replace(found.motion, tracks=found.motion.tracks[:1])
    fig = diagnosis_trials.trials_figure(few, [("baseline", found.null.predictions[:1])])
    canvas = FigureCanvasAgg(fig)
    canvas.draw()
    (name,) = (ax.yaxis.label for ax in fig.axes if ax.get_ylabel().startswith("residual"))
    box = name.get_window_extent(canvas.get_renderer())
    assert box.y0 > 0
    assert box.y1 < fig.bbox.y1


@pytest.mark.parametrize("joints", [1, 2, 40])
def test_every_joint_has_its_noise_level_and_numbers_do_not_touch(joints: int) -> None:
    error = SimpleNamespace(name="actuation", unit="m", before=0.02, after=0.01, noise_level=0.009)
    numbers = range(1, joints + 1)
    parts = [SimpleNamespace(name=f"joint {k}", before=0.02, after=0.01, noise_level=1e-3 * k) for k in numbers]
    (ax,) = diagnosis_ladder.parts_figure(SimpleNamespace(error=error, parts=parts)).axes  # type: ignore[arg-type]
    (levels,) = (c for c in ax.collections if isinstance(c, LineCollection))
    drawn = np.array(levels.get_segments())
    assert drawn[:, :, 0].mean(axis=1) == pytest.approx(list(numbers))
    assert drawn[:, 0, 1] == pytest.approx(list(numbers))  # mm
    assert (np.ptp(drawn[:, :, 0], axis=1) > 0.5).all()
    assert len(ax.get_xticks()) <= diagnosis_ladder.MOST_TICKS
    assert ax.get_legend_handles_labels()[1] == ["before", "after", "noise level"]


@pytest.mark.parametrize(("left", "arrows"), [(0.01, []), (1e-5, [2])])
def test_what_is_left_far_below_the_noise_is_an_arrow_on_the_axis(left: float, arrows: list[int]) -> None:
    error = SimpleNamespace(name="actuation", unit="m", before=0.02, after=0.01, noise_level=0.009)
    after = {1: 0.01, 2: left}
    parts = [SimpleNamespace(name=f"joint {k}", before=0.02, after=a, noise_level=1e-3) for k, a in after.items()]
    (ax,) = diagnosis_ladder.parts_figure(SimpleNamespace(error=error, parts=parts)).axes  # type: ignore[arg-type]
    drawn = [line for line in ax.get_lines() if line.get_marker() == "v"]
    assert [x for line in drawn for x in line.get_xdata()] == arrows
    assert all(y == ax.get_ylim()[0] for line in drawn for y in line.get_ydata())


@pytest.mark.parametrize(("settings", "columns"), [(1, 1), (3, 3), (5, 3), (8, 4), (9, 3)])
def test_as_few_places_for_paths_as_can_be_stay_empty(settings: int, columns: int) -> None:
    assert diagnosis.columns_of(settings) == columns


def test_the_lead_is_three_cards_and_says_what_became_worse(diagnosed: tuple[Diagnosis, dict[str, Any], Path]) -> None:
    record = diagnosed[1]
    verdict, cause, gain = cards(record)
    assert verdict.answer == "explained"
    assert "load at vertex 2" in cause.answer
    assert "Nothing became worse." in gain.sentences
    spoilt = {**record, "gain": {**record["gain"], "heading_error_rad": {"before": 0.01, "after": 0.02}}}
    assert worse(spoilt) == ["heading error, RMS"]
    assert cards(spoilt)[2].tone == "warn"
    both = {"before": 0.0636, "after": 0.0554, "before_interval": [0.032, 0.0738], "after_interval": [0.0504, 0.0745]}
    doubtful = cards({**record, "gain": {**record["gain"], "path_rms_m": both}})[2]
    assert doubtful.tone == "warn"
    assert any("overlap: the gain is not certain" in text for text in doubtful.sentences)


def test_a_report_that_leaves_much_unexplained_does_not_reassure(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path], tmp_path: Path
) -> None:
    settled = diagnosed[1] | {"alternatives": [], "next_experiment": None}
    for verdict, alternatives, experiment in [
        ("explained", "in the place of what is named.<", "None needed"),
        ("partly explained", "something is left that nothing here explains", "what is left has none"),
    ]:
        write_pages(tmp_path, settled | {"verdict": verdict})
        page = (tmp_path / "report.html").read_text(encoding="utf-8")
        assert alternatives in page
        assert experiment in page
        assert ("None needed" in page) == (verdict == "explained")


def test_every_trial_moves_in_the_animation_and_the_extended_model_stays_closer(
    diagnosed: tuple[Diagnosis, dict[str, Any], Path],
) -> None:
    d = diagnosed[0]
    trials = animated(d)
    assert [t.name for t in trials] == [t.recording.name for t in d.motion.selection.motion.tracks]
    for trial in trials:
        apart = {k: np.abs(trial.layers[k].bodies - trial.layers["measured"].bodies).max() for k in LAYERS}
        assert all(np.isfinite(x) for x in apart.values())
    mean = {k: np.mean([np.abs(t.layers[k].path - t.layers["measured"].path).max() for t in trials]) for k in LAYERS}
    assert mean["extended"] < mean["baseline"]
    data = animation_data(trials)
    assert len(data) == len(trials)
    assert sum(len(t["time"]) for t in data) <= ALL_FRAMES


def test_before_and_after_share_one_scale_on_the_floor(diagnosed: tuple[Diagnosis, dict[str, Any], Path]) -> None:
    found = diagnosed[0].motion.selection
    fig = diagnosis_maps.floor_figure(windows(found.motion, found.null.predictions, found.best.predictions), True)
    quivers = [c for ax in fig.axes for c in ax.collections if isinstance(c, Quiver)]
    assert len(quivers) == 2
    assert quivers[0].scale == quivers[1].scale
    assert sum(isinstance(a, QuiverKey) for ax in fig.axes for a in ax.get_children()) == 1
    assert len([ax for ax in fig.axes if ax.get_ylabel() == "RMS over noise"]) == 1


@pytest.mark.parametrize("size", [2e-3, 0.3, 40.0])
def test_squares_of_the_floor_suit_the_size_of_what_was_visited(size: float) -> None:
    corners = np.array([[[0.0, 0.0], [size, size / 3]]])
    side = cell_side(SimpleNamespace(vertices=corners))  # type: ignore[arg-type]
    assert size / ACROSS <= side * (1 + 1e-9) < 2.5 * size / ACROSS  # steps of 1, 2, 5 are at most 2.5 apart


def test_terms_are_explained_once_and_names_stay_text() -> None:
    text = str(glossed("noise level <b>, noise level, Simone"))
    assert text.count("<abbr") == 1
    assert "&lt;b&gt;" in text


def test_gains_are_joined_only_between_neighbouring_vertices_that_were_tried() -> None:
    ax = figure(4.0, 3.0).add_subplot()
    diagnosis_maps.vertex_scores([("load", k, 5.0 + k) for k in (0, 1, 4, 7)], ax)
    (line,) = ax.lines
    assert np.isnan(line.get_ydata()[[2, 3, 5, 6]]).all()


@pytest.mark.parametrize(
    ("gain", "drawn", "words"), [(500.0, 500.0, ""), (7e4, 70.0, ", thousands"), (3e6, 3.0, ", millions")]
)
def test_large_gains_are_in_thousands_or_millions_and_say_so(gain: float, drawn: float, words: str) -> None:
    ax = figure(4.0, 3.0).add_subplot()
    diagnosis_maps.vertex_scores([("load", 0, gain), ("inertia", None, 9e9)], ax)
    assert ax.lines[0].get_ydata()[0] == pytest.approx(drawn)
    assert ax.get_ylabel() == f"chi squared gained{words}"


@pytest.mark.parametrize("vertices", [5, 12, 41])
def test_vertices_have_ticks_that_do_not_touch_and_middles_of_edges_are_named(vertices: int) -> None:
    still = np.zeros((3, 3))
    points = np.zeros((3, vertices, 2))
    w = Windows(still, still, still + 1, np.zeros(3), np.zeros(3), np.zeros(3), still, points, points[..., 0])
    for middles in (False, True):
        axes = diagnosis_maps.body_figure(w, True, [("load", 1, 3.0)], middles).axes
        for ax in axes:
            assert len(ax.get_xticks()) <= diagnosis_maps.MOST_TICKS
            assert ("middles of edges" in ax.get_xlabel()) == middles


@pytest.mark.parametrize(("gain", "scale"), [(40.0, "linear"), (5e5, "log")])
def test_what_chance_gains_is_seen_beside_any_gain(gain: float, scale: str) -> None:
    best = SimpleNamespace(effects=())
    found = SimpleNamespace(scores=[("load", 1, gain), ("load", 2, 3.0)], best=best, refused=(), undetected=())
    fig = diagnosis_ranking.ranking_figure(found)  # type: ignore[arg-type]
    (ax,) = fig.axes
    assert ax.get_xscale() == scale
    assert "chosen" not in ax.get_legend_handles_labels()[1]


def test_what_was_chosen_has_a_row_of_its_own_and_the_places_of_a_scan_have_one_together() -> None:
    scan = [("friction_patch", None, 900.0 - k) for k in range(100)]
    others = [("load", k, 100.0 + k) for k in range(20)]
    harmful = [("worn_wheel", 3, -2.0)]
    keys = [("friction_patch", None), ("worn_wheel", 3), ("toe", None)]
    best = SimpleNamespace(effects=[SimpleNamespace(key=key) for key in keys])
    found = SimpleNamespace(scores=scan + others + harmful, best=best, refused=(), undetected=())
    rows = diagnosis_ranking.ranked(found)  # type: ignore[arg-type]
    assert list(rows)[:2] == [("friction_patch", None), ("load", 19)]
    assert rows["friction_patch", None] == 900.0
    assert len(rows) == diagnosis_ranking.MOST + 2
    (ax,) = diagnosis_ranking.ranking_figure(found).axes  # type: ignore[arg-type]
    names = [t.get_text() for t in ax.get_yticklabels()]
    assert names[:2] == ["friction_patch", "load at vertex 19"]
    assert set(names[-2:]) == {"worn_wheel at vertex 3", "toe"}
    assert len(ax.patches) == len(rows)
    assert [t.get_text() for t in ax.texts] == ["gains nothing alone"] * 2


@pytest.mark.parametrize(
    ("last", "legend"), [([], "why is written there"), ([("toe", None, 4.0)], "as written, else less in full")]
)
def test_the_ranking_says_why_what_gains_much_is_not_named(
    last: list[tuple[str, int | None, float]], legend: str
) -> None:
    load, drift, saturation = (
        SimpleNamespace(key=key) for key in (("load", 1), ("frame_drift", None), ("grip_saturation", None))
    )
    found = SimpleNamespace(
        scores=[("frame_drift", None, 23.0), ("load", 1, 9.0), ("grip_saturation", None, 8.0), *last],
        best=SimpleNamespace(effects=()),
        refused=(
            SimpleNamespace(effect=drift, share=0.031, beyond=False),
            SimpleNamespace(effect=saturation, share=0.2, beyond=True),
        ),
        undetected=(SimpleNamespace(added=load),),
    )
    (ax,) = diagnosis_ranking.ranking_figure(found).axes  # type: ignore[arg-type]
    assert [t.get_text() for t in ax.texts] == [
        "takes away 3% of what is left, as a wrong effect could",
        "its trace in the path is below noise",
        "pushed beyond its bound",
    ]
    assert ax.get_legend_handles_labels()[1][0].startswith(f"not chosen: {legend}")
