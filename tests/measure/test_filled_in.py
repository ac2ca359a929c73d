"""Points on straight lines between frames are no sightings: they are hidden, whoever wrote them and however rounded."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from serpenoid.measure.film.filled_in import rounded_by, without_filled_in
from serpenoid.measure.load import load_campaign
from serpenoid.measure.tracks import Tracks
from specimens import animal_campaign

FRAMES = 300


def crawl(points: int, noise: float, seed: int = 0, per_second: float = 30.0) -> np.ndarray:
    """Points (FRAMES, points, 2) of a body one unit long with a wave on it."""
    time, arc = np.arange(FRAMES)[:, None] / per_second, (np.arange(400) + 0.5) / 400
    angle = 0.7 * np.sin(2 * np.pi * (0.6 * time + 1.2 * arc))
    steps = np.stack([np.cos(angle), np.sin(angle)], axis=2) / 400
    at = np.linspace(0, 400, points).astype(int)
    found = np.concatenate([np.zeros((FRAMES, 1, 2)), np.cumsum(steps, axis=1)], axis=1)[:, at]
    found[..., 0] += 0.1 * time
    return found + np.random.default_rng(seed).normal(0, noise, found.shape)


def tracks(points: np.ndarray, time: np.ndarray | None = None, known: bool = True) -> Tracks:
    names = tuple(f"p{k}" for k in range(points.shape[1]))
    time = np.arange(len(points)) / 30 if time is None else time
    return Tracks(time, names, points, "made", (False,) * len(names), known)


def filled(points: np.ndarray, gaps: list[tuple[int, int, slice]]) -> tuple[np.ndarray, np.ndarray]:
    """The same with straight lines across gaps of frames first..last, and which points these are."""
    points, made = points.copy(), np.zeros(points.shape[:2], dtype=bool)
    for first, last, which in gaps:
        ends = points[[first - 1, last + 1]]
        share = (np.arange(first, last + 1) - first + 1) / (last - first + 2)
        line = ends[0] + share[:, None, None] * (ends[1] - ends[0])
        points[first : last + 1, which] = line[:, which]
        made[first : last + 1, which] = True
    return points, made


GAPS = [(20, 24, slice(None)), (60, 89, slice(2, 4)), (120, 121, slice(None)), (200, 212, slice(0, 1))]


@pytest.mark.parametrize(("points", "noise", "digits"), [(5, 3e-3, 4), (13, 1e-3, 4), (13, 1e-3, 16), (21, 2e-4, 6)])
def test_points_on_straight_lines_are_hidden_and_no_others(points: int, noise: float, digits: int) -> None:
    written, made = filled(crawl(points, noise, seed=digits), GAPS)
    told, said = without_filled_in(tracks(np.round(written, digits)))
    kept = ~made.all(axis=1)
    assert (np.isnan(told.floor[..., 0]) == made[kept]).mean() > 0.99  # a kink may be small by chance
    assert len(told.time_s) == kept.sum()
    assert f"in {(~kept).sum()} of {FRAMES} frames all" in said


@pytest.mark.parametrize("scale", [2.5e-5, 0.2137, 0.7333e-3])
@pytest.mark.parametrize("noise", [0.2, 0.6, 2.0])
def test_pixels_of_any_size_fill_in_nothing(scale: float, noise: float) -> None:
    """Numbers on a grid that is no decimal one: second differences are zero by chance."""
    for seed, (points, size) in enumerate(((5, 120.0), (13, 400.0), (20, 900.0))):
        pixels = np.round(size * crawl(points, noise / size, seed))
        for told in (scale * pixels, (scale * pixels).astype(np.float32).astype(float), np.round(scale * pixels, 6)):
            assert without_filled_in(tracks(told))[1] == ""


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_a_body_that_starts_and_stops_is_on_no_lines(noise: float) -> None:
    """It is between two kinks, and bends by less than the file's steps from frame to frame."""
    for seed, per_second in ((0, 30.0), (1, 100.0), (2, 1000.0)):
        clock = np.concatenate([np.repeat(t, 25) if t % 3 else np.arange(25) + 25 * t for t in range(12)])
        points = 500 * crawl(9, 0.0, seed, per_second)[np.minimum(clock, FRAMES - 1)]
        points += np.random.default_rng(seed).normal(0, noise, points.shape)
        for told in (np.round(points), np.round(points, 2), points):
            assert without_filled_in(tracks(told))[1] == ""


@pytest.mark.parametrize(("per_second", "jitter"), [(30.0, 0.0), (24.0, 0.0), (240.0, 0.0), (30.0, 0.1)])
def test_times_may_be_rounded_or_uneven(per_second: float, jitter: float) -> None:
    """jitter: SD of frames' times over the time between them, by which points are filled in, too."""
    stamps = np.arange(FRAMES) / per_second
    stamps += np.random.default_rng(0).uniform(-jitter, jitter, FRAMES) / per_second
    points, made = crawl(9, 1e-3), np.zeros((FRAMES, 9), dtype=bool)
    for first, last in ((40, 60), (100, 109), (200, 240)):
        share = (stamps[first : last + 1] - stamps[first - 1]) / (stamps[last + 1] - stamps[first - 1])
        points[first : last + 1] = points[first - 1] + share[:, None, None] * (points[last + 1] - points[first - 1])
        made[first : last + 1] = True
    told, _ = without_filled_in(tracks(np.round(points, 7), stamps if jitter else np.round(stamps, 3)))
    assert len(told.time_s) == (~made.all(axis=1)).sum()


def test_single_precision_and_pixels_are_read_alike() -> None:
    written, made = filled(1000 * crawl(9, 1e-3), GAPS)
    single = written.astype(np.float32).astype(float)
    assert rounded_by(single) < 1e-3
    for points in (single, np.round(written, 3)):
        told, _ = without_filled_in(tracks(points, known=False))
        assert np.isnan(told.floor[..., 0]).sum() == made[~made.all(axis=1)].sum()


@pytest.mark.parametrize("times", [2, 3, 6])
def test_film_that_was_put_on_more_frames_is_the_film_that_was_taken(times: int) -> None:
    points = crawl(9, 1e-3)[: FRAMES // times]
    fine = np.arange((len(points) - 1) * times + 1) / times
    at = np.minimum(fine.astype(int), len(points) - 2)
    written = points[at] + (fine - at)[:, None, None] * (points[at + 1] - points[at])
    told, _ = without_filled_in(tracks(np.round(written, 7), fine / 10))
    np.testing.assert_allclose(told.time_s, np.arange(len(points)) / 10, atol=1e-12)
    np.testing.assert_allclose(told.floor, points, atol=1e-6)


@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-3, 1e-2])
@pytest.mark.parametrize("digits", [0, 1, 2, 3, 6, 16])
def test_points_that_were_seen_stay(noise: float, digits: int) -> None:
    for seed, size in ((0, 1.0), (1, 30.0)):
        slow = crawl(9, noise, seed, per_second=1000.0)
        rests = np.concatenate([np.repeat(slow[:1], 60, axis=0), slow])
        glides = np.linspace(0, 3, FRAMES)[:, None, None] + crawl(9, noise, seed)[:1]
        glides = glides + np.random.default_rng(seed).normal(0, 1e-3, glides.shape)
        for points in (slow, rests, glides, crawl(9, noise, seed)):
            if np.isfinite(points).all() and (np.round(size * points, digits) != 0).any():
                assert without_filled_in(tracks(np.round(size * points, digits)))[1] == ""


def test_a_film_that_was_filled_in_is_measured_as_one_with_empty_cells(tmp_path: Path) -> None:
    written, made = filled(np.round(crawl(9, 1e-3), 5), GAPS)
    motions = []
    for name, points in (("filled", written), ("empty", np.where(made[..., None], np.nan, written))):
        (tmp_path / name).mkdir()
        (trial,) = load_campaign(animal_campaign(tmp_path / name, name, np.arange(FRAMES) / 30, points, "m")).trials
        assert any("filled in by a program" in note for note in trial.notes) == (name == "filled")
        motions.append(trial.motion)
    frames = [motion.time_s[motion.measured] for motion in motions]
    np.testing.assert_allclose(*frames)
    np.testing.assert_allclose(*(motion.poses[motion.measured] for motion in motions), atol=1e-6)
