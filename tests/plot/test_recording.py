"""Pictures of recordings and of what is compared with them: words that fit an animal, titles within the figure."""

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from rehearsal import snake
from serpenoid.measure.load import load_campaign
from serpenoid.measure.schedule import Schedule
from serpenoid.model import Model
from serpenoid.plot import calibration, recording

LAMPREY = Path(__file__).parents[2] / "problems" / "campaigns" / "lamprey.toml"


@pytest.fixture(scope="module")
def trial():
    return load_campaign(LAMPREY).trials[0]


def test_an_animal_has_no_cycles_and_a_robot_has(trial):
    table = np.zeros((20, trial.body.joint_count))
    for schedule, word in ((None, "the recording"), (Schedule(table, 1.0, 1, 0.0), "a cycle")):
        ax = recording.floor(replace(trial, schedule=schedule), Figure().add_subplot())
        assert f"body as {word} begins" in ax.get_legend_handles_labels()[1]


def test_what_is_said_of_hidden_markers_is_within_the_figure(trial):
    markers = trial.motion.markers.copy()
    markers[:, 3] = np.nan
    fig = recording.trial_figure(replace(trial, motion=replace(trial.motion, markers=markers)))
    FigureCanvasAgg(fig).draw()
    (title,) = (ax._left_title for ax in fig.axes if ax.get_title(loc="left").startswith("Dark"))
    assert "never seen" in title.get_text()
    assert title.get_window_extent().x1 < fig.bbox.x1


def test_the_time_axes_of_a_recording_are_one_and_have_no_long_numbers(trial):
    for since, label, first in ((0.0, "time [s]", 0.0), (1.7e9, "time since 1700000000 s [s]", 0.0)):
        motion = replace(trial.motion, time_s=trial.motion.time_s - trial.motion.time_s[0] + since)
        late = replace(trial, motion=motion)
        axes = [draw(late, Figure().add_subplot()) for draw in (recording.visibility, recording.angles)]
        assert {ax.get_xlabel() for ax in axes} == {label}
        for ax in axes:
            assert ax.get_xlim() == pytest.approx((first, np.ptp(motion.time_s)))


def test_what_is_seen_when_stands_at_its_time_and_missing_frames_show_nothing():
    time = np.concatenate([np.arange(10), 30.0 + np.arange(10)])  # the picture's middle is a hole
    seen = np.ones((2, 20), dtype=bool)
    seen[1, 10:] = False
    shown = recording.evenly(time, seen)
    assert shown.shape == (2, 40)
    assert shown[0, :10].all()
    assert not shown[:, 12:28].any()
    assert shown[0, -9:].all()
    assert not shown[1, -9:].any()


@pytest.mark.parametrize("stated", [None, (0.35, 3.0)])
def test_no_ratio_is_drawn_that_cannot_be(stated):
    names = ("anisotropy_ratio",)
    medium = snake().medium.model_copy(update={"anisotropy_ratio_bounds": stated})
    model = Model(snake().body, medium)
    fit = SimpleNamespace(names=names, values=np.array([0.5]), robust_sd=np.array([6.0]), interval=[(0.4, 0.6)])
    trials = [SimpleNamespace(trial="a", estimate=fit, best_rms_eps=0.5)]
    together = SimpleNamespace(interval=[(0.4, 0.6)], values=[0.5])
    found = SimpleNamespace(trials=trials, together=together, names=names)
    ax = calibration.trial_values(found, model, Figure().add_subplot())
    ends = stated or (1e-4, 1.0)
    assert ax.get_xlim() == pytest.approx(ends)
    robust = ax.collections[0].get_segments()[0]
    assert robust[:, 0] == pytest.approx(ends)
