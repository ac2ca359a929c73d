"""A body that stretches in places while its length stays is told from noise, and from a body that only bends."""

import re

import numpy as np
import pytest

from serpenoid.measure.load import load_campaign
from specimens import animal_campaign

NOISE = 0.001  # body lengths
TIME = np.arange(240) / 30
ALONG = np.linspace(0, 1, 401)


def crawler(stretch: float, vertices: int = 12, bend: float = 2.5, hidden: float = 0.0, noise: float = NOISE):
    """Points (F, N, 2) of a body that bends by a wave, goes on at 0.2 lengths a second, and stretches by another wave
    one body long."""
    wave = 2 * np.pi * (ALONG + 0.9 * TIME[:, None])
    heading = bend * np.sin(2 * np.pi * (ALONG / 0.8 + TIME[:, None])) / (2 * np.pi / 0.8)
    steps = (1 + stretch * np.cos(wave))[..., None] * np.stack([np.cos(heading), np.sin(heading)], axis=2)
    middle = (steps[:, 1:] + steps[:, :-1]) / 2 * ALONG[1]
    points = np.concatenate([np.zeros((len(TIME), 1, 2)), np.cumsum(middle, axis=1)], axis=1)
    points[..., 0] += 0.2 * TIME[:, None]
    rng = np.random.default_rng(2)
    seen = points[:, np.linspace(0, 400, vertices).astype(int)]
    seen = seen + noise * rng.normal(size=seen.shape)
    seen[rng.random(seen.shape[:2]) < hidden] = np.nan
    return seen


def notes(folder, points) -> str:
    return " ".join(load_campaign(animal_campaign(folder, "a", TIME, 100 * points, "mm")).trials[0].notes)


@pytest.mark.parametrize("stretch", [0.2, 0.05])
def test_a_body_that_stretches_in_places_is_told(tmp_path, stretch):
    said = notes(tmp_path, crawler(stretch))
    share = re.search(r"neighbouring points vary by ([\d.]+)%.*stretches in places \(peristalsis\)", said)
    assert share
    assert float(share[1]) / 100 == pytest.approx(stretch / np.sqrt(2), rel=0.15)  # 12 points show most of a wave


@pytest.mark.parametrize(
    ("vertices", "bend", "hidden", "noise"), [(12, 2.5, 0.0, NOISE), (25, 5.0, 0.05, 3 * NOISE), (8, 6.0, 0.0, NOISE)]
)
def test_a_body_that_only_bends_stretches_nowhere(tmp_path, vertices, bend, hidden, noise):
    said = notes(tmp_path, crawler(0.0, vertices, bend, hidden, noise))
    assert "stretches" not in said
    assert "lengthening" not in said


def test_rigid_links_stretch_nowhere_though_no_curve_runs_between_their_ends(tmp_path):
    heading = 0.5 * np.sin(2 * np.pi * (np.linspace(0, 1, 11) / 0.8 + TIME[:, None]))
    steps = np.stack([np.cos(heading), np.sin(heading)], axis=2) / 11
    points = np.concatenate([np.zeros((len(TIME), 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    points[..., 0] += 0.2 * TIME[:, None]
    said = notes(tmp_path, points + NOISE / 3 * np.random.default_rng(4).normal(size=points.shape))
    assert "stretches" not in said


def lasting(shape, frames: int = 5) -> np.ndarray:
    """Noise (F, N, 2) that a tracker has smoothed over some frames, of SD 1."""
    rough = np.random.default_rng(6).normal(size=(shape[0] + frames - 1, *shape[1:]))
    return np.lib.stride_tricks.sliding_window_view(rough, frames, axis=0).sum(axis=-1) / np.sqrt(frames)


@pytest.mark.parametrize("stretch", [0.0, 0.05, 0.2])
def test_what_a_body_stretches_by_is_no_noise_of_its_points(tmp_path, stretch):
    """To what a smoothed stretch leaves of it; the misfit of rigid links to all of it is 5 and 21 times the noise."""
    motion = load_campaign(animal_campaign(tmp_path, "a", TIME, 100 * crawler(stretch), "mm")).trials[0].motion
    assert motion.marker_sd == pytest.approx(NOISE, rel=0.2)
    assert motion.stretches.any == (stretch > 0)


def test_noise_that_lasts_is_no_stretch_and_stays_noise(tmp_path):
    """All directions have it alike; by second differences it would be a fifth, and the body would crawl by it."""
    points = crawler(0.0, noise=0.0)
    points = points + 2 * NOISE * lasting(points.shape)
    (trial,) = load_campaign(animal_campaign(tmp_path, "a", TIME, 100 * points, "mm")).trials
    assert not trial.motion.stretches.any
    assert trial.motion.marker_sd == pytest.approx(2 * NOISE, rel=0.15)
    assert not [note for note in trial.notes if "peristalsis" in note]


def animals(count: int = 5) -> np.ndarray:
    """Points (F, count, 2) of animals that each swim to and fro in a dish, by slow waves of their own."""
    rng = np.random.default_rng(3)
    rates, phases = rng.uniform(0.1, 0.4, (3, count, 2)), rng.uniform(0, 2 * np.pi, (3, count, 2))
    return np.sin(2 * np.pi * rates[:, None] * TIME[:, None, None] + phases[:, None]).sum(axis=0)


def test_of_points_of_several_animals_it_is_asked_whether_they_are_of_one_body(tmp_path):
    said = notes(tmp_path, animals())
    assert "Are they points of one body, and in their order along it?" in said
    assert "peristalsis" not in said


@pytest.mark.parametrize(
    ("stretch", "vertices", "bend", "noise"), [(0.2, 12, 2.5, NOISE), (0.0, 25, 5.0, 0.012), (0.0, 5, 9.0, NOISE)]
)
def test_of_one_body_that_stretches_scatters_or_bends_much_this_is_not_asked(tmp_path, stretch, vertices, bend, noise):
    """Noise of 0.3 edges, and edges that bend by more than a right angle."""
    assert "one body" not in notes(tmp_path, crawler(stretch, vertices, bend, noise=noise))
