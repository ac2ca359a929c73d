"""A plane that is tilted to the floor of `up_axis` is told from heights, and points are measured in it."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from serpenoid.measure.film.level import levelled
from serpenoid.measure.tracks import Tracks, floor_plane

FRAMES = 200
AXES = {"x": [1, 2, 0], "y": [2, 0, 1], "z": [0, 1, 2]}  # in the file: of what lies along the floor, and up


def motion(markers: int, seed: int) -> np.ndarray:
    """Places (FRAMES, markers, 2) [m] on a floor: a body that bends and moves."""
    rng, time = np.random.default_rng(seed), np.linspace(0, 6, FRAMES)[:, None]
    along = np.linspace(0, 0.5, markers)
    angle = 0.6 * np.sin(2 * np.pi * (time - along))
    points = np.stack([along + 0.1 * time + 0 * angle, 0.1 * angle], axis=2)
    turn = rng.uniform(0, 2 * np.pi)
    return points @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])


def seen(
    places: np.ndarray, tilt: float, way: float, up: str, noise: float, posts: float, seed: int
) -> tuple[Tracks, np.ndarray]:
    """The same on a floor that rises by `tilt` [rad] along `way`, as cameras tell it; posts [m]: of markers."""
    rng = np.random.default_rng(seed)
    uphill = np.array([np.cos(way), np.sin(way)])
    high = rng.uniform(0, posts, places.shape[1]) + 0 * places[..., 0]
    along = places @ uphill
    level = places + ((np.cos(tilt) - 1) * along - np.sin(tilt) * high)[..., None] * uphill
    space = np.empty((*along.shape, 3))
    space[..., AXES[up]] = np.concatenate([level, (np.sin(tilt) * along + np.cos(tilt) * high)[..., None]], axis=2)
    space += noise * rng.normal(size=space.shape)
    space[rng.random(along.shape) < 0.05] = np.nan
    names = tuple("abcdefghijklmnop"[: places.shape[1]])
    return Tracks(
        np.arange(FRAMES) / 30, names, floor_plane(space, up), "made", (False,) * len(names), space=space
    ), along


def lengths(points: np.ndarray) -> np.ndarray:
    return np.nanmedian(np.linalg.norm(points[:, 1:] - points[:, :-1], axis=2), axis=0)


@pytest.mark.parametrize(("markers", "noise", "posts"), [(4, 1e-4, 0.0), (9, 5e-4, 0.03), (16, 1e-3, 0.06)])
@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_lengths_are_those_in_the_plane(markers: int, noise: float, posts: float, up: str) -> None:
    for seed, (degrees, way) in enumerate(product((3.0, 10.0, 35.0), (0.3, 2.0))):
        places = motion(markers, seed)
        tracks, _ = seen(places, np.radians(degrees), way, up, noise, posts, seed)
        found, said = levelled(tracks, up)
        told = float(said.split("tilted by ")[1].split(" degrees")[0])
        assert told == pytest.approx(degrees, abs=0.6)
        # posts of other heights lean in the plane's own frame by nothing: neighbours are as far apart as on the floor
        np.testing.assert_allclose(lengths(found.floor), lengths(places), rtol=4 * noise / lengths(places).min())


@pytest.mark.parametrize("seed", range(6))
def test_a_level_floor_stays_as_it_is(seed: int) -> None:
    for up, noise in (("z", 1e-4), ("y", 2e-3)):
        tracks, _ = seen(motion(8, seed), 0.0, 0.0, up, noise, 0.05, seed)
        assert levelled(tracks, up) == (tracks, "")


@pytest.mark.parametrize("phase", [0.0, 0.125, 0.25, 0.5])
def test_a_body_that_lifts_its_parts_in_turn_is_on_no_slope(phase: float) -> None:
    """Heights that go with the beat, and with the way to the side that it makes."""
    for high in (0.01, 0.05):
        tracks, _ = seen(motion(10, 0), 0.0, 0.0, "z", 1e-3, 0.0, 0)
        assert tracks.space is not None
        beat = np.linspace(0, 6, FRAMES)[:, None] - np.linspace(0, 0.5, 10) - phase
        tracks.space[..., 2] += high * np.maximum(np.sin(2 * np.pi * beat), 0)
        assert levelled(tracks, "z") == (tracks, "")


def test_a_step_is_no_slope() -> None:
    places = motion(8, 3)
    tracks, _ = seen(places, 0.0, 0.0, "z", 5e-4, 0.02, 3)
    assert tracks.space is not None
    about = places - places.mean(axis=(0, 1))
    along = about @ np.linalg.svd(about.reshape(-1, 2), full_matrices=False)[2][0]
    tracks.space[..., 2] += 0.05 / (1 + np.exp(-along / 0.02))
    assert levelled(tracks, "z") == (tracks, "")


@pytest.mark.filterwarnings("error")
def test_a_film_of_which_every_other_frame_is_lost_is_levelled() -> None:
    tracks, _ = seen(motion(8, 2), 0.2, 1.0, "z", 1e-4, 0.0, 2)
    assert tracks.space is not None
    tracks.space[::2] = np.nan
    assert "tilted by 11.5 degrees" in levelled(tracks, "z")[1]


def test_a_plane_between_all_axes_is_levelled_too() -> None:
    tracks, _ = seen(motion(8, 2), np.radians(50.0), np.pi / 4, "z", 1e-4, 0.0, 2)
    found, said = levelled(tracks, "z")
    assert "tilted by 50.0 degrees" in said
    np.testing.assert_allclose(lengths(found.floor), lengths(motion(8, 2)), rtol=0.01)


def test_another_axis_that_is_up_and_a_body_that_shows_no_plane_are_left_alone() -> None:
    tracks, _ = seen(motion(8, 1), 0.1, 0.5, "z", 1e-3, 0.0, 1)
    assert levelled(tracks, "y")[1] == levelled(tracks, "x")[1] == ""
    still = np.repeat(motion(8, 1)[:1], FRAMES, axis=0)
    assert levelled(seen(still, 0.1, 0.5, "z", 0.0, 0.0, 1)[0], "z")[1] == ""
    flat = Tracks(tracks.time_s, tracks.names, tracks.floor, "made", tracks.unlabelled)
    assert levelled(flat, "z") == (flat, "")
