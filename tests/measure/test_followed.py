"""Films that move with an animal: told, since its way over the floor is not in them."""

import numpy as np
import pytest

from serpenoid.measure.animals.followed import followed
from serpenoid.measure.load import load_campaign
from specimens import animal_campaign
from swimmers_by_curves import Curve


def film(ratio: float) -> tuple[np.ndarray, np.ndarray]:
    beats, points, _ = Curve(ratio=ratio, waves=1.3, amplitude=0.9).film(15, 161, 4)
    return 2 * beats, points + np.random.default_rng(5).normal(0, 0.001, points.shape)


def test_points_counted_from_their_centroid_or_from_one_of_them_are_said_to_be(tmp_path):
    """With K = 5 and every frame about its centroid, `fit` said K = 1.001 (1 .. 1.006) and nothing else."""
    time, points = film(5.0)
    for name, origin, said in (
        ("cut", points.mean(axis=1, keepdims=True), "the centroid of its points stays where it is"),
        ("whole", np.round(points.mean(axis=1, keepdims=True), 3), "the centroid of its points stays where it is"),
        ("head", points[:, -1:], "its point 15 of 15 (the head) stays where it is"),
        ("amid", points[:, 6:7], "its point 7 of 15 stays where it is"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        notes = load_campaign(animal_campaign(folder, name, time, points - origin, "mm")).trials[0].notes
        assert sum(note.startswith(said) for note in notes) == 1
        assert not any("head first" in note or "tail first" in note for note in notes)


@pytest.mark.parametrize("ratio", [0.4, 1.1, 5.0])
def test_a_body_that_goes_somewhere_is_not_followed(ratio):
    _, points = film(ratio)
    assert followed(points) == ""
    points[::2, 3] = np.nan
    assert followed(points) == ""


def test_a_body_that_rests_for_most_of_the_film_is_not_followed():
    """Of two snakes of thirty that rested nearly all the time a point seemed to be held, by medians."""
    _, points = film(5.0)
    rests = np.concatenate([np.repeat(points[:1], 800, axis=0), points])
    assert followed(rests + np.random.default_rng(0).normal(0, 1e-4, rests.shape)) == ""


def test_bends_that_run_neither_way_tell_of_no_exchanged_ends(tmp_path):
    """Of 56 % of a path that was travelled tail first, by bends to and fro, a note asked whether the ends were."""
    time, points = film(5.0)
    points = 1.2 * points - 0.2 * points.mean(axis=1, keepdims=True)
    standing = points[np.abs(np.arange(-82, 79))] - 0.002 * np.arange(161)[:, None, None]
    notes = load_campaign(animal_campaign(tmp_path, "rocks", time, standing, "mm")).trials[0].notes
    assert any("its bends stand, or run to and fro" in note for note in notes)
    assert not any("as head and tail would" in note for note in notes)
