"""A film's scale from the lengths that are stated: no noise lengthens it, and its standard error is its scatter."""

from __future__ import annotations

import numpy as np
import pytest

from serpenoid.body import Body
from serpenoid.errors import InputError
from serpenoid.measure.animals.film_scale import film_scale
from serpenoid.measure.load import load_campaign
from serpenoid.measure.trial_files import neighbour_ratio
from swimmers_by_curves import Curve

PIXELS = 400.0
EDGES = np.array([0.04, 0.08, 0.06, 0.1, 0.08, 0.05, 0.09])


def worm(points: int, frames: int = 120) -> tuple[Body, np.ndarray, np.ndarray]:
    """A body, times and points of a curve with eight edges a wave and more [px]."""
    time, seen, _ = Curve(6.0, min(1.2, (points - 1) / 8), 0.8).film(points, frames, 4.0)
    return Body(kind="crawler", vertices=points, length_m=0.2), time, PIXELS * seen


def robot(frames: int = 200) -> tuple[Body, np.ndarray]:
    """A chain that bends at random [px]; edges in metres."""
    turned = np.cumsum(np.random.default_rng(4).normal(scale=0.3, size=(frames, len(EDGES))), axis=1)
    steps = EDGES[:, None] * np.stack([np.cos(turned), np.sin(turned)], axis=-1)
    points = np.concatenate([np.zeros((frames, 1, 2)), np.cumsum(steps, axis=1)], axis=1)
    return Body(kind="crawling robot", vertices=8, edge_lengths=tuple(EDGES)), PIXELS / EDGES.sum() * points


def noisy(points: np.ndarray, noise: float, hidden: float, seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    seen = points + rng.normal(0, noise, points.shape)
    seen[rng.random(seen.shape[:2]) < hidden] = np.nan
    return seen


def test_without_noise_the_scale_of_links_is_exact_and_that_of_a_curve_as_its_spline() -> None:
    """Splines miss 1e-6 of arcs with ten edges a wave (clean films of another generator: up to 5e-6)."""
    body, points = robot()
    assert film_scale(body, points).ratio * EDGES.sum() == pytest.approx(PIXELS, rel=1e-12)
    body, _, points = worm(13)
    assert film_scale(body, points).ratio * 0.2 == pytest.approx(PIXELS, rel=5e-6)


@pytest.mark.parametrize(
    ("points", "noise", "hidden"),
    [
        pytest.param(13, 0.01, 0.0, marks=pytest.mark.slow),
        (13, 0.04, 0.08),
        pytest.param(21, 0.05, 0.0, marks=pytest.mark.slow),
        (9, 0.03, 0.04),
    ],
)
def test_noise_does_not_lengthen_an_animal_and_the_standard_error_is_what_the_scale_scatters_by(
    points: int, noise: float, hidden: float
) -> None:
    """noise: over the distance of points. Medians of ratios are 0.01 to 0.6 % too large there; 24 films know their RMS
    to 14 %, their mean to a fifth of a standard error."""
    body, _, seen = worm(points)
    films = [noisy(seen, noise * PIXELS / (points - 1), hidden, seed) for seed in range(24)]
    found = [film_scale(body, film) for film in films]
    z = np.array([(one.ratio * 0.2 / PIXELS - 1) / one.sd for one in found])
    assert abs(z.mean()) < 0.9
    assert 0.6 < np.sqrt(np.mean(z**2)) < 1.5
    if noise > 0.02:
        medians = np.array([neighbour_ratio(film, body) * 0.2 / PIXELS - 1 for film in films])
        assert medians.mean() > 10 * abs(np.mean([one.ratio * 0.2 / PIXELS - 1 for one in found]))


@pytest.mark.parametrize("noise", [0.5, 3.0])
def test_noise_does_not_lengthen_links_of_different_lengths(noise: float) -> None:
    body, seen = robot()
    found = [film_scale(body, noisy(seen, noise, 0.05, seed)) for seed in range(24)]
    z = np.array([(one.ratio * EDGES.sum() / PIXELS - 1) / one.sd for one in found])
    assert abs(z.mean()) < 0.9
    assert 0.6 < np.sqrt(np.mean(z**2)) < 1.5


def test_points_that_leap_away_and_frames_that_show_nothing_do_no_harm() -> None:
    body, _, seen = worm(13)
    film = noisy(seen, 0.3, 0.0, 1)
    before = film_scale(body, film)
    film[5::20, 4] += 40.0
    film[9::20] = np.nan
    after = film_scale(body, film)
    assert after.ratio == pytest.approx(before.ratio, rel=3 * before.sd)
    assert after.sd < 1.5 * before.sd


def test_points_that_slide_along_the_body_are_no_noise_for_sure() -> None:
    """Interior points go back and forth by up to 12 % of an edge, three times a film: nothing is longer by it, and the
    standard error has what was taken off as if by noise."""
    body, time, every = worm(241)
    body = Body(kind="crawler", vertices=13, length_m=0.2)
    place = 20.0 * np.arange(13) + 2.4 * np.sin(2 * np.pi * (0.75 * time[:, None] + 0.37 * np.arange(13)))
    place[:, [0, -1]] = 0, 240
    low = np.minimum(place.astype(int), 239)
    frames, share = np.arange(len(time))[:, None], (place - low)[..., None]
    film = every[frames, low] * (1 - share) + every[frames, low + 1] * share
    found = film_scale(body, noisy(film, 0.1, 0.0, 1))
    assert found.sd > 5e-4
    assert found.ratio * 0.2 / PIXELS == pytest.approx(1, abs=2 * found.sd)


def test_a_scale_is_the_same_in_any_unit_and_from_any_side() -> None:
    body, _, seen = worm(13)
    film = noisy(seen, 0.3, 0.05, 1)
    found = film_scale(body, film)
    larger, turned = film_scale(body, 7 * film), film_scale(body, film[:, ::-1, ::-1])
    assert larger.ratio == pytest.approx(7 * found.ratio, rel=1e-12)
    assert larger.sd == pytest.approx(found.sd, rel=1e-6)
    assert turned.ratio == pytest.approx(found.ratio, rel=found.sd)  # other noise is drawn on its points


def campaign(folder, film: np.ndarray, time: np.ndarray, keys: str = "", body: str = "length_m = 0.2") -> list[str]:
    """Its trial's notes."""
    np.savez(folder / "m.npz", t_s=time, points=film)
    (folder / "campaign.toml").write_text(
        f'format = 1\nname = "worm"\n[body]\nkind = "crawler"\nvertices = {film.shape[1]}\n{body}\n[motion]\n'
        f'format = "array"\nlength_unit = "px"\n{keys}\n[[trial]]\nname = "a"\nmotion = "m.npz"\n'
    )
    return list(load_campaign(folder).trials[0].notes)


def test_a_scale_that_is_found_is_said_with_its_error_and_one_that_is_known_is_not(tmp_path) -> None:
    _, time, seen = worm(13)
    film = noisy(seen, 0.3, 0.0, 1)
    said = [note for note in campaign(tmp_path, film, time) if "pixels by its points" in note]
    assert len(said) == 1
    assert "`metres_per_pixel`" in said[0]
    assert not any("pixels by its points" in note for note in campaign(tmp_path, film, time, "metres_per_pixel = 5e-4"))
    film[:, ::2] = np.nan
    with pytest.raises(InputError, match="no two neighbouring markers are ever seen together"):
        campaign(tmp_path, film, time)


@pytest.mark.parametrize("told", ["length_m = 0.2", "edge_lengths = [0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02, 0.02]"])
def test_points_that_do_not_stand_as_stated_are_said_with_what_to_do(tmp_path, told: str) -> None:
    """Of a body whose points stand 20 % farther apart at the head than at the tail nothing was said but that it needs
    more points."""
    _, time, every = worm(81)
    at = np.round(np.cumsum([0, *np.linspace(8, 12, 8)])).astype(int)
    film = noisy(every[:, at], 0.3, 0.0, 1)
    said = [note for note in campaign(tmp_path, film, time, body=told) if "times as far apart along the body" in note]
    assert len(said) == 1
    assert f"Leave {'them' if 'edge' in told else '`length_m`'} out" in said[0]
    even = noisy(every[:, ::10], 0.3, 0.0, 1)
    assert not any("along the body" in note for note in campaign(tmp_path, even, time, body=told))
    assert not any("along the body" in note for note in campaign(tmp_path, film, time, body=""))
