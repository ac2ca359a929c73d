"""A film that is turned, mirrored or moved tells the same K of an animal, with the same interval."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from serpenoid.compare.calibrate import anisotropy, drag_ratio
from serpenoid.compare.start import neutral_model
from serpenoid.measure.load import load_campaign
from serpenoid.measure.shapes.own_noise import own_noise
from swimmers_by_curves import Curve

pytestmark = pytest.mark.usefixtures("virtual_machine")
POINTS, NOISE = 9, 0.004
COLUMNS = "t_s," + ",".join(f"x_{k},y_{k}" for k in range(POINTS))
QUARTER = np.array([[0.0, 1.0], [-1.0, 0.0]])
OTHERS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "a quarter": lambda points: points @ QUARTER,
    "half a turn": lambda points: -points,
    "mirrored": lambda points: points * [1, -1],
    "mirrored and moved": lambda points: points[..., ::-1] + [1e3, -700],
}


def seen() -> tuple[np.ndarray, np.ndarray]:
    """Times (F,) and points (F, POINTS, 2) with noise of a worm with K = 8, two beats."""
    beats, points, _ = Curve(ratio=8.0, waves=0.9, amplitude=0.8).film(POINTS, 41, 2.0)
    return beats, points + np.random.default_rng(3).normal(0, NOISE, points.shape)


def told(folder: Path, points: np.ndarray, unit: str, body: str) -> np.ndarray:
    """K and its interval, and what is left over noise."""
    folder.mkdir()
    table = np.column_stack([seen()[0], points.reshape(len(points), -1)])
    np.savetxt(folder / "worm.csv", table, "%.17g", ",", header=COLUMNS, comments="")
    (folder / "campaign.toml").write_text(
        f'format = 1\nname = "worm"\n[body]\nvertices = {POINTS}\nkind = "crawler"\n{body}[motion]\nformat = "tidy"\n'
        f'length_unit = "{unit}"\n[[trial]]\nname = "crawl"\nmotion = "worm.csv"\n'
    )
    campaign = load_campaign(folder)
    model = neutral_model(campaign)
    found = anisotropy(campaign, model)
    return np.array([*drag_ratio(found, model), found.noise_scale])


@pytest.mark.parametrize(("unit", "body"), [pytest.param("m", "", marks=pytest.mark.slow), ("px", "length_m = 0.5\n")])
def test_k_and_its_interval_are_the_same_however_the_film_lies(tmp_path: Path, unit: str, body: str) -> None:
    points = seen()[1] * (500 if unit == "px" else 1)
    plain = told(tmp_path / "plain", points, unit, body)
    assert plain[1] < 8 < plain[2]
    for name, other in OTHERS.items():
        assert told(tmp_path / name, other(points), unit, body) == pytest.approx(plain, rel=1e-5), name


def test_noise_lies_as_the_body_does_and_hides_no_point() -> None:
    points = seen()[1]
    points[3, 2] = np.nan
    (drawn,) = own_noise(points, 1)
    for name, other in OTHERS.items():
        (moved,) = own_noise(other(points), 1)
        centre = other(np.zeros(2))
        expected = {tuple(np.round(other(one) - centre, 6).ravel()) for one in drawn}
        assert {tuple(np.round(one, 6).ravel()) for one in moved} == expected, name
    assert np.isfinite(drawn).all()
    assert drawn.sum(axis=0) == pytest.approx(0.0, abs=1e-12)
    assert drawn[0].std() == pytest.approx(1.0, abs=0.05)
