"""A film that an editor has cut: the moment is told, and the trials to make of it."""

import re

import numpy as np
import pytest

from serpenoid.measure.animals.animal import between
from serpenoid.measure.load import load_campaign
from specimens import animal_campaign
from swimmers_by_curves import Curve

FRAMES, BEATS = 200, 8


def film(folder, keep: list[slice], moved=0.0):
    """A campaign of the frames that are kept, counted on without a hole; what follows the first cut is moved."""
    _, points, _ = Curve(ratio=6.0, waves=1.0, amplitude=0.7).film(9, FRAMES, BEATS)
    points = points + 0.001 * np.random.default_rng(3).normal(size=points.shape)
    kept = np.concatenate([points[part] for part in keep])
    kept[keep[0].stop - (keep[0].start or 0) :] += moved
    return animal_campaign(folder, "a", np.arange(len(kept)) / 25, 100 * kept, "mm")


def note(folder) -> str:
    return " ".join(n for n in load_campaign(folder).trials[0].notes if "film cut" in n)


@pytest.mark.parametrize(
    ("keep", "moved"), [((slice(0, 90), slice(112, 200)), 0.0), ((slice(0, 90), slice(90, 200)), 0.3)]
)
def test_a_cut_is_told_with_the_two_trials_to_make_of_it(tmp_path, keep, moved):
    folder = film(tmp_path, list(keep), moved)
    said = re.search(r"at ([\d.]+) s.*2 trials, `to_s = \1` in the first and `from_s = \1` in the second", note(folder))
    assert said
    assert 89 / 25 < float(said[1]) < 90 / 25
    file = folder / "campaign.toml"
    head, trial = file.read_text().split("[[trial]]")
    halves = [trial.replace("crawl", name) + f"{key} = {said[1]}\n" for name, key in (("a", "to_s"), ("b", "from_s"))]
    file.write_text("[[trial]]".join([head, *halves]))
    for one, frames in zip(load_campaign(folder).trials, (90, keep[1].stop - keep[1].start), strict=True):
        assert len(one.motion.time_s) == frames
        assert not one.motion.jumps


def test_two_cuts_make_three_trials(tmp_path):
    assert re.search(
        r"at [\d.]+ and [\d.]+ s.*3 trials", note(film(tmp_path, [slice(0, 60), slice(80, 130), slice(150, 200)]))
    )


def test_a_film_that_is_whole_or_shakes_for_some_frames_is_not_cut(tmp_path):
    assert not note(film(tmp_path, [slice(0, 200)]))
    shaken = film(tmp_path, [slice(0, 200)])
    rows = np.genfromtxt(tmp_path / "a.csv", delimiter=",", skip_header=1)
    rows[100:103, 1:] += 20
    header = (tmp_path / "a.csv").read_text().split("\n")[0]
    np.savetxt(tmp_path / "a.csv", rows, fmt="%.5f", delimiter=",", header=header, comments="")
    assert not note(shaken)


def test_a_moment_between_two_frames_is_told_from_both():
    for before, after in ((4.96, 5.0), (0.0010, 0.0015), (100.0, 102.0), (29.970, 30.0033)):
        assert before < float(between(before, after)) < after
