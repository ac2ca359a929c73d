"""Points where no body goes: how many are left out is said, and neither they nor a frame of them are another animal."""

from types import SimpleNamespace

import numpy as np
import pytest

from serpenoid.measure.animals.animal import remarks
from serpenoid.measure.film.quality import Jump
from serpenoid.measure.load import load_campaign
from specimens import animal_campaign
from test_animal_words import crawl


def trial(folder, points, time):
    folder.mkdir(exist_ok=True)
    return load_campaign(animal_campaign(folder, "a", time, 0.4 * points, "m")).trials[0]


def test_how_many_points_are_left_out_is_said_with_when(tmp_path):
    time, points = crawl(100)
    assert "taken for wild" not in " ".join(trial(tmp_path / "clean", points, time).notes)
    points[[30, 31, 60, 75, 80], [2, 2, 5, 1, 4]] += 0.4
    said = " ".join(trial(tmp_path / "wild", points, time).notes)
    assert "5 points (0.71%) taken for wild" in said
    assert "at 1.2, 1.24, 2.4 s and 2 moments more" in said


def test_a_frame_that_shows_another_shape_elsewhere_is_none_of_the_path(tmp_path):
    """All its points are there and fit no chain; before, a linear step from the path took the body half a length aside
    in this frame, at as many times the noise."""
    time, points = crawl(100)
    points[50] = points[50].mean(axis=0) + [0.4, 0.3] + 0.01 * np.random.default_rng(5).normal(size=points[50].shape)
    motion = trial(tmp_path, points, time).motion
    assert motion is not None
    between = (motion.poses[49, :2] + motion.poses[51, :2]) / 2
    assert np.linalg.norm(motion.poses[50, :2] - between) < 0.01
    assert np.isnan(motion.markers[50]).all()


@pytest.mark.parametrize(("moved", "told"), [(slice(None), True), ([2], False)])
def test_only_where_most_points_leap_the_whole_body_is_elsewhere(tmp_path, moved, told):
    """One wild point of seven takes their centroid along by a seventh of its way."""
    time, points = crawl(100)
    campaign = load_campaign(animal_campaign(tmp_path, "a", time, 0.4 * points, "m"))
    motion = campaign.trials[0].motion
    assert motion is not None
    markers = motion.markers.copy()
    markers[50:, moved] += [0.7, 0.0]
    size = 0.7 if told else 0.1
    changes = {"markers": markers, "runs": (slice(0, 50), slice(50, 100)), "jumps": (Jump(50, 2.0, None, size),)}
    cut = SimpleNamespace(**{name: getattr(motion, name) for name in [*vars(motion), "known"]} | changes)
    cut.beat = motion.beat
    assert ("another animal" in " ".join(remarks(campaign.body, cut))) == told
